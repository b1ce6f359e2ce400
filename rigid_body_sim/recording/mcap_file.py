# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The framing of an MCAP file: records in order, chunks with indexes, and the summary at its end.

Every record is opcode (1 byte), length (8 bytes), content; integers are little endian, a string is
its length (4 bytes) and UTF-8, a map is its length and its pairs. Order in the file: magic,
header, schemas and channels, metadata and attachments, chunks each followed by its message
indexes, data end, summary, footer, magic.

Everything is under a CRC-32: each chunk, each attachment, the summary, and by a running one, told
in the data end, every byte before that.

Source: the MCAP format specification, version 0 (https://mcap.dev/spec). No compression: doubles
of a moving body hardly compress, and the writer stays faster than the disk.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from contextlib import suppress
from io import FileIO
from struct import pack

import numpy as np

from rigid_body_sim.recording.chunk import Chunk, message_indexes
from rigid_body_sim.recording.seal import MESSAGES_CRC, crc_text

MAGIC = b'\x89MCAP0\r\n'

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX = range(9, 14)
SUMMARY_OFFSET, DATA_END = 14, 15


class McapFile:
    """
    Writes one MCAP file front to back.

    After each call the file ends with a whole record: a write that fails is cut off again and the
    OSError passed on. The stream is unbuffered, so what a call wrote survives the death of the
    process.

    first_time, last_time : [ns] log times of the messages so far; None before the first
    """

    def __init__(self, stream: FileIO, *, library: str, profile: str = 'ros2') -> None:
        self._stream = stream
        self._position = 0
        self._crc = 0
        self._messages_crc = 0
        self._schemas: list[bytes] = []
        self._channels: list[bytes] = []
        self._chunk_indexes: list[bytes] = []
        self._attachment_indexes: list[bytes] = []
        self._metadata_indexes: list[bytes] = []
        self._counts = np.zeros(1, np.int64)
        self.first_time: int | None = None
        self.last_time: int | None = None
        self._append(MAGIC, _record(HEADER, _string(profile) + _string(library)))

    def add_schema(self, name: str, encoding: str, definition: bytes) -> int:
        """Declare a message type; returns its id (1, 2, ...)."""
        number = len(self._schemas) + 1
        content = pack('<H', number) + _string(name) + _string(encoding) + _sized(definition)
        record = _record(SCHEMA, content)
        self._append(record)
        self._schemas.append(record)
        return number

    def add_channel(
        self, schema: int, topic: str, encoding: str, metadata: Mapping[str, str]
    ) -> int:
        """Declare a topic; returns its channel id (1, 2, ...)."""
        number = len(self._channels) + 1
        content = pack('<HH', number, schema) + _string(topic) + _string(encoding) + _map(metadata)
        record = _record(CHANNEL, content)
        self._append(record)
        self._channels.append(record)
        self._counts = np.append(self._counts, 0)
        return number

    def write_metadata(self, name: str, content: Mapping[str, str]) -> None:
        """Write a named map of strings."""
        record = _record(METADATA, _string(name) + _map(content))
        index = pack('<QQ', self._position, len(record)) + _string(name)
        self._append(record)
        self._metadata_indexes.append(_record(METADATA_INDEX, index))

    def write_attachment(
        self,
        name: str,
        media_type: str,
        content: bytes,
        *,
        log_time: int = 0,
        create_time: int = 0,
    ) -> None:
        """Write a named file; times in ns, 0 so that equal runs have equal bytes."""
        names = _string(name) + _string(media_type)
        body = pack('<QQ', log_time, create_time) + names + pack('<Q', len(content)) + content
        record = _record(ATTACHMENT, body + pack('<I', zlib.crc32(body)))
        index = (
            pack('<5Q', self._position, len(record), log_time, create_time, len(content)) + names
        )
        self._append(record)
        self._attachment_indexes.append(_record(ATTACHMENT_INDEX, index))

    def write_chunk(self, chunk: Chunk) -> None:
        """Write messages and their index; one chunk holds at least one message."""
        first, last = int(chunk.times.min()), int(chunk.times.max())
        size = len(chunk.body)
        head = pack('<QQQI', first, last, size, zlib.crc32(chunk.body)) + _string('')
        head = pack('<BQ', CHUNK, len(head) + 8 + size) + head + pack('<Q', size)
        indexes, channels, places = message_indexes(chunk)
        start, length = self._position, len(head) + size
        self._append(head, chunk.body, indexes)
        self._messages_crc = zlib.crc32(chunk.body, self._messages_crc)
        offsets = np.empty(len(channels), [('channel', '<u2'), ('offset', '<u8')])
        offsets['channel'] = channels
        offsets['offset'] = start + length + places
        content = (
            pack('<4Q', first, last, start, length)
            + _sized(offsets.tobytes())
            + pack('<Q', len(indexes))
            + _string('')
            + pack('<QQ', size, size)
        )
        self._chunk_indexes.append(_record(CHUNK_INDEX, content))
        self._counts += np.bincount(chunk.channels, minlength=len(self._counts))
        self.first_time = first if self.first_time is None else min(first, self.first_time)
        self.last_time = last if self.last_time is None else max(last, self.last_time)

    def count(self, channel: int) -> int:
        """Messages of one channel that are in the file."""
        return int(self._counts[channel])

    def checksums(self) -> dict[str, str]:
        """CRC-32 of all message records so far, one after the other, for an ending to keep."""
        return {MESSAGES_CRC: crc_text(self._messages_crc)}

    def finish(self) -> None:
        """Write the summary that lets a reader find everything without scanning."""
        data_end = _record(DATA_END, pack('<I', self._crc))
        summary_start = self._position + len(data_end)
        groups = [
            (SCHEMA, b''.join(self._schemas)),
            (CHANNEL, b''.join(self._channels)),
            (STATISTICS, self._statistics()),
            (CHUNK_INDEX, b''.join(self._chunk_indexes)),
            (ATTACHMENT_INDEX, b''.join(self._attachment_indexes)),
            (METADATA_INDEX, b''.join(self._metadata_indexes)),
        ]
        summary, offsets = b'', b''
        for opcode, records in groups:
            if records:
                place = pack('<BQQ', opcode, summary_start + len(summary), len(records))
                offsets += _record(SUMMARY_OFFSET, place)
                summary += records
        footer = pack('<BQQQ', FOOTER, 20, summary_start, summary_start + len(summary))
        tail = summary + offsets + footer
        self._append(data_end, tail, pack('<I', zlib.crc32(tail)), MAGIC)

    def _statistics(self) -> bytes:
        used = np.flatnonzero(self._counts)
        counts = b''.join(pack('<HQ', channel, self._counts[channel]) for channel in used)
        content = pack(
            '<QHIIIIQQ',
            int(self._counts.sum()),
            len(self._schemas),
            len(self._channels),
            len(self._attachment_indexes),
            len(self._metadata_indexes),
            len(self._chunk_indexes),
            self.first_time or 0,
            self.last_time or 0,
        )
        return _record(STATISTICS, content + _sized(counts))

    def _append(self, *parts: bytes) -> None:
        end, crc = self._position, self._crc
        try:
            for part in parts:
                rest = memoryview(part)
                while rest:
                    rest = rest[self._stream.write(rest) :]
                end += len(part)
                crc = zlib.crc32(part, crc)
        except OSError:
            with suppress(OSError):  # the first error is the one to tell
                self._stream.truncate(self._position)
            raise
        self._position, self._crc = end, crc


def _record(opcode: int, content: bytes) -> bytes:
    return pack('<BQ', opcode, len(content)) + content


def _sized(content: bytes) -> bytes:
    return pack('<I', len(content)) + content


def _string(text: str) -> bytes:
    return _sized(text.encode())


def _map(pairs: Mapping[str, str]) -> bytes:
    return _sized(b''.join(_string(key) + _string(value) for key, value in pairs.items()))
