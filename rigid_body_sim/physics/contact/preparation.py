# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a batch of contacts needs once in a tick: gains of its points, speeds of approach.

    1/m = n . (1/m_A + 1/m_B) n + (r_A x n) . I_A^-1 (r_A x n) + (r_B x n) . I_B^-1 (r_B x n)
    lambda_max = (k11 + k22)/2 + sqrt((k11 - k22)^2/4 + k12^2), of the same form with the tangents

The speed with which two surfaces a gap s apart would meet, v_n' from v_n under the acceleration
a_n of free motion at the point (gravity, forces, and what the turn of the bodies adds):

    v_n'^2 = v_n^2 - 2 a_n s        for v_n < 0, s > 0; else v_n

With it a ball bounces to the height that its energy allows, wherever in the tick it lands.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.passes import _relative
from rigid_body_sim.physics.contact.rows import (
    APPROACH,
    DA,
    DB,
    GAIN,
    GAP0,
    IA,
    IB,
    MA,
    MB,
    RA,
    RB,
    ROLL_GAIN,
    SLIP_GAIN,
    SPIN_GAIN,
    UA,
    UB,
    WA,
    WB,
    A,
    B,
    N,
    O,
    T,
)
from rigid_body_sim.physics.contact.touching_bodies import ACC
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]


@inline
def _inverse(
    g: Array, i: int, k: int, ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> Any:
    """Return a . I^-1 b with the inverse inertia whose rows begin at i."""
    return (
        ax * (g[k + i] * bx + g[k + i + 8] * by + g[k + i + 16] * bz)
        + ay * (g[k + i + 8] * bx + g[k + i + 24] * by + g[k + i + 32] * bz)
        + az * (g[k + i + 16] * bx + g[k + i + 32] * by + g[k + i + 40] * bz)
    )


@inline
def _largest(k11: float, k12: float, k22: float) -> Any:
    half = 0.5 * (k11 - k22)
    return 0.5 * (k11 + k22) + math.sqrt(half * half + k12 * k12)


@kernel
def gains(lanes: int, s: Array, p: int, g: Array) -> None:
    """Find the gains of one point of each lane."""
    for k in range(lanes):
        m = g[k + MA] + g[k + MB]
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        tx, ty, tz = s[k + T], s[k + T + 8], s[k + T + 16]
        ox, oy, oz = s[k + O], s[k + O + 8], s[k + O + 16]
        ax, ay, az = s[p + RA + k], s[p + RA + 8 + k], s[p + RA + 16 + k]
        bx, by, bz = s[p + RB + k], s[p + RB + 8 + k], s[p + RB + 16 + k]
        ux, uy, uz = ay * nz - az * ny, az * nx - ax * nz, ax * ny - ay * nx
        vx, vy, vz = by * nz - bz * ny, bz * nx - bx * nz, bx * ny - by * nx
        normal = m + (
            _inverse(g, IA, k, ux, uy, uz, ux, uy, uz) + _inverse(g, IB, k, vx, vy, vz, vx, vy, vz)
        )
        s[p + GAIN + k] = 1.0 / normal if normal > 0.0 else 0.0
        ux, uy, uz = ay * tz - az * ty, az * tx - ax * tz, ax * ty - ay * tx
        vx, vy, vz = by * tz - bz * ty, bz * tx - bx * tz, bx * ty - by * tx
        qx, qy, qz = ay * oz - az * oy, az * ox - ax * oz, ax * oy - ay * ox
        rx, ry, rz = by * oz - bz * oy, bz * ox - bx * oz, bx * oy - by * ox
        k11 = m + (
            _inverse(g, IA, k, ux, uy, uz, ux, uy, uz) + _inverse(g, IB, k, vx, vy, vz, vx, vy, vz)
        )
        k22 = m + (
            _inverse(g, IA, k, qx, qy, qz, qx, qy, qz) + _inverse(g, IB, k, rx, ry, rz, rx, ry, rz)
        )
        k12 = _inverse(g, IA, k, ux, uy, uz, qx, qy, qz) + _inverse(
            g, IB, k, vx, vy, vz, rx, ry, rz
        )
        largest = _largest(k11, k12, k22)
        s[p + SLIP_GAIN + k] = 1.0 / largest if largest > 0.0 else 0.0


@kernel
def angular_gains(lanes: int, s: Array, g: Array) -> None:
    """Find the gains against rolling and twisting of each lane; without inertia there are none."""
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        tx, ty, tz = s[k + T], s[k + T + 8], s[k + T + 16]
        ox, oy, oz = s[k + O], s[k + O + 8], s[k + O + 16]
        spin = _inverse(g, IA, k, nx, ny, nz, nx, ny, nz) + _inverse(
            g, IB, k, nx, ny, nz, nx, ny, nz
        )
        k11 = _inverse(g, IA, k, tx, ty, tz, tx, ty, tz) + _inverse(
            g, IB, k, tx, ty, tz, tx, ty, tz
        )
        k22 = _inverse(g, IA, k, ox, oy, oz, ox, oy, oz) + _inverse(
            g, IB, k, ox, oy, oz, ox, oy, oz
        )
        k12 = _inverse(g, IA, k, tx, ty, tz, ox, oy, oz) + _inverse(
            g, IB, k, tx, ty, tz, ox, oy, oz
        )
        largest = _largest(k11, k12, k22)
        s[k + ROLL_GAIN] = 1.0 / largest if largest > 0.0 else 0.0
        s[k + SPIN_GAIN] = 1.0 / spin if spin > 0.0 else 0.0


@kernel
def gather_accelerations(lanes: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch the accelerations of the bodies of a batch."""
    for k in range(lanes):
        a, b = int(s[k + A]) + ACC, int(s[k + B]) + ACC
        for row in range(6):
            g[k + DA + 8 * row] = bodies[a + row]
            g[k + DB + 8 * row] = bodies[b + row]


@inline
def _acceleration(g: Array, d: int, u: int, w: int, k: int, x: float, y: float, z: float) -> Any:
    """Acceleration of a point at arm r: a + alpha x r + omega x (omega x r)."""
    ux, uy, uz = g[k + u], g[k + u + 8], g[k + u + 16]
    wx, wy, wz = g[k + w], g[k + w + 8], g[k + w + 16]
    vx, vy, vz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
    return (
        g[k + d] + ((uy * z - uz * y) + (wy * vz - wz * vy)),
        g[k + d + 8] + ((uz * x - ux * z) + (wz * vx - wx * vz)),
        g[k + d + 16] + ((ux * y - uy * x) + (wx * vy - wy * vx)),
    )


@kernel
def approach(lanes: int, s: Array, p: int, g: Array) -> None:
    """Find the speed of approach of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = s[k + N], s[k + N + 8], s[k + N + 16]
        x, y, z = _relative(g, s, p, k)
        vn = nx * x + ny * y + nz * z
        ax, ay, az = _acceleration(
            g, DA, UA, WA, k, s[p + RA + k], s[p + RA + 8 + k], s[p + RA + 16 + k]
        )
        bx, by, bz = _acceleration(
            g, DB, UB, WB, k, s[p + RB + k], s[p + RB + 8 + k], s[p + RB + 16 + k]
        )
        gap = s[p + GAP0 + k]
        square = vn * vn - 2.0 * gap * (nx * (bx - ax) + ny * (by - ay) + nz * (bz - az))
        ahead = (vn < 0.0) & (gap > 0.0)
        s[p + APPROACH + k] = -math.sqrt(square if square > 0.0 else 0.0) if ahead else vn
