# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How far colliders reach within a tick, and which may touch in it.

A collider reaches as far as its bounding box, what it may move in a tick, and the margin. Two
boxes, or a box and a plane, that pass the tests here are a pair for the narrow phase; `pair_list`
finds them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.collider import (
    BOUNDS,
    CORE,
    POSE,
    TABLE,
    bounding_box,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# reaches: one row per collider; [m], velocity [m/s]; TURN: what turning and forces add; REACH: how
# far beyond its box another may be that a pair of it counts as near, if that one does not move
MIDDLE, HALF, SPEED, TURN, SMALL, REACH = (
    0,
    3,
    6,
    9,
    10,
    11,
)
ROW = 12


@kernel
def find_reaches(
    n: int, h: float, margin: float, table: Indices, bounds: Array, poses: Array, bodies: Array,
    reaches: Array,
) -> None:  # fmt: skip
    """
    Find how far each collider reaches: bounding box, velocity, and what turning adds in a tick.
    """
    for i in range(n):
        b, o = i * BOUNDS, i * ROW
        radius = bounds[b + 7]
        if radius == math.inf:
            continue
        x, y, z, ex, ey, ez = bounding_box(bounds, b, poses, i * POSE)
        reaches[o], reaches[o + 1], reaches[o + 2] = x, y, z
        reaches[o + 3], reaches[o + 4], reaches[o + 5] = ex, ey, ez
        small = min(margin, 0.1 * radius) if radius > 0.0 else margin
        reaches[o + SMALL] = small
        core = table[i * TABLE + CORE]
        speed = 0.0
        if core >= 0:
            m = core * solver_bodies.SIZE
            u, v, w = (
                bodies[m + solver_bodies.MOMENTUM],
                bodies[m + solver_bodies.MOMENTUM + 1],
                bodies[m + solver_bodies.MOMENTUM + 2],
            )
            im = bodies[m + solver_bodies.INVERSE_MASS]
            u, v, w = u * im, v * im, w * im
            reaches[o + SPEED], reaches[o + SPEED + 1], reaches[o + SPEED + 2] = u, v, w
            speed = math.sqrt(u * u + v * v + w * w) * h
            a, b2, c = (
                bodies[m + solver_bodies.ANGULAR_MOMENTUM],
                bodies[m + solver_bodies.ANGULAR_MOMENTUM + 1],
                bodies[m + solver_bodies.ANGULAR_MOMENTUM + 2],
            )
            i1, i2, i3 = (
                bodies[m + solver_bodies.INVERSE_INERTIA],
                bodies[m + solver_bodies.INVERSE_INERTIA + 1],
                bodies[m + solver_bodies.INVERSE_INERTIA + 2],
            )
            i4, i5, i6 = (
                bodies[m + solver_bodies.INVERSE_INERTIA + 3],
                bodies[m + solver_bodies.INVERSE_INERTIA + 4],
                bodies[m + solver_bodies.INVERSE_INERTIA + 5],
            )
            p = i1 * a + i2 * b2 + i3 * c
            q = i2 * a + i4 * b2 + i5 * c
            r = i3 * a + i5 * b2 + i6 * c
            u, v, w = (
                x - bodies[m + solver_bodies.START_POSITION],
                y - bodies[m + solver_bodies.START_POSITION + 1],
                z - bodies[m + solver_bodies.START_POSITION + 2],
            )
            lever = math.sqrt(u * u + v * v + w * w) + radius
            turn = math.sqrt(p * p + q * q + r * r) * lever * h
            u, v, w = (
                bodies[m + solver_bodies.FREE_ACCELERATION],
                bodies[m + solver_bodies.FREE_ACCELERATION + 1],
                bodies[m + solver_bodies.FREE_ACCELERATION + 2],
            )
            fall = math.sqrt(u * u + v * v + w * w) * h * h
            reaches[o + TURN] = min(turn, 2.0 * lever) + fall
        reaches[o + REACH] = 0.5 * small + speed + reaches[o + TURN]


@inline
def margin_of(reaches: Array, a: int, b: int, h: float) -> float:
    """Gap within which two colliders may meet in a tick [m]."""
    u = reaches[b + SPEED] - reaches[a + SPEED]
    v = reaches[b + SPEED + 1] - reaches[a + SPEED + 1]
    w = reaches[b + SPEED + 2] - reaches[a + SPEED + 2]
    return (
        min(reaches[a + SMALL], reaches[b + SMALL])
        + h * math.sqrt(u * u + v * v + w * w)
        + (reaches[a + TURN] + reaches[b + TURN])
    )


@inline
def may_meet(reaches: Array, a: int, b: int, h: float) -> bool:
    """Tell whether two colliders may touch in a tick; a, b: where their rows begin."""
    margin = margin_of(reaches, a, b, h)
    return (
        abs(reaches[b] - reaches[a]) <= reaches[a + HALF] + reaches[b + HALF] + margin
        and abs(reaches[b + 1] - reaches[a + 1])
        <= reaches[a + HALF + 1] + reaches[b + HALF + 1] + margin
        and abs(reaches[b + 2] - reaches[a + 2])
        <= reaches[a + HALF + 2] + reaches[b + HALF + 2] + margin
    )


@inline
def meets_plane(at: int, b: int, h: float, reaches: Array, numbers: Array, bounds: Array) -> bool:
    """Tell whether collider b may touch the plane whose numbers begin at a place."""
    nx, ny, nz = numbers[at], numbers[at + 1], numbers[at + 2]
    o = b * ROW
    x, y, z = reaches[o], reaches[o + 1], reaches[o + 2]
    extent = min(
        abs(nx) * reaches[o + HALF]
        + abs(ny) * reaches[o + HALF + 1]
        + abs(nz) * reaches[o + HALF + 2],
        bounds[b * BOUNDS + 7],
    )
    toward = -(nx * reaches[o + SPEED] + ny * reaches[o + SPEED + 1] + nz * reaches[o + SPEED + 2])
    margin = reaches[o + SMALL] + max(toward, 0.0) * h + reaches[o + TURN]
    return nx * x + ny * y + nz * z - numbers[at + 3] - extent <= margin
