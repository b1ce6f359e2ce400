# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Names, types and quality of service of the recorded topics.

Names are absolute: namespace + '/' + body + '/' + leaf; the clock is `/clock` in every namespace.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import yaml

from rigid_body_sim.recording import cdr

CLOCK_TOPIC = '/clock'

COMMAND_TYPES = {
    'force': cdr.Vector3Stamped.TYPE,
    'torque': cdr.Vector3Stamped.TYPE,
    'wrench': cdr.WrenchStamped.TYPE,
    'impulse': cdr.WrenchStamped.TYPE,
    'set_state': cdr.Odometry.TYPE,
}

_INFINITE = {'sec': 9223372036, 'nsec': 854775807}

# The profile with which a bag is played: that of ROS where nothing else is asked for.
QOS: tuple[Mapping[str, Any], ...] = (
    {
        'history': 'keep_last',
        'depth': 10,
        'reliability': 'reliable',
        'durability': 'volatile',
        'deadline': _INFINITE,
        'lifespan': _INFINITE,
        'liveliness': 'automatic',
        'liveliness_lease_duration': _INFINITE,
        'avoid_ros_namespace_conventions': False,
    },
)


class Topic(NamedTuple):
    """A topic: absolute name and type name with `/msg/`."""

    name: str
    type: str


_SafeDumper = getattr(yaml, 'CSafeDumper', yaml.SafeDumper)  # fifteen times as fast, if built in


class _Dumper(_SafeDumper):  # type: ignore[misc, valid-type]  # the base is chosen at run time
    """Block style without anchors: the parsers of rosbag2 and rosbags want plain text."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def dump_yaml(content: Any) -> str:
    """Return YAML text in block style, keys in the given order, without anchors."""
    return yaml.dump(content, Dumper=_Dumper, sort_keys=False, default_flow_style=False)


@cache
def qos_text() -> str:
    """The quality of service as the text that stands in a channel's metadata."""
    return dump_yaml([dict(profile) for profile in QOS])


def body_topic(namespace: str, body: str, leaf: str, type_name: str) -> Topic:
    """Topic of one body, for example `/lab/box/pose` in the namespace `/lab`."""
    prefix = namespace.strip('/')
    return Topic(f'/{prefix}/{body}/{leaf}' if prefix else f'/{body}/{leaf}', type_name)


def node_topic(namespace: str, leaf: str, type_name: str) -> Topic:
    """Topic of all bodies, for example `/lab/poses` in the namespace `/lab`."""
    prefix = namespace.strip('/')
    return Topic(f'/{prefix}/{leaf}' if prefix else f'/{leaf}', type_name)


def command_topics(bodies: Sequence[str], *, namespace: str = '') -> list[Topic]:
    """Every topic on which a body takes commands, body by body."""
    return [
        body_topic(namespace, body, leaf, type_name)
        for body in bodies
        for leaf, type_name in COMMAND_TYPES.items()
    ]
