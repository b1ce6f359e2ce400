# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The contacts in a bag: how many, the largest force, the deepest overlap, what each body carries.

Read are the topics `<body>/contacts` as `recording.contact_packing` writes them. A contact of two
movable bodies is told on both topics; it counts twice.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.contact_packing import FORCE, GAP, LEAF, cloud_points
from rigid_body_sim.recording.record_values import RecordValues

Array = NDArray[np.float64]

HOW_TO_RECORD = 'simulate --contacts records them, and the node with publish_contacts:=true'


@dataclass(frozen=True)
class Extreme:
    """The largest or smallest value met: on which body, at which simulation time [s]."""

    value: float
    body: str
    time: float


@dataclass(frozen=True)
class ContactSummary:
    """
    All contacts of a bag.

    messages, contacts : how many
    largest_force      : [N]  mean over a tick, of one contact point
    deepest_gap        : [m]  negative: the bodies overlapped
    """

    messages: int
    contacts: int
    largest_force: Extreme | None
    deepest_gap: Extreme | None


def scene_has_contact(bag: Bag) -> bool:
    """Whether the bodies of the recorded run met; false in bags of other recorders."""
    contact = RecordValues(bag.path, 'manifest', bag.manifest).section('contact', '{}')
    return contact.get('mode', 'none') != 'none'


def contact_topics(bag: Bag) -> dict[str, str]:
    """Topics of contacts of our bags: topic -> body."""
    if not bag.manifest:
        return {}
    return {
        name: name.split('/')[-2]
        for name, topic in bag.topics.items()
        if name.endswith(f'/{LEAF}') and topic.type == cdr.PointCloud2.TYPE
    }


def read_points(payload: bytes) -> Array:
    """Return the points of one message, (k, number of fields)."""
    cloud = cdr.decode(cdr.PointCloud2.TYPE, payload)
    assert isinstance(cloud, cdr.PointCloud2)
    return cloud_points(cloud)


def summarise(bag: Bag) -> ContactSummary | None:
    """Go through all contacts; None where the bag has no topic for them."""
    topics = contact_topics(bag)
    if not topics:
        return None
    messages, contacts = 0, 0
    force = gap = None
    for body, time, points in _all(bag, topics):
        messages, contacts = messages + 1, contacts + len(points)
        if not len(points):
            continue
        largest = math.sqrt(float(np.max(np.sum(points[:, FORCE] ** 2, axis=1))))
        deepest = float(np.min(points[:, GAP]))
        if force is None or largest > force.value:
            force = Extreme(largest, body, time)
        if gap is None or deepest < gap.value:
            gap = Extreme(deepest, body, time)
    return ContactSummary(messages, contacts, force, gap)


def _all(bag: Bag, topics: dict[str, str]) -> Iterator[tuple[str, float, Array]]:
    for message in bag.messages_by_time(topics):
        yield topics[message.topic], message.log_time / 1e9, read_points(message.data)
