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
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
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
    limit = max(16.0 * q[p + contact_point.WARM_NORMAL], LOAD * q[p + contact_point.NORMAL_MASS])
    new = q[p + contact_point.NORMAL_IMPULSE]
    return limit / new if new > limit else 1.0


@kernel
def carry_on(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Let the loads of one point of each lane go on; add what it gave to the sums of the tick."""
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        new, t, o = (
            q[k + contact_point.NORMAL_IMPULSE],
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
        )
        most = q[k + contact_point.LARGEST_NORMAL_IMPULSE]
        x, y, z = vector(q, k + contact_point.TOTAL_IMPULSE)
        q[k + contact_point.LARGEST_NORMAL_IMPULSE] = new if new > most else most
        (
            q[k + contact_point.TOTAL_IMPULSE],
            q[k + contact_point.TOTAL_IMPULSE + 8],
            q[k + contact_point.TOTAL_IMPULSE + 16],
        ) = x + new, y + t, z + o
        keep = lasting(q, k)
        new, t, o = keep * new, keep * t, keep * o
        (
            q[k + contact_point.NORMAL_IMPULSE],
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
        ) = new, t, o
        new, t, o = 0.5 * new, 0.5 * t, 0.5 * o
        x = new * nx + (t * tx + o * ox)
        y = new * ny + (t * ty + o * oy)
        z = new * nz + (t * tz + o * oz)
        (
            q[k + contact_point.WARM_NORMAL],
            q[k + contact_point.WARM_TANGENT_1],
            q[k + contact_point.WARM_TANGENT_2],
        ) = new, t, o
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


@kernel
def carry_twist_on(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        r, p, turn = (
            0.5 * q[k + contact_point.ROLLING_IMPULSE_1],
            0.5 * q[k + contact_point.ROLLING_IMPULSE_2],
            0.5 * q[k + contact_point.TWIST_IMPULSE],
        )
        (
            q[k + contact_point.WARM_ROLLING_1],
            q[k + contact_point.WARM_ROLLING_2],
            q[k + contact_point.WARM_TWIST],
        ) = r, p, turn
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
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        ax, ay, az, bx, by, bz = arms(q, k)
        normal = q[k + contact_point.NORMAL_IMPULSE]
        t, o = disc(
            q[k + contact_point.TANGENT_IMPULSE_1],
            q[k + contact_point.TANGENT_IMPULSE_2],
            s[k + constraint.FRICTION] * normal,
        )
        q[k + contact_point.TANGENT_IMPULSE_1], q[k + contact_point.TANGENT_IMPULSE_2] = t, o
        normal, t, o = 0.5 * normal, 0.5 * t, 0.5 * o
        x = normal * nx + (t * tx + o * ox)
        y = normal * ny + (t * ty + o * oy)
        z = normal * nz + (t * tz + o * oz)
        (
            q[k + contact_point.WARM_NORMAL],
            q[k + contact_point.WARM_TANGENT_1],
            q[k + contact_point.WARM_TANGENT_2],
        ) = normal, t, o
        (
            q[k + contact_point.TOTAL_IMPULSE],
            q[k + contact_point.TOTAL_IMPULSE + 8],
            q[k + contact_point.TOTAL_IMPULSE + 16],
        ) = 0.0, 0.0, 0.0
        q[k + contact_point.LARGEST_NORMAL_IMPULSE] = 0.0
        q[k + contact_point.SEPARATION] = q[k + contact_point.INITIAL_SEPARATION]
        strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


@kernel
def turn_twist(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for k in range(lanes):
        x, y, z = vector(q, k + contact_point.RECALLED_ANGULAR_IMPULSE)
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        r, p, turn = tx * x + ty * y + tz * z, ox * x + oy * y + oz * z, nx * x + ny * y + nz * z
        (
            q[k + contact_point.ROLLING_IMPULSE_1],
            q[k + contact_point.ROLLING_IMPULSE_2],
            q[k + contact_point.TWIST_IMPULSE],
        ) = r, p, turn
        (
            q[k + contact_point.WARM_ROLLING_1],
            q[k + contact_point.WARM_ROLLING_2],
            q[k + contact_point.WARM_TWIST],
        ) = 0.5 * r, 0.5 * p, 0.5 * turn
        twist(g, k, 0.5 * x, 0.5 * y, 0.5 * z)


@kernel
def give(used: int, place: int, s: Array, g: Array, bodies: Array) -> None:
    """Give the bodies of a batch the loads of its points, as momenta at `place`."""
    for k in range(used):
        a, b = int(s[k + constraint.BODY_A]), int(s[k + constraint.BODY_B])
        for axis in range(3):
            row = k + 8 * axis
            bodies[a + place + axis] -= g[row + lane_scratch.IMPULSE]
            bodies[b + place + axis] += g[row + lane_scratch.IMPULSE]
            bodies[a + place + 3 + axis] += g[row + lane_scratch.ANGULAR_MOMENTUM_A]
            bodies[b + place + 3 + axis] += g[row + lane_scratch.ANGULAR_MOMENTUM_B]


@kernel
def clear(lanes: int, g: Array) -> None:
    """Begin the sums of a batch."""
    for k in range(lanes):
        for axis in range(3):
            g[k + lane_scratch.IMPULSE + 8 * axis] = 0.0
            g[k + lane_scratch.ANGULAR_MOMENTUM_A + 8 * axis] = 0.0
            g[k + lane_scratch.ANGULAR_MOMENTUM_B + 8 * axis] = 0.0
