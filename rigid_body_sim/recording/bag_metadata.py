# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`metadata.yaml`: what rosbag2 and rosbags read before they open the MCAP file of a bag.

Version 9, as ROS 2 Jazzy writes it. It is written last and by rename: a bag directory without it
is unfinished. The quality of service stands here and in the channels; where the two differ,
rosbags drops the topic in silence, so both come from the text in the channel.

A topic has forty lines, all but two of them the same for every topic of its type: PyYAML writes
those once for each type, and reads them once, and a thousand bodies cost no more than their own
lines.
"""

from __future__ import annotations

import os
import re
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
_TOPICS = 'topics_with_message_count'
_BELOW_ROOT = '  '
_ITEM = re.compile(  # of the list of topics, as this package and rosbag2 write it
    r'  - topic_metadata:\n      name: (/[A-Za-z0-9_/]*)\n'
    r'((?:      .*\n)+)    message_count: (0|[1-9][0-9]{0,17})\n',
    re.ASCII,
)
_PLAIN_NAME = re.compile(r'/[A-Za-z0-9_/]*', re.ASCII)  # YAML writes it as it is


class TopicSummary(NamedTuple):
    """One topic of a bag: its channel's fields and the number of its messages."""

    name: str
    type: str
    encoding: str
    qos: str
    hash: str
    messages: int


class Information(NamedTuple):
    """
    What metadata.yaml of a bag of one file tells.

    first_time, last_time : [ns] of the messages, 0 if there are none
    custom                : what the run adds, as strings
    """

    file_name: str
    topics: Sequence[TopicSummary]
    first_time: int
    last_time: int
    custom: Mapping[str, str]

    def text(self) -> str:
        """Return the inner map as YAML: what the record in the file holds."""
        return dump_yaml(self._head()) + self._topic_list() + dump_yaml(self._tail())

    def file_text(self) -> str:
        """Return the whole text of metadata.yaml: the inner map under its one key."""
        head, tail = (dump_yaml({_ROOT: part}) for part in (self._head(), self._tail()))
        below_root = tail.partition('\n')[2]
        return head + self._topic_list(_BELOW_ROOT) + below_root

    def _head(self) -> dict[str, Any]:
        return {
            'version': VERSION,
            'storage_identifier': 'mcap',
            **self._extent(),
        }

    def _extent(self) -> dict[str, Any]:
        return {
            'duration': {'nanoseconds': self.last_time - self.first_time},
            'starting_time': {'nanoseconds_since_epoch': self.first_time},
            'message_count': sum(topic.messages for topic in self.topics),
        }

    def _topic_list(self, margin: str = '') -> str:
        if not self.topics:
            return f'{margin}{_TOPICS}: []\n'
        return f'{margin}{_TOPICS}:\n' + ''.join(_topic_text(each, margin) for each in self.topics)

    def _tail(self) -> dict[str, Any]:
        extent = self._extent()
        file = {
            'path': self.file_name,
            'starting_time': extent['starting_time'],
            'duration': extent['duration'],
            'message_count': extent['message_count'],
        }
        return {
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self.file_name],
            'files': [file],
            'custom_data': dict(self.custom),
            'ros_distro': 'jazzy',
        }


def write(directory: Path, text: str) -> None:
    """Write metadata.yaml under a temporary name, then rename it."""
    temporary = directory / f'.{FILE_NAME}.part'
    with temporary.open('w', encoding='utf-8') as stream:
        stream.write(text)
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
    return content == f'{_ROOT}:\n{indent(inner, _BELOW_ROOT)}'


def _information(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise ValueError('it is no regular file')
    if path.stat().st_size > MOST_CHARACTERS:
        raise ValueError(f'longer than {MOST_CHARACTERS} bytes')
    text = path.read_text(encoding='utf-8')
    content = _read_item_by_item(text) or read_yaml(text)
    information = content.get(_ROOT) if isinstance(content, dict) else None
    if not isinstance(information, dict):
        raise ValueError(f'it has no map {_ROOT}')
    names = information.get('relative_file_paths')
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise ValueError('relative_file_paths is no list of file names')
    if not all(Path(name).name.strip('.') and '\0' not in name for name in names):
        raise ValueError('relative_file_paths names what is no file')
    return information


def _read_item_by_item(text: str) -> dict[str, Any] | None:
    """
    Read the text of metadata.yaml, of each type of topics one item; None for one that is laid out
    in another way than those that are written.
    """
    mark = f'\n{_BELOW_ROOT}{_TOPICS}:\n'
    head, found, rest = text.partition(mark)
    items, place = [], 0
    while (item := _ITEM.match(rest, place)) is not None:
        items.append(item)
        place = item.end()
    tail = rest[place:]
    if not (found and items and text.isascii()) or _TOPICS in tail or tail[:3].strip(' ') == '':
        return None
    if tail.startswith(f'{_BELOW_ROOT}-'):
        return None
    try:
        content = read_yaml(f'{head}{mark.rstrip()} []\n{tail}')
        if content[_ROOT][_TOPICS] != []:
            return None
        kinds = {same: _one_item(same) for same in {item[2] for item in items}}
    except (ValueError, LookupError, TypeError):
        return None
    content[_ROOT][_TOPICS] = [
        {'topic_metadata': {**kinds[same], 'name': name}, 'message_count': int(count)}
        for name, same, count in (item.groups() for item in items)
    ]
    return content


def _one_item(same: str) -> dict[str, Any]:
    """Read what all topics of a type have in common; its name is first and still to be given."""
    (item,) = read_yaml(f'  - topic_metadata:\n      name: /\n{same}    message_count: 0\n')
    topic = item['topic_metadata']
    if item != {'topic_metadata': topic, 'message_count': 0} or topic['name'] != '/':
        raise ValueError('not an item of the list')
    return topic


def _topic_text(topic: TopicSummary, margin: str) -> str:
    """Return the item of one topic in the list, as PyYAML writes it."""
    if not _PLAIN_NAME.fullmatch(topic.name):
        return indent(dump_yaml([_topic_entry(topic)]), margin)
    before, after = _around_name(topic.type, topic.encoding, topic.qos, topic.hash, margin)
    return f'{before}{topic.name}{after}{topic.messages}\n'


@cache
def _around_name(
    kind: str, encoding: str, qos: str, type_hash: str, margin: str
) -> tuple[str, str]:
    """Return what stands before the name of a topic, and from there to its number of messages."""
    nameless = TopicSummary('/', kind, encoding, qos, type_hash, 0)
    entry = indent(dump_yaml([_topic_entry(nameless)]), margin)
    before, name, after = entry.partition('name: /')
    return before + name.rstrip('/'), after.removesuffix('0\n')


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
