# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Copies records, one by one, into a new MCAP file with its own chunks, indexes and summary.

Ids of schemas and channels are given anew; everything else stays as it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from io import FileIO
from pathlib import Path

import numpy as np
from mcap.records import Attachment, Channel, Header, Metadata, Schema

from rigid_body_sim.recording import bag_directory, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_metadata import RECORD_NAME, TopicSummary
from rigid_body_sim.recording.bag_reader import RECOVERED
from rigid_body_sim.recording.batch import MESSAGE_HEAD, MESSAGE_LENGTH_EXTRA, MESSAGE_OPCODE
from rigid_body_sim.recording.chunk import Chunk
from rigid_body_sim.recording.chunk_queue import DIRECT_CHUNK_BYTES
from rigid_body_sim.recording.mcap_file import McapFile


class BagCopy:
    """
    The file being written.

    limit : number of messages to copy; later ones are left out
    """

    def __init__(self, output: FileIO, limit: int) -> None:
        self._output = output
        self._limit = limit
        self._file: McapFile
        self._schemas: dict[int, int] = {0: 0}
        self._schema_names: dict[int, str] = {0: ''}
        self._channels: dict[int, int] = {}
        self._originals: dict[int, Channel] = {}
        self._start_chunk()

    def take(self, record: mcap_scan.Record) -> None:
        """Copy one record of the data section; the first must be the header."""
        opcode = record.opcode
        if opcode == mcap_file.MESSAGE:
            if self._limit > 0:
                self._limit -= 1
                self._take_message(mcap_scan.message(record))
        elif opcode == mcap_file.HEADER:
            header = record.parse(Header)
            library = f'{header.library} recovered'.lstrip()
            self._file = McapFile(self._output, library=library, profile=header.profile)
        elif opcode == mcap_file.SCHEMA:
            self._take_schema(record.parse(Schema))
        elif opcode == mcap_file.CHANNEL:
            self._take_channel(record.parse(Channel))
        elif opcode == mcap_file.METADATA:
            metadata = record.parse(Metadata)
            if metadata.name != RECORD_NAME:
                self._end_chunk()
                self._file.write_metadata(metadata.name, metadata.metadata)
        elif opcode == mcap_file.ATTACHMENT:
            attachment = record.parse(Attachment)
            self._file.write_attachment(
                attachment.name,
                attachment.media_type,
                attachment.data,
                log_time=attachment.log_time,
                create_time=attachment.create_time,
            )

    def finish(self, directory: Path, note: Mapping[str, str]) -> None:
        """Complete the bag; `note` tells what was done to it."""
        self._end_chunk()
        self._file.write_metadata(RECOVERED, note)
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
