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
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import arms, shift, strike, vector

Array = NDArray[np.float64]

LAYERED = False  # whether anything is a ball or a capsule; bound by `specialise`


@kernel
def gather_motion(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how the bodies of a batch have moved over the substep."""
    for k in range(used):
        a, b = (
            int(s[k + constraint.BODY_A]) + solver_bodies.DISPLACEMENT,
            int(s[k + constraint.BODY_B]) + solver_bodies.DISPLACEMENT,
        )
        for row in range(7):
            g[k + lane_scratch.DISPLACEMENT_A + 8 * row] = bodies[a + row]
            g[k + lane_scratch.DISPLACEMENT_B + 8 * row] = bodies[b + row]


@inline
def _load(s, q, g, k, nx, ny, nz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz):
    """
    Give one point of a lane the second half of its load, where it is now.

    A point that did not press during the motion has none.
    """
    presses = q[k + contact_point.NORMAL_IMPULSE] > 0.0
    new = q[k + contact_point.WARM_NORMAL] if presses else 0.0
    t = q[k + contact_point.WARM_TANGENT_1] if presses else 0.0
    o = q[k + contact_point.WARM_TANGENT_2] if presses else 0.0
    x = new * nx + (t * tx + o * ox)
    y = new * ny + (t * ty + o * oy)
    z = new * nz + (t * tz + o * oz)
    q[k + contact_point.ARM_A], q[k + contact_point.ARM_A + 8], q[k + contact_point.ARM_A + 16] = (
        ax,
        ay,
        az,
    )
    q[k + contact_point.ARM_B], q[k + contact_point.ARM_B + 8], q[k + contact_point.ARM_B + 16] = (
        bx,
        by,
        bz,
    )
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
        fixed = (s[k + constraint.INVERSE_MASS_A] == 0.0) | (
            s[k + constraint.INVERSE_MASS_B] == 0.0
        )
        stays = (
            fixed
            & (s[k + constraint.RESTITUTION] > 0.0)
            & (q[k + contact_point.APPROACH_VELOCITY] < 0.0)
        )
        f = 0.0 if stays else 1.0
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        ux, uy, uz = vector(g, k + lane_scratch.TURN_A)
        vx, vy, vz = vector(g, k + lane_scratch.TURN_B)
        if LAYERED:
            c, d = s[k + constraint.RADIUS_A], s[k + constraint.RADIUS_B]
            x, y, z = ax - c * nx, ay - c * ny, az - c * nz
            ux, uy, uz = shift(ux, uy, uz, g[k + lane_scratch.TURN_SCALAR_A], x, y, z)
            x, y, z = bx + d * nx, by + d * ny, bz + d * nz
            vx, vy, vz = shift(vx, vy, vz, g[k + lane_scratch.TURN_SCALAR_B], x, y, z)
        else:
            ux, uy, uz = shift(ux, uy, uz, g[k + lane_scratch.TURN_SCALAR_A], ax, ay, az)
            vx, vy, vz = shift(vx, vy, vz, g[k + lane_scratch.TURN_SCALAR_B], bx, by, bz)
        x, y, z = (
            g[k + lane_scratch.DISPLACEMENT_B] - g[k + lane_scratch.DISPLACEMENT_A],
            g[k + lane_scratch.DISPLACEMENT_B + 8] - g[k + lane_scratch.DISPLACEMENT_A + 8],
            g[k + lane_scratch.DISPLACEMENT_B + 16] - g[k + lane_scratch.DISPLACEMENT_A + 16],
        )
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        x, y, z = x + (vx - ux), y + (vy - uy), z + (vz - uz)
        gap = q[k + contact_point.SEPARATION]
        gap += nx * x + ny * y + nz * z
        w = s[k + constraint.SURFACE_WEIGHT]
        ax, ay, az = ax + f * (ux + w * x), ay + f * (uy + w * y), az + f * (uz + w * z)
        w = 1.0 - w
        bx, by, bz = bx + f * (vx - w * x), by + f * (vy - w * y), bz + f * (vz - w * z)
        q[k + contact_point.SEPARATION] = gap
        _load(s, q, g, k, nx, ny, nz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz)


def follower(*, layered: bool) -> Callable[..., Any]:
    """Make the kernel of a scene; layered: it has balls or capsules."""
    return specialise(_follow, name='layered' if layered else 'bare', LAYERED=layered)


@kernel
def gather_way(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch how far the bodies of a batch have moved over the substep."""
    for k in range(used):
        a, b = (
            int(s[k + constraint.BODY_A]) + solver_bodies.DISPLACEMENT,
            int(s[k + constraint.BODY_B]) + solver_bodies.DISPLACEMENT,
        )
        for axis in range(3):
            g[k + lane_scratch.DISPLACEMENT_A + 8 * axis] = bodies[b + axis] - bodies[a + axis]


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
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        vx, vy, vz = vector(g, k + lane_scratch.DISPLACEMENT_A)
        gap = q[k + contact_point.SEPARATION]
        w = s[k + constraint.SURFACE_WEIGHT]
        x, y, z = ax - bx + vx, ay - by + vy, az - bz + vz
        square = x * x + y * y + z * z
        balls = (s[k + constraint.ROUNDNESS] > 1.0) & (square > manifold.TINY)
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
        q[k + contact_point.SEPARATION] = gap + closer
        bx, by, bz = ax - x, ay - y, az - z
        s[k + constraint.NORMAL], s[k + constraint.NORMAL + 8], s[k + constraint.NORMAL + 16] = (
            ux,
            uy,
            uz,
        )
        share = 1.0 / (1.0 + (nx * ux + ny * uy + nz * uz))
        nx, ny, nz = nx + ux, ny + uy, nz + uz
        turn = share * (tx * ux + ty * uy + tz * uz)
        tx, ty, tz = tx - turn * nx, ty - turn * ny, tz - turn * nz
        turn = share * (ox * ux + oy * uy + oz * uz)
        ox, oy, oz = ox - turn * nx, oy - turn * ny, oz - turn * nz
        (
            s[k + constraint.TANGENT_1],
            s[k + constraint.TANGENT_1 + 8],
            s[k + constraint.TANGENT_1 + 16],
        ) = tx, ty, tz
        (
            s[k + constraint.TANGENT_2],
            s[k + constraint.TANGENT_2 + 8],
            s[k + constraint.TANGENT_2 + 16],
        ) = ox, oy, oz
        _load(s, q, g, k, ux, uy, uz, tx, ty, tz, ox, oy, oz, ax, ay, az, bx, by, bz)
