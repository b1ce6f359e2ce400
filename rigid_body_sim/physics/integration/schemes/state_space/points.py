# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a Runge–Kutta step for points: r' = p / m, p' = F.

The workspace of a block holds y = (r, p), then the slopes K of each stage, six rows each.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.state.blocks import (
    EX,
    EY,
    EZ,
    FX,
    FY,
    FZ,
    GX,
    GY,
    GZ,
    IM,
    PX,
    PY,
    PZ,
    RX,
    RY,
    RZ,
    add_compensated,
)

# numbers of y, and of a slope, in a block: 384, and eight more so that the rows of one lane do not
# all fall into the same few sets of the cache, which costs a single body a third of its time
POINT = 392
FEW = 8  # [body] so few of a block are taken one by one: their sums fit the registers

# bound for each tableau by `specialise`
STAGES = 1
A: tuple[float, ...] = (0.0,)  # the tableau, row by row
B: tuple[float, ...] = (1.0,)
TOTAL = 0  # slope that `end` may overwrite
BC = 0.0  # sum b c


@inline
def begin(lanes, s, y):
    for k in range(lanes):
        y[k], y[k + 64], y[k + 128] = s[k + RX], s[k + RY], s[k + RZ]
        y[k + 192], y[k + 256], y[k + 320] = s[k + PX], s[k + PY], s[k + PZ]


@inline
def _move_by(lanes, factor, y, start, slope, s):
    """Position and momentum of a stage: y + factor K, or its previous value + factor K."""
    if start:
        for k in range(lanes):
            s[k + RX] = y[k] + factor * slope[k]
            s[k + RY] = y[k + 64] + factor * slope[k + 64]
            s[k + RZ] = y[k + 128] + factor * slope[k + 128]
            s[k + PX] = y[k + 192] + factor * slope[k + 192]
            s[k + PY] = y[k + 256] + factor * slope[k + 256]
            s[k + PZ] = y[k + 320] + factor * slope[k + 320]
    else:
        for k in range(lanes):
            s[k + RX] += factor * slope[k]
            s[k + RY] += factor * slope[k + 64]
            s[k + RZ] += factor * slope[k + 128]
            s[k + PX] += factor * slope[k + 192]
            s[k + PY] += factor * slope[k + 256]
            s[k + PZ] += factor * slope[k + 320]


@inline
def slope_of(lanes, s, slope):
    for k in range(lanes):
        im = s[k + IM]
        slope[k], slope[k + 64], slope[k + 128] = s[k + PX] * im, s[k + PY] * im, s[k + PZ] * im
        slope[k + 192], slope[k + 256], slope[k + 320] = s[k + FX], s[k + FY], s[k + FZ]


def move(stage, lanes, h, s, y):
    """Make the state of a stage from the slopes of those before it."""
    if lanes < FEW:
        for k in range(lanes):
            rx, ry, rz, px, py, pz = (
                y[k],
                y[k + 64],
                y[k + 128],
                y[k + 192],
                y[k + 256],
                y[k + 320],
            )
            for j in range(stage):
                g = h * A[stage * STAGES + j]
                if g != 0.0:
                    m = POINT * (j + 1) + k
                    rx += g * y[m]
                    ry += g * y[m + 64]
                    rz += g * y[m + 128]
                    px += g * y[m + 192]
                    py += g * y[m + 256]
                    pz += g * y[m + 320]
            s[k + RX], s[k + RY], s[k + RZ] = rx, ry, rz
            s[k + PX], s[k + PY], s[k + PZ] = px, py, pz
    else:
        start = True
        for j in range(stage):
            g = h * A[stage * STAGES + j]
            if g != 0.0:
                _move_by(lanes, g, y, start, y[POINT * (j + 1) : POINT * (j + 2)], s)
                start = False


@inline
def finish(k, h, s, y, rx, ry, rz, px, py, pz):
    """y + h K of one body."""
    s[k + RX], s[k + EX] = add_compensated(y[k], s[k + EX], h * rx)
    s[k + RY], s[k + EY] = add_compensated(y[k + 64], s[k + EY], h * ry)
    s[k + RZ], s[k + EZ] = add_compensated(y[k + 128], s[k + EZ], h * rz)
    s[k + PX], s[k + GX] = add_compensated(y[k + 192], s[k + GX], h * px)
    s[k + PY], s[k + GY] = add_compensated(y[k + 256], s[k + GY], h * py)
    s[k + PZ], s[k + GZ] = add_compensated(y[k + 320], s[k + GZ], h * pz)


@inline
def _scale(lanes, factor, slope, total):
    for k in range(lanes):
        total[k] = factor * slope[k]
        total[k + 64] = factor * slope[k + 64]
        total[k + 128] = factor * slope[k + 128]
        total[k + 192] = factor * slope[k + 192]
        total[k + 256] = factor * slope[k + 256]
        total[k + 320] = factor * slope[k + 320]


@inline
def _add(lanes, factor, slope, total):
    for k in range(lanes):
        total[k] += factor * slope[k]
        total[k + 64] += factor * slope[k + 64]
        total[k + 128] += factor * slope[k + 128]
        total[k + 192] += factor * slope[k + 192]
        total[k + 256] += factor * slope[k + 256]
        total[k + 320] += factor * slope[k + 320]


@inline
def _finish_all(lanes, h, s, y, z):
    for k in range(lanes):
        finish(k, h, s, y, z[k], z[k + 64], z[k + 128], z[k + 192], z[k + 256], z[k + 320])


def end(lanes, h, s, y):
    """y + h sum b K. May overwrite the slope TOTAL."""
    if lanes < FEW:
        for k in range(lanes):
            rx = ry = rz = px = py = pz = 0.0
            for j in range(STAGES):
                g = B[j]
                if g != 0.0:
                    m = POINT * (j + 1) + k
                    rx += g * y[m]
                    ry += g * y[m + 64]
                    rz += g * y[m + 128]
                    px += g * y[m + 192]
                    py += g * y[m + 256]
                    pz += g * y[m + 320]
            finish(k, h, s, y, rx, ry, rz, px, py, pz)
    else:
        z = y[POINT * (TOTAL + 1) : POINT * (TOTAL + 2)]
        _scale(lanes, B[0], y[POINT : 2 * POINT], z)
        for j in range(1, STAGES):
            if B[j] != 0.0:
                _add(lanes, B[j], y[POINT * (j + 1) : POINT * (j + 2)], z)
        _finish_all(lanes, h, s, y, z)


def step_under_held_force(lanes, h, s):
    """
    Step points under a constant force: the tableau summed by hand.

    r <- r + h p/m + h^2 (sum b_i c_i) F/m,   p <- p + h F
    """
    for k in range(lanes):
        g = h * s[k + IM]
        d = h * BC
        s[k + RX], s[k + EX] = add_compensated(
            s[k + RX], s[k + EX], g * (s[k + PX] + d * s[k + FX])
        )
        s[k + RY], s[k + EY] = add_compensated(
            s[k + RY], s[k + EY], g * (s[k + PY] + d * s[k + FY])
        )
        s[k + RZ], s[k + EZ] = add_compensated(
            s[k + RZ], s[k + EZ], g * (s[k + PZ] + d * s[k + FZ])
        )
        s[k + PX], s[k + GX] = add_compensated(s[k + PX], s[k + GX], h * s[k + FX])
        s[k + PY], s[k + GY] = add_compensated(s[k + PY], s[k + GY], h * s[k + FY])
        s[k + PZ], s[k + GZ] = add_compensated(s[k + PZ], s[k + GZ], h * s[k + FZ])
