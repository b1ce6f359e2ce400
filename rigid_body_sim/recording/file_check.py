# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Compares one MCAP file with itself: what its records are, with what its indexes and its summary
say of them.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from struct import Struct
from typing import BinaryIO

from mcap.records import Attachment, Channel, MessageIndex, Metadata, Schema

from rigid_body_sim.recording import mcap_file, mcap_scan
from rigid_body_sim.recording.mcap_summary import Summary

Entries = dict[int, list[tuple[int, int]]]
Span = tuple[int, int]  # place and length [bytes] of a record with its frame
FRAME_BYTES = 9
_INDEX_HEAD = Struct('<HI')  # of a message index: channel, bytes of its entries
_ENTRY = Struct('<QQ')  # log time, place in the chunk


class Contents:
    """
    What is really in a file, front to back.

    problems : what is wrong with the records themselves, a line each
    crc      : CRC-32 of all message records, one after the other
    """

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.crc = 0
        self.counts: Counter[int] = Counter()
        self.first_time, self.last_time = 0, 0
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.chunks: list[tuple[Span, tuple[int, int], Entries]] = []  # span, times, messages
        self.indexes: list[Entries] = []  # what the records after each chunk say
        self.attachments: list[Span] = []
        self.metadata: list[Span] = []
        self.descents = 0
        self.apart = 0
        self._latest = -1

    def take(self, record: mcap_scan.Record) -> None:
        """Take a record of the data section."""
        opcode = record.opcode
        if opcode == mcap_file.CHUNK:
            self._take_chunk(record)
        elif opcode == mcap_file.MESSAGE_INDEX and self.indexes:
            channel, entries = _message_index(record)
            self.indexes[-1].setdefault(channel, []).extend(entries)
        elif opcode == mcap_file.ATTACHMENT:
            record.parse(Attachment)
            self.attachments.append(_span(record))
        elif opcode == mcap_file.METADATA:
            record.parse(Metadata)
            self.metadata.append(_span(record))
        else:
            if opcode == mcap_file.MESSAGE:
                self.crc = mcap_scan.message_crc(record, self.crc)
            self._take_inner(record)

    def _take_chunk(self, record: mcap_scan.Record) -> None:
        chunk, body = mcap_scan.opened_chunk(record)
        entries: Entries = {}
        records = list(mcap_scan.records_within(body, record))
        self._sum(records, body)
        for part in records:
            message = self._take_inner(part)
            if message is None:
                continue
            entry = (message.log_time, part.position)
            entries.setdefault(message.channel, []).append(entry)
        stated = (chunk.message_start_time, chunk.message_end_time)
        times = [time for each in entries.values() for time, _ in each]
        actual = (min(times), max(times)) if times else stated  # of none any time is right
        if stated != actual:
            self.problems.append(
                f'chunk at byte {record.position}: times {stated} ns, its messages {actual} ns'
            )
        self.chunks.append((_span(record), actual, entries))
        self.indexes.append({})

    def _sum(self, records: list[mcap_scan.Record], body: bytes) -> None:
        """Go on with the CRC of all messages; a body of nothing else is summed at once."""
        if all(record.opcode == mcap_file.MESSAGE for record in records):
            self.crc = zlib.crc32(body, self.crc)
            return
        for record in records:
            if record.opcode == mcap_file.MESSAGE:
                self.crc = mcap_scan.message_crc(record, self.crc)

    def _take_inner(self, record: mcap_scan.Record) -> mcap_scan.Message | None:
        """Take a record that may stand in a chunk or outside; return it if it is a message."""
        if record.opcode == mcap_file.MESSAGE:
            message = mcap_scan.message(record)
            self._count(message)
            return message
        if record.opcode == mcap_file.SCHEMA:
            schema = record.parse(Schema)
            if self.schemas.setdefault(schema.id, schema) != schema:
                self.problems.append(f'schema {schema.id} is declared twice, not alike')
        elif record.opcode == mcap_file.CHANNEL:
            channel = record.parse(Channel)
            if self.channels.setdefault(channel.id, channel) != channel:
                self.problems.append(f'channel {channel.id} is declared twice, not alike')
        return None

    def _count(self, message: mcap_scan.Message) -> None:
        time = message.log_time
        if not self.counts:
            self.first_time = self.last_time = time
        self.first_time, self.last_time = min(self.first_time, time), max(self.last_time, time)
        self.counts[message.channel] += 1
        self.descents += time < self._latest
        self.apart += time != message.publish_time
        self._latest = time


def _message_index(record: mcap_scan.Record) -> tuple[int, list[tuple[int, int]]]:
    """
    Read which messages of a channel stand where in a chunk: at once what the mcap package reads
    number by number. What does not fit it is asked about.
    """
    content = record.content
    size = len(content) - _INDEX_HEAD.size
    if size >= 0:
        channel, stated = _INDEX_HEAD.unpack_from(content)
        if stated == size and size % _ENTRY.size == 0:
            return channel, [*_ENTRY.iter_unpack(content[_INDEX_HEAD.size :])]
    index = record.parse(MessageIndex)
    return index.channel_id, [(time, place) for time, place in index.records]


def read_contents(stream: BinaryIO) -> Contents:
    """Go through the data section; Torn where it cannot be read."""
    contents = Contents()
    try:
        for record in mcap_scan.records(stream):
            if record.opcode == mcap_file.DATA_END:
                break
            contents.take(record)
    except mcap_scan.WrongSum as error:
        contents.problems.insert(0, str(error))
    return contents


def check_file(contents: Contents, summary: Summary) -> Iterator[str]:
    """Name what does not fit together in one file."""
    yield from contents.problems
    yield from _check_declared(contents, summary)
    yield from _check_statistics(contents, summary)
    yield from _check_indexes(contents, summary)
    if contents.descents:
        yield f'log time goes back {contents.descents} times; it must ascend'
    if contents.last_time > mcap_scan.MOST_TIME:
        yield f'log time {contents.last_time} ns; ROS holds at most {mcap_scan.MOST_TIME}'


def _check_declared(contents: Contents, summary: Summary) -> Iterator[str]:
    for number in contents.counts.keys() - contents.channels.keys():
        yield f'{contents.counts[number]} messages of channel {number}, which is not declared'
    for what, declared, stated in (
        ('channels', contents.channels, summary.channels),
        ('schemas', contents.schemas, summary.schemas),
    ):
        if declared != stated:
            yield f'{what} differ from those of the summary: {_unlike(declared, stated)}'
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        if schema is None or not schema.data:
            yield f'{channel.topic}: no message definition; rosbags cannot read the topic'


def _unlike(a: Mapping[int, object], b: Mapping[int, object]) -> str:
    numbers = sorted(n for n in a.keys() | b.keys() if a.get(n) != b.get(n))
    return f'number {", ".join(map(str, numbers[:5]))}{" and others" if len(numbers) > 5 else ""}'


def _check_statistics(contents: Contents, summary: Summary) -> Iterator[str]:
    statistics = summary.statistics
    if statistics is None:
        yield 'the summary has no statistics'
        return
    total = contents.counts.total()
    stated = {
        channel: count for channel, count in statistics.channel_message_counts.items() if count
    }
    if stated != dict(contents.counts) or statistics.message_count != total:
        yield f'statistics count {statistics.message_count} messages, the file holds {total}'
    span = (statistics.message_start_time, statistics.message_end_time)
    actual = (contents.first_time, contents.last_time)
    if total and span != actual:  # of none any time is right
        yield f'statistics span {span} ns, the messages {actual} ns'
    for what, count, found in (
        ('schemas', statistics.schema_count, contents.schemas),
        ('channels', statistics.channel_count, contents.channels),
        ('attachments', statistics.attachment_count, contents.attachments),
        ('metadata records', statistics.metadata_count, contents.metadata),
        ('chunks', statistics.chunk_count, contents.chunks),
    ):
        if count != len(found):
            yield f'statistics count {count} {what}, the file holds {len(found)}'


def _check_indexes(contents: Contents, summary: Summary) -> Iterator[str]:
    for what, stated, found in (
        ('attachment', summary.attachments, contents.attachments),
        ('metadata', summary.metadata, contents.metadata),
    ):
        if sorted((index.offset, index.length) for index in stated) != found:
            yield f'{len(stated)} {what} indexes do not match {len(found)} records'
    spans = sorted(
        (
            (index.chunk_start_offset, index.chunk_length),
            (index.message_start_time, index.message_end_time),
        )
        for index in summary.chunks
    )
    if spans != [(span, times) for span, times, _ in contents.chunks]:
        yield f'{len(spans)} chunk indexes do not match {len(contents.chunks)} chunks'
    for ((place, _), _, entries), index in zip(contents.chunks, contents.indexes):
        if index != entries:
            yield f'chunk at byte {place}: its message index does not match its messages'


def _span(record: mcap_scan.Record) -> Span:
    return record.position, FRAME_BYTES + len(record.content)
