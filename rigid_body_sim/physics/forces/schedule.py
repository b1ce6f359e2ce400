# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Instants at which a wrench begins or ends: a table of forces that runs out, a burn-out.

Across a jump every integrator falls to order one. So a tick that holds such an instant is done in
two steps with the instant between them, and what acts is switched on and off between steps: never
by comparing times inside one, where rounding would decide on which side of the jump its last
evaluation lies.
"""

from __future__ import annotations

import math
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
    """The switches of one scene."""

    def __init__(self, switches: Sequence[Switch]) -> None:
        self._switches = tuple(switches)
        instants = {t for s in switches for t in (s.begin, s.end) if math.isfinite(t)}
        self._instants = sorted(instants)

    def cuts(self, tick: float, h: float) -> tuple[float, list[float]]:
        """
        Find the next instant after a tick boundary.

            tick, h : boundary [tick], tick length [s] returns : whole ticks up to the instant
            (infinity if there is none), and if they are none the instants inside
                      the tick that begins here [tick]
        """
        places = [_snapped(t / h) for t in self._instants if abs(t / h) < math.inf]
        coming = [place for place in places if place > tick + SNAP]
        if not coming:
            return math.inf, []
        whole = math.floor(coming[0] - tick)
        return whole, [place for place in coming if place < tick + 1.0] if whole == 0 else []

    def set(self, elements: Array, begin: float, end: float, h: float) -> None:
        """Switch for a step from one place to another [tick], between which no instant lies."""
        middle = 0.5 * (begin + end) * h
        for switch in self._switches:
            elements[switch.place] = 1.0 if switch.begin < middle < switch.end else 0.0


def _snapped(place: float) -> float:
    nearest = round(place)
    return float(nearest) if abs(place - nearest) < SNAP else place
