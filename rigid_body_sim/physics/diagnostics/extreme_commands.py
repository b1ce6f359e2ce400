# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Commands of a size that no method follows, for the words of a run that diverged.

    held    : dv = |F| T / m,   domega = |tau| T / I_min
    impulse : dv = |J| / m,     domega = |H| / I_min
        F, tau : [N], [N m]        what is held, for T [s]
        J, H   : [N s], [N m s]    what is given at once
        I_min  : [kg m^2]          least principal moment about the centre of mass

A command is extreme where dv is above FAST, or h domega above TURN (h [s]: tick). It is a guess,
made only when a run has diverged: a torque that another one balances may be called extreme too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from rigid_body_sim.physics.model.scene import Body, Vector

FAST = 1e4  # [m/s] what stones, robots and rockets stay below; less names commands that are well
TURN = 100.0  # [rad] in a tick, which a hundredth of it would not resolve either; 0.1 is usual
FAR = 1e9  # [m] from the origin, where a place is rounded to 1e-7 m; scenes span up to 1e6
LONGEST_HOLD = 1.0  # [s] of what is held until changed


class Excess(NamedTuple):
    """
    How far a command is beyond what a run bears.

    share : [-] above 1 it is extreme
    words : what it is, and what it does
    place : the body or the topic that it came to
    """

    share: float = 0.0
    words: str = ''
    place: str = ''

    def of(self, place: str) -> Excess:
        """Say where it came."""
        return self._replace(place=place)

    @property
    def blame(self) -> str:
        """Name it as the likely cause."""
        return f'likely by the command to {self.place}: {self.words}; check its size and unit'

    @property
    def is_extreme(self) -> bool:
        """Whether it explains that a run diverges."""
        return self.share > 1.0


NONE = Excess()


def of_push(
    *,
    mass: float,
    moment: float,
    force: Vector,
    torque: Vector,
    dt: float,
    seconds: float | None = LONGEST_HOLD,
) -> Excess:
    """
    Judge what pushes a body.

    mass, moment  : [kg], [kg m^2] the least of all; 0.0: it does not turn
    force, torque : [N], [N m], held for `seconds`; with None an impulse [N s], [N m s]
    dt            : [s] tick
    """
    time, s = (1.0, ' s') if seconds is None else (min(seconds, LONGEST_HOLD), '')
    held = 'at once' if seconds is None else f'within {time:g} s'
    pushed, turned = math.hypot(*force), math.hypot(*torque)
    speed = pushed / mass * time
    kind, twist = ('impulse', 'angular impulse') if seconds is None else ('force', 'torque')
    found = [
        Excess(speed / FAST, f'{kind} of {pushed:.3g} N{s}, which gives {speed:.3g} m/s {held}')
    ]
    if turned and moment:
        spin = turned / moment * time
        words = f'{twist} of {turned:.3g} N m{s}, which gives {spin:.3g} rad/s {held}'
        found.append(Excess(spin * dt / TURN, words))
    return worst(found)


def largest_modest(*, mass: float, moment: float, dt: float) -> float:
    """Give a size [N, N m, N s, N m s] up to which `of_push` finds nothing extreme."""
    return min(FAST * mass, TURN / dt * moment if moment else math.inf) / max(1.0, LONGEST_HOLD)


def of_state(*, position: Vector, velocity: Vector, spin: Vector, dt: float) -> Excess:
    """Judge where a body is put [m], and how it moves then [m/s], [rad/s]."""
    distance, speed, turn = (math.hypot(*values) for values in (position, velocity, spin))
    return worst(
        [
            Excess(distance / FAR, f'position {distance:.3g} m from the origin'),
            Excess(speed / FAST, f'velocity of {speed:.3g} m/s'),
            Excess(turn * dt / TURN, f'angular velocity of {turn:.3g} rad/s'),
        ]
    )


def worst(found: Iterable[Excess]) -> Excess:
    """Choose what is farthest beyond."""
    return max(found, key=lambda excess: excess.share)


def least_moment(body: Body) -> float:
    """Give the least principal moment of inertia [kg m^2]; 0.0 of what does not turn."""
    if body.inertia is None:
        return 0.0
    with np.errstate(all='ignore'):
        return max(0.0, float(np.linalg.eigvalsh(body.inertia)[0]))
