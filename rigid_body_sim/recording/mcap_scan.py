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
from collections.abc import Collection, Iterator
from io import BytesIO
from struct import Struct, unpack_from
from typing import BinaryIO, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Attachment, Chunk, DataEnd, McapRecord

from rigid_body_sim.recording import mcap_file

MOST_BYTES = (
    1 << 30
)  # [bytes] of a record or of an unpacked chunk; writers close chunks at some MiB
SMALL_CHUNK = 1 << 24  # [bytes] below it a chunk may be packed as tightly as it will
MOST_PACKED = 1000  # times; doubles shrink two to ten times, a bomb some thousand times
MOST_TIME = 2**63 - 1  # [ns] the largest that ROS and rosbag2 can hold

_FRAME = Struct('<BQ')
_MESSAGE = Struct('<HIQQ')
_CHANNEL = Struct('<BQH')  # the frame of a message record, and its channel
RUN_OF_INDEXES = 1 << 16  # [bytes] of message indexes that are stepped over at once
_WINDOW = 1 << 27  # [bytes] of memory that a zstd frame may ask for

R = TypeVar('R', bound=McapRecord)


class Torn(Exception):
    """The file is whole up to `position` [bytes] only."""

    def __init__(self, position: int, problem: str) -> None:
        super().__init__(f'at byte {position}: {problem}')
        self.position = position


class Altered(Torn):
    """
    Records that are not torn and cannot be: within a chunk that matches its CRC, or at a time that
    no writer gives. A cut leaves no such thing, so nothing near it is to be believed.
    """


class WrongSum(Torn):
    """All records before `position` can be read, but some byte of them is not what was written."""


class _WholeReads(ReadDataStream):
    """A stream that does not give less than was asked for."""

    def read(self, length: int) -> bytes:
        content = super().read(length)
        if len(content) < length:
            raise EndOfFile
        return content


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
            return kind.read(_WholeReads(BytesIO(content)))  # type: ignore[attr-defined]
        except (McapError, struct.error, ValueError, OverflowError) as error:
            problem = str(error) or 'it ends too soon'
            raise Torn(self.position, f'unreadable {kind.__name__}: {problem}') from error


class Message(NamedTuple):
    """One message record; times in ns."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


def records(stream: BinaryIO, *, message_indexes: bool = True) -> Iterator[Record]:
    """
    Yield every record of the file up to its footer; Torn where the good part ends.

    message_indexes : whether to yield those too: a file has one for each channel of each chunk
                      (they count in the CRC all the same)

    WrongSum in place of the data end, if the bytes before it do not match the CRC that it states.
    """
    size = stream.seek(0, 2)
    stream.seek(0)
    if stream.read(len(mcap_file.MAGIC)) != mcap_file.MAGIC:
        raise Torn(0, 'the file does not start as an MCAP file')
    position, crc = len(mcap_file.MAGIC), zlib.crc32(mcap_file.MAGIC)
    while True:
        frame = stream.read(_FRAME.size)
        if len(frame) < _FRAME.size:
            raise Torn(position, 'the file ends without a footer')
        opcode, length = _FRAME.unpack(frame)
        if opcode == mcap_file.MESSAGE_INDEX and not message_indexes:
            run = frame + stream.read(RUN_OF_INDEXES)
            end = end_of_indexes(run)
            stream.seek(position + max(end, _FRAME.size))
            if end:
                crc = zlib.crc32(run[:end], crc)
                position += end
                continue
        if opcode == 0 or position + _FRAME.size + length > size:
            raise Torn(position, f'record with opcode {opcode} and {length} bytes is not whole')
        if length > MOST_BYTES:
            raise Torn(position, f'record of {length} bytes; read are at most {MOST_BYTES}')
        record = Record(opcode, position, stream.read(length))
        if opcode == mcap_file.DATA_END:
            _check_data(record, crc)
        yield record
        crc = zlib.crc32(record.content, zlib.crc32(frame, crc))
        position += _FRAME.size + length
        if opcode == mcap_file.FOOTER:
            if stream.read(len(mcap_file.MAGIC)) != mcap_file.MAGIC:
                raise Torn(position, 'the end mark is missing')
            return


def end_of_indexes(run: bytes) -> int:
    """Tell where the last whole message index ends of those that bytes begin with."""
    end, last = 0, len(run) - _FRAME.size
    while end <= last:
        opcode, length = _FRAME.unpack_from(run, end)
        if opcode != mcap_file.MESSAGE_INDEX or end + length > last:
            break
        end += _FRAME.size + length
    return end


def opened_chunk(record: Record) -> tuple[Chunk, bytes]:
    """Return a chunk and its uncompressed records, their CRC checked."""
    chunk = record.parse(Chunk)
    size, packed = chunk.uncompressed_size, len(chunk.data)
    if size > min(MOST_BYTES, max(SMALL_CHUNK, MOST_PACKED * packed)):
        raise Torn(record.position, f'chunk of {packed} bytes claims to hold {size}')
    try:
        body = _unpacked(chunk)
    except Exception as error:  # each compressor has errors of its own
        raise Torn(record.position, f'chunk cannot be decompressed: {error}') from error
    if len(body) != size:
        raise Torn(record.position, f'chunk does not have the {size} bytes that it claims')
    _check_crc(body, chunk.uncompressed_crc, record)
    return chunk, body


def _unpacked(chunk: Chunk) -> bytes:
    """Return what a chunk holds, and of a longer one a byte more than it claims."""
    most = chunk.uncompressed_size + 1
    if chunk.compression == '':
        return chunk.data
    if chunk.compression == 'zstd':
        import zstandard

        unpacker = zstandard.ZstdDecompressor(max_window_size=_WINDOW)
        return unpacker.stream_reader(chunk.data).read(most)
    if chunk.compression == 'lz4':
        import lz4.frame

        return lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=most)
    raise ValueError(f'compression {chunk.compression!r} is unknown')


def inner_records(record: Record) -> Iterator[Record]:
    """Yield the records in a chunk; their positions are offsets in its uncompressed body."""
    return records_within(opened_chunk(record)[1], record)


def records_within(body: bytes, record: Record) -> Iterator[Record]:
    """Yield the records in the uncompressed body of a chunk."""
    position, size = 0, len(body)
    while position < size:
        opcode, start, position = _inner_frame(body, position, record)
        yield Record(opcode, start - _FRAME.size, body[start:position])


def _inner_frame(body: bytes, position: int, chunk: Record) -> tuple[int, int, int]:
    """Opcode, start and end of the content of the record at a place in a chunk."""
    start = position + _FRAME.size
    if start > len(body):
        raise Altered(chunk.position, 'chunk ends within a record')
    opcode, length = _FRAME.unpack_from(body, position)
    if opcode == 0:  # what zeros would be: nine bytes each, and no end of them
        raise Altered(chunk.position, 'chunk holds a record with opcode 0')
    if start + length > len(body):
        raise Altered(chunk.position, 'chunk ends within a record')
    return opcode, start, start + length


def chunk_messages(
    record: Record, wanted: Collection[int], known: Collection[int]
) -> Iterator[Message]:
    """
    Yield the messages of wanted channels in a chunk; the others are only stepped over. Torn for
    one of a channel that is not known.
    """
    body = opened_chunk(record)[1]
    position, size = 0, len(body)
    while position < size:
        if position + _CHANNEL.size <= size:  # a record of a channel that nobody wants
            opcode, length, channel = _CHANNEL.unpack_from(body, position)
            if opcode == mcap_file.MESSAGE and channel not in wanted:
                position += _FRAME.size + length
                if length < _MESSAGE.size:
                    raise Altered(record.position, 'message record is too short')
                if position > size:
                    raise Altered(record.position, 'chunk ends within a record')
                if channel not in known:
                    raise Altered(record.position, f'message of the unknown channel {channel}')
                continue
        found, position = message_at(body, position, record)
        if found is not None:
            yield found


def message_at(body: bytes, position: int, chunk: Record) -> tuple[Message | None, int]:
    """
    Read the record at a place in a chunk; return its message, or None if it is none, and its end.
    """
    opcode, start, end = _inner_frame(body, position, chunk)
    if opcode != mcap_file.MESSAGE:
        return None, end
    if end - start < _MESSAGE.size:
        raise Altered(chunk.position, 'message record is too short')
    channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(body, start)
    data = body[start + _MESSAGE.size : end]
    return Message(channel, sequence, log_time, publish_time, data), end


def framed(record: Record) -> bytes:
    """Give the bytes of a record."""
    return _FRAME.pack(record.opcode, len(record.content)) + record.content


def message(record: Record) -> Message:
    """Read a message record; Altered where it cannot be one."""
    if len(record.content) < _MESSAGE.size:
        raise Altered(record.position, 'message record is too short')
    channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(record.content)
    data = record.content[_MESSAGE.size :]
    return Message(channel, sequence, log_time, publish_time, data)


def message_crc(record: Record, crc: int) -> int:
    """Go on with a CRC-32 over the bytes of a record."""
    frame = _FRAME.pack(record.opcode, len(record.content))
    return zlib.crc32(record.content, zlib.crc32(frame, crc))


def _check_data(record: Record, actual: int) -> None:
    """Compare the CRC of all bytes before the data end; 0 means that the writer gave none."""
    expected = record.parse(DataEnd).data_section_crc
    if expected and actual != expected:
        raise WrongSum(
            record.position,
            f'the data section has the CRC {actual:#010x}, its end says {expected:#010x}',
        )


def _check_crc(content: bytes, expected: int, record: Record) -> None:
    """Compare a CRC; 0 means that the writer gave none."""
    actual = zlib.crc32(content)
    if expected and actual != expected:
        raise Torn(record.position, f'CRC is {actual:#010x}, expected {expected:#010x}')
