# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ticks that are cut at impacts: for islands in which what flies meets what the solver moves, or
comes to rest.

    until the tick is over: to the next impact by a piece of the tick, in which the pairs that meet
    are hidden from the solver; the impact, and what follows from it at that instant; and on

The first guess of an instant is that of free flight. The piece itself tells how far the two are
apart at its end, and at what speed they approach, and Newton's method goes on from there: the
instant is that of the motion as the solver makes it.

Each island is cut at its own instants, as a manner of its own (`islands.manners`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.events import event_lists, impact_list
from rigid_body_sim.physics.contact.islands.manners import WHOLE, bodies_of_colliders, followed

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

MOST_CUTS = 32  # [-] of a tick of an island; what meets then is left to the solver
NEWTON_STEPS = 6  # [-] to an instant; 1 to 3 are needed where the solver is smooth
EXACT = 1e-16  # [-] of the tick: a better instant is none
SAME_INSTANT = 1e-9  # [-] of a tick: what begins so little before one begins with it
FIRST = 1 << 40  # manner of the first island that is cut: finer than any number of pieces


def _roots(count: int, links: Indices) -> Indices:
    """Of each body the first of those with which impacts of the last tick join it."""
    return followed(links[:count].copy())


def manners_wanted(count: int, links: Indices) -> Indices:
    """Manner that each body wants: a number of its own for each island that is to be cut."""
    roots = _roots(count, links)
    concerned = links[event_lists.CONCERNED * count : (event_lists.CONCERNED + 1) * count]
    return np.where(concerned[roots] == 1, FIRST + roots, WHOLE)


def pairs_met(count: int, links: Indices) -> Indices:
    """Pairs (m, 2) of bodies that impacts of the last tick join."""
    roots = _roots(count, links)
    return np.stack((roots, np.arange(count)), axis=1)[roots != np.arange(count)]


def pairs_struck(impacts: list[Array], table: Indices) -> Indices:
    """Pairs (m, 2) of moving bodies of some impacts."""
    rows = np.concatenate([np.zeros((0, impact_list.SIZE)), *(_rows(part) for part in impacts)])
    columns = [impact_list.COLLIDER_A, impact_list.COLLIDER_B]
    pairs = bodies_of_colliders(table)[rows[:, columns].astype(np.int64)]
    return pairs[(pairs >= 0).all(axis=1)]


def _rows(impacts: Array) -> Array:
    return impacts.reshape(-1, impact_list.SIZE)


def of_manner(impacts: list[Array], manner: int, wanted: Indices, table: Indices) -> list[Array]:
    """Those of some impacts whose bodies want a manner."""
    if not impacts:
        return []
    rows = np.concatenate([_rows(part) for part in impacts])
    bodies = bodies_of_colliders(table)
    columns = [impact_list.COLLIDER_A, impact_list.COLLIDER_B]
    of_pair = bodies[rows[:, columns].astype(np.int64)].max(axis=1)
    return [rows[np.append(wanted, WHOLE)[of_pair] == manner].ravel()]


def in_order(impacts: list[Array]) -> list[Array]:
    """Put the impacts of one tick in the order of their instants."""
    if not impacts:
        return []
    rows = np.concatenate([_rows(part) for part in impacts])
    order = np.argsort(rows[:, impact_list.PART], kind='stable')
    return [rows[order].ravel()]


def better_instant(length: float, seen: Any, most: float) -> float:
    """
    Improve a length [s] after which two meet by what is seen then, by Newton's method.

    seen : gap [m] and approach [m/s];   most : [s] the largest that is possible
    """
    gap, approach = seen
    if not approach > 0.0:
        return length
    return min(max(length + gap / approach, 0.0), most)


def have_met(seen: Any, h: float) -> bool:
    """
    Tell whether two touch that a piece up to the end of the tick [s] has brought together.

    seen : gap [m] and approach [m/s]
    """
    gap, approach = seen
    return gap <= max(approach, 0.0) * SAME_INSTANT * h


def number_of(ticks: Any, h: float, whole: float) -> Any:
    """Give the numbers of the ticks of a length [s] in which ticks of another one begin."""
    return np.floor(h * ticks / whole + SAME_INSTANT)


def count_in(impacts: Array, h: float, whole: float) -> None:
    """
    Count the instants of impacts in ticks of another length, in place.

    h, whole : [s] of the ticks so far, and from now on
    """
    start = h * impacts[impact_list.TICK :: impact_list.SIZE]
    ticks = number_of(impacts[impact_list.TICK :: impact_list.SIZE], h, whole)
    impacts[impact_list.PART :: impact_list.SIZE] += start - ticks * whole
    impacts[impact_list.TICK :: impact_list.SIZE] = ticks
