# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`metadata.yaml`: what rosbag2 and rosbags read before they open the MCAP file of a bag.

Version 9, as ROS 2 Jazzy writes it. It is written last and by rename: a bag directory without it
is unfinished. The quality of service stands here and in the channels; where the two differ,
rosbags drops the topic in silence, so both come from the text in the channel.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from textwrap import indent
from typing import Any, NamedTuple

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.plain_yaml import MOST_CHARACTERS, read_yaml
from rigid_body_sim.recording.topics import dump_yaml

FILE_NAME = 'metadata.yaml'
RECORD_NAME = 'rosbag2'  # the metadata record that holds the inner map in the MCAP file
VERSION = 9
_ROOT = 'rosbag2_bagfile_information'


class TopicSummary(NamedTuple):
    """One topic of a bag: its channel's fields and the number of its messages."""

    name: str
    type: str
    encoding: str
    qos: str
    hash: str
    messages: int


def bag_information(
    *,
    file_name: str,
    topics: Sequence[TopicSummary],
    first_time: int,
    last_time: int,
    custom: Mapping[str, str],
) -> dict[str, Any]:
    """Return the inner map of metadata.yaml for a bag of one file; times in ns, 0 if empty."""
    start = {'nanoseconds_since_epoch': first_time}
    duration = {'nanoseconds': last_time - first_time}
    count = sum(topic.messages for topic in topics)
    return {
        'version': VERSION,
        'storage_identifier': 'mcap',
        'duration': duration,
        'starting_time': start,
        'message_count': count,
        'topics_with_message_count': [_topic_entry(topic) for topic in topics],
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file_name],
        'files': [
            {
                'path': file_name,
                'starting_time': start,
                'duration': duration,
                'message_count': count,
            }
        ],
        'custom_data': dict(custom),
        'ros_distro': 'jazzy',
    }


def write(directory: Path, information: Mapping[str, Any]) -> None:
    """Write metadata.yaml under a temporary name, then rename it."""
    temporary = directory / f'.{FILE_NAME}.part'
    with temporary.open('w', encoding='utf-8') as stream:
        stream.write(dump_yaml({_ROOT: dict(information)}))
        stream.flush()
        os.fsync(stream.fileno())
    temporary.replace(directory / FILE_NAME)


def read(directory: Path) -> dict[str, Any]:
    """Return the inner map of a bag directory's metadata.yaml; UserError if it is none."""
    path = directory / FILE_NAME
    try:
        return _information(path)
    except OSError as error:
        raise UserError(f'{path}: cannot be read ({error.strerror})') from error
    except ValueError as error:
        raise UserError(f'{path}: not the metadata of a bag ({error})') from error


def is_text_of(directory: Path, inner: str) -> bool:
    """Whether metadata.yaml is the inner map, as YAML, under its one key."""
    try:
        content = (directory / FILE_NAME).read_text(encoding='utf-8')
    except (OSError, ValueError):
        return False
    return content == f'{_ROOT}:\n{indent(inner, "  ")}'


def _information(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise ValueError('it is no regular file')
    if path.stat().st_size > MOST_CHARACTERS:
        raise ValueError(f'longer than {MOST_CHARACTERS} bytes')
    content = read_yaml(path.read_text(encoding='utf-8'))
    information = content.get(_ROOT) if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise ValueError(f'it has no map {_ROOT}')
    names = information.get('relative_file_paths')
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise ValueError('relative_file_paths is no list of file names')
    if not all(Path(name).name.strip('.') and '\0' not in name for name in names):
        raise ValueError('relative_file_paths names what is no file')
    return information


def _topic_entry(topic: TopicSummary) -> dict[str, Any]:
    return {
        'topic_metadata': {
            'name': topic.name,
            'type': topic.type,
            'serialization_format': topic.encoding,
            'offered_qos_profiles': _profiles(topic.qos),
            'type_description_hash': topic.hash,
        },
        'message_count': topic.messages,
    }


@cache
def _profiles(text: str) -> list[dict[str, Any]]:
    """Quality of service as plain values, none if the text is no list of profiles."""
    try:
        profiles = read_yaml(text) or []
    except ValueError:
        return []
    plain = isinstance(profiles, list) and all(isinstance(each, dict) for each in profiles)
    return profiles if plain else []
