# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Instants at which a wrench begins, ends, or changes its course: a table of forces that runs out,
its rows, a burn-out.

Across a jump every integrator falls to order one, across a kink to order two, across the row of a
spline to order four. So a tick that holds such an instant is done in
two steps with the instant between them, and what acts is switched on and off between steps: never
by comparing times inside one, where rounding would decide on which side of the jump its last
evaluation lies.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A jump this near to a tick boundary is at it: instant / dt is rounded by 1e-16 of the tick
# number. A larger value misplaces what acts by that share of a tick; a smaller one makes steps of
# no length, which cost time and no more.
SNAP = 1e-9  # [tick]


class Switch(NamedTuple):
    """
    One element that acts for a while only.

    place      : where in the tables the 1 or 0 stands that the kernel reads
    begin, end : [s]
    """

    place: int
    begin: float
    end: float


class Schedule:
    """
    The switches of one scene, and the kinks of what acts: instants [s], ascending, at which a
    wrench goes on but changes its course. A kink matters inside a tick alone.
    """

    def __init__(self, switches: Sequence[Switch], kinks: Array | None = None) -> None:
        self._switches = tuple(switches)
        instants = {t for s in switches for t in (s.begin, s.end) if math.isfinite(t)}
        self._instants = np.array(sorted(instants), dtype=np.float64)
        self._kinks = np.zeros(0) if kinks is None else kinks
        self._placed_for: tuple[float, float] | None = None
        self._jumps: list[float] = []
        self._bends: list[float] = []

    def cuts(self, tick: float, h: float) -> tuple[float, list[float]]:
        """
        Find the next instant after a tick boundary.

        tick, h : boundary [tick], tick length [s]
        returns : whole ticks up to the instant, or to the tick that holds it (infinity if there
                  is none), and if they are none the instants inside the tick that begins here
                  [tick]
        """
        self._place(tick, h)
        coming = [places[k] for places, k in self._after(tick + SNAP) if k < len(places)]
        if not coming:
            return math.inf, []
        whole = math.floor(min(coming) - tick)
        if whole > 0:
            return whole, []
        inside = {
            place
            for places, first in self._after(tick + SNAP)
            for place in places[first : bisect_left(places, tick + 1.0)]
        }
        return 0, sorted(inside)

    def _after(self, place: float) -> tuple[tuple[list[float], int], ...]:
        """Where in both lists the first place stands that lies behind another [tick]."""
        return tuple((found, bisect_right(found, place)) for found in (self._jumps, self._bends))

    def _place(self, tick: float, h: float) -> None:
        """Find the places of the instants [tick], once for each tick length."""
        offset = round(tick - math.floor(tick), 9)  # not zero where a recording has another dt
        if self._placed_for != (h, offset):
            self._placed_for = (h, offset)
            self._jumps = _snapped(_ticks(self._instants, h)).tolist()
            bends = _snapped(_ticks(self._kinks, h))
            from_boundary = np.abs(bends - offset - np.round(bends - offset))
            self._bends = bends[from_boundary >= SNAP].tolist()

    def set(self, elements: Array, begin: float, end: float, h: float) -> None:
        """Switch for a step from one place to another [tick], between which no instant lies."""
        middle = 0.5 * (begin + end) * h
        for switch in self._switches:
            elements[switch.place] = 1.0 if switch.begin < middle < switch.end else 0.0


def _ticks(instants: Array, h: float) -> Array:
    """Places [tick] of instants [s], without those that no run comes to."""
    with np.errstate(over='ignore'):
        places = instants / h
    return places[np.isfinite(places)]


def _snapped(places: Array) -> Array:
    """Put on tick boundaries what is as good as there."""
    nearest = np.round(places)
    return np.where(np.abs(places - nearest) < SNAP, nearest, places)


def places_of(instants: Array, h: float) -> Array:
    """Places [tick] of instants [s], as a schedule has them."""
    return _snapped(_ticks(instants, h))
