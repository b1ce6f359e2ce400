# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How the lowest points of a body of revolution go round its rim while its axis turns over a plane
or a side of a box that cannot move.

    n normal of the plane, a axis, p = n x a / |n x a| the level line across it, so that the lowest
    point of a rim of radius r lies at c a + r (a x p) from the centre of mass

The points of a manifold keep their places in the frame (a, p, a x p), whose turn from (a, p) to
(a', p') is one about p by the change of the tilt, then one about n by the change of the heading:

    q = (n S, C) (p s, c) = (s C p + c S n + s S n x p, c C)
        s, c : sine and cosine of half the change of the tilt, the angle from n to a
        S, C : the same of half the change of the heading, the angle from p to p' about n

So the point found at the start of a tick is the lowest one after each substep too, and its gap
that of the rim. Where the axis stands on the plane there is no heading: below FLAT, or where the
heading turns by a right angle or more, the points turn with the axis alone.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import FLAT
from rigid_body_sim.physics.contact.solver import constraint, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import cross, shift, vector
from rigid_body_sim.physics.state.blocks import rotate

Array = NDArray[np.float64]

# [-] what points follow in a substep: cosine of the largest change of the heading, and of half the
# largest change of the tilt
TURNED, TILTED = 0.0, 0.1


@kernel
def go_round(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Let the points of the rims of a batch turn with the frame of their lowest points."""
    for k in range(used):
        whose = s[k + constraint.ROUNDNESS]
        if whose >= 0.0:
            continue
        o = int(s[k + constraint.BODY_A] if whose == -1.0 else s[k + constraint.BODY_B])
        ax, ay, az = rotate(
            bodies[o + solver_bodies.SUBSTEP_ORIENTATION], bodies[o + solver_bodies.SUBSTEP_ORIENTATION + 1], bodies[o + solver_bodies.SUBSTEP_ORIENTATION + 2], bodies[o + solver_bodies.SUBSTEP_ORIENTATION + 3],
            bodies[o + solver_bodies.SYMMETRY_AXIS], bodies[o + solver_bodies.SYMMETRY_AXIS + 1], bodies[o + solver_bodies.SYMMETRY_AXIS + 2],
        )  # fmt: skip
        ux, uy, uz = (
            bodies[o + solver_bodies.TURN],
            bodies[o + solver_bodies.TURN + 1],
            bodies[o + solver_bodies.TURN + 2],
        )
        ux, uy, uz = shift(ux, uy, uz, bodies[o + solver_bodies.TURN_SCALAR], ax, ay, az)
        bx, by, bz = ax + ux, ay + uy, az + uz
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        px, py, pz = cross(nx, ny, nz, ax, ay, az)
        qx, qy, qz = cross(nx, ny, nz, bx, by, bz)
        before = math.sqrt(px * px + py * py + pz * pz)
        after = math.sqrt(qx * qx + qy * qy + qz * qz)
        if not (before > FLAT and after > FLAT):
            continue
        px, py, pz = px / before, py / before, pz / before
        qx, qy, qz = qx / after, qy / after, qz / after
        heading = px * qx + py * qy + pz * qz
        if not heading > TURNED:
            continue
        tx, ty, tz = cross(px, py, pz, qx, qy, qz)
        big_c = math.sqrt(0.5 * (1.0 + heading))
        big_s = 0.5 * (nx * tx + ny * ty + nz * tz) / big_c
        up, now = nx * ax + ny * ay + nz * az, nx * bx + ny * by + nz * bz
        c = math.sqrt(max(0.5 * (1.0 + (up * now + before * after)), 0.0))
        if not c > TILTED:
            continue
        d = 0.5 * (after * up - before * now) / c
        tx, ty, tz = cross(nx, ny, nz, px, py, pz)
        along, about, both = d * big_c, c * big_s, d * big_s
        to = k + (lane_scratch.TURN_A if whose == -1.0 else lane_scratch.TURN_B)
        g[to] = along * px + (about * nx + both * tx)
        g[to + 8] = along * py + (about * ny + both * ty)
        g[to + 16] = along * pz + (about * nz + both * tz)
        g[to + 24] = c * big_c  # SA, SB
