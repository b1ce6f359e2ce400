# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation by the semi-implicit Euler method: the customary step of games, order one.

    omega' = omega - h I^-1 (omega x I omega)      body axes, explicit gyroscopic term
    q'     = q exp(h omega')
    L'     = R(q') I omega'

The angular momentum is recomputed, so it is not kept: the energy grows without bound from about h |omega| = 0.01 on.
The rotation by h omega' uses a rational sine and cosine that lie on the unit circle to rounding; the angle is right to
2e-17 at h |omega| = 0.5, 1e-10 at 2, 8e-9 at 3 rad.
"""

from __future__ import annotations

from rigid_body_sim.physics.blocks import (
    I1,
    I2,
    I3,
    J1,
    J2,
    J3,
    LX,
    LY,
    LZ,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    TX,
    TY,
    TZ,
    rotate,
)
from rigid_body_sim.physics.kernels import inline, kernel


@inline
def exponential(a, b, c):
    """
    Unit quaternion of a rotation by twice the vector (a, b, c) [rad].

    With y = |(a, b, c)|^2 / 4, N = 945 - 105 y + y^2, D = 945 - 420 y + 15 y^2, x = sqrt(y):
        cos 2x = (D^2 - y N^2) / (D^2 + y N^2),   sin 2x / 2x = N D / (D^2 + y N^2)
    the (4, 5) Padé approximant of tan x.
    """
    y = 0.25 * (a * a + b * b + c * c)
    n = 945.0 + y * (y - 105.0)
    d = 945.0 + y * (15.0 * y - 420.0)
    nn = y * n * n
    dd = d * d
    over = 1.0 / (dd + nn)
    s = n * d * over
    return a * s, b * s, c * s, (dd - nn) * over


@kernel
def drift(block, lanes, kick, h, rotation, method):
    """Kick the angular momentum and turn one block of bodies."""
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    for k in range(lanes):
        x = s[k + QX]
        y = s[k + QY]
        z = s[k + QZ]
        w = s[k + QW]
        a, b, c = rotate(
            -x,
            -y,
            -z,
            w,
            s[k + LX] + kick * s[k + TX],
            s[k + LY] + kick * s[k + TY],
            s[k + LZ] + kick * s[k + TZ],
        )
        u = a * s[k + J1]
        v = b * s[k + J2]
        t = c * s[k + J3]
        u, v, t = (
            u - h * (v * c - t * b) * s[k + J1],
            v - h * (t * a - u * c) * s[k + J2],
            t - h * (u * b - v * a) * s[k + J3],
        )
        ex, ey, ez, ew = exponential(0.5 * h * u, 0.5 * h * v, 0.5 * h * t)
        nx = x * ew + w * ex + (y * ez - z * ey)
        ny = y * ew + w * ey + (z * ex - x * ez)
        nz = z * ew + w * ez + (x * ey - y * ex)
        nw = w * ew - (x * ex + y * ey + z * ez)
        f = 1.5 - 0.5 * (nx * nx + ny * ny + nz * nz + nw * nw)
        nx, ny, nz, nw = nx * f, ny * f, nz * f, nw * f
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = nx, ny, nz, nw
        s[k + LX], s[k + LY], s[k + LZ] = rotate(
            nx, ny, nz, nw, u * s[k + I1], v * s[k + I2], t * s[k + I3]
        )
