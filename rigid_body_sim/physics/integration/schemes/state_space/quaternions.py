# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a Runge–Kutta step for rotations: q' = q (omega, 0) / 2, omega' = I^-1 (R^T torque -
omega x I omega).

q is scaled by 1.5 - |q|^2 / 2 in every stage and normalised after the step: a smooth map that is
one on the unit sphere, so the order stays. The workspace of a block holds y = (q, omega), the rate
omega of the stage, then the slopes K of each stage, seven rows each.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, unbound
from rigid_body_sim.physics.state.blocks import (
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
    TX,
    TY,
    TZ,
    rotate,
)

# numbers of y, and of a slope, in a block: 448, and eight more so that the rows of one lane do not
# all fall into the same few sets of the cache, which costs a single body a third of its time
TURN = 456
TURN_START = 640  # where the slopes begin
FEW = 8  # [body] so few of a block are taken one by one: their sums fit the registers

# bound for each tableau by `specialise`
STAGES = 1
A: tuple[float, ...] = (0.0,)  # the tableau, row by row
B: tuple[float, ...] = (1.0,)
FOR_FORCES = True  # whether forces will read the state of a stage
TOTAL = 0  # slope that `end` may overwrite
B1 = B2 = B3 = 0.0
LADDER: tuple[float, ...] = (0.0, 0.0, 0.0)  # the entries beside the diagonal
move_: Callable[..., Any] = unbound
end_: Callable[..., Any] = unbound


@inline
def begin(lanes, s, y, memory):
    """Start a step: y = (q, omega); no memory is needed."""
    for k in range(lanes):
        x, u, v, w = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        a, b, c = rotate(-x, -u, -v, w, s[k + LX], s[k + LY], s[k + LZ])
        a *= s[k + J1]
        b *= s[k + J2]
        c *= s[k + J3]
        y[k], y[k + 64], y[k + 128], y[k + 192] = x, u, v, w
        y[k + 256], y[k + 320], y[k + 384] = a, b, c
        y[k + 448], y[k + 512], y[k + 576] = a, b, c


@inline
def set_rate(lanes, s, y):
    """
    Write the rate omega of the state, for the slope there: the same bits that `begin` would write.
    """
    for k in range(lanes):
        a, b, c = rotate(
            -s[k + QX], -s[k + QY], -s[k + QZ], s[k + QW], s[k + LX], s[k + LY], s[k + LZ]
        )
        y[k + 448], y[k + 512], y[k + 576] = a * s[k + J1], b * s[k + J2], c * s[k + J3]


@inline
def _move_by(lanes, factor, y, start, slope, s):
    if start:
        for k in range(lanes):
            s[k + QX] = y[k] + factor * slope[k]
            s[k + QY] = y[k + 64] + factor * slope[k + 64]
            s[k + QZ] = y[k + 128] + factor * slope[k + 128]
            s[k + QW] = y[k + 192] + factor * slope[k + 192]
            y[k + 448] = y[k + 256] + factor * slope[k + 256]
            y[k + 512] = y[k + 320] + factor * slope[k + 320]
            y[k + 576] = y[k + 384] + factor * slope[k + 384]
    else:
        for k in range(lanes):
            s[k + QX] += factor * slope[k]
            s[k + QY] += factor * slope[k + 64]
            s[k + QZ] += factor * slope[k + 128]
            s[k + QW] += factor * slope[k + 192]
            y[k + 448] += factor * slope[k + 256]
            y[k + 512] += factor * slope[k + 320]
            y[k + 576] += factor * slope[k + 384]


@inline
def _move_lane(k, stage, h, s, y, a, stages, for_forces):
    """The same for one body, the sums in registers."""
    q, r, t, u = y[k], y[k + 64], y[k + 128], y[k + 192]
    d, e, f = y[k + 256], y[k + 320], y[k + 384]
    for j in range(stage):
        g = h * a[stage * stages + j]
        if g != 0.0:
            m = TURN_START + TURN * j + k
            q += g * y[m]
            r += g * y[m + 64]
            t += g * y[m + 128]
            u += g * y[m + 192]
            d += g * y[m + 256]
            e += g * y[m + 320]
            f += g * y[m + 384]
    y[k + 448], y[k + 512], y[k + 576] = d, e, f
    if for_forces:
        _set_attitude(k, s, q, r, t, u, d, e, f)
    else:
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = q, r, t, u


@inline
def _set_attitude(k, s, x, u, v, w, a, b, c):
    """Scale q of a stage to unit length and rebuild L = R I omega for the forces to read."""
    f = 1.5 - 0.5 * (x * x + u * u + v * v + w * w)
    x, u, v, w = x * f, u * f, v * f, w * f
    s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = x, u, v, w
    s[k + LX], s[k + LY], s[k + LZ] = rotate(
        x, u, v, w, s[k + I1] * a, s[k + I2] * b, s[k + I3] * c
    )


@inline
def _set_attitudes(lanes, y, s):
    for k in range(lanes):
        _set_attitude(
            k, s, s[k + QX], s[k + QY], s[k + QZ], s[k + QW], y[k + 448], y[k + 512], y[k + 576]
        )


@inline
def _rates(x, u, v, w, a, b, c, tx, ty, tz, i1, i2, i3, v1, v2, v3):
    """q' = q (omega, 0) / 2 and omega' = I^-1 (R^T torque - omega x I omega), q of unit length."""
    d, e, g = rotate(-x, -u, -v, w, tx, ty, tz)
    return (
        0.5 * (w * a + (u * c - v * b)),
        0.5 * (w * b + (v * a - x * c)),
        0.5 * (w * c + (x * b - u * a)),
        -0.5 * (x * a + u * b + v * c),
        (d - (i3 - i2) * b * c) * v1,
        (e - (i1 - i3) * c * a) * v2,
        (g - (i2 - i1) * a * b) * v3,
    )


@inline
def _slope(x, u, v, w, a, b, c, tx, ty, tz, i1, i2, i3, v1, v2, v3):
    """The same with q scaled to unit length first."""
    f = 1.5 - 0.5 * (x * x + u * u + v * v + w * w)
    return _rates(x * f, u * f, v * f, w * f, a, b, c, tx, ty, tz, i1, i2, i3, v1, v2, v3)


@inline
def _unit(x, u, v, w):
    """Normalise to the last bit or two."""
    f = 1.0 / math.sqrt(x * x + u * u + v * v + w * w)
    x, u, v, w = x * f, u * f, v * f, w * f
    f = 1.5 - 0.5 * (x * x + u * u + v * v + w * w)
    return x * f, u * f, v * f, w * f


@inline
def slope_of(lanes, s, y, slope):
    """Slope of a stage whose q has unit length."""
    for k in range(lanes):
        x, u, v, w, a, b, c = _rates(
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW], y[k + 448], y[k + 512], y[k + 576],
            s[k + TX], s[k + TY], s[k + TZ],
            s[k + I1], s[k + I2], s[k + I3], s[k + J1], s[k + J2], s[k + J3],
        )  # fmt: skip
        slope[k], slope[k + 64], slope[k + 128], slope[k + 192] = x, u, v, w
        slope[k + 256], slope[k + 320], slope[k + 384] = a, b, c


@inline
def _slope_of_scaled(lanes, s, y, slope):
    """Slope of a stage whose q is about of unit length."""
    for k in range(lanes):
        x, u, v, w, a, b, c = _slope(
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW], y[k + 448], y[k + 512], y[k + 576],
            s[k + TX], s[k + TY], s[k + TZ],
            s[k + I1], s[k + I2], s[k + I3], s[k + J1], s[k + J2], s[k + J3],
        )  # fmt: skip
        slope[k], slope[k + 64], slope[k + 128], slope[k + 192] = x, u, v, w
        slope[k + 256], slope[k + 320], slope[k + 384] = a, b, c


def move(stage, lanes, h, s, y):
    """Make the state of a stage from the slopes of those before it."""
    if lanes < FEW:
        for k in range(lanes):
            _move_lane(k, stage, h, s, y, A, STAGES, FOR_FORCES)
    else:
        start = True
        for j in range(stage):
            g = h * A[stage * STAGES + j]
            if g != 0.0:
                slope = y[TURN_START + TURN * j : TURN_START + TURN * (j + 1)]
                _move_by(lanes, g, y, start, slope, s)
                start = False
        if FOR_FORCES:
            _set_attitudes(lanes, y, s)


@inline
def _finish(k, h, s, y, q, r, t, u, d, e, f):
    """y + h K of one body, q normalised, L rebuilt."""
    x, u, v, w = _unit(y[k] + h * q, y[k + 64] + h * r, y[k + 128] + h * t, y[k + 192] + h * u)
    s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = x, u, v, w
    s[k + LX], s[k + LY], s[k + LZ] = rotate(
        x,
        u,
        v,
        w,
        s[k + I1] * (y[k + 256] + h * d),
        s[k + I2] * (y[k + 320] + h * e),
        s[k + I3] * (y[k + 384] + h * f),
    )


@inline
def _scale(lanes, factor, slope, total):
    for k in range(lanes):
        total[k] = factor * slope[k]
        total[k + 64] = factor * slope[k + 64]
        total[k + 128] = factor * slope[k + 128]
        total[k + 192] = factor * slope[k + 192]
        total[k + 256] = factor * slope[k + 256]
        total[k + 320] = factor * slope[k + 320]
        total[k + 384] = factor * slope[k + 384]


@inline
def _add(lanes, factor, slope, total):
    for k in range(lanes):
        total[k] += factor * slope[k]
        total[k + 64] += factor * slope[k + 64]
        total[k + 128] += factor * slope[k + 128]
        total[k + 192] += factor * slope[k + 192]
        total[k + 256] += factor * slope[k + 256]
        total[k + 320] += factor * slope[k + 320]
        total[k + 384] += factor * slope[k + 384]


@inline
def _finish_all(lanes, h, s, y, z):
    for k in range(lanes):
        _finish(
            k, h, s, y, z[k], z[k + 64], z[k + 128], z[k + 192], z[k + 256], z[k + 320], z[k + 384]
        )


def end(lanes, h, s, y, memory):
    """y + h sum b K, q normalised, L rebuilt. May overwrite the slope TOTAL."""
    if lanes < FEW:
        for k in range(lanes):
            q = r = t = u = d = e = f = 0.0
            for j in range(STAGES):
                g = B[j]
                if g != 0.0:
                    m = TURN_START + TURN * j + k
                    q += g * y[m]
                    r += g * y[m + 64]
                    t += g * y[m + 128]
                    u += g * y[m + 192]
                    d += g * y[m + 256]
                    e += g * y[m + 320]
                    f += g * y[m + 384]
            _finish(k, h, s, y, q, r, t, u, d, e, f)
    else:
        z = y[TURN_START + TURN * TOTAL : TURN_START + TURN * (TOTAL + 1)]
        _scale(lanes, B[0], y[TURN_START : TURN_START + TURN], z)
        for j in range(1, STAGES):
            if B[j] != 0.0:
                _add(lanes, B[j], y[TURN_START + TURN * j : TURN_START + TURN * (j + 1)], z)
        _finish_all(lanes, h, s, y, z)


def step_on_a_ladder(lanes, h, s, y):
    """
    Step free or steadily torqued rotations by a tableau in which each stage builds on the one
    before it alone.

    Up to four stages (Euler, midpoint, the classical method) in registers: three times as fast as
    through `y`.
    """
    for k in range(lanes):
        x, u, v, w = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        i1, i2, i3 = s[k + I1], s[k + I2], s[k + I3]
        v1, v2, v3 = s[k + J1], s[k + J2], s[k + J3]
        tx, ty, tz = s[k + TX], s[k + TY], s[k + TZ]
        a, b, c = rotate(-x, -u, -v, w, s[k + LX], s[k + LY], s[k + LZ])
        a, b, c = a * v1, b * v2, c * v3
        d1, d2, d3, d4, d5, d6, d7 = _slope(
            x, u, v, w, a, b, c, tx, ty, tz, i1, i2, i3, v1, v2, v3
        )
        z1, z2, z3, z4 = B[0] * d1, B[0] * d2, B[0] * d3, B[0] * d4
        z5, z6, z7 = B[0] * d5, B[0] * d6, B[0] * d7
        if STAGES > 1:
            g = h * LADDER[0]
            d1, d2, d3, d4, d5, d6, d7 = _slope(
                x + g * d1, u + g * d2, v + g * d3, w + g * d4, a + g * d5, b + g * d6, c + g * d7,
                tx, ty, tz, i1, i2, i3, v1, v2, v3,
            )  # fmt: skip
            z1, z2, z3, z4 = z1 + B1 * d1, z2 + B1 * d2, z3 + B1 * d3, z4 + B1 * d4
            z5, z6, z7 = z5 + B1 * d5, z6 + B1 * d6, z7 + B1 * d7
        if STAGES > 2:
            g = h * LADDER[1]
            d1, d2, d3, d4, d5, d6, d7 = _slope(
                x + g * d1, u + g * d2, v + g * d3, w + g * d4, a + g * d5, b + g * d6, c + g * d7,
                tx, ty, tz, i1, i2, i3, v1, v2, v3,
            )  # fmt: skip
            z1, z2, z3, z4 = z1 + B2 * d1, z2 + B2 * d2, z3 + B2 * d3, z4 + B2 * d4
            z5, z6, z7 = z5 + B2 * d5, z6 + B2 * d6, z7 + B2 * d7
        if STAGES > 3:
            g = h * LADDER[2]
            d1, d2, d3, d4, d5, d6, d7 = _slope(
                x + g * d1, u + g * d2, v + g * d3, w + g * d4, a + g * d5, b + g * d6, c + g * d7,
                tx, ty, tz, i1, i2, i3, v1, v2, v3,
            )  # fmt: skip
            z1, z2, z3, z4 = z1 + B3 * d1, z2 + B3 * d2, z3 + B3 * d3, z4 + B3 * d4
            z5, z6, z7 = z5 + B3 * d5, z6 + B3 * d6, z7 + B3 * d7
        x, u, v, w = _unit(x + h * z1, u + h * z2, v + h * z3, w + h * z4)
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = x, u, v, w
        s[k + LX], s[k + LY], s[k + LZ] = rotate(
            x, u, v, w, i1 * (a + h * z5), i2 * (b + h * z6), i3 * (c + h * z7)
        )


def step(lanes, h, s, y):
    """Step free or steadily torqued rotations by any tableau."""
    begin(lanes, s, y, y[:0])
    for stage in range(STAGES):
        if stage > 0:
            move_(stage, lanes, h, s, y)
        _slope_of_scaled(
            lanes, s, y, y[TURN_START + TURN * stage : TURN_START + TURN * (stage + 1)]
        )
    end_(lanes, h, s, y, y[:0])
