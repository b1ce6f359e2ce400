# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads the records of an MCAP file front to back, also of a torn one.

It needs no index and no summary, and says where the good part ends: `Torn` carries the position of
the first record that is not whole. Chunks are checked against their CRC before anything in them is
believed.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from io import BytesIO
from struct import Struct, unpack_from
from typing import BinaryIO, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Attachment, Chunk, McapRecord
from mcap.stream_reader import get_chunk_data_stream

from rigid_body_sim.recording import mcap_file

_FRAME = Struct('<BQ')
_MESSAGE = Struct('<HIQQ')
_COMPRESSIONS = ('', 'lz4', 'zstd')

R = TypeVar('R', bound=McapRecord)


class Torn(Exception):
    """The file is whole up to `position` [bytes] only."""

    def __init__(self, position: int, problem: str) -> None:
        super().__init__(f'at byte {position}: {problem}')
        self.position = position


class Record(NamedTuple):
    """One record: opcode, place in the file [bytes], content."""

    opcode: int
    position: int
    content: bytes

    def parse(self, kind: type[R]) -> R:
        """Read the content as a record of the mcap package; an attachment's CRC is checked."""
        content = self.content
        if kind is Attachment and len(content) >= 4:
            _check_crc(content[:-4], unpack_from('<I', content, len(content) - 4)[0], self)
        try:
            return kind.read(ReadDataStream(BytesIO(content)))  # type: ignore[attr-defined]
        except (McapError, struct.error, ValueError) as error:
            raise Torn(self.position, f'unreadable {kind.__name__}: {error}') from error


class Message(NamedTuple):
    """One message record; times in ns."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


def records(stream: BinaryIO) -> Iterator[Record]:
    """Yield every record of the file up to its footer; Torn where the good part ends."""
    size = stream.seek(0, 2)
    stream.seek(0)
    if stream.read(len(mcap_file.MAGIC)) != mcap_file.MAGIC:
        raise Torn(0, 'the file does not start as an MCAP file')
    position = len(mcap_file.MAGIC)
    while True:
        frame = stream.read(_FRAME.size)
        if len(frame) < _FRAME.size:
            raise Torn(position, 'the file ends without a footer')
        opcode, length = _FRAME.unpack(frame)
        if opcode == 0 or position + _FRAME.size + length > size:
            raise Torn(position, f'record with opcode {opcode} and {length} bytes is not whole')
        yield Record(opcode, position, stream.read(length))
        position += _FRAME.size + length
        if opcode == mcap_file.FOOTER:
            if stream.read(len(mcap_file.MAGIC)) != mcap_file.MAGIC:
                raise Torn(position, 'the end mark is missing')
            return


def chunk_body(record: Record) -> bytes:
    """Return the uncompressed records of a chunk, its CRC checked."""
    chunk = record.parse(Chunk)
    if chunk.compression not in _COMPRESSIONS:
        raise Torn(record.position, f'chunk compression {chunk.compression!r} is unknown')
    try:
        stream, size = get_chunk_data_stream(chunk)
        body = stream.read(size)
    except Exception as error:  # each compressor has errors of its own
        raise Torn(record.position, f'chunk cannot be decompressed: {error}') from error
    if len(body) != chunk.uncompressed_size:
        raise Torn(record.position, f'chunk has {len(body)} bytes, not {chunk.uncompressed_size}')
    _check_crc(body, chunk.uncompressed_crc, record)
    return body


def inner_records(record: Record) -> Iterator[Record]:
    """Yield the records in a chunk; their positions are offsets in its uncompressed body."""
    body = chunk_body(record)
    position, size = 0, len(body)
    while position < size:
        try:
            opcode, length = _FRAME.unpack_from(body, position)
        except struct.error as error:
            raise Torn(record.position, 'chunk ends within a record') from error
        start, stop = position + _FRAME.size, position + _FRAME.size + length
        if stop > size:
            raise Torn(record.position, 'chunk ends within a record')
        yield Record(opcode, position, body[start:stop])
        position = stop


def chunk_messages(record: Record) -> Iterator[Message]:
    """Yield the messages of a chunk: `inner_records` and `message` in one loop, for speed."""
    body = chunk_body(record)
    position, size = 0, len(body)
    try:
        while position < size:
            opcode, length = _FRAME.unpack_from(body, position)
            start = position + _FRAME.size
            position = start + length
            if position > size:
                raise Torn(record.position, 'chunk ends within a record')
            if opcode == mcap_file.MESSAGE:
                channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body, start)
                data = body[start + _MESSAGE.size : position]
                yield Message(channel, sequence, log_time, publish_time, data)
    except struct.error as error:
        raise Torn(record.position, 'chunk ends within a record') from error


def message(record: Record) -> Message:
    """Read a message record."""
    try:
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(record.content)
    except struct.error as error:
        raise Torn(record.position, 'message record is too short') from error
    data = record.content[_MESSAGE.size :]
    return Message(channel, sequence, log_time, publish_time, data)


def _check_crc(content: bytes, expected: int, record: Record) -> None:
    """Compare a CRC; 0 means that the writer gave none."""
    actual = zlib.crc32(content)
    if expected and actual != expected:
        raise Torn(record.position, f'CRC is {actual:#010x}, expected {expected:#010x}')
