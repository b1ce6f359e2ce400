# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads the summary at the end of an MCAP file, and single records at the places that it names.

Nothing is believed before it is looked at: places and lengths are compared with the size of the
file, the summary with its CRC. What does not fit is `Torn`.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from struct import Struct
from typing import BinaryIO

from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

from rigid_body_sim.recording import mcap_file
from rigid_body_sim.recording.mcap_scan import MOST_BYTES, Record, Torn

_FRAME = Struct('<BQ')
# of the index of a chunk: times, place, length and how many bytes of offsets follow; an offset;
# how long the message indexes are, and the name of the compression; sizes
_CHUNK_HEAD, _OFFSET = Struct('<QQQQI'), Struct('<HQ')
_CHUNK_NAME, _CHUNK_SIZES = Struct('<QI'), Struct('<QQ')
_FOOTER_BYTES = 20
_TAIL = _FRAME.size + _FOOTER_BYTES + len(mcap_file.MAGIC)  # footer and end mark
_CRC_BYTES = 4


@dataclass
class Summary:
    """
    What the summary says is in the file.

    start       : [bytes] where it begins
    schemas     : id -> Schema
    channels    : id -> Channel
    chunks, metadata, attachments : their indexes, in file order
    statistics  : None where it has none
    has_crc     : whether a CRC protects it
    """

    start: int
    has_crc: bool
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    statistics: Statistics | None = None


def read_summary(stream: BinaryIO) -> Summary:
    """Read the summary of a file that has both of its marks; Torn if it has no good one."""
    size = stream.seek(0, 2)
    place = size - _TAIL
    if place < len(mcap_file.MAGIC):
        raise Torn(0, 'the file is too short to hold anything')
    tail = _read(stream, place, _TAIL)
    opcode, length = _FRAME.unpack_from(tail)
    if (opcode, length) != (mcap_file.FOOTER, _FOOTER_BYTES):
        raise Torn(place, 'the footer is missing')
    content = tail[_FRAME.size : _FRAME.size + _FOOTER_BYTES]
    footer = Record(opcode, place, content).parse(Footer)
    start = footer.summary_start
    if not 0 < start <= place:
        raise Torn(place, 'the file has no summary')
    body = _read(stream, start, place - start)
    covered = body + tail[: _FRAME.size + _FOOTER_BYTES - _CRC_BYTES]
    if footer.summary_crc and zlib.crc32(covered) != footer.summary_crc:
        raise Torn(start, 'the summary does not match its CRC')
    summary = Summary(start, bool(footer.summary_crc))
    for record in _records(body, start):
        _take(summary, record)
    return summary


def metadata_at(stream: BinaryIO, index: MetadataIndex) -> Metadata:
    """Read a named map of strings."""
    return _record_at(stream, mcap_file.METADATA, index.offset, index.length).parse(Metadata)


def attachment_at(stream: BinaryIO, index: AttachmentIndex) -> Attachment:
    """Read a named file, its CRC checked."""
    return _record_at(stream, mcap_file.ATTACHMENT, index.offset, index.length).parse(Attachment)


def _take(summary: Summary, record: Record) -> None:
    if record.opcode == mcap_file.SCHEMA:
        schema = record.parse(Schema)
        summary.schemas[schema.id] = schema
    elif record.opcode == mcap_file.CHANNEL:
        channel = record.parse(Channel)
        summary.channels[channel.id] = channel
    elif record.opcode == mcap_file.STATISTICS:
        summary.statistics = record.parse(Statistics)
    elif record.opcode == mcap_file.CHUNK_INDEX:
        summary.chunks.append(_chunk_index(record))
    elif record.opcode == mcap_file.METADATA_INDEX:
        summary.metadata.append(record.parse(MetadataIndex))
    elif record.opcode == mcap_file.ATTACHMENT_INDEX:
        summary.attachments.append(record.parse(AttachmentIndex))


def _chunk_index(record: Record) -> ChunkIndex:
    """
    Read the index of a chunk: what the mcap package reads number by number, of thousands of
    channels in each chunk, at once. What does not fit it is asked about.
    """
    content = record.content
    try:
        first, last, start, length, size = _CHUNK_HEAD.unpack_from(content)
        begin = _CHUNK_HEAD.size
        offsets = dict(_OFFSET.iter_unpack(content[begin : begin + size]))
        index_length, letters = _CHUNK_NAME.unpack_from(content, begin + size)
        begin += size + _CHUNK_NAME.size
        compression = content[begin : begin + letters].decode()
        packed, unpacked = _CHUNK_SIZES.unpack_from(content, begin + letters)
    except (struct.error, ValueError):
        return record.parse(ChunkIndex)
    return ChunkIndex(
        chunk_length=length,
        chunk_start_offset=start,
        compression=compression,
        compressed_size=packed,
        message_end_time=last,
        message_index_length=index_length,
        message_index_offsets=offsets,
        message_start_time=first,
        uncompressed_size=unpacked,
    )


def _records(body: bytes, start: int) -> list[Record]:
    found, place = [], 0
    while place < len(body):
        if place + _FRAME.size > len(body):
            raise Torn(start + place, 'the summary ends within a record')
        opcode, length = _FRAME.unpack_from(body, place)
        begin = place + _FRAME.size
        if opcode == 0 or begin + length > len(body):
            raise Torn(start + place, f'record with opcode {opcode} and {length} bytes')
        found.append(Record(opcode, start + place, body[begin : begin + length]))
        place = begin + length
    return found


def _record_at(stream: BinaryIO, opcode: int, place: int, length: int) -> Record:
    """Read the record of which an index says that it is there, `length` bytes with its frame."""
    size = stream.seek(0, 2)
    if length < _FRAME.size or place + length > size:
        raise Torn(place, f'an index names {length} bytes, the file has {size} in all')
    content = _read(stream, place, length)
    if _FRAME.unpack_from(content) != (opcode, length - _FRAME.size):
        raise Torn(place, 'an index names a record that is not there')
    return Record(opcode, place, content[_FRAME.size :])


def _read(stream: BinaryIO, place: int, length: int) -> bytes:
    if length > MOST_BYTES:
        raise Torn(place, f'{length} bytes; read are at most {MOST_BYTES}')
    stream.seek(place)
    return stream.read(length)
