# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Copies records, one by one, into a new MCAP file with its own chunks, indexes and summary.

Ids of schemas and channels are given anew; everything else stays as it was.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from io import FileIO
from pathlib import Path

import numpy as np
from mcap.records import Attachment, Channel, Header, McapRecord, Metadata, Schema

from rigid_body_sim.recording import bag_directory, mcap_scan
from rigid_body_sim.recording.bag_metadata import RECORD_NAME, TopicSummary
from rigid_body_sim.recording.bag_reader import RECOVERED
from rigid_body_sim.recording.bag_writer import ENDING
from rigid_body_sim.recording.batch import MESSAGE_HEAD, MESSAGE_LENGTH_EXTRA, MESSAGE_OPCODE
from rigid_body_sim.recording.chunk import Chunk
from rigid_body_sim.recording.chunk_queue import DIRECT_CHUNK_BYTES
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.recording.seal import sealed


class BagCopy:
    """
    The file being written.

    header   : of the source; None where it could not be read
    limit    : number of messages to copy; later ones are left out
    left_out : names of metadata records that are not copied
    """

    def __init__(
        self, output: FileIO, header: Header | None, limit: int, left_out: Collection[str]
    ) -> None:
        self._output = output
        self._limit = limit
        self._left_out = {RECORD_NAME, RECOVERED, *left_out}
        library = f'{header.library if header else ""} recovered'.lstrip()
        self._file = McapFile(
            output, library=library, profile=header.profile if header else 'ros2'
        )
        self._schemas: dict[int, int] = {0: 0}
        self._schema_names: dict[int, str] = {0: ''}
        self._channels: dict[int, int] = {}
        self._originals: dict[int, Channel] = {}
        self._start_chunk()

    def take(self, record: McapRecord | mcap_scan.Message) -> None:
        """Copy one record; a channel after its schema, a message after its channel."""
        if isinstance(record, mcap_scan.Message):
            if self._limit > 0:
                self._limit -= 1
                self._take_message(record)
        elif isinstance(record, Schema):
            self._take_schema(record)
        elif isinstance(record, Channel):
            self._take_channel(record)
        elif isinstance(record, Metadata) and record.name not in self._left_out:
            self._take_metadata(record)
        elif isinstance(record, Attachment):
            self._end_chunk()
            self._file.write_attachment(
                record.name,
                record.media_type,
                record.data,
                log_time=record.log_time,
                create_time=record.create_time,
            )

    def finish(self, directory: Path, note: Mapping[str, str]) -> None:
        """Complete the bag; `note` tells what was done to it."""
        self._end_chunk()
        self._file.write_metadata(RECOVERED, sealed({**note, **self._file.checksums()}))
        topics = [
            TopicSummary(
                channel.topic,
                self._schema_names[channel.schema_id],
                channel.message_encoding,
                channel.metadata.get('offered_qos_profiles', ''),
                channel.metadata.get('topic_type_hash', ''),
                self._file.count(self._channels[old]),
            )
            for old, channel in self._originals.items()
        ]
        bag_directory.finish(directory, self._file, self._output, topics=topics, custom=note)

    def _take_metadata(self, record: Metadata) -> None:
        """Copy a map of strings; an ending gets the checksum of the messages as they stand now."""
        self._end_chunk()
        content = record.metadata
        if record.name == ENDING:
            content = sealed({**content, **self._file.checksums()})
        self._file.write_metadata(record.name, content)

    def _take_schema(self, schema: Schema) -> None:
        if schema.id not in self._schemas:
            self._schema_names[schema.id] = schema.name
            self._schemas[schema.id] = self._file.add_schema(
                schema.name, schema.encoding, schema.data
            )

    def _take_channel(self, channel: Channel) -> None:
        if channel.id not in self._channels:
            self._originals[channel.id] = channel
            self._channels[channel.id] = self._file.add_channel(
                self._schemas[channel.schema_id],
                channel.topic,
                channel.message_encoding,
                channel.metadata,
            )

    def _take_message(self, message: mcap_scan.Message) -> None:
        number = self._channels[message.channel]
        head = MESSAGE_HEAD.pack(
            MESSAGE_OPCODE,
            MESSAGE_LENGTH_EXTRA + len(message.data),
            number,
            message.sequence,
            message.log_time,
            message.publish_time,
        )
        self._ids.append(number)
        self._times.append(message.log_time)
        self._offsets.append(self._size)
        self._parts += (head, message.data)
        self._size += len(head) + len(message.data)
        if self._size >= DIRECT_CHUNK_BYTES:
            self._end_chunk()

    def _start_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._ids: list[int] = []
        self._times: list[int] = []
        self._offsets: list[int] = []
        self._size = 0

    def _end_chunk(self) -> None:
        if self._ids:
            self._file.write_chunk(
                Chunk(
                    b''.join(self._parts),
                    np.array(self._ids, np.uint16),
                    np.array(self._times, np.int64),
                    np.array(self._offsets, np.int64),
                )
            )
            self._start_chunk()
