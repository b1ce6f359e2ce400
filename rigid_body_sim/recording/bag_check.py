# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Looks for everything that is wrong with a recording, also what readers pass over in silence.

CRCs, indexes, statistics, ascending times, type hashes, agreement of metadata.yaml with the file,
manifest and attachments. Each finding is one line; no finding means that every reader sees every
message.
"""

from __future__ import annotations

import hashlib
import os
import zlib
from collections import Counter
from collections.abc import Iterator
from typing import Any, BinaryIO

import yaml
from mcap.reader import make_reader
from mcap.records import Attachment, Footer, MessageIndex
from mcap.summary import Summary

from rigid_body_sim.recording import bag_metadata, mcap_file, mcap_scan
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.definitions import HASHES

Entries = dict[int, list[tuple[int, int]]]


def check(path: str | os.PathLike[str]) -> list[str]:
    """Return the findings; UserError for a path that holds no bag at all."""
    try:
        bag = Bag(path)
        findings = []
        for file in bag.files:
            with file.open('rb') as stream:
                findings += [f'{file.name}: {finding}' for finding in _check_file(stream)]
    except (DamagedBag, mcap_scan.Torn) as error:
        return [str(error)]
    findings += _check_channels(bag)
    findings += _check_manifest(bag)
    if bag.information is not None:
        findings += [
            f'{bag_metadata.FILE_NAME}: {finding}'
            for finding in _check_metadata(bag, bag.information)
        ]
    return findings


class _Contents:
    """What is really in a file."""

    def __init__(self) -> None:
        self.counts: Counter[int] = Counter()
        self.first_time, self.last_time = 0, 0
        self.chunks: list[tuple[int, Entries]] = []  # place in the file, messages
        self.indexes: list[Entries] = []  # what the records after each chunk say
        self.descents = 0
        self._latest = -1

    def add(self, message: mcap_scan.Message) -> None:
        """Count one message."""
        time = message.log_time
        if not self.counts:
            self.first_time = self.last_time = time
        self.first_time, self.last_time = min(self.first_time, time), max(self.last_time, time)
        self.counts[message.channel] += 1
        self.descents += time < self._latest
        self._latest = time


def _check_file(stream: BinaryIO) -> Iterator[str]:
    contents = _Contents()
    for record in mcap_scan.records(stream):
        if record.opcode == mcap_file.CHUNK:
            entries: Entries = {}
            for part in mcap_scan.inner_records(record):
                if part.opcode == mcap_file.MESSAGE:
                    message = mcap_scan.message(part)
                    contents.add(message)
                    entry = (message.log_time, part.position)
                    entries.setdefault(message.channel, []).append(entry)
            contents.chunks.append((record.position, entries))
            contents.indexes.append({})
        elif record.opcode == mcap_file.MESSAGE_INDEX and contents.indexes:
            index = record.parse(MessageIndex)
            contents.indexes[-1][index.channel_id] = [
                (time, place) for time, place in index.records
            ]
        elif record.opcode == mcap_file.MESSAGE:
            contents.add(mcap_scan.message(record))
        elif record.opcode == mcap_file.ATTACHMENT:
            record.parse(Attachment)
        elif record.opcode == mcap_file.FOOTER:
            yield from _check_footer(stream, record)
    stream.seek(0)
    summary = make_reader(stream).get_summary()
    if summary is not None:
        yield from _check_summary(summary, contents)
    for (place, entries), index in zip(contents.chunks, contents.indexes):
        if index != entries:
            yield f'chunk at byte {place}: its message index does not match its messages'
    if contents.descents:
        yield f'log time goes back {contents.descents} times; it must ascend'


def _check_footer(stream: BinaryIO, record: mcap_scan.Record) -> Iterator[str]:
    footer = record.parse(Footer)
    here = stream.tell()
    stream.seek(footer.summary_start)
    content = stream.read(record.position + 9 + 16 - footer.summary_start)
    stream.seek(here)
    if footer.summary_crc and zlib.crc32(content) != footer.summary_crc:
        yield 'the summary does not match its CRC'


def _check_summary(summary: Summary, contents: _Contents) -> Iterator[str]:
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
    if span != actual:
        yield f'statistics span {span} ns, the messages {actual} ns'
    places = sorted(index.chunk_start_offset for index in summary.chunk_indexes)
    if places != [place for place, _ in contents.chunks]:
        yield f'{len(places)} chunk indexes do not match {len(contents.chunks)} chunks'
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        if schema is None or not schema.data:
            yield f'{channel.topic}: no message definition; rosbags cannot read the topic'


def _check_channels(bag: Bag) -> Iterator[str]:
    for channel in bag.channels:
        if not channel.metadata.get('offered_qos_profiles'):
            yield f'{channel.topic}: no quality of service in its channel'
        stated = channel.metadata.get('topic_type_hash', '')
        known = HASHES.get(bag.topics[channel.topic].type)
        if stated and known and stated != known:
            yield f'{channel.topic}: type hash {stated}, expected {known}'


def _check_manifest(bag: Bag) -> Iterator[str]:
    if not bag.manifest:
        yield 'no manifest: not recorded by rigid_body_sim, cannot be replayed'
        return
    if not bag.complete and not bag.recovered:
        yield 'no ending record: the run was cut off'
    expected = bag.manifest.get('scene_sha256')
    if expected is not None:
        scene = bag.attachments.get('scene.yaml')
        if scene is None:
            yield 'the attachment scene.yaml is missing'
        elif hashlib.sha256(scene).hexdigest() != expected:
            yield 'the attachment scene.yaml does not match scene_sha256 of the manifest'


def _check_metadata(bag: Bag, information: dict[str, Any]) -> Iterator[str]:
    try:
        yield from _compare_metadata(bag, information)
    except (KeyError, TypeError, AttributeError) as error:
        yield f'missing or misplaced: {error}'


def _compare_metadata(bag: Bag, information: dict[str, Any]) -> Iterator[str]:
    if information['version'] > bag_metadata.VERSION:
        yield f'version {information["version"]}; rosbags reads up to {bag_metadata.VERSION}'
    start = information['starting_time']['nanoseconds_since_epoch']
    stop = start + information['duration']['nanoseconds']
    if (start, stop) != (bag.first_time, bag.last_time):
        yield f'times {(start, stop)} ns, the messages {(bag.first_time, bag.last_time)} ns'
    total = sum(bag.counts.values())
    if information['message_count'] != total:
        yield f'{information["message_count"]} messages, the file holds {total}'
    stated = {
        entry['topic_metadata']['name']: entry
        for entry in information['topics_with_message_count']
    }
    for name in sorted(stated.keys() ^ bag.topics.keys()):
        yield f'{name}: in the {"metadata" if name in stated else "file"} only'
    for channel in bag.channels:
        if channel.topic in stated:
            yield from _compare_topic(bag, channel, stated[channel.topic])


def _compare_topic(bag: Bag, channel: Any, entry: dict[str, Any]) -> Iterator[str]:
    name, topic = channel.topic, entry['topic_metadata']
    if topic['type'] != bag.topics[name].type:
        yield f'{name}: type {topic["type"]}, in the file {bag.topics[name].type}'
    if entry['message_count'] != bag.counts[name]:
        yield f'{name}: {entry["message_count"]} messages, the file holds {bag.counts[name]}'
    qos = topic['offered_qos_profiles']
    qos = yaml.safe_load(qos) if isinstance(qos, str) else qos
    if qos != (yaml.safe_load(channel.metadata.get('offered_qos_profiles', '')) or []):
        yield f'{name}: quality of service differs from its channel; rosbags drops the topic'
    if topic.get('type_description_hash', '') != channel.metadata.get('topic_type_hash', ''):
        yield f'{name}: type hash differs from its channel'
