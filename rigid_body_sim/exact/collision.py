# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts without friction: two bodies, and a ball that bounces on the ground.

Two bodies, n from A to B:  J = (1 + e) mu (v_A - v_B).n,  1/mu = 1/m_A + 1/m_B
    v_A -= J n/m_A,  v_B += J n/m_B,  energy lost = mu (1 - e^2) ((v_A - v_B).n)^2/2
Ball dropped from h0 in gravity g, t0 = sqrt(2 h0/g):
    impact k (k = 0, 1, ...) at t0 (1 + 2 (e + ... + e^k)), flight after it 2 t0 e^(k+1),
    at rest from t0 (1 + e)/(1 - e); with e = 1 it never rests
    e : [-] restitution  J : [N s]
Source: textbook. A central impact: the normal passes through both centres of mass.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Array, Translation, column


class Impact(NamedTuple):
    """
    What an impact leaves.

    velocity_a, velocity_b : (d,) [m/s]  afterwards
    impulse                : (d,) [N s]  received by B; A receives the opposite
    energy_lost            : [J]
    """

    velocity_a: Array
    velocity_b: Array
    impulse: Array
    energy_lost: float


def impact(
    *,
    mass_a: float,
    mass_b: float,
    velocity_a: ArrayLike,
    velocity_b: ArrayLike,
    normal: ArrayLike,
    restitution: float,
) -> Impact:
    """
    Velocities after a frictionless central impact.

    mass_a, mass_b         : [kg]        may be infinite (a wall)
    velocity_a, velocity_b : (d,) [m/s]  before
    normal                 : (d,) [-]    unit vector from A to B
    restitution            : [-]         0 (they stay together) to 1 (elastic)
    Bodies that part already are left alone.
    """
    v_a, v_b, n = (np.asarray(x, dtype=float) for x in (velocity_a, velocity_b, normal))
    closing = max(float((v_a - v_b) @ n), 0.0)
    reduced_mass = 1.0 / (1.0 / mass_a + 1.0 / mass_b)
    impulse = (1.0 + restitution) * reduced_mass * closing * n
    return Impact(
        v_a - impulse / mass_a,
        v_b + impulse / mass_b,
        impulse,
        0.5 * reduced_mass * (1.0 - restitution) * (1.0 + restitution) * closing**2,
    )


def bounce_times(count: int, *, height: float, gravity: float, restitution: float) -> Array:
    """
    Instants [s] of the first impacts of a ball dropped from rest.

    height      : [m]  of its lowest point above the ground
    gravity     : [m/s^2] > 0
    restitution : [-]  0 <= e <= 1
    """
    powers = restitution ** np.arange(1, count)
    fall = np.sqrt(2.0 * height / gravity)
    return fall * (1.0 + 2.0 * np.concatenate([[0.0], np.cumsum(powers)]))


def rest_time(*, height: float, gravity: float, restitution: float) -> float:
    """Instant [s] at which the bouncing ends: t0 (1 + e)/(1 - e); infinite for e = 1."""
    if restitution == 1.0:
        return math.inf
    fall = np.sqrt(2.0 * height / gravity)
    return float(fall * (1.0 + restitution) / (1.0 - restitution))


def bouncing(t: ArrayLike, *, height: float, gravity: float, restitution: float) -> Translation:
    """
    Height and upward velocity of a ball dropped from rest that bounces until it rests.

    t           : (*T) [s] >= 0
    restitution : [-]  0 <= e <= 1
    Other arguments as in `bounce_times`. At an impact the velocity is that after it.
    returns d = 1
    """
    e, s = restitution, column(t)
    if not 0.0 <= e <= 1.0:
        raise ValueError(f'restitution {e:g}; allowed: 0 (it stays down) to 1 (it never rests)')
    fall = np.sqrt(2.0 * height / gravity)
    end = rest_time(height=height, gravity=gravity, restitution=e)
    flying, resting = s < fall, s >= end
    hopped = np.where(flying | resting, 0.0, 0.5 * (s / fall - 1.0))  # [-] e + ... + e^k, and on
    impacts = _impacts(hopped, e)
    since = s - fall * (1.0 + 2.0 * e * _sum_of_powers(impacts, e))
    impacts += np.where(
        since < 0.0, -1.0, np.where(since >= 2.0 * fall * e ** (impacts + 1), 1, 0)
    )
    impacts = np.maximum(impacts, 0.0)  # rounding may have put an instant beside its flight
    since = s - fall * (1.0 + 2.0 * e * _sum_of_powers(impacts, e))
    launch = gravity * fall * e ** (impacts + 1.0)
    z = np.where(flying, height - 0.5 * gravity * s**2, since * (launch - 0.5 * gravity * since))
    v = np.where(flying, -gravity * s, launch - gravity * since)
    return Translation(np.where(resting, 0.0, z), np.where(resting, 0.0, v))


def _sum_of_powers(count: Array, e: float) -> Array:
    """Return 1 + e + ... + e^(count - 1) = (1 - e^count)/(1 - e), also where e is 1 or near."""
    if e in (0.0, 1.0):
        return count if e == 1.0 else np.minimum(count, 1.0)
    return -np.expm1(count * np.log(e)) / (1.0 - e)


def _impacts(hopped: Array, e: float) -> Array:
    """Return how many terms of e + e^2 + ... fit into a sum: the inverse of `_sum_of_powers`."""
    if e in (0.0, 1.0):
        return np.floor(hopped)
    share = np.minimum(hopped * ((1.0 - e) / e), 1.0 - np.finfo(float).epsneg)  # 1 - e^k
    return np.floor(np.log1p(-share) / np.log(e))
