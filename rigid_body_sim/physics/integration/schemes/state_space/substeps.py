# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The error of a substep, what is kept for the case that it is refused, and how long the next one
shall be.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.integration.schemes.state_space.points import POINT
from rigid_body_sim.physics.integration.schemes.state_space.quaternions import TURN, TURN_START
from rigid_body_sim.physics.state.blocks import (
    EX,
    EY,
    EZ,
    GX,
    GY,
    GZ,
    LX,
    LY,
    LZ,
    PX,
    PY,
    PZ,
    QW,
    QX,
    QY,
    QZ,
    RX,
    RY,
    RZ,
)

# bound for each pair by `specialise`
STAGES = 1
ERROR: tuple[float, ...] = (1.0, -1.0)

SAFETY = 0.9  # [-] of the substep that would just be accepted; nearer to 1 more are refused
LEAST, LARGEST = 0.2, 5.0  # [-] change of the substep at once


@inline
def after_acceptance(error, before, refused):
    """Factor of the substep after one with this error: 0.9 e^(-1/8) e_before^(1/16)."""
    e = max(error, 1e-10)
    factor = SAFETY * math.sqrt(math.sqrt(math.sqrt(math.sqrt(before) / e)))
    factor = min(max(factor, LEAST), LARGEST)
    return min(factor, 1.0) if refused else factor


@inline
def after_refusal(error):
    """
    Factor of the substep after one refused with this error, which may be no number: 0.9 e^(-1/4).
    """
    if error < math.inf:
        return max(LEAST, SAFETY / math.sqrt(math.sqrt(error)))
    return LEAST


@inline
def _length(x, y, z):
    return math.sqrt(x * x + y * y + z * z)


def error_of_points(lanes, h, s, y, rtol, atol, first, worst, culprit):
    """
    Largest relative error of the bodies of a block and whose it is, or what was before where that
    is larger.
    """
    for k in range(lanes):
        rx = ry = rz = px = py = pz = 0.0
        for j in range(STAGES + 1):
            m = POINT * (j + 1) + k
            rx += ERROR[j] * y[m]
            ry += ERROR[j] * y[m + 64]
            rz += ERROR[j] * y[m + 128]
            px += ERROR[j] * y[m + 192]
            py += ERROR[j] * y[m + 256]
            pz += ERROR[j] * y[m + 320]
        size = max(_length(y[k], y[k + 64], y[k + 128]), _length(s[k + RX], s[k + RY], s[k + RZ]))
        e = h * _length(rx, ry, rz) / (atol + rtol * size)
        size = max(
            _length(y[k + 192], y[k + 256], y[k + 320]), _length(s[k + PX], s[k + PY], s[k + PZ])
        )
        f = h * _length(px, py, pz) / (atol + rtol * size)
        if f > e or f != f:
            e = f
        if e > worst or e != e:
            worst, culprit = e, first + k
    return worst, culprit


def error_of_turns(lanes, h, y, rtol, atol, first, worst, culprit):
    """The same for rotations: of q, whose length is one, and of omega in body axes."""
    for k in range(lanes):
        qx = qy = qz = qw = a = b = c = 0.0
        for j in range(STAGES + 1):
            m = TURN_START + TURN * j + k
            qx += ERROR[j] * y[m]
            qy += ERROR[j] * y[m + 64]
            qz += ERROR[j] * y[m + 128]
            qw += ERROR[j] * y[m + 192]
            a += ERROR[j] * y[m + 256]
            b += ERROR[j] * y[m + 320]
            c += ERROR[j] * y[m + 384]
        e = h * math.sqrt(qx * qx + qy * qy + qz * qz + qw * qw) / (atol + rtol)
        size = max(
            _length(y[k + 256], y[k + 320], y[k + 384]),
            _length(y[k + 448], y[k + 512], y[k + 576]),
        )
        f = h * _length(a, b, c) / (atol + rtol * size)
        if f > e or f != f:
            e = f
        if e > worst or e != e:
            worst, culprit = e, first + k
    return worst, culprit


@inline
def take_over(rows, lanes, slope, first):
    """Make the slope at the new state the first of the next substep."""
    for row in range(rows):
        for k in range(lanes):
            first[k + 64 * row] = slope[k + 64 * row]


@inline
def save_points(lanes, s, saved):
    """Keep what rounding lost; r and p are in y."""
    for k in range(lanes):
        saved[k], saved[k + 64], saved[k + 128] = s[k + EX], s[k + EY], s[k + EZ]
        saved[k + 192], saved[k + 256], saved[k + 320] = s[k + GX], s[k + GY], s[k + GZ]


@inline
def restore_points(lanes, y, saved, s):
    """Return to the start of the substep."""
    for k in range(lanes):
        s[k + RX], s[k + RY], s[k + RZ] = y[k], y[k + 64], y[k + 128]
        s[k + PX], s[k + PY], s[k + PZ] = y[k + 192], y[k + 256], y[k + 320]
        s[k + EX], s[k + EY], s[k + EZ] = saved[k], saved[k + 64], saved[k + 128]
        s[k + GX], s[k + GY], s[k + GZ] = saved[k + 192], saved[k + 256], saved[k + 320]


@inline
def save_turns(lanes, s, memory, saved):
    """Keep q and L."""
    for k in range(lanes):
        saved[k], saved[k + 64], saved[k + 128] = s[k + QX], s[k + QY], s[k + QZ]
        saved[k + 192] = s[k + QW]
        saved[k + 256], saved[k + 320], saved[k + 384] = s[k + LX], s[k + LY], s[k + LZ]


@inline
def restore_turns(lanes, saved, y, s):
    """Return to the start of the substep."""
    for k in range(lanes):
        s[k + QX], s[k + QY], s[k + QZ] = saved[k], saved[k + 64], saved[k + 128]
        s[k + QW] = saved[k + 192]
        s[k + LX], s[k + LY], s[k + LZ] = saved[k + 256], saved[k + 320], saved[k + 384]
