# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulses from which a substep starts, those of the last one, lane by lane.

    J_t = T . J_W,  |J_t| <= mu J_n        J_W : friction as a vector of the world
    held by B: J, r_B x J; by A: -J, -r_A x J

Between substeps the arms are those of now, so that angular momentum stays. From the last tick
`assembly` leaves J_W in the rows of the sums, and angular impulses in those of the bounce.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver.constraint import (
    BN,
    BO,
    BT,
    GAIN,
    GAP,
    GAP0,
    HN,
    HO,
    HQ,
    HR,
    HS,
    HT,
    JN,
    JO,
    JQ,
    JR,
    JS,
    JT,
    LA,
    LB,
    MOST,
    MU,
    PS,
    SUM,
    T2,
    A,
    B,
    N,
    T,
)
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, disc, strike, twist, vector

Array = NDArray[np.float64]

LOAD = 0.02  # [m/s] what gravity gives in two milliseconds


@inline
def lasting(q: Array, p: int) -> Any:
    """
    Share of the impulse of a point that is a load, from which the next substep starts.

    The impulse of an impact does not last: what it gives once too much lifts the body before it
    is taken back. A load changes the velocity of the point by less than LOAD, or is at most eight
    times what this substep started from.
    """
    limit = max(16.0 * q[p + HN], LOAD * q[p + GAIN])
    new = q[p + JN]
    return limit / new if new > limit else 1.0


@kernel
def carry_on(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Let the loads of one point of each lane go on; add what it gave to the sums of the tick."""
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        new, t, o = q[k + JN], q[k + JT], q[k + JO]
        most = q[k + MOST]
        x, y, z = vector(q, k + SUM)
        q[k + MOST] = new if new > most else most
        q[k + SUM], q[k + SUM + 8], q[k + SUM + 16] = x + new, y + t, z + o
        keep = lasting(q, k)
        new, t, o = keep * new, keep * t, keep * o
        q[k + JN], q[k + JT], q[k + JO] = new, t, o
        new, t, o = 0.5 * new, 0.5 * t, 0.5 * o
        x = new * nx + (t * tx + o * ox)
        y = new * ny + (t * ty + o * oy)
        z = new * nz + (t * tz + o * oz)
        q[k + HN], q[k + HT], q[k + HO] = new, t, o
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


@kernel
def carry_twist_on(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        r, p, turn = 0.5 * q[k + JR], 0.5 * q[k + JQ], 0.5 * q[k + JS]
        q[k + HR], q[k + HQ], q[k + HS] = r, p, turn
        x = r * tx + p * ox + turn * nx
        y = r * ty + p * oy + turn * ny
        z = r * tz + p * oz + turn * nz
        twist(g, k, x, y, z)


@kernel
def turn(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Turn the impulses of the last tick to the tangents of one point of each lane; sum up what they
    are to its bodies.
    """
    for k in range(lanes):
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = vector(q, k + SUM)
        normal = q[k + JN]
        t, o = disc(tx * x + ty * y + tz * z, ox * x + oy * y + oz * z, s[k + MU] * normal)
        q[k + JT], q[k + JO] = t, o
        normal, t, o = 0.5 * normal, 0.5 * t, 0.5 * o
        x = normal * nx + (t * tx + o * ox)
        y = normal * ny + (t * ty + o * oy)
        z = normal * nz + (t * tz + o * oz)
        q[k + HN], q[k + HT], q[k + HO] = normal, t, o
        q[k + SUM], q[k + SUM + 8], q[k + SUM + 16] = 0.0, 0.0, 0.0
        q[k + MOST] = 0.0
        q[k + GAP] = q[k + GAP0]
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


@kernel
def turn_twist(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for k in range(lanes):
        x, y, z = vector(q, k + BN)
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        r, p, turn = tx * x + ty * y + tz * z, ox * x + oy * y + oz * z, nx * x + ny * y + nz * z
        q[k + JR], q[k + JQ], q[k + JS] = r, p, turn
        q[k + HR], q[k + HQ], q[k + HS] = 0.5 * r, 0.5 * p, 0.5 * turn
        q[k + BN], q[k + BT], q[k + BO] = 0.0, 0.0, 0.0
        twist(g, k, 0.5 * x, 0.5 * y, 0.5 * z)


@kernel
def give(used: int, place: int, s: Array, g: Array, bodies: Array) -> None:
    """Give the bodies of a batch the loads of its points, as momenta at `place`."""
    for k in range(used):
        a, b = int(s[k + A]), int(s[k + B])
        for axis in range(3):
            row = k + 8 * axis
            bodies[a + place + axis] -= g[row + PS]
            bodies[b + place + axis] += g[row + PS]
            bodies[a + place + 3 + axis] += g[row + LA]
            bodies[b + place + 3 + axis] += g[row + LB]


@kernel
def clear(lanes: int, g: Array) -> None:
    """Begin the sums of a batch."""
    for k in range(lanes):
        for axis in range(3):
            g[k + PS + 8 * axis] = 0.0
            g[k + LA + 8 * axis] = 0.0
            g[k + LB + 8 * axis] = 0.0
