# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Vectors, matrices and velocities of one lane; see `rows` for the places."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch

Array = NDArray[np.float64]


@inline
def cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Any:
    """Return a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@inline
def arms(q: Array, k: int) -> Any:
    """Arms of the point from the centres of A and B."""
    return (
        q[k + contact_point.ARM_A], q[k + contact_point.ARM_A + 8], q[k + contact_point.ARM_A + 16], q[k + contact_point.ARM_B], q[k + contact_point.ARM_B + 8], q[k + contact_point.ARM_B + 16],
    )  # fmt: skip


@inline
def vector(g: Array, k: int) -> Any:
    """Three numbers of a lane, row after row."""
    return g[k], g[k + 8], g[k + 16]


@inline
def inertia(s: Array, k: int) -> Any:
    """Inverse inertia of a lane: xx, xy, xz, yy, yz, zz."""
    return s[k], s[k + 8], s[k + 16], s[k + 24], s[k + 32], s[k + 40]


@inline
def times(xx, xy, xz, yy, yz, zz, x, y, z):
    """Apply a symmetric matrix to a vector."""
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@inline
def turning(s: Array, i: int, g: Array, m: int) -> Any:
    """Angular velocity I^-1 L of a body of a lane [rad/s]."""
    return times(
        s[i], s[i + 8], s[i + 16], s[i + 24], s[i + 32], s[i + 40], g[m], g[m + 8], g[m + 16]
    )


@inline
def relative(s, g, k, ax, ay, az, bx, by, bz):
    """Velocity of B relative to A at a point: v_B - v_A + w_B x r_B - w_A x r_A [m/s]."""
    ux, uy, uz = turning(
        s, k + constraint.INVERSE_INERTIA_A, g, k + lane_scratch.ANGULAR_MOMENTUM_A
    )
    wx, wy, wz = turning(
        s, k + constraint.INVERSE_INERTIA_B, g, k + lane_scratch.ANGULAR_MOMENTUM_B
    )
    m = s[k + constraint.INVERSE_MASS_A] + s[k + constraint.INVERSE_MASS_B]
    return (
        (g[k + lane_scratch.RELATIVE_VELOCITY] + m * g[k + lane_scratch.IMPULSE])
        + ((wy * bz - wz * by) - (uy * az - uz * ay)),
        (g[k + lane_scratch.RELATIVE_VELOCITY + 8] + m * g[k + lane_scratch.IMPULSE + 8])
        + ((wz * bx - wx * bz) - (uz * ax - ux * az)),
        (g[k + lane_scratch.RELATIVE_VELOCITY + 16] + m * g[k + lane_scratch.IMPULSE + 16])
        + ((wx * by - wy * bx) - (ux * ay - uy * ax)),
    )


@inline
def disc(t: float, o: float, limit: float) -> Any:
    """Bring a vector onto a disc."""
    size = t * t + o * o
    over = size > limit * limit
    factor = limit / math.sqrt(size if over else 1.0) if over else 1.0
    return t * factor, o * factor


@inline
def strike(g, k, ax, ay, az, bx, by, bz, x, y, z):
    """Give B of a lane the impulse (x, y, z) [N s] at arm b, and A its opposite at arm a."""
    px, py, pz = vector(g, k + lane_scratch.IMPULSE)
    hx, hy, hz = vector(g, k + lane_scratch.ANGULAR_MOMENTUM_A)
    lx, ly, lz = vector(g, k + lane_scratch.ANGULAR_MOMENTUM_B)
    ax, ay, az = cross(ax, ay, az, x, y, z)
    bx, by, bz = cross(bx, by, bz, x, y, z)
    (
        g[k + lane_scratch.IMPULSE],
        g[k + lane_scratch.IMPULSE + 8],
        g[k + lane_scratch.IMPULSE + 16],
    ) = px + x, py + y, pz + z
    (
        g[k + lane_scratch.ANGULAR_MOMENTUM_A],
        g[k + lane_scratch.ANGULAR_MOMENTUM_A + 8],
        g[k + lane_scratch.ANGULAR_MOMENTUM_A + 16],
    ) = hx - ax, hy - ay, hz - az
    (
        g[k + lane_scratch.ANGULAR_MOMENTUM_B],
        g[k + lane_scratch.ANGULAR_MOMENTUM_B + 8],
        g[k + lane_scratch.ANGULAR_MOMENTUM_B + 16],
    ) = lx + bx, ly + by, lz + bz


@inline
def shift(ux, uy, uz, w, x, y, z):
    """Motion of a point at arm (x, y, z) by the turn of its body: w t + u x t, t = 2 u x r."""
    tx, ty, tz = cross(ux, uy, uz, x, y, z)
    tx, ty, tz = 2.0 * tx, 2.0 * ty, 2.0 * tz
    sx, sy, sz = cross(ux, uy, uz, tx, ty, tz)
    return w * tx + sx, w * ty + sy, w * tz + sz


@inline
def twist(g: Array, k: int, x: float, y: float, z: float) -> None:
    """Give B of a lane the angular impulse (x, y, z), and A its opposite [N m s]."""
    hx, hy, hz = vector(g, k + lane_scratch.ANGULAR_MOMENTUM_A)
    lx, ly, lz = vector(g, k + lane_scratch.ANGULAR_MOMENTUM_B)
    (
        g[k + lane_scratch.ANGULAR_MOMENTUM_A],
        g[k + lane_scratch.ANGULAR_MOMENTUM_A + 8],
        g[k + lane_scratch.ANGULAR_MOMENTUM_A + 16],
    ) = hx - x, hy - y, hz - z
    (
        g[k + lane_scratch.ANGULAR_MOMENTUM_B],
        g[k + lane_scratch.ANGULAR_MOMENTUM_B + 8],
        g[k + lane_scratch.ANGULAR_MOMENTUM_B + 16],
    ) = lx + x, ly + y, lz + z
