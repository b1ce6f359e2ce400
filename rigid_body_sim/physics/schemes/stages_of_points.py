# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a Runge–Kutta step for points: r' = p / m, p' = F.

The workspace of a block holds y = (r, p), then the slopes K of each stage, six rows each.
"""

from __future__ import annotations

from rigid_body_sim.physics.blocks import (
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
from rigid_body_sim.physics.kernels import kernel

POINT = 384  # numbers of y, and of a slope, in a block

# bound for each tableau by `specialise`
STAGES = 1
A: tuple[float, ...] = (0.0,)
B: tuple[float, ...] = (1.0,)
BC = 0.0  # sum b c


@kernel
def begin(lanes, s, y):
    for k in range(lanes):
        y[k], y[k + 64], y[k + 128] = s[k + RX], s[k + RY], s[k + RZ]
        y[k + 192], y[k + 256], y[k + 320] = s[k + PX], s[k + PY], s[k + PZ]


@kernel
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


@kernel
def slope(lanes, s, slope):
    for k in range(lanes):
        im = s[k + IM]
        slope[k], slope[k + 64], slope[k + 128] = s[k + PX] * im, s[k + PY] * im, s[k + PZ] * im
        slope[k + 192], slope[k + 256], slope[k + 320] = s[k + FX], s[k + FY], s[k + FZ]


def move(stage, lanes, h, s, y):
    """Make the state of a stage from the slopes of those before it."""
    start = True
    for j in range(stage):
        a = A[stage * STAGES + j]
        if a != 0.0:
            _move_by(lanes, h * a, y, start, y[POINT * (j + 1) : POINT * (j + 2)], s)
            start = False


def end(lanes, h, s, y):
    """y + h sum b K."""
    for k in range(lanes):
        rx = ry = rz = px = py = pz = 0.0
        for j in range(STAGES):
            m = POINT * (j + 1) + k
            rx += B[j] * y[m]
            ry += B[j] * y[m + 64]
            rz += B[j] * y[m + 128]
            px += B[j] * y[m + 192]
            py += B[j] * y[m + 256]
            pz += B[j] * y[m + 320]
        s[k + RX], s[k + EX] = add_compensated(y[k], s[k + EX], h * rx)
        s[k + RY], s[k + EY] = add_compensated(y[k + 64], s[k + EY], h * ry)
        s[k + RZ], s[k + EZ] = add_compensated(y[k + 128], s[k + EZ], h * rz)
        s[k + PX], s[k + GX] = add_compensated(y[k + 192], s[k + GX], h * px)
        s[k + PY], s[k + GY] = add_compensated(y[k + 256], s[k + GY], h * py)
        s[k + PZ], s[k + GZ] = add_compensated(y[k + 320], s[k + GZ], h * pz)


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
