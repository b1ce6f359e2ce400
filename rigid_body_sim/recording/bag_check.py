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
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from mcap.records import Channel, Schema

from rigid_body_sim.errors import RunError
from rigid_body_sim.recording import bag_metadata, mcap_scan
from rigid_body_sim.recording.bag_reader import SUSPECT, Bag, DamagedBag
from rigid_body_sim.recording.definitions import HASHES, definition
from rigid_body_sim.recording.file_check import Contents, check_file, read_contents
from rigid_body_sim.recording.plain_yaml import read_yaml
from rigid_body_sim.recording.seal import crc_text
from rigid_body_sim.recording.topics import dump_yaml


def check(path: str | os.PathLike[str]) -> list[str]:
    """Return the findings; UserError for a path that holds no bag at all."""
    findings = []
    try:
        bag = Bag(path)
        for file, summary in zip(bag.files, bag.summaries):
            with file.open('rb') as stream:
                contents = read_contents(stream)
            findings += [f'{file.name}: {finding}' for finding in check_file(contents, summary)]
            if bag.manifest:
                findings += _check_ours(bag, contents)
    except (DamagedBag, RunError, mcap_scan.Torn) as error:
        return [*findings, str(error)]
    findings += _check_channels(bag)
    findings += _check_manifest(bag)
    if bag.information is not None:
        findings += [
            f'{bag_metadata.FILE_NAME}: {finding}'
            for finding in _check_metadata(bag, bag.information)
        ]
    return findings


def _check_ours(bag: Bag, contents: Contents) -> Iterator[str]:
    """Compare a file of this package with what it always writes."""
    stated = bag.messages_crc
    if stated is not None and stated != crc_text(contents.crc):
        yield f'the messages have the CRC {crc_text(contents.crc)}, recorded was {stated}'
    if contents.apart:
        yield f'publish time and log time of {contents.apart} messages are not the same'
    for channel in contents.channels.values():
        yield from _check_type(channel, contents.schemas.get(channel.schema_id))


def _check_type(channel: Channel, schema: Schema | None) -> Iterator[str]:
    """Compare the type of a topic with the definition that this package knows."""
    if schema is None or schema.name not in HASHES:
        yield f'{channel.topic}: its type is not one that this package records'
    elif (schema.encoding, schema.data) != ('ros2msg', definition(schema.name).encode()):
        yield f'{channel.topic}: the definition of {schema.name} is not that of ROS 2'
    if channel.message_encoding != 'cdr':
        yield f'{channel.topic}: messages are encoded as {channel.message_encoding!r}, not cdr'


def _check_channels(bag: Bag) -> Iterator[str]:
    for channel in bag.channels:
        qos = channel.metadata.get('offered_qos_profiles', '')
        if not qos:
            yield f'{channel.topic}: no quality of service in its channel'
        elif _profiles(qos) is None:
            yield f'{channel.topic}: the quality of service in its channel is no list of profiles'
        stated = channel.metadata.get('topic_type_hash', '')
        known = HASHES.get(bag.topics[bag.own_name(channel.topic)].type)
        if stated and known and stated != known:
            yield f'{channel.topic}: type hash {stated}, expected {known}'


def _check_manifest(bag: Bag) -> Iterator[str]:
    if not bag.manifest:
        yield 'no manifest: not recorded by rigid_body_sim, cannot be replayed'
        return
    if not bag.complete and not bag.recovered:
        yield 'no ending record: the run was cut off'
    if problem := bag.recovered.get(SUSPECT):
        yield f'recovered from a file that was not as it was recorded: {problem}'
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
        if bag.manifest:
            yield from _compare_with_record(bag, information)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        yield f'missing or misplaced: {error}'


def _compare_metadata(bag: Bag, information: dict[str, Any]) -> Iterator[str]:
    if information['version'] > bag_metadata.VERSION:
        yield f'version {information["version"]}; rosbags reads up to {bag_metadata.VERSION}'
    start = information['starting_time']['nanoseconds_since_epoch']
    stop = start + information['duration']['nanoseconds']
    total = sum(bag.counts.values())
    if total and (start, stop) != (bag.first_time, bag.last_time):  # of none any time is right
        yield f'times {(start, stop)} ns, the messages {(bag.first_time, bag.last_time)} ns'
    if information['message_count'] != total:
        yield f'{information["message_count"]} messages, the file holds {total}'
    stated = {
        entry['topic_metadata']['name']: entry
        for entry in information['topics_with_message_count']
    }
    for name in sorted(stated.keys() ^ set(map(bag.wire_name, bag.topics))):
        yield f'{name}: in the {"metadata" if name in stated else "file"} only'
    for channel in bag.channels:
        if channel.topic in stated:
            yield from _compare_topic(bag, channel, stated[channel.topic])


def _compare_topic(bag: Bag, channel: Any, entry: dict[str, Any]) -> Iterator[str]:
    name, topic = channel.topic, entry['topic_metadata']
    kind, count = bag.topics[bag.own_name(name)].type, bag.counts[bag.own_name(name)]
    if topic['type'] != kind:
        yield f'{name}: type {topic["type"]}, in the file {kind}'
    if entry['message_count'] != count:
        yield f'{name}: {entry["message_count"]} messages, the file holds {count}'
    qos = topic['offered_qos_profiles']
    qos = _profiles(qos) if isinstance(qos, str) else qos
    if qos != _profiles(channel.metadata.get('offered_qos_profiles', '')):
        yield f'{name}: quality of service differs from its channel; rosbags drops the topic'
    told = topic.get('type_description_hash')
    hash_of_channel = channel.metadata.get('topic_type_hash')
    if told and hash_of_channel and told != hash_of_channel:  # some recorders tell one, or none
        yield f'{name}: type hash differs from its channel'


def _compare_with_record(bag: Bag, information: dict[str, Any]) -> Iterator[str]:
    """
    Compare with the same map in the file, which its CRC protects; a renamed file keeps its old
    name there.
    """
    text = bag.metadata_text
    if text is None:
        yield 'the file does not hold the same again; it was packed anew'
        return
    if bag_metadata.is_text_of(bag.path, text):  # as it is written; parsing takes long
        return
    recorded = read_yaml(text)
    names = {'relative_file_paths': None, 'files': None}
    if dump_yaml({**recorded, **names}) != dump_yaml({**information, **names}):
        keys = recorded.keys() | information.keys()
        other = sorted(
            str(key) for key in keys - names.keys() if recorded.get(key) != information.get(key)
        )
        yield f'differs from what was recorded in: {", ".join(other) or "its types"}'
    paths = [file['path'] for file in information['files']]
    if paths != information['relative_file_paths']:
        yield f'files {paths}, relative_file_paths {information["relative_file_paths"]}'
    for file, stated in zip(information['files'], recorded['files']):
        if dump_yaml({**file, 'path': ''}) != dump_yaml({**stated, 'path': ''}):
            yield f'files: {file}, recorded was {stated}'


@lru_cache(maxsize=64)  # one text for all topics of a recorder, as a rule
def _profiles(text: str) -> list[Any] | None:
    """Quality of service as a list; None if the text is none."""
    try:
        profiles = read_yaml(text) or []
    except ValueError:
        return None
    return profiles if isinstance(profiles, list) else None
