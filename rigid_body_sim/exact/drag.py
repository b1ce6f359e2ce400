# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Motion against drag: linear, and quadratic along the vertical.

m v' = m g - c v   or   m v' = m g - b |v| v

Linear, any direction, v_inf = m g/c:
    v = v_inf + (v0 - v_inf) e^(-c t/m),  r = r0 + v_inf t + (v0 - v_inf) (m/c) (1 - e^(-c t/m))
Quadratic, z upwards, v_t = sqrt(m g/b):
    fall from rest: v = -v_t tanh(g t/v_t),  z = z0 - (v_t^2/g) ln cosh(g t/v_t)
    rise at v0 > 0: v = v_t tan(a - g t/v_t),  z = z0 + (v_t^2/g) ln(cos(a - g t/v_t)/cos a),
                    a = atan(v0/v_t), until t = v_t a/g, height (v_t^2/(2 g)) ln(1 + (v0/v_t)^2)
Source: textbook.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Array, Translation, column


def linear(
    t: ArrayLike,
    *,
    mass: float,
    coefficient: float,
    acceleration: ArrayLike,
    position: ArrayLike,
    velocity: ArrayLike,
) -> Translation:
    """
    Flight with linear drag in a uniform field.

    t            : (*T) [s]
    mass         : [kg]          > 0
    coefficient  : [N s/m]       c > 0
    acceleration : (d,) [m/s^2]  of the field; gravity, say
    position     : (d,) [m]      at t = 0, world
    velocity     : (d,) [m/s]    at t = 0, world
    """
    s = column(t)
    r0, v0, g = (np.asarray(x, dtype=float) for x in (position, velocity, acceleration))
    rate = coefficient / mass
    v_inf = g / rate
    return Translation(
        r0 + v_inf * s - (v0 - v_inf) * np.expm1(-rate * s) / rate,
        v_inf + (v0 - v_inf) * np.exp(-rate * s),
    )


def terminal_speed(*, mass: float, coefficient: float, gravity: float) -> float:
    """Speed [m/s] at which quadratic drag b v^2 carries the weight: sqrt(m g/b)."""
    return float(np.sqrt(mass * gravity / coefficient))


def quadratic_fall(
    t: ArrayLike, *, mass: float, coefficient: float, gravity: float, height: float = 0.0
) -> Translation:
    """
    Fall from rest with quadratic drag.

    t           : (*T) [s]
    mass        : [kg]        > 0
    coefficient : [N s^2/m^2] b > 0
    gravity     : [m/s^2]     > 0, downwards
    height      : [m]         at t = 0
    returns d = 1: z [m] and its rate [m/s], upwards
    """
    v_t = terminal_speed(mass=mass, coefficient=coefficient, gravity=gravity)
    x = gravity * column(t) / v_t
    return Translation(height - v_t**2 / gravity * _log_cosh(x), -v_t * np.tanh(x))


def quadratic_rise(
    t: ArrayLike,
    *,
    mass: float,
    coefficient: float,
    gravity: float,
    speed: float,
    height: float = 0.0,
) -> Translation:
    """
    Rise with quadratic drag, up to the apex and not beyond.

    t     : (*T) [s]  0 <= t <= apex time
    speed : [m/s]     > 0, upwards, at t = 0
    Other arguments and the result as in `quadratic_fall`.
    """
    v_t = terminal_speed(mass=mass, coefficient=coefficient, gravity=gravity)
    start = np.arctan(speed / v_t)
    x = start - gravity * column(t) / v_t
    gain = np.log(np.cos(x) / np.cos(start))
    return Translation(height + v_t**2 / gravity * gain, v_t * np.tan(x))


def apex(*, mass: float, coefficient: float, gravity: float, speed: float) -> tuple[float, float]:
    """Return time [s] to and height [m] of the highest point of `quadratic_rise`."""
    v_t = terminal_speed(mass=mass, coefficient=coefficient, gravity=gravity)
    time = v_t / gravity * np.arctan(speed / v_t)
    height = v_t**2 / (2.0 * gravity) * np.log1p((speed / v_t) ** 2)
    return float(time), float(height)


def _log_cosh(x: Array) -> Array:
    """Return ln cosh x for x >= 0, without overflow at large x and without loss at small x."""
    small = np.log1p(2.0 * np.sinh(0.5 * np.minimum(x, 1.0)) ** 2)
    return np.where(x < 1.0, small, x + np.log1p(np.exp(-2.0 * x)) - np.log(2.0))
