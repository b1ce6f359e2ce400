# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Coulomb friction on level ground: a block that stops, a wheel that begins to roll.

Block:  distance v0^2/(2 mu g), time v0/(mu g)
Wheel of inertia I = beta m R^2, thrown without spin:
    sliding: v = v0 - mu g t,  R w = mu g t/beta
    rolling: v = R w = v0/(1 + beta), from t* = v0/(mu g (1 + 1/beta)) on
    solid sphere, beta = 2/5: t* = 2 v0/(7 mu g), v = 5 v0/7
Without friction both move on at v0 for ever, and the times and the distance are infinite.
Source: textbook. Rigid bodies, no rolling friction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Array


class Slide(NamedTuple):
    """
    Motion along the ground.

    distance      : (*T) [m]
    speed         : (*T) [m/s]
    surface_speed : (*T) [m/s]  R w, radius times spin; equal to `speed` when rolling
    """

    distance: Array
    speed: Array
    surface_speed: Array


def stopping(*, speed: float, friction: float, gravity: float) -> tuple[float, float]:
    """Return time [s] and distance [m] in which a block comes to rest from `speed` [m/s]."""
    deceleration = friction * gravity
    if deceleration == 0.0:
        return math.inf, math.inf
    return speed / deceleration, speed**2 / (2.0 * deceleration)


def block(t: ArrayLike, *, speed: float, friction: float, gravity: float) -> Slide:
    """
    Slide of a block until it rests, and its rest.

    t        : (*T) [s] >= 0
    speed    : [m/s]    > 0 at t = 0
    friction : [-]      coefficient mu >= 0
    gravity  : [m/s^2]  > 0
    """
    end, _ = stopping(speed=speed, friction=friction, gravity=gravity)
    s = np.minimum(np.asarray(t, dtype=float), end)
    deceleration = friction * gravity
    v = np.maximum(speed - deceleration * s, 0.0)
    return Slide(s * (speed - 0.5 * deceleration * s), v, np.zeros_like(v))


def rolling_start(
    *, speed: float, friction: float, gravity: float, beta: float
) -> tuple[float, float]:
    """Return the time [s] at which the wheel begins to roll and its speed [m/s] from then on."""
    stop, _ = stopping(speed=speed, friction=friction, gravity=gravity)
    return stop * beta / (1.0 + beta), speed / (1.0 + beta)


def wheel(t: ArrayLike, *, speed: float, friction: float, gravity: float, beta: float) -> Slide:
    """
    Slide, then roll, of a wheel or ball thrown without spin.

    beta : [-]  I/(m R^2) > 0: solid sphere 2/5, cylinder 1/2, hoop 1
    Other arguments as in `block`.
    """
    t = np.asarray(t, dtype=float)
    start, rolling_speed = rolling_start(
        speed=speed, friction=friction, gravity=gravity, beta=beta
    )
    s = np.minimum(t, start)
    a = friction * gravity
    distance = s * (speed - 0.5 * a * s) + rolling_speed * (t - s)
    rolls = t >= start
    return Slide(
        distance,
        np.where(rolls, rolling_speed, speed - a * s),
        np.where(rolls, rolling_speed, a * s / beta),
    )
