# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Writes a recorded run: a rosbag2 bag directory with one MCAP file.

The manifest and the attachments come first and reach the file at once, so that a killed run still
tells what it was; then the messages in the order they are handed in; at the end the ending record,
the summary, and `metadata.yaml`. A directory without `metadata.yaml` is an unfinished recording:
`bag recover` restores it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import bag_directory
from rigid_body_sim.recording.bag_metadata import TopicSummary
from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_HEAD_SIZE,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.chunk import join
from rigid_body_sim.recording.chunk_queue import DirectQueue, Queue, ThreadedQueue
from rigid_body_sim.recording.definitions import HASHES, definition
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.recording.seal import ATTACHMENTS, sealed, sha256_of
from rigid_body_sim.recording.topics import Topic, qos_text

MANIFEST = 'rigid_body_sim'
DERIVED_BY = 'derived_by'  # key of a manifest: the verb, where no run is recorded
ENDING = 'rigid_body_sim_end'
_MAX_CHANNELS = 65535  # channel ids are 16 bits, from 1
_SHOWN_BY_ROSBAG2 = ('schema_version', 'dt_ns', 'integrator')
_MEDIA_TYPES = {'.yaml': 'application/yaml', '.csv': 'text/csv', '.stl': 'model/stl'}


class RecordingGone(RunError):
    """The file that is written to does not stand any more where it was made."""


class BagWriter:
    """
    One recording.

    topics      : topics[i] gets channel id i + 1, which the packers' batches must agree with
    on_demand   : topics that get the next ids, each when its first message comes: a reader is not
                  shown what nobody used
    manifest    : what the run is, as strings; SHA-256 of the attachments and of itself are added
    attachments : file name -> bytes; the scene and what it names
    names       : of topics that have another name in the file: own -> there
    background  : False: chunks are closed by bytes, in the caller's thread; equal runs give equal
                  files. True: a worker thread writes them, half a second (wall) later at most
    """

    def __init__(
        self,
        directory: str | os.PathLike[str],
        *,
        topics: Sequence[Topic],
        manifest: Mapping[str, str],
        attachments: Mapping[str, bytes],
        background: bool = False,
        on_demand: Sequence[Topic] = (),
        names: Mapping[str, str] | None = None,
    ) -> None:
        if len(topics) > _MAX_CHANNELS:
            raise UserError(
                f'{directory}: {len(topics)} topics; a recording holds at most {_MAX_CHANNELS}; '
                'record fewer bodies'
            )
        self.path = Path(directory)
        self._topics = tuple(topics)
        self._names = names or {}
        self._channels = {topic.name: number for number, topic in enumerate(topics, start=1)}
        self._on_demand = {topic.name: topic for topic in on_demand}
        self._schemas: dict[str, int] = {}
        self._declared = 0  # topics that are in the file
        self._custom = {
            f'{MANIFEST}.{key}': manifest[key] for key in _SHOWN_BY_ROSBAG2 if key in manifest
        }
        self._message_layouts: dict[tuple[str, int], TickLayout] = {}
        self._checked: list[tuple[Topic, ...]] = []
        self._safe_tick = 0
        self._is_derived = DERIVED_BY in manifest
        self._failure: RunError | None = None
        self._closed = False
        self._stream = bag_directory.open_file(bag_directory.create(self.path))
        try:
            version = manifest.get('package_version', '')
            self._file = McapFile(self._stream, library=f'rigid_body_sim {version}'.rstrip())
            self._declare_topics(len(self._topics))
            stated = {**manifest, ATTACHMENTS: sha256_of(attachments)}
            self._file.write_metadata(MANIFEST, sealed(stated))
            for name, content in attachments.items():
                media_type = _MEDIA_TYPES.get(Path(name).suffix, 'application/octet-stream')
                self._file.write_attachment(name, media_type, content)
        except OSError as error:
            raise self._not_begun(error) from error
        self._queue: Queue = (ThreadedQueue if background else DirectQueue)(self._write_chunk)

    def begin(self, batches: Iterable[Batch]) -> None:
        """
        Record the states where a run begins, and hand them to the operating system. RunError where
        they cannot be written; nothing is left of the bag then.
        """
        try:
            for batch in batches:
                self.write(batch)
            self.flush()
        except RunError as failure:
            with suppress(RunError):
                self.break_off()
            if not isinstance(failure.__cause__, OSError):
                raise
            raise self._not_begun(failure.__cause__) from failure.__cause__

    def write(self, batch: Batch) -> None:
        """Record a batch. RunError if an earlier one could not be written."""
        self._raise_failure()
        topics = batch.layout.topics
        if not any(topics is known for known in self._checked):
            self._check(batch.layout)
        self._queue.put(batch)

    def write_message(self, topic: str, sequence: int, time_ns: int, payload: bytes) -> None:
        """
        Record one message between batches: a command that took effect at the start of tick
        `sequence`.

        payload : CDR bytes; log time and publish time are time_ns
        """
        layout = self._message_layouts.get((topic, len(payload)))
        if layout is None:
            self._number(topic)
            layout = self._lay_out_message(topic, len(payload))
        head = MESSAGE_HEAD.pack(
            MESSAGE_OPCODE,
            MESSAGE_LENGTH_EXTRA + len(payload),
            self._channels[topic],
            sequence,
            time_ns,
            time_ns,
        )
        self._queue.put(Batch(layout, head + payload, (time_ns,), None))

    def flush(self) -> None:
        """Hand everything recorded so far to the operating system."""
        self._queue.flush()

    def close(self, ending: Mapping[str, str], last: Iterable[Batch] = ()) -> None:
        """
        Finish the bag; a second call does nothing.

        last   : what is still to be recorded
        ending : how the run ended, as strings; the only place for wall-clock values; checksums of
                 the messages and of itself are added
        """
        if self._closed:
            return
        self._closed = True
        try:
            try:
                for batch in last:
                    self.write(batch)
            finally:
                self._queue.stop()
            self._raise_failure()
            self._look_after_it()
            self._file.write_metadata(ENDING, sealed({**ending, **self._file.checksums()}))
            bag_directory.finish(
                self.path, self._file, self._stream, topics=self._summaries(), custom=self._custom
            )
        except OSError as error:
            raise self._failed(error) from error
        finally:
            self._stream.close()

    def break_off(self) -> None:
        """
        Write what was handed in and leave the bag without an ending, as a killed run does: `bag
        recover` restores it.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._queue.stop()
            self._raise_failure()
            self._look_after_it()
        finally:
            self._stream.close()

    def _number(self, topic: str) -> None:
        """Give a topic the next channel id, if it has none."""
        if topic in self._channels:
            return
        if len(self._topics) == _MAX_CHANNELS:
            raise RunError(
                f'{self.path}: messages on more than {_MAX_CHANNELS} topics; a recording holds no '
                'more; record fewer bodies, or command fewer of them'
            )
        self._topics = (*self._topics, self._on_demand[topic])  # before a batch with it waits
        self._channels[topic] = len(self._topics)

    def _declare_topics(self, count: int) -> None:
        """Write schemas and channels until so many topics are in the file."""
        qos, schemas = qos_text(), self._schemas
        for name, kind in self._topics[self._declared : count]:
            if kind not in schemas:
                schemas[kind] = self._file.add_schema(kind, 'ros2msg', definition(kind).encode())
            metadata = {'offered_qos_profiles': qos, 'topic_type_hash': HASHES[kind]}
            self._file.add_channel(schemas[kind], self._names.get(name, name), 'cdr', metadata)
            self._declared += 1

    def _summaries(self) -> list[TopicSummary]:
        return [
            TopicSummary(
                self._names.get(name, name),
                kind,
                'cdr',
                qos_text(),
                HASHES[kind],
                self._file.count(self._channels[name]),
            )
            for name, kind in self._topics[: self._declared]
        ]

    def _check(self, layout: TickLayout) -> None:
        start = layout.first_channel_id - 1
        if self._topics[start : start + len(layout.topics)] != layout.topics:
            raise ValueError(
                f'{self.path}: channel {layout.first_channel_id} of the batch is '
                f'{layout.topics[0].name}, which is not what the recording was opened with'
            )
        self._checked.append(layout.topics)

    def _lay_out_message(self, topic: str, size: int) -> TickLayout:
        layout = TickLayout.of_records(
            self._topics,
            1,
            channels=[self._channels[topic]],
            sizes=[MESSAGE_HEAD_SIZE + size],
            time_offsets=[0],
        )
        self._message_layouts[topic, size] = layout
        return layout

    def _write_chunk(self, batches: Sequence[Batch]) -> None:
        self._raise_failure()
        self._look_after_it()
        try:
            chunk = join(batches)
            self._declare_topics(int(chunk.channels.max()))
            self._file.write_chunk(chunk)
        except OSError as error:
            raise self._failed(error) from error
        self._safe_tick = max((batch.tick or 0 for batch in batches), default=0) or self._safe_tick

    def _raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _look_after_it(self) -> None:
        """Fail where somebody removed or moved the file: nobody would find what is written."""
        where = bag_directory.where_it_went(self._stream)
        if where is not None:
            self._failure = self._gone(where)
            raise self._failure

    def _gone(self, where: Path) -> RecordingGone:
        said = f'{self.path}: the file of this recording was'
        if where == bag_directory.NOWHERE:
            return RecordingGone(
                f'{said} removed while it was written, and what was recorded is lost; begin '
                'again, and leave its folder alone'
            )
        told = 'nothing in it is of use; begin again'
        if self._safe_tick and not self._is_derived:
            told = (
                f'ticks up to {self._safe_tick} are safe there; restore them with: bag recover '
                f'{where} -o NEW'
            )
        return RecordingGone(f'{said} moved to {where} while it was written; {told}')

    def _not_begun(self, error: OSError) -> RunError:
        """Take away what was begun, so that its path is free again."""
        self._stream.close()
        with suppress(OSError):
            bag_directory.remove(self.path)
        return RunError(
            f'{self.path}: no bag could be begun there ({error.strerror}), and nothing is '
            'recorded; make room, or choose another place, and begin again'
        )

    def _failed(self, error: OSError) -> RunError:
        where = bag_directory.where_it_went(self._stream)
        if where is not None:
            self._failure = self._gone(where)
            return self._failure
        told = 'nothing in it is of use; make room, remove it, and begin again'
        if self._safe_tick and not self._is_derived:
            told = (
                f'ticks up to {self._safe_tick} are safe; '
                f'make room, then restore them with: bag recover {self.path} -o NEW'
            )
        self._failure = RunError(f'{self.path}: writing failed ({error.strerror}); {told}')
        return self._failure
