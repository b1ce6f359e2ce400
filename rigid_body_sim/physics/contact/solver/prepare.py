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

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import (
    arms,
    cross,
    inertia,
    relative,
    times,
    turning,
    vector,
)

Array = NDArray[np.float64]


@inline
def _inverse(xx, xy, xz, yy, yz, zz, ax, ay, az, bx, by, bz):
    """Return a . I^-1 b."""
    x, y, z = times(xx, xy, xz, yy, yz, zz, bx, by, bz)
    return ax * x + ay * y + az * z


@inline
def _largest(k11: float, k12: float, k22: float) -> Any:
    half = 0.5 * (k11 - k22)
    return 0.5 * (k11 + k22) + math.sqrt(half * half + k12 * k12)


@kernel
def gains(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Find the gains of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        ax, ay, az, bx, by, bz = arms(q, k)
        a1, a2, a3, a4, a5, a6 = inertia(s, k + constraint.INVERSE_INERTIA_A)
        b1, b2, b3, b4, b5, b6 = inertia(s, k + constraint.INVERSE_INERTIA_B)
        m = s[k + constraint.INVERSE_MASS_A] + s[k + constraint.INVERSE_MASS_B]
        x, y, z = cross(ax, ay, az, nx, ny, nz)
        cx, cy, cz = times(a1, a2, a3, a4, a5, a6, x, y, z)
        u, v, w = cross(bx, by, bz, nx, ny, nz)
        dx, dy, dz = times(b1, b2, b3, b4, b5, b6, u, v, w)
        normal = m + ((x * cx + y * cy + z * cz) + (u * dx + v * dy + w * dz))
        ux, uy, uz = cross(ax, ay, az, tx, ty, tz)
        vx, vy, vz = cross(bx, by, bz, tx, ty, tz)
        px, py, pz = cross(ax, ay, az, ox, oy, oz)
        rx, ry, rz = cross(bx, by, bz, ox, oy, oz)
        k11 = m + (
            _inverse(a1, a2, a3, a4, a5, a6, ux, uy, uz, ux, uy, uz)
            + _inverse(b1, b2, b3, b4, b5, b6, vx, vy, vz, vx, vy, vz)
        )
        k22 = m + (
            _inverse(a1, a2, a3, a4, a5, a6, px, py, pz, px, py, pz)
            + _inverse(b1, b2, b3, b4, b5, b6, rx, ry, rz, rx, ry, rz)
        )
        k12 = _inverse(a1, a2, a3, a4, a5, a6, ux, uy, uz, px, py, pz) + _inverse(
            b1, b2, b3, b4, b5, b6, vx, vy, vz, rx, ry, rz
        )
        largest = _largest(k11, k12, k22)
        q[k + contact_point.CROSS_TERM_1] = (ux * cx + uy * cy + uz * cz) + (
            vx * dx + vy * dy + vz * dz
        )
        q[k + contact_point.CROSS_TERM_2] = (px * cx + py * cy + pz * cz) + (
            rx * dx + ry * dy + rz * dz
        )
        q[k + contact_point.NORMAL_MASS] = 1.0 / normal if normal > 0.0 else 0.0
        q[k + contact_point.TANGENT_MASS] = 1.0 / largest if largest > 0.0 else 0.0


@kernel
def angular_gains(lanes: int, s: Array, g: Array) -> None:
    """Find the gains against rolling and twisting of each lane; without inertia there are none."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        a1, a2, a3, a4, a5, a6 = inertia(s, k + constraint.INVERSE_INERTIA_A)
        b1, b2, b3, b4, b5, b6 = inertia(s, k + constraint.INVERSE_INERTIA_B)
        a1, a2, a3, a4, a5, a6 = a1 + b1, a2 + b2, a3 + b3, a4 + b4, a5 + b5, a6 + b6
        spin = _inverse(a1, a2, a3, a4, a5, a6, nx, ny, nz, nx, ny, nz)
        k11 = _inverse(a1, a2, a3, a4, a5, a6, tx, ty, tz, tx, ty, tz)
        k22 = _inverse(a1, a2, a3, a4, a5, a6, ox, oy, oz, ox, oy, oz)
        k12 = _inverse(a1, a2, a3, a4, a5, a6, tx, ty, tz, ox, oy, oz)
        largest = _largest(k11, k12, k22)
        s[k + constraint.ROLLING_MASS] = 1.0 / largest if largest > 0.0 else 0.0
        s[k + constraint.TWIST_MASS] = 1.0 / spin if spin > 0.0 else 0.0


@kernel
def gather_accelerations(used: int, s: Array, g: Array, bodies: Array) -> None:
    """Fetch the accelerations of the bodies of a batch."""
    for k in range(used):
        a, b = (
            int(s[k + constraint.BODY_A]) + solver_bodies.FREE_ACCELERATION,
            int(s[k + constraint.BODY_B]) + solver_bodies.FREE_ACCELERATION,
        )
        for row in range(6):
            g[k + lane_scratch.DISPLACEMENT_A + 8 * row] = bodies[a + row]
            g[k + lane_scratch.DISPLACEMENT_B + 8 * row] = bodies[b + row]


@inline
def _acceleration(g, d, u, wx, wy, wz, k, x, y, z):
    """Acceleration of a point at arm r: a + alpha x r + omega x (omega x r)."""
    ux, uy, uz = vector(g, k + u)
    vx, vy, vz = cross(wx, wy, wz, x, y, z)
    tx, ty, tz = cross(wx, wy, wz, vx, vy, vz)
    vx, vy, vz = cross(ux, uy, uz, x, y, z)
    return g[k + d] + (vx + tx), g[k + d + 8] + (vy + ty), g[k + d + 16] + (vz + tz)


@kernel
def approach(lanes: int, threshold: float, s: Array, q: Array, g: Array) -> None:
    """Find the speed of approach of one point of each lane; 0 for what does not bounce."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        ax, ay, az, bx, by, bz = arms(q, k)
        x, y, z = relative(s, g, k, ax, ay, az, bx, by, bz)
        vn = nx * x + ny * y + nz * z
        wx, wy, wz = turning(
            s, k + constraint.INVERSE_INERTIA_A, g, k + lane_scratch.ANGULAR_MOMENTUM_A
        )
        ax, ay, az = _acceleration(
            g, lane_scratch.DISPLACEMENT_A, lane_scratch.TURN_A, wx, wy, wz, k, ax, ay, az
        )
        wx, wy, wz = turning(
            s, k + constraint.INVERSE_INERTIA_B, g, k + lane_scratch.ANGULAR_MOMENTUM_B
        )
        bx, by, bz = _acceleration(
            g, lane_scratch.DISPLACEMENT_B, lane_scratch.TURN_B, wx, wy, wz, k, bx, by, bz
        )
        gap = q[k + contact_point.INITIAL_SEPARATION]
        square = vn * vn - 2.0 * gap * (nx * (bx - ax) + ny * (by - ay) + nz * (bz - az))
        ahead = (vn < 0.0) & (gap > 0.0)
        met = -math.sqrt(square if square > 0.0 else 0.0) if ahead else vn
        q[k + contact_point.APPROACH_VELOCITY] = met if met < -threshold else 0.0
