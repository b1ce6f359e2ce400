# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reads a recording: a bag directory or a lone `.mcap` file, ours or of any other rosbag2 with MCAP
storage.

Messages come in file order, which is the order in which the simulator consumed and produced them.
Chunks are checked against their CRC as they are read.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Statistics
from mcap.stream_reader import CRCValidationError
from mcap.summary import Summary

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import bag_metadata, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_writer import DERIVED_BY, ENDING, MANIFEST
from rigid_body_sim.recording.topics import Topic

RECOVERED = 'rigid_body_sim_recovered'  # metadata record of a recovered bag


class DamagedBag(UserError):
    """A recording that is torn, unfinished or damaged: `bag recover` saves what is good."""


class RecordedMessage(NamedTuple):
    """
    One message as the file holds it.

    topic    : absolute name
    sequence : tick (see `packing`); 0 in bags of other recorders
    log_time : [ns] simulation time in our bags
    data     : CDR payload
    """

    topic: str
    sequence: int
    log_time: int
    data: bytes


class Bag:
    """
    One finished recording.

    path        : what was asked for
    files       : its MCAP files in order
    information : inner map of metadata.yaml; None for a lone file
    topics      : name -> Topic
    counts      : name -> number of messages
    first_time, last_time : [ns] log times; 0 where there is no message
    manifest    : what the run was; empty in bags of other recorders
    ending      : how it ended; None when the run was cut off
    attachments : file name -> bytes
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.files, self.information = _locate(self.path)
        self.topics: dict[str, Topic] = {}
        self.counts: dict[str, int] = {}
        self.attachments: dict[str, bytes] = {}
        self.channels: list[Channel] = []
        self._metadata: dict[str, dict[str, str]] = {}
        self._names: list[dict[int, str]] = []
        times: list[int] = []
        for file in self.files:
            times += self._open(file)
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

    def messages(self, topics: Collection[str] | None = None) -> Iterator[RecordedMessage]:
        """Yield the messages of the given topics, all by default, in file order."""
        for file, names in zip(self.files, self._names):
            wanted = {
                channel: name
                for channel, name in names.items()
                if topics is None or name in topics
            }
            with file.open('rb') as stream:
                try:
                    yield from _messages(stream, wanted)
                except mcap_scan.Torn as error:
                    raise _damaged(file, error) from error

    def _open(self, file: Path) -> tuple[int, ...]:
        try:
            with file.open('rb') as stream:
                _check_ends(file, stream)
                reader = make_reader(stream, validate_crcs=True)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None:
                    raise ValueError('no summary')
                for record in reader.iter_metadata():
                    self._metadata[record.name] = record.metadata
                for attachment in reader.iter_attachments():
                    self.attachments[attachment.name] = attachment.data
        except OSError as error:
            raise UserError(f'{file}: cannot be read ({error.strerror})') from error
        except (McapError, CRCValidationError, ValueError, LookupError) as error:
            raise _damaged(file, error) from error
        return self._take(file, summary, summary.statistics)

    def _take(self, file: Path, summary: Summary, statistics: Statistics) -> tuple[int, ...]:
        counts = statistics.channel_message_counts
        for number, channel in summary.channels.items():
            schema = summary.schemas.get(channel.schema_id)
            topic = Topic(channel.topic, schema.name if schema else '')
            if self.topics.setdefault(topic.name, topic) != topic:
                raise UserError(f'{file}: topic {topic.name} has two types')
            self.counts[topic.name] = self.counts.get(topic.name, 0) + counts.get(number, 0)
        self.channels += summary.channels.values()
        self._names.append({number: channel.topic for number, channel in summary.channels.items()})
        if statistics.message_count == 0:
            return ()
        return statistics.message_start_time, statistics.message_end_time


def _locate(path: Path) -> tuple[tuple[Path, ...], dict[str, Any] | None]:
    """Find the MCAP files of a bag and its metadata."""
    if not path.exists():
        raise UserError(
            f'{path}: no such file or directory; expected a bag directory or an .mcap file'
        )
    if not path.is_dir():
        return (path,), None
    if not (path / bag_metadata.FILE_NAME).exists():
        if any(path.glob('*.mcap')):
            raise DamagedBag(
                f'{path}: unfinished recording (no metadata.yaml); '
                f'restore it with: bag recover {path} -o NEW'
            )
        raise UserError(f'{path}: not a bag: holds neither metadata.yaml nor an .mcap file')
    information = bag_metadata.read(path)
    storage = information.get('storage_identifier')
    compression = information.get('compression_mode')
    if storage != 'mcap' or compression:
        raise UserError(
            f'{path}: storage {storage!r}, compression mode {compression!r}; '
            "allowed: 'mcap', none; convert it with: ros2 bag convert"
        )
    files = tuple(path / Path(name).name for name in information['relative_file_paths'])
    for file in files:
        if not file.exists():
            raise UserError(f'{file}: missing, but metadata.yaml names it')
    return files, information


def _check_ends(file: Path, stream: BinaryIO) -> None:
    """Refuse what is no MCAP file, and what was torn off."""
    magic = mcap_file.MAGIC
    if stream.read(len(magic)) != magic:
        raise UserError(f'{file}: not a bag: does not start as an MCAP file')
    size = stream.seek(0, 2)
    stream.seek(max(len(magic), size - len(magic)))
    if stream.read() != magic:
        raise DamagedBag(
            f'{file}: torn: its end is missing; restore the rest with: bag recover {file} -o NEW'
        )
    stream.seek(0)


def _messages(stream: BinaryIO, wanted: dict[int, str]) -> Iterator[RecordedMessage]:
    for record in mcap_scan.records(stream):
        found: Iterable[mcap_scan.Message] = ()
        if record.opcode == mcap_file.CHUNK:
            found = mcap_scan.chunk_messages(record)
        elif record.opcode == mcap_file.MESSAGE:
            found = (mcap_scan.message(record),)
        elif record.opcode == mcap_file.DATA_END:
            return
        for channel, sequence, log_time, _, data in found:
            if channel in wanted:
                yield RecordedMessage(wanted[channel], sequence, log_time, data)


def _damaged(file: Path, error: Exception) -> DamagedBag:
    return DamagedBag(
        f'{file}: damaged ({" ".join(str(error).split())}); '
        f'save what is good with: bag recover {file} -o NEW'
    )
