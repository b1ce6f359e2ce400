# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that move farther in a tick than they are large: whether and where they hit.

Conservative advancement: at distance d and with a speed of approach of at most b, nothing can
touch before d/b. The pair is moved on by that time, its distance found again, and so on until it
touches, or the tick is over. A pair that misses gets no contact in this tick: the extended planes
of far faces cannot stop what flies past an edge. A pair that hits asks for a finer tick, in pieces
in which bodies move by less than their size; the pieces are ticks like others.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, specialise, unbound
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.collider import (
    BOUNDS,
    CORE,
    POSE,
    SIZES,
    TABLE,
    TYPE,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT, POINTS, SEPARATION
from rigid_body_sim.physics.contact.collision.swept_aabbs import ROW, SPEED, TURN

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FAST = 0.5  # [-] of the radius of the smaller: motion in a tick from which a pair is advanced
PIECE = 0.25  # [-] of it: motion in a piece of a finer tick
MOST_PIECES = 4096
STEPS = 48  # of the advancement; a pair still undecided then is taken as a hit
TOUCH = 1e-3  # [-] of the radius: distance that counts as touching

# bound for each scene by `specialise`
meet: Callable[..., Any] = unbound


@inline
def size_of(bounds: Array, a: int, b: int) -> Any:
    """Radius of the smaller of two colliders that has one [m]."""
    u, v = bounds[a * BOUNDS + 7], bounds[b * BOUNDS + 7]
    if u <= 0.0:
        return v
    if v <= 0.0:
        return u
    return min(u, v)


@inline
def motion_of(reaches: Array, a: int, b: int, h: float) -> Any:
    """Bound of what two colliders move relative to each other in a tick [m]."""
    o, p = a * ROW, b * ROW
    u = reaches[p + SPEED] - reaches[o + SPEED]
    v = reaches[p + SPEED + 1] - reaches[o + SPEED + 1]
    w = reaches[p + SPEED + 2] - reaches[o + SPEED + 2]
    return math.sqrt(u * u + v * v + w * w) * h + reaches[o + TURN] + reaches[p + TURN]


@kernel
def _move(
    i: int, to: int, time: float, table: Indices, bodies: Array, reaches: Array, poses: Array
) -> None:
    """Write the pose of a collider after free motion over a time."""
    p = i * POSE
    for entry in range(POSE):
        poses[to + entry] = poses[p + entry]
    core = table[i * TABLE + CORE]
    if core < 0:
        return
    o = core * solver_bodies.SIZE
    x, y, z = (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2],
    )
    wx = (
        bodies[o + solver_bodies.INVERSE_INERTIA] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 1] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 2] * z
    )
    wy = (
        bodies[o + solver_bodies.INVERSE_INERTIA + 1] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 3] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 4] * z
    )
    wz = (
        bodies[o + solver_bodies.INVERSE_INERTIA + 2] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 4] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 5] * z
    )
    rate = math.sqrt(wx * wx + wy * wy + wz * wz)
    sine, cosine = 0.0, 1.0
    if rate > 0.0:
        half = 0.5 * rate * time
        sine, cosine = math.sin(half) / rate, math.cos(half)
    qx, qy, qz = sine * wx, sine * wy, sine * wz
    for column in range(4):  # arm of the origin, then the axes
        if column == 0:
            x, y, z = (
                poses[p] - bodies[o + solver_bodies.START_POSITION],
                poses[p + 1] - bodies[o + solver_bodies.START_POSITION + 1],
                poses[p + 2] - bodies[o + solver_bodies.START_POSITION + 2],
            )
        else:
            x, y, z = poses[p + 2 + column], poses[p + 5 + column], poses[p + 8 + column]
        tx, ty, tz = 2.0 * (qy * z - qz * y), 2.0 * (qz * x - qx * z), 2.0 * (qx * y - qy * x)
        x, y, z = (
            x + cosine * tx + (qy * tz - qz * ty),
            y + cosine * ty + (qz * tx - qx * tz),
            z + cosine * tz + (qx * ty - qy * tx),
        )
        if column == 0:
            r = i * ROW + SPEED
            poses[to] = bodies[o + solver_bodies.START_POSITION] + (x + time * reaches[r])
            poses[to + 1] = bodies[o + solver_bodies.START_POSITION + 1] + (
                y + time * reaches[r + 1]
            )
            poses[to + 2] = bodies[o + solver_bodies.START_POSITION + 2] + (
                z + time * reaches[r + 2]
            )
        else:
            poses[to + 2 + column] = x
            poses[to + 5 + column] = y
            poses[to + 8 + column] = z


def _hits(
    a: int, b: int, n: int, h: float, motion: float, numbers: Array, table: Indices,
    bounds: Array, bodies: Array, reaches: Array, poses: Array, found: Array,
) -> bool:  # fmt: skip
    """Tell whether two colliders touch within a tick, or may."""
    near = TOUCH * size_of(bounds, a, b)
    time = 0.0
    for _step in range(STEPS):
        _move(a, n * POSE, time, table, bodies, reaches, poses)
        _move(b, (n + 1) * POSE, time, table, bodies, reaches, poses)
        reach = motion * (1.0 - time / h) + near
        points = meet(
            table[a * TABLE + TYPE], table[b * TABLE + TYPE], numbers, table[a * TABLE + SIZES],
            table[b * TABLE + SIZES], poses, n * POSE, (n + 1) * POSE, reach, found,
        )  # fmt: skip
        if points == 0:
            return False
        gap = found[POINTS + SEPARATION]
        for point in range(1, points):
            gap = min(gap, found[POINTS + point * POINT + SEPARATION])
        if not gap > near:
            return True
        time += gap / motion * h
        if not time < h:
            return False
    return True


def advancement(name: str, meet: Callable[..., Any]) -> Callable[..., Any]:
    """Make the kernel that tells whether a fast pair hits, with the pair kernels of a scene."""
    return specialise(_hits, name=name, meet=meet)
