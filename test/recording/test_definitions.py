# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Message definitions and hashes are those of ROS 2 Jazzy.
"""

import json
import os
import sys
from pathlib import Path

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.definitions import HASHES, definition

SEPARATOR = '=' * 80


def installed(type_name, suffix):
    """
    Path of an installed interface file; skips where none is installed.
    """
    package, _, name = type_name.split('/')
    prefixes = [*filter(None, os.environ.get('AMENT_PREFIX_PATH', '').split(':')), sys.prefix]
    for prefix in prefixes:
        path = Path(prefix, 'share', package, 'msg', f'{name}.{suffix}')
        if path.exists():
            return path
    pytest.skip(f'{package} is not installed')


def declared(text):
    """
    The fields of a .msg text without comments and spacing.
    """
    lines = (line.split('#')[0].split() for line in text.splitlines())
    return [' '.join(words) for words in lines if words]


def sections(type_name):
    """
    Type name -> text, from our definition.
    """
    first, *others = definition(type_name).split(f'\n{SEPARATOR}\n')
    found = {type_name: first}
    for other in others:
        headline, _, text = other.partition('\n')
        found[headline.removeprefix('MSG: ').replace('/', '/msg/')] = text
    return found


@pytest.mark.parametrize('type_name', cdr.TYPES)
def test_texts_are_the_installed_ones_without_comments(type_name):
    for name, text in sections(type_name).items():
        assert declared(text) == declared(installed(name, 'msg').read_text())


@pytest.mark.parametrize('type_name', cdr.TYPES)
def test_hashes_are_the_installed_ones(type_name):
    entries = json.loads(installed(type_name, 'json').read_text())['type_hashes']
    assert {entry['type_name']: entry['hash_string'] for entry in entries}[type_name] == (
        HASHES[type_name]
    )


@pytest.mark.parametrize('type_name', cdr.TYPES)
def test_rosbags_computes_our_hash_from_our_text(type_name):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition(type_name), type_name))
    assert store.hash_rihs01(type_name) == HASHES[type_name]
    assert get_typestore(Stores.ROS2_JAZZY).hash_rihs01(type_name) == HASHES[type_name]


def test_dependencies_follow_depth_first_in_sorted_order_each_once():
    assert list(sections(cdr.PoseStamped.TYPE)) == [
        'geometry_msgs/msg/PoseStamped',
        'geometry_msgs/msg/Pose',
        'geometry_msgs/msg/Point',
        'geometry_msgs/msg/Quaternion',
        'std_msgs/msg/Header',
        'builtin_interfaces/msg/Time',
    ]
    assert 'MSG: std_msgs/Header\n' in definition(cdr.PoseStamped.TYPE)
