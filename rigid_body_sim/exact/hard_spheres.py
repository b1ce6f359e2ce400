# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Smooth hard spheres that fly straight and meet: billiards, and Newton's cradle.

Two of them meet after t, the smaller root of |x + v t| = R, in the form without cancellation

    t = (x^2 - R^2) / (-x.v + sqrt((x.v)^2 - v^2 (x^2 - R^2))),   x.v < 0
    x, v : position [m] and velocity [m/s] of one against the other     R : sum of the radii [m]

and the impact is central: `collision.impact`. Of spheres that touch, a pair at a time meets, the
one that approaches fastest first, until nobody approaches: so does a row of steel balls, through
which an impact runs as a wave from ball to ball. With N equal balls the last leaves with

    v_N = v (1/2 (1 + e))^(N - 1)
Source: textbook; the rule of pairs: Brogliato, Nonsmooth Mechanics, 3rd ed. (2016), 6.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.collision import impact
from rigid_body_sim.exact.motion import Array, Translation

TOUCHING = 1e-12  # [-] of the radii: spheres closer than that touch
STOPPED = 1e-14  # [m/s] slower approach is none
MOST_IMPACTS = 100_000


def _meeting(x: Array, v: Array, reach: float) -> float:
    """Give the time [s] until two spheres meet; infinity where they do not."""
    closing = float(x @ v)
    if closing >= -STOPPED * reach:
        return math.inf
    apart = float(x @ x) - reach * reach
    if apart <= TOUCHING * reach * reach:
        return 0.0
    inside = closing * closing - float(v @ v) * apart
    return apart / (math.sqrt(inside) - closing) if inside > 0.0 else math.inf


def hard_spheres(
    position: ArrayLike,
    velocity: ArrayLike,
    *,
    mass: ArrayLike,
    radius: ArrayLike,
    restitution: float,
    duration: float,
) -> tuple[Translation, int]:
    """
    Follow spheres from impact to impact: where they are at the end, and how many impacts there
    were.

    position, velocity : (n, d) [m], [m/s]  at the start, not overlapping
    mass, radius       : (n,) or one number [kg], [m]
    duration           : [s]
    """
    x, v = (np.array(given, dtype=float) for given in (position, velocity))
    m, r = (np.broadcast_to(np.asarray(of, dtype=float), len(x)) for of in (mass, radius))
    pairs = [(i, j) for j in range(len(x)) for i in range(j)]
    left = duration
    for count in range(MOST_IMPACTS):
        found = []
        for i, j in pairs:
            time = _meeting(x[j] - x[i], v[j] - v[i], float(r[i] + r[j]))
            if time <= left:
                way = x[j] + v[j] * time - x[i] - v[i] * time
                approach = float((v[j] - v[i]) @ way) / float(np.linalg.norm(way))
                found.append((time, approach, i, j))
        if not found:
            return Translation(x + v * left, v), count
        time, _, i, j = min(found)
        x += v * time
        left -= time
        way = x[j] - x[i]
        after = impact(
            mass_a=float(m[i]), mass_b=float(m[j]), velocity_a=v[i], velocity_b=v[j],
            normal=way / np.linalg.norm(way), restitution=restitution,
        )  # fmt: skip
        v[i], v[j] = after.velocity_a, after.velocity_b
    raise ArithmeticError(f'more than {MOST_IMPACTS} impacts in {duration} s')
