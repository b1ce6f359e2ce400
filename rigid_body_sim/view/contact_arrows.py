# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The contact forces of a bag as arrows for the playback page: where they act, and how large.

Each contact is drawn once, as the force on the body that the scene lists later, or on the one that
can move, and from the surface of that body:

x = p + g n / 2
    p : (3,) [m]  recorded point, midway between the surfaces
    g : [m]       distance of the surfaces, negative where they overlap
    n : (3,) [-]  unit normal into this body

The point is found at the start of the tick and goes with the body that can move; between two that
can, with the rounder, or half with each. So between two that slide along each other x may be off
by their way in the tick, or half of it, where an edge slides. In a tick that was cut into pieces,
a contact that let go is drawn where it acted, not where the body is by then.

Where an instant has more contacts than fit into a page, the largest are kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.analysis.recorded_contacts import contact_topics, read_points
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.contact_packing import FORCE, GAP, NORMAL, OTHER, POINT
from rigid_body_sim.view.page_numbers import PageNumbers

Array = NDArray[np.float64]

LARGEST = 16_000_000  # [byte] of arrows in one page
BYTES_PER_ARROW = 24
USUAL = 0.9  # [-] share of the forces that are no longer than the usual arrow
MOST_LIVE = 1000  # [-] arrows of an instant of a run that goes on
LONGEST = 4.0  # [-] usual arrows: an impact would hide all else


@dataclass(frozen=True, eq=False)
class ContactArrows:
    """
    Arrows at the instants of a page.

    starts : (k + 1,)  where those of each instant begin
    arrows : (n, 6)    point [m] and force [N], world axes
    left   : how many smaller ones were left out
    """

    starts: NDArray[np.int64]
    arrows: Array
    left: int

    def drawn(self, numbers: PageNumbers, length: float) -> dict[str, Any]:
        """
        Give what the page needs.

        numbers : takes the arrows
        length  : [m] of an arrow that only a tenth of the forces exceed
        """
        sizes = np.linalg.norm(self.arrows[:, 3:], axis=1)
        usual = float(np.quantile(sizes, USUAL)) if sizes.size else 0.0
        return {
            'starts': numbers.add(self.starts, 'u4'),
            'arrows': numbers.add_places(self.arrows, length),
            'metres': length / usual if usual > 0.0 else 0.0,  # per newton
            'longest': LONGEST * length,
            'left': self.left,
        }


def read_arrows(bag: Bag, times: Array, places: Mapping[str, int]) -> ContactArrows | None:
    """
    Read the contact forces at some instants; None where the bag has no topic for contacts.

    times  : (k,) [s] of the page, ascending
    places : place of each body in the scene, by name; a body that is not named there has none
    """
    topics = contact_topics(bag)
    if not topics:
        return None
    told = {places.get(body, -1) for body in topics.values()}
    instants = {int(t): i for i, t in enumerate(np.rint(times * 1e9))}
    found: list[list[Array]] = [[] for _ in times]
    for message in bag.messages_by_time(topics):
        instant = instants.get(message.log_time)
        if instant is None:
            continue
        place = places.get(topics[message.topic], -1)
        found[instant].append(_arrows(read_points(message.data), place, told))
    return _largest(found, max(1, LARGEST // (BYTES_PER_ARROW * max(1, len(times)))))


def arrows_of(touching: Sequence[Mapping[str, Array]], places: Mapping[str, int]) -> ContactArrows:
    """
    Give the arrows of what bodies were told of at some instants.

    touching : as `RecordedMotion` has it;   places : of each body in the scene, by name
    """
    found = []
    for told in touching:
        own = {places.get(body, -1) for body in told}
        found.append([_arrows(rows, places.get(body, -1), own) for body, rows in told.items()])
    return _largest(found, MOST_LIVE)


def _arrows(points: Array, place: int, told: set[int]) -> Array:
    """Arrows (k, 6) of the contacts of a body, but of those that another body tells too."""
    others = points[:, OTHER].astype(np.int64)
    twice = np.isin(others, list(told)) & (others > place)
    surface = points[:, POINT] + 0.5 * points[:, GAP, None] * points[:, NORMAL]
    return np.hstack((surface, points[:, FORCE]))[~twice]


def _largest(found: Sequence[Sequence[Array]], room: int) -> ContactArrows:
    """Put the arrows of all instants together, of each as many as there is room for."""
    kept, left = [np.zeros((0, 6))], 0
    starts = np.zeros(len(found) + 1, dtype=np.int64)
    for i, parts in enumerate(found):
        arrows = np.concatenate([np.zeros((0, 6)), *parts])
        if len(arrows) > room:
            order = np.argsort(-np.sum(arrows[:, 3:] ** 2, axis=1), kind='stable')
            left += len(arrows) - room
            arrows = arrows[order[:room]]
        kept.append(arrows)
        starts[i + 1] = starts[i] + len(arrows)
    return ContactArrows(starts, np.concatenate(kept), left)
