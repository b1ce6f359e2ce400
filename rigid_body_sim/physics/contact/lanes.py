# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Vectors, matrices and velocities of one lane; see `rows` for the places."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.rows import RA, RB
from rigid_body_sim.physics.kernels import inline

Array = NDArray[np.float64]


@inline
def cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Any:
    """Return a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@inline
def arms(q: Array, k: int) -> Any:
    """Arms of the point from the centres of A and B."""
    return (
        q[k + RA], q[k + RA + 8], q[k + RA + 16], q[k + RB], q[k + RB + 8], q[k + RB + 16],
    )  # fmt: skip


@inline
def vector(g: Array, k: int) -> Any:
    """Three numbers of a lane, row after row."""
    return g[k], g[k + 8], g[k + 16]


@inline
def inertia(g: Array, k: int) -> Any:
    """Inverse mass and inverse inertia of a lane: 1/m, xx, xy, xz, yy, yz, zz."""
    return g[k], g[k + 8], g[k + 16], g[k + 24], g[k + 32], g[k + 40], g[k + 48]


@inline
def times(xx, xy, xz, yy, yz, zz, x, y, z):
    """Apply a symmetric matrix to a vector."""
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@inline
def relative(ux, uy, uz, ox, oy, oz, ax, ay, az, vx, vy, vz, wx, wy, wz, bx, by, bz):
    """Velocity of B relative to A at a point: v + w x b - u - o x a [m/s]."""
    return (
        (vx - ux) + ((wy * bz - wz * by) - (oy * az - oz * ay)),
        (vy - uy) + ((wz * bx - wx * bz) - (oz * ax - ox * az)),
        (vz - uz) + ((wx * by - wy * bx) - (ox * ay - oy * ax)),
    )


@inline
def disc(t: float, o: float, limit: float) -> Any:
    """Bring a vector onto a disc."""
    size = t * t + o * o
    over = size > limit * limit
    factor = limit / math.sqrt(size if over else 1.0) if over else 1.0
    return t * factor, o * factor
