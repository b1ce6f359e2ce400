# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What contact points are after the motion over a substep: gap and arms follow the bodies.

And there they get the second half of their load. A load J, what the last substep gave, acts in
two halves, as other forces do (velocity Verlet): J/2 before the motion, at the arms of then, and
J/2 after it, at those of now. So what is carried, slides or rolls moves with its mean velocity,
to second order in the substep, and the two halves of a point at rest cancel its weight exactly.
A point that did not press during the motion gets neither half.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, specialise
from rigid_body_sim.physics.contact.collision.geometry.manifold import TINY
from rigid_body_sim.physics.contact.solver.constraint import (
    APPROACH,
    BOUNCE,
    DA,
    DB,
    GAP,
    HN,
    HO,
    HT,
    JN,
    LAYER_A,
    LAYER_B,
    MASS_A,
    MASS_B,
    RA,
    RB,
    ROUND_PAIR,
    SA,
    SB,
    T2,
    UA,
    UB,
    WEIGHT,
    A,
    B,
    N,
    T,
)
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, shift, strike, vector
from rigid_body_sim.physics.contact.solver_bodies import D

Array = NDArray[np.float64]

LAYERED = False  # whether anything is a ball or a capsule; bound by `specialise`


@kernel
def gather_motion(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how the bodies of a batch have moved over the substep."""
    for k in range(used):
        a, b = int(s[k + A]) + D, int(s[k + B]) + D
        for row in range(7):
            g[k + DA + 8 * row] = bodies[a + row]
            g[k + DB + 8 * row] = bodies[b + row]


@inline
def _load(s, q, g, k, nx, ny, nz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz):
    """
    Give one point of a lane the second half of its load, where it is now.

    A point that did not press during the motion has none.
    """
    presses = q[k + JN] > 0.0
    new = q[k + HN] if presses else 0.0
    t = q[k + HT] if presses else 0.0
    o = q[k + HO] if presses else 0.0
    x = new * nx + (t * tx + o * ox)
    y = new * ny + (t * ty + o * oy)
    z = new * nz + (t * tz + o * oz)
    q[k + RA], q[k + RA + 8], q[k + RA + 16] = ax, ay, az
    q[k + RB], q[k + RB + 8], q[k + RB + 16] = bx, by, bz
    strike(g, k, ax, ay, az, bx, by, bz, x, y, z)


def _follow(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Find gap and arms of a point of each lane after the motion over a substep, and give it the
    second half of its load there.

    The point moves as the surface of A, of B, or in the middle (`WEIGHT`), and both arms end in
    it: impulses at it keep the angular momentum of the two to the last digits. The layer of a
    ball or a capsule about its core does not turn with it: r = c + layer n moves by D c.

    What bounces off something that cannot move keeps its arms: it bounces at the end of the tick
    by the law of the place where it hit.
    """
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        fixed = (s[k + MASS_A] == 0.0) | (s[k + MASS_B] == 0.0)
        stays = fixed & (s[k + BOUNCE] > 0.0) & (q[k + APPROACH] < 0.0)
        f = 0.0 if stays else 1.0
        nx, ny, nz = vector(s, k + N)
        ux, uy, uz = vector(g, k + UA)
        vx, vy, vz = vector(g, k + UB)
        if LAYERED:
            c, d = s[k + LAYER_A], s[k + LAYER_B]
            x, y, z = ax - c * nx, ay - c * ny, az - c * nz
            ux, uy, uz = shift(ux, uy, uz, g[k + SA], x, y, z)
            x, y, z = bx + d * nx, by + d * ny, bz + d * nz
            vx, vy, vz = shift(vx, vy, vz, g[k + SB], x, y, z)
        else:
            ux, uy, uz = shift(ux, uy, uz, g[k + SA], ax, ay, az)
            vx, vy, vz = shift(vx, vy, vz, g[k + SB], bx, by, bz)
        x, y, z = (
            g[k + DB] - g[k + DA],
            g[k + DB + 8] - g[k + DA + 8],
            g[k + DB + 16] - g[k + DA + 16],
        )
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        x, y, z = x + (vx - ux), y + (vy - uy), z + (vz - uz)
        gap = q[k + GAP]
        gap += nx * x + ny * y + nz * z
        w = s[k + WEIGHT]
        ax, ay, az = ax + f * (ux + w * x), ay + f * (uy + w * y), az + f * (uz + w * z)
        w = 1.0 - w
        bx, by, bz = bx + f * (vx - w * x), by + f * (vy - w * y), bz + f * (vz - w * z)
        q[k + GAP] = gap
        _load(s, q, g, k, nx, ny, nz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz)


def follower(*, layered: bool) -> Callable[..., Any]:
    """Make the kernel of a scene; layered: it has balls or capsules."""
    return specialise(_follow, name='layered' if layered else 'bare', LAYERED=layered)


@kernel
def gather_way(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how far the bodies of a batch have moved over the substep."""
    for k in range(used):
        a, b = int(s[k + A]) + D, int(s[k + B]) + D
        for axis in range(3):
            g[k + DA + 8 * axis] = bodies[b + axis] - bodies[a + axis]


@kernel
def follow_balls(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Do what `follow` does where a ball meets a ball, or what cannot move.

    Between two balls the normal turns into their line of centres, and the gap is not linearised:

        d = x_B - x_A = r_A - r_B,  n' = d / |d|,  s' = s + |d'| - |d|
        t' = t - (n' . t)/(1 + n . n') (n + n'), the smallest turn that takes n to n'
    """
    for k in range(lanes):
        ax, ay, az, bx, by, bz = arms(q, k)
        nx, ny, nz = vector(s, k + N)
        tx, ty, tz = vector(s, k + T)
        ox, oy, oz = vector(s, k + T2)
        vx, vy, vz = vector(g, k + DA)
        gap = q[k + GAP]
        w = s[k + WEIGHT]
        x, y, z = ax - bx + vx, ay - by + vy, az - bz + vz
        square = x * x + y * y + z * z
        balls = (s[k + ROUND_PAIR] > 1.0) & (square > TINY)
        now = math.sqrt(square if balls else 1.0)
        before = nx * (ax - bx) + ny * (ay - by) + nz * (az - bz)
        closer = now - before if balls else nx * vx + ny * vy + nz * vz
        ux = x / now if balls else nx
        uy = y / now if balls else ny
        uz = z / now if balls else nz
        arm = (nx * ax + ny * ay + nz * az) + w * closer
        ax = arm * ux if balls else ax + w * vx
        ay = arm * uy if balls else ay + w * vy
        az = arm * uz if balls else az + w * vz
        q[k + GAP] = gap + closer
        bx, by, bz = ax - x, ay - y, az - z
        s[k + N], s[k + N + 8], s[k + N + 16] = ux, uy, uz
        share = 1.0 / (1.0 + (nx * ux + ny * uy + nz * uz))
        nx, ny, nz = nx + ux, ny + uy, nz + uz
        turn = share * (tx * ux + ty * uy + tz * uz)
        tx, ty, tz = tx - turn * nx, ty - turn * ny, tz - turn * nz
        turn = share * (ox * ux + oy * uy + oz * uz)
        ox, oy, oz = ox - turn * nx, oy - turn * ny, oz - turn * nz
        s[k + T], s[k + T + 8], s[k + T + 16] = tx, ty, tz
        s[k + T2], s[k + T2 + 8], s[k + T2 + 16] = ox, oy, oz
        _load(s, q, g, k, ux, uy, uz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz)
