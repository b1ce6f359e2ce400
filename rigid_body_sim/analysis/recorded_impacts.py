# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The impacts in a bag, as `recording.impact_packing` writes them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.state.impacts import KINDS, NO_IMPACTS, Impacts
from rigid_body_sim.recording import cdr, impact_packing
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.impact_packing import BILLION, LEAF, impact_points
from rigid_body_sim.recording.record_values import RecordValues

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LargestImpulse:
    """The largest impulse [N s]: between which bodies, at which simulation time [s]."""

    value: float
    bodies: tuple[str, str]
    time: float


@dataclass(frozen=True)
class ImpactSummary:
    """
    All impacts of a bag.

    messages, impacts : how many
    kinds             : how many of each kind: see `physics.state.impacts`
    largest_impulse   : None where there is no impact
    """

    messages: int
    impacts: int
    kinds: dict[str, int]
    largest_impulse: LargestImpulse | None


def impact_topic(bag: Bag) -> str | None:
    """Name the topic of impacts of our bags; None where there is none."""
    if not bag.manifest:
        return None
    for name, topic in bag.topics.items():
        if name.endswith(f'/{LEAF}') and topic.type == cdr.PointCloud2.TYPE:
            return name
    return None


def read_impacts(bag: Bag) -> Impacts:
    """Read all impacts of a bag; none where it has no topic of them."""
    points = [found for _, found in _messages(bag)]
    return impacts_of(np.concatenate(points)) if points else NO_IMPACTS


def impacts_of(points: Array) -> Impacts:
    """Give the points of messages, (m, number of fields), as impacts."""
    seconds, rest = points[:, impact_packing.SECONDS], points[:, impact_packing.NANOSECONDS]
    return Impacts(
        seconds.astype(np.int64) * BILLION + rest.astype(np.int64),
        points[:, impact_packing.REMAINDER],
        points[:, impact_packing.BODIES].astype(np.int64),
        points[:, impact_packing.POINT],
        points[:, impact_packing.NORMAL],
        points[:, impact_packing.IMPULSE],
        points[:, impact_packing.APPROACH],
        points[:, impact_packing.KIND].astype(np.int64),
    )


def summarise(bag: Bag) -> ImpactSummary | None:
    """Go through all impacts; None where the bag has no topic of them."""
    if impact_topic(bag) is None:
        return None
    names = RecordValues(bag.path, 'manifest', bag.manifest).json('bodies', '[]')
    messages, counts, largest = 0, np.zeros(len(KINDS), dtype=np.int64), None
    for _, points in _messages(bag):
        messages += 1
        found = impacts_of(points)
        counts += np.bincount(found.kind, minlength=len(KINDS))[: len(KINDS)]
        sizes = np.linalg.norm(found.impulse, axis=1)
        first = int(np.argmax(sizes))
        if largest is None or sizes[first] > largest.value:
            a, b = (str(names[place]) for place in found.bodies[first])
            largest = LargestImpulse(float(sizes[first]), (a, b), float(found.time[first]))
    kinds = {str(kind): int(count) for kind, count in zip(KINDS, counts, strict=True)}
    return ImpactSummary(messages, int(counts.sum()), kinds, largest)


def _messages(bag: Bag) -> Iterator[tuple[float, Array]]:
    """Go through the messages: the instant of publishing [s], and the points, at least one."""
    topic = impact_topic(bag)
    if topic is not None:
        for message in bag.messages_by_time([topic]):
            points = impact_points(message.data)
            if len(points):
                yield message.log_time / 1e9, points
