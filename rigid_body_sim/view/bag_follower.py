# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Follows a bag that is being written: each look reads the records that were added since.

A writer appends whole records; what is not whole yet is read at the next look. The scene stands
before the first message, so that the first look knows what to draw.
"""

from __future__ import annotations

import struct
import time
from pathlib import Path
from struct import Struct
from typing import BinaryIO

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Metadata, Schema

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.recording import bag_files, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_writer import MANIFEST
from rigid_body_sim.scene import load_scene
from rigid_body_sim.stop_signals import STOP, say
from rigid_body_sim.view.growing_motion import KINDS, GrowingMotion, tells_motion
from rigid_body_sim.view.recorded_motion import RecordedMotion

SCENE = 'scene.yaml'
BEGINNING = 30.0  # [s] for a bag to come into being and to hold a first instant
LOOK = 0.1  # [s] between looks for that
MOST_AT_FIRST, MOST_AT_ONCE = 2000, 25  # instants of what was there, and of each look
LARGEST_LOOK = 1 << 26  # [byte] read at once
_FRAME = Struct('<BQ')


class BagFollower:
    """
    A bag that grows.

    scene, title, about : known after `begin`
    ended               : whether the writer has closed it
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.scene: Scene | None = None
        self.title, self.about = path.name, ''
        self.ended = False
        self._position = len(mcap_file.MAGIC)
        self._types: dict[int, str] = {}
        self._names: dict[int, str] = {}  # of the topics that tell of the motion
        self._files: dict[str, bytes] = {}
        self._motion: GrowingMotion | None = None

    def begin(self) -> RecordedMotion:
        """
        Wait until there is something to show; RunError: nothing comes, UserError: it is no bag.
        """
        if not self.path.exists():
            self._await_path()
        deadline = time.monotonic() + BEGINNING
        while True:
            if self._file() is not None:
                first = self._look(MOST_AT_FIRST)
                if first is not None:
                    self._learn_scene()
                    return first
            if self.ended and self._motion is None:
                raise self._without_poses()
            if time.monotonic() > deadline or self.ended or STOP.number:
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
            if time.monotonic() > deadline or STOP.number:
                raise UserError(
                    f'{self.path}: no such file or directory, and no run made it; give the bag '
                    'that is being written, or no BAG for the node that is running'
                )
            time.sleep(LOOK)

    def more(self) -> RecordedMotion | None:
        """Give what came since the last call."""
        return None if self.ended else self._look(MOST_AT_ONCE)

    def _file(self) -> Path | None:
        """Find the file; None while there is none yet."""
        try:
            return bag_files.lone_file(self.path)
        except UserError:
            if self.path.exists() and not self.path.is_dir():
                raise
            return None

    def _look(self, most: int) -> RecordedMotion | None:
        file = self._file()
        if file is None:
            raise RunError(f'{self.path}: is no longer there')
        with file.open('rb') as stream:
            if not mcap_file.MAGIC.startswith(stream.read(len(mcap_file.MAGIC))):
                raise UserError(f'{file}: not a bag: does not start as an MCAP file')
            while not self.ended and self._take_some(stream):
                pass
        return None if self._motion is None else self._motion.whole(most=most)

    def _take_some(self, stream: BinaryIO) -> bool:
        """Read and take whole records; tells whether there was any."""
        stream.seek(self._position)
        content = stream.read(LARGEST_LOOK)
        at = 0
        while at + _FRAME.size <= len(content):
            opcode, length = _FRAME.unpack_from(content, at)
            if at == 0 and length > mcap_scan.MOST_BYTES:
                raise RunError(f'{self.path}: a record of {length} bytes; it is damaged')
            end = at + _FRAME.size + length
            if end > len(content):
                if at == 0 and length + _FRAME.size > LARGEST_LOOK:
                    raise RunError(f'{self.path}: a record of {length} bytes is too large here')
                break
            record = mcap_scan.Record(opcode, self._position + at, content[at + _FRAME.size : end])
            self._take(record)
            at = end
            if self.ended:
                break
        self._position += at
        return at > 0

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
                if tells_motion(channel.topic, self._types.get(channel.schema_id, '')):
                    self._names[channel.id] = channel.topic
            elif record.opcode == mcap_file.ATTACHMENT:
                attachment = record.parse(Attachment)
                self._files[attachment.name] = attachment.data
            elif record.opcode == mcap_file.METADATA:
                metadata = record.parse(Metadata)
                if metadata.name == MANIFEST:
                    self.about = _about(metadata.metadata)
            elif record.opcode == mcap_file.DATA_END:
                self.ended = True
        except (mcap_scan.Torn, McapError, struct.error) as error:
            raise RunError(f'{self.path}: damaged ({error})') from error

    def _take_message(self, message: mcap_scan.Message) -> None:
        name = self._names.get(message.channel)
        if name is None:
            return
        if self._motion is None:
            names = self._names.values()
            poses = [each for each in names if each.endswith('/pose')]
            if not poses:
                raise self._without_poses()
            self._motion = GrowingMotion(poses, names)
        self._motion.take(name, message.data)

    def _without_poses(self) -> RunError:
        return RunError(
            f'{self.path}: has no topics <body>/pose to follow; expected messages of '
            f'{KINDS["pose"]} on topics that end in /pose'
        )

    def _learn_scene(self) -> None:
        source = self._files.pop(SCENE, None)
        if source is not None:
            self.scene = load_scene(source, files=self._files)
            self.title = self.scene.name
        self._files = {}


def _about(manifest: dict[str, str]) -> str:
    """Integrator and tick length, as far as the manifest tells."""
    parts = []
    if integrator := manifest.get('integrator', '').split():
        parts.append(f'integrator {integrator[0]}')
    if (dt_ns := manifest.get('dt_ns', '')).isdecimal():
        parts.append(f'dt = {int(dt_ns) * 1e-9:g} s')
    return ', '.join(parts)
