# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads a recording: a bag directory or a lone `.mcap` file, ours or of any other rosbag2 with MCAP
storage.

Messages come in file order, which is the order in which the simulator consumed and produced them,
or, for bags of other recorders, by their log times.
Chunks are checked against their CRC as they are read.
"""

from __future__ import annotations

import os
from bisect import bisect_right
from collections.abc import Collection, Iterable, Iterator
from operator import attrgetter
from pathlib import Path

from mcap.records import Channel, Statistics

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import bag_files, bag_metadata, mcap_file, mcap_scan, mcap_summary
from rigid_body_sim.recording.bag_files import DamagedBag, damaged
from rigid_body_sim.recording.bag_writer import DERIVED_BY, ENDING, MANIFEST
from rigid_body_sim.recording.mcap_summary import Summary
from rigid_body_sim.recording.message_stream import MessageStream
from rigid_body_sim.recording.record_values import RecordValues
from rigid_body_sim.recording.recorded_message import RecordedMessage
from rigid_body_sim.recording.seal import (
    ATTACHMENTS,
    MESSAGES_CRC,
    altered_files,
    is_broken,
    without_checks,
)
from rigid_body_sim.recording.topic_names import own_names, read_names
from rigid_body_sim.recording.topics import Topic

__all__ = ['RECOVERED', 'SUSPECT', 'Bag', 'DamagedBag', 'RecordedMessage']

RECOVERED = 'rigid_body_sim_recovered'  # metadata record of a recovered bag
SUSPECT = 'suspect'  # key in it: what shows that the source was altered, not only cut off
NEVER = 2**64  # [ns] behind every log time
_LOG_TIME = attrgetter('log_time')
_TITLES = {MANIFEST: 'manifest', ENDING: 'ending record', RECOVERED: 'recovery record'}


class Bag:
    """
    One finished recording.

    path        : what was asked for
    files       : its MCAP files in order
    information : inner map of metadata.yaml; None for a lone file
    topics      : name -> Topic, by the names that the run gives them
    wire_names  : of topics that have another name in the file: own -> there
    counts      : name -> number of messages
    first_time, last_time : [ns] log times; 0 where there is no message
    manifest    : what the run was; empty in bags of other recorders
    ending      : how it ended; None when the run was cut off
    attachments : file name -> bytes
    channels    : of all files
    summaries   : what the end of each file says of it
    messages_crc : CRC-32 of all message records as it was recorded; None where it was not
    reordered   : topics that `messages_by_time` has found in another order in the file

    Manifest, ending and attachments are those that were recorded, or opening the bag has failed:
    each carries its own checksum, older bags excepted.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.files, self.information = bag_files.locate(self.path)
        self.summaries: list[Summary] = []
        self.messages_crc: str | None = None
        self._attachments_stated: str | None = None
        self.topics: dict[str, Topic] = {}
        self.wire_names: dict[str, str] = {}
        self._own_names: dict[str, str] = {}
        self.counts: dict[str, int] = {}
        self.attachments: dict[str, bytes] = {}
        self.channels: list[Channel] = []
        self._metadata: dict[str, dict[str, str]] = {}
        self._names: list[dict[int, str]] = []
        self.reordered: set[str] = set()
        times: list[int] = []
        for file in self.files:
            times += self._open(file)
        if altered := altered_files(self._attachments_stated, self.attachments):
            raise RunError(
                f'{self.path}: the attachment {altered[0]} is not the one that was recorded (its '
                'sha256 differs, or it is missing)'
            )
        self.first_time, self.last_time = min(times, default=0), max(times, default=0)

    @property
    def manifest(self) -> dict[str, str]:
        """What the run was, as strings."""
        return self._metadata.get(MANIFEST, {})

    @property
    def holds_run(self) -> bool:
        """Whether it is the recording of a run, and not what was derived from one."""
        return bool(self.manifest) and DERIVED_BY not in self.manifest

    def need_run(self) -> dict[str, str]:
        """Return the manifest of a run; UserError for a bag that does not hold one."""
        if self.holds_run:
            return self.manifest
        what = 'only messages'
        if DERIVED_BY in self.manifest:
            what = f'but what {self.manifest[DERIVED_BY]} derived from '
            what += str(self.manifest.get('source'))
        raise UserError(
            f'{self.path}: holds no run of rigid_body_sim, {what}; replay needs a bag that this '
            'package recorded'
        )

    @property
    def ending(self) -> dict[str, str] | None:
        """How the run ended, as strings; None when it was cut off."""
        return self._metadata.get(ENDING)

    @property
    def complete(self) -> bool:
        """Whether the recording was closed by its own run."""
        return self.ending is not None

    @property
    def recovered(self) -> dict[str, str]:
        """What the recovery said of itself (last_tick, dropped); empty when there was none."""
        return self._metadata.get(RECOVERED, {})

    @property
    def metadata_text(self) -> str | None:
        """What the file itself holds of metadata.yaml; None where nobody wrote it."""
        return self._metadata.get(bag_metadata.RECORD_NAME, {}).get('serialized_metadata')

    def wire_name(self, topic: str) -> str:
        """Name in the file, and on the wire, of a topic."""
        return self.wire_names.get(topic, topic)

    def own_name(self, wire_name: str) -> str:
        """Name that the run gives a topic of the file."""
        return self._own_names.get(wire_name, wire_name)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """Yield the messages of the given topics, all by default, in file order."""
        for place in range(len(self.files)):
            for _, found in self._records(place, topics):
                yield from found

    def messages_by_time(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """
        Yield them in the order of their log times, those of one time in file order.

        MCAP promises no order in the file, and recorders that write in threads keep none. A
        message waits until nothing behind it can be earlier, as the indexes of chunks tell: one
        chunk of them, where the file is in order.
        """
        waiting: list[RecordedMessage] = []
        earliest = NEVER  # of those that wait
        latest: dict[str, int] = {}  # of each topic, so far
        for nothing_before, found in self._groups(topics):
            for message in found:
                if message.log_time < latest.get(message.topic, 0):
                    self.reordered.add(message.topic)
                latest[message.topic] = message.log_time
            waiting += found
            earliest = min(earliest, min(map(_LOG_TIME, found), default=NEVER))
            if earliest > nothing_before:
                continue
            waiting.sort(key=_LOG_TIME)
            end = bisect_right(waiting, nothing_before, key=_LOG_TIME)
            yield from waiting[:end]
            del waiting[:end]
            earliest = waiting[0].log_time if waiting else NEVER

    def _groups(
        self, topics: Collection[str] | None
    ) -> Iterator[tuple[int, list[RecordedMessage]]]:
        """Yield messages of records, and the log time [ns] before which none behind them is."""
        for place, summary in enumerate(self.summaries):
            of_files = (each.statistics for each in self.summaries[place + 1 :])
            later = min(
                (each.message_start_time for each in of_files if each and each.message_count),
                default=NEVER,
            )
            offsets, least = _least_behind(summary, later)
            in_chunks = True  # of what stands outside no index tells
            for record, messages in self._records(place, topics):
                in_chunks &= record.opcode == mcap_file.CHUNK
                found = list(messages)
                yield least[bisect_right(offsets, record.position)] if in_chunks else -1, found
            yield later, []

    def _records(
        self, place: int, topics: Collection[str] | None
    ) -> Iterator[tuple[mcap_scan.Record, Iterator[RecordedMessage]]]:
        """Yield the records of a file that hold messages, and those of the given topics."""
        file, names = self.files[place], self._names[place]
        wanted = {
            channel: name for channel, name in names.items() if topics is None or name in topics
        }
        with file.open('rb') as stream:
            try:
                for record in mcap_scan.records(stream, message_indexes=False):
                    if record.opcode == mcap_file.DATA_END:
                        return
                    if record.opcode in (mcap_file.CHUNK, mcap_file.MESSAGE):
                        yield record, _messages(file, record, wanted, names)
            except mcap_scan.Torn as error:
                raise damaged(file, error) from error

    @property
    def recorded_topics(self) -> Collection[str]:
        """Names of the topics that the files themselves hold."""
        return self.topics

    def names_in_files(self) -> Iterator[tuple[Path, dict[int, str]]]:
        """Yield each file with the topic of each of its channels."""
        return zip(self.files, self._names, strict=True)

    def stream(self) -> MessageStream:
        """Read all messages, in file order, from the first on."""
        return MessageStream(self.files, self._names, damaged)

    def _open(self, file: Path) -> tuple[int, ...]:
        try:
            with file.open('rb') as stream:
                bag_files.check_ends(file, stream)
                summary = mcap_summary.read_summary(stream)
                if summary.statistics is None:
                    raise damaged(file, 'no summary, or one without statistics')
                for index in summary.metadata:
                    record = mcap_summary.metadata_at(stream, index)
                    self._keep(file, record.name, record.metadata)
                for index in summary.attachments:
                    attachment = mcap_summary.attachment_at(stream, index)
                    self.attachments[attachment.name] = attachment.data
        except OSError as error:
            raise UserError(f'{file}: cannot be read ({error.strerror})') from error
        except mcap_scan.Torn as error:
            raise damaged(file, error) from error
        self.summaries.append(summary)
        return self._take(file, summary, summary.statistics)

    def _keep(self, file: Path, name: str, content: dict[str, str]) -> None:
        if name in _TITLES:
            if is_broken(content):
                raise damaged(file, f'the {_TITLES[name]} does not match its checksum')
            if name in self._metadata:
                raise damaged(file, f'it has two records of the kind {_TITLES[name]}')
            self.messages_crc = content.get(MESSAGES_CRC, self.messages_crc)
            self._attachments_stated = content.get(ATTACHMENTS, self._attachments_stated)
        self._metadata[name] = without_checks(content)

    def _take(self, file: Path, summary: Summary, statistics: Statistics) -> tuple[int, ...]:
        counts = statistics.channel_message_counts
        self.wire_names = read_names(RecordValues(self.path, 'manifest', self.manifest))
        self._own_names = own_names(self.wire_names)
        names = {n: self.own_name(channel.topic) for n, channel in summary.channels.items()}
        if len(set(names.values())) < len({c.topic for c in summary.channels.values()}):
            raise damaged(file, 'two topics have one name in its manifest')
        for number, channel in summary.channels.items():
            schema = summary.schemas.get(channel.schema_id)
            topic = Topic(names[number], schema.name if schema else '')
            if self.topics.setdefault(topic.name, topic) != topic:
                raise UserError(f'{file}: topic {topic.name} has two types')
            self.counts[topic.name] = self.counts.get(topic.name, 0) + counts.get(number, 0)
        self.channels += summary.channels.values()
        self._names.append(names)
        if statistics.message_count == 0:
            return ()
        return statistics.message_start_time, statistics.message_end_time


def _messages(
    file: Path, record: mcap_scan.Record, wanted: dict[int, str], known: Collection[int]
) -> Iterator[RecordedMessage]:
    found: Iterable[mcap_scan.Message]
    try:
        if record.opcode == mcap_file.CHUNK:
            found = mcap_scan.chunk_messages(record, wanted, known)
        else:
            found = (mcap_scan.message(record),)
        for channel, sequence, log_time, publish_time, data in found:
            if channel in wanted:
                yield RecordedMessage(wanted[channel], sequence, log_time, data, publish_time)
            elif channel not in known:
                problem = f'message of the unknown channel {channel}'
                raise mcap_scan.Torn(record.position, problem)
    except mcap_scan.Torn as error:
        raise damaged(file, error) from error


def _least_behind(summary: Summary, later: int) -> tuple[list[int], list[int]]:
    """
    Places of the chunks of a file, and before which log time [ns] nothing is from each of them on.

    later : the same of what follows the file: the last
    """
    chunks = sorted(summary.chunks, key=lambda index: index.chunk_start_offset)
    least = [later]
    for index in reversed(chunks):
        least.append(min(least[-1], index.message_start_time))
    return [index.chunk_start_offset for index in chunks], least[::-1]
