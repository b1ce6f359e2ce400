# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Motion against drag: linear, and quadratic along the vertical.

m v' = m g - c v   or   m v' = m g - b |v| v

Linear, any direction, x = c t/m, p1 = (1 - e^-x)/x, p2 = (e^-x - 1 + x)/x^2:
    v = v0 e^-x + g t p1,  r = r0 + v0 t p1 + g t^2 p2
Quadratic, z upwards, v_t = sqrt(m g/b), x = g t/v_t:
    fall from rest: v = -v_t tanh x,  z = z0 - (v_t^2/g) ln cosh x
    rise at v0 > 0: v = (v0 - v_t tan x)/(1 + v0/v_t tan x),
                    z = z0 + (v_t^2/g) ln(cos x + v0/v_t sin x),
                    until t = (v_t/g) atan(v0/v_t), height (v_t^2/(2 g)) ln(1 + (v0/v_t)^2)
Each is written in quotients that have a limit where the drag is zero (`quotients`): there the
motion is ballistic, and near there no digit is lost.
Source: textbook.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import quotients
from rigid_body_sim.exact.motion import Array, Translation, column

NEARLY_A_PARABOLA = 1e-4  # [-] below it 2 ln cosh x/x^2 is 1 - x^2/6 to round-off


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
    coefficient  : [N s/m]       c >= 0
    acceleration : (d,) [m/s^2]  of the field; gravity, say
    position     : (d,) [m]      at t = 0, world
    velocity     : (d,) [m/s]    at t = 0, world
    """
    s = column(t)
    r0, v0, g = (np.asarray(x, dtype=float) for x in (position, velocity, acceleration))
    x = coefficient / mass * s
    once, twice = s * quotients.decay_once(x), s * s * quotients.decay_twice(x)
    return Translation(r0 + v0 * once + g * twice, v0 * np.exp(-x) + g * once)


def quadratic_fall(
    t: ArrayLike, *, mass: float, coefficient: float, gravity: float, height: float = 0.0
) -> Translation:
    """
    Fall from rest with quadratic drag.

    t           : (*T) [s]
    mass        : [kg]        > 0
    coefficient : [N s^2/m^2] b >= 0
    gravity     : [m/s^2]     > 0, downwards
    height      : [m]         at t = 0
    returns d = 1: z [m] and its rate [m/s], upwards
    """
    s = column(t)
    x = np.sqrt(gravity * coefficient / mass) * s
    share = np.where(x == 0.0, 1.0, np.tanh(x) / np.where(x == 0.0, 1.0, x))
    return Translation(height - 0.5 * gravity * s**2 * _fallen(x), -gravity * s * share)


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
    s, by_mass = column(t), coefficient / mass
    x = np.sqrt(gravity * by_mass) * s
    # (v_t^2/g) (cos x + v0/v_t sin x - 1): the height without drag, and its logarithm with it
    way = s * (speed * quotients.sine(x) - 0.5 * gravity * s * quotients.sine(0.5 * x) ** 2)
    slope = s * quotients.tangent(x)
    return Translation(
        height + way * quotients.logarithm(by_mass * way),
        (speed - gravity * slope) / (1.0 + speed * by_mass * slope),
    )


def apex(*, mass: float, coefficient: float, gravity: float, speed: float) -> tuple[float, float]:
    """Return time [s] to and height [m] of the highest point of `quadratic_rise`."""
    ratio = speed * np.sqrt(coefficient / (mass * gravity))  # v0/v_t
    time = speed / gravity * (np.arctan(ratio) / ratio if ratio > 0.0 else 1.0)
    height = speed**2 / (2.0 * gravity) * quotients.logarithm(np.asarray(ratio**2))
    return float(time), float(height)


def _fallen(x: Array) -> Array:
    """Return 2 ln cosh x/x^2 for x >= 0: no overflow at large x, no loss at small, 1 at 0."""
    small = np.log1p(2.0 * np.sinh(0.5 * np.minimum(x, 1.0)) ** 2)
    log_cosh = np.where(x < 1.0, small, x + np.log1p(np.exp(-2.0 * x)) - np.log(2.0))
    near = x < NEARLY_A_PARABOLA
    far = np.where(near, 1.0, x)
    return np.where(near, 1.0 - np.minimum(x, 1.0) ** 2 / 6.0, 2.0 * log_cosh / far / far)
