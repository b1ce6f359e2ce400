# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Follows a bag that is being written: each look reads the records that were added since.

A writer appends whole records; what is not whole yet is read at the next look. The scene stands
before the first message, so that the first look knows what to draw.

A run may be written faster than anybody can read it. Of more than a look may interpret, chunks are
stepped over evenly, the newest never: in bags of ours, where they hold messages alone; in others
names of topics may stand in any chunk, and a look goes only as far as it may.

Where another file has come in its place, another run begins.
"""

from __future__ import annotations

import os
import struct
import time
from dataclasses import replace
from pathlib import Path
from struct import Struct
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Metadata, Schema

from rigid_body_sim.analysis.scene_begin import began_of
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording import bag_files, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_writer import MANIFEST
from rigid_body_sim.recording.every_body import ARRAYS, BodyArray, arrays_of
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.recording.topic_names import own_names, read_names
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.view.growing_motion import KINDS, GrowingMotion, tells_motion
from rigid_body_sim.view.recorded_motion import RecordedMotion

SCENE = 'scene.yaml'
BEGINNING = 30.0  # [s] for a bag to come into being and to hold a first instant
LOOK = 0.1  # [s] between looks for that
MOST_AT_FIRST, MOST_AT_ONCE = 2000, 25  # instants of what was there, and of each look
FIRST_LOOK, LATER_LOOK = 1 << 26, 1 << 22  # [byte] that are interpreted at once: 2 s, 0.1 s
BUFFER = 1 << 16  # [byte]
HEAD = 1 << 12  # [byte] by which a file is known again: of ours with parts of its manifest
_FRAME = Struct('<BQ')


class BagFollower:
    """
    A bag that grows.

    scene, title, about : known after `begin`
    ended               : whether the writer has closed it
    run                 : how often its time went back, as of a bag of a player in a loop, or
                          another file came in its place
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._runs_before = 0  # of files that were here before this one
        self._missed_since: float | None = None
        self._begin_file()

    def _begin_file(self) -> None:
        """Know nothing of the file that is there."""
        self.scene: Scene | None = None
        self.title, self.about = self.path.name, ''
        self.ended = False
        self._node: tuple[int, int] | None = None  # of the file system
        self._head = b''
        self._position = len(mcap_file.MAGIC)
        self._types: dict[int, str] = {}
        self._channels: dict[int, Topic] = {}
        self._own: dict[str, str] = {}  # topic in the file -> that of the run
        self._names: dict[int, str] = {}  # own, of the topics that tell of the motion
        self._manifest: RecordValues | None = None
        self._files: dict[str, bytes] = {}
        self._is_ours = False  # what our writers make: chunks hold messages alone
        self._motion: GrowingMotion | None = None

    @property
    def run(self) -> int:
        """Which run it is that is shown."""
        return self._runs_before + (0 if self._motion is None else self._motion.run)

    def begin(self) -> RecordedMotion:
        """
        Wait until there is something to show; RunError: nothing comes, UserError: it is no bag.
        """
        if not self.path.exists():
            self._await_path()
        deadline = time.monotonic() + BEGINNING
        while True:
            if self._file() is not None:
                first = self._look(MOST_AT_FIRST, FIRST_LOOK)
                if first is not None:
                    return self._with_scene(first)
            if self.ended and self._motion is None:
                raise self._without_poses()
            STOP.check(lambda: f'before {self.path} had a state of a body')
            if time.monotonic() > deadline or self.ended:
                raise RunError(f'{self.path}: no state of a body came within {BEGINNING:g} s')
            time.sleep(LOOK)

    def _await_path(self) -> None:
        """Say at once that there is nothing yet, and give a run that begins time to make it."""
        if not self.path.absolute().parent.is_dir():
            raise UserError(
                f'{self.path}: no such file or directory, nor the folder it would be in'
            )
        say(
            f'{self.path}: no such file or directory yet; waiting up to {BEGINNING:g} s for a run '
            'that makes it (Ctrl-C ends)'
        )
        deadline = time.monotonic() + BEGINNING
        while not self.path.exists():
            STOP.check(lambda: f'before {self.path} was there')
            if time.monotonic() > deadline:
                raise UserError(
                    f'{self.path}: no such file or directory, and no run made it; give the bag '
                    'that is being written, or no BAG for the node that is running'
                )
            time.sleep(LOOK)

    def more(self) -> RecordedMotion | None:
        """Give what came since the last call."""
        file = self._file()
        if file is None:
            self._miss()
            return None
        self._missed_since = None
        if self._is_another(file):
            run = self.run
            self._begin_file()
            self._runs_before = run + 1
        if self.ended:
            return None
        is_new = self._motion is None
        limits = (MOST_AT_FIRST, FIRST_LOOK) if is_new else (MOST_AT_ONCE, LATER_LOOK)
        block = self._look(*limits)
        return self._with_scene(block) if is_new and block is not None else block

    def _miss(self) -> None:
        """Wait for another run where the file went before it was whole; RunError: none came."""
        if self.ended:
            return
        now = time.monotonic()
        self._missed_since = now if self._missed_since is None else self._missed_since
        if now - self._missed_since > BEGINNING:
            raise RunError(
                f'{self.path}: is no longer there, and no run made it anew within {BEGINNING:g} s'
            )

    def _is_another(self, file: Path) -> bool:
        """Tell whether this is not the file that was looked at before."""
        if self._node is None:
            return False
        try:
            with file.open('rb', buffering=0) as stream:
                status, head = os.fstat(stream.fileno()), stream.read(len(self._head))
        except FileNotFoundError:  # it goes just now
            return False
        grown = status.st_size >= self._position and head == self._head
        return not grown or (status.st_dev, status.st_ino) != self._node

    def _file(self) -> Path | None:
        """Find the file; None while there is none yet."""
        try:
            return bag_files.lone_file(self.path)
        except UserError:
            if self.path.exists() and not self.path.is_dir():
                raise
            return None

    def _look(self, most: int, room: int) -> RecordedMotion | None:
        """Interpret about so many bytes of what came, and give so many instants of them."""
        file = self._file()
        if file is None:
            return None
        with file.open('rb', buffering=BUFFER) as stream:
            status = os.fstat(stream.fileno())
            self._node, size = (status.st_dev, status.st_ino), status.st_size
            self._head = stream.read(HEAD)
            stream.seek(0)
            if not mcap_file.MAGIC.startswith(stream.read(len(mcap_file.MAGIC))):
                raise UserError(f'{file}: not a bag: does not start as an MCAP file')
            self._take_some(stream, size, room)
        return None if self._motion is None else self._motion.whole(most=most)

    def _take_some(self, stream: BinaryIO, size: int, room: int) -> None:
        """Take whole records of a file of so many bytes, until so many are interpreted."""
        share = room / max(size - self._position, room)
        taken = due = 0.0  # [byte] interpreted; that may be, of chunks that came
        passed: tuple[int, int] | None = None  # the last chunk, where it was stepped over
        while not self.ended and (taken < room or self._is_ours):
            position = self._position
            stream.seek(position)
            frame = stream.read(_FRAME.size)
            if len(frame) < _FRAME.size:
                break
            opcode, length = _FRAME.unpack(frame)
            if length > mcap_scan.MOST_BYTES:
                raise RunError(f'{self.path}: a record of {length} bytes; it is damaged')
            self._position = position + _FRAME.size + length
            if self._position > size:
                self._position = position
                break
            if opcode == mcap_file.MESSAGE_INDEX:
                run = frame + stream.read(mcap_scan.RUN_OF_INDEXES)
                self._position = max(self._position, position + mcap_scan.end_of_indexes(run))
                continue
            if opcode == mcap_file.CHUNK:
                due += length * share
                passed = (position, length) if self._is_ours and due <= 0.0 else None
                if passed is not None:
                    continue
                due -= length
            if opcode == mcap_file.DATA_END and passed is not None:
                self._take_chunk(stream, *passed)
                passed = None
                stream.seek(position + _FRAME.size)
            taken += length
            self._take(mcap_scan.Record(opcode, position, stream.read(length)))
        if passed is not None:
            self._take_chunk(stream, *passed)

    def _take_chunk(self, stream: BinaryIO, position: int, length: int) -> None:
        """Interpret a chunk that was stepped over, as none came after it."""
        stream.seek(position + _FRAME.size)
        self._take(mcap_scan.Record(mcap_file.CHUNK, position, stream.read(length)))

    def _take(self, record: mcap_scan.Record) -> None:
        try:
            if record.opcode == mcap_file.CHUNK:
                for inner in mcap_scan.inner_records(record):
                    self._take(inner)
            elif record.opcode == mcap_file.MESSAGE:
                self._take_message(mcap_scan.message(record))
            elif record.opcode == mcap_file.SCHEMA:
                schema = record.parse(Schema)
                self._types[schema.id] = schema.name
            elif record.opcode == mcap_file.CHANNEL:
                channel = record.parse(Channel)
                kind = self._types.get(channel.schema_id, '')
                self._channels[channel.id] = Topic(channel.topic, kind)
                self._name(channel.id)
            elif record.opcode == mcap_file.ATTACHMENT:
                attachment = record.parse(Attachment)
                self._files[attachment.name] = attachment.data
            elif record.opcode == mcap_file.METADATA:
                metadata = record.parse(Metadata)
                if metadata.name == MANIFEST:
                    self._is_ours = True
                    self.about = _about(metadata.metadata)
                    values = RecordValues(self.path, 'manifest', metadata.metadata)
                    self._manifest = values
                    self._own = own_names(read_names(values))
                    for channel_id in self._channels:  # which stand before it
                        self._name(channel_id)
            elif record.opcode == mcap_file.DATA_END:
                self.ended = True
        except (mcap_scan.Torn, McapError, struct.error) as error:
            raise RunError(f'{self.path}: damaged ({error})') from error

    def _name(self, channel: int) -> None:
        """Note the own name of a topic, if it tells of the motion."""
        wire, kind = self._channels[channel]
        name = self._own.get(wire, wire)
        self._names.pop(channel, None)
        if tells_motion(name, kind) or ARRAYS.get(name.rpartition('/')[2]) == kind:
            self._names[channel] = name

    def _take_message(self, message: mcap_scan.Message) -> None:
        name = self._names.get(message.channel)
        if name is None:
            return
        if self._motion is None:
            arrays = self._arrays()
            cut = [topic.name for array in arrays.values() for topic in array.parts.values()]
            names = [*self._names.values(), *cut]
            poses = [each for each in names if each.endswith('/pose')]
            if not poses:
                raise self._without_poses()
            self._motion = GrowingMotion(poses, names, arrays=arrays)
        self._motion.take(name, message.data)

    def _arrays(self) -> dict[str, BodyArray]:
        """Find the arrays that hold bodies without topics of their own."""
        values = self._manifest
        if values is None or not values.text('bodies', ''):
            return {}
        kinds = {name: self._channels[number].type for number, name in self._names.items()}
        return arrays_of(values.names('bodies'), kinds, namespace=values.text('namespace', ''))

    def _without_poses(self) -> RunError:
        return RunError(
            f'{self.path}: has no topics <body>/pose to follow; expected messages of '
            f'{KINDS["pose"]} on topics that end in /pose'
        )

    def _with_scene(self, first: RecordedMotion) -> RecordedMotion:
        """Read the scene, and tell when it began."""
        source = self._files.pop(SCENE, None)
        if source is not None:
            self.scene = load_scene(source, files=self._files)
            self.title = self.scene.name
        assert self._motion is not None
        self._motion.began = (0.0,)
        if self.scene is not None and self._is_ours:
            self._motion.began = (began_of(self._files, self.scene, path=self.path) / 1e9,)
        self._files = {}
        return replace(first, began=self._motion.began)


def _about(manifest: dict[str, str]) -> str:
    """Integrator and tick length, as far as the manifest tells."""
    parts = []
    if integrator := manifest.get('integrator', '').split():
        parts.append(f'integrator {integrator[0]}')
    if (dt_ns := manifest.get('dt_ns', '')).isdecimal():
        parts.append(f'dt = {int(dt_ns) * 1e-9:g} s')
    return ', '.join(parts)
