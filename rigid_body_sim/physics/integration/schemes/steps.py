# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Steps that every scheme needs: begin an evaluation, kick and drift points, look for numbers that
are none.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel
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
    HX,
    HY,
    HZ,
    IM,
    KX,
    KY,
    KZ,
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
    ROTATION,
    RX,
    RY,
    RZ,
    TRANSLATION,
    TX,
    TY,
    TZ,
    add_compensated,
)


@inline
def start_evaluation(n_bodies, n_rigid, translation, rotation):
    """Set the sums of forces and torques to what is held over the tick."""
    for block in range((n_bodies + 63) // 64):
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        for k in range(min(64, n_bodies - 64 * block)):
            s[k + FX] = s[k + HX]
            s[k + FY] = s[k + HY]
            s[k + FZ] = s[k + HZ]
    for block in range((n_rigid + 63) // 64):
        s = rotation[block * ROTATION : block * ROTATION + ROTATION]
        for k in range(min(64, n_rigid - 64 * block)):
            s[k + TX] = s[k + KX]
            s[k + TY] = s[k + KY]
            s[k + TZ] = s[k + KZ]


@kernel
def kick(block, lanes, time, translation):
    """Let the forces act for a time: p <- p + time F."""
    s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
    for k in range(lanes):
        s[k + PX], s[k + GX] = add_compensated(s[k + PX], s[k + GX], time * s[k + FX])
        s[k + PY], s[k + GY] = add_compensated(s[k + PY], s[k + GY], time * s[k + FY])
        s[k + PZ], s[k + GZ] = add_compensated(s[k + PZ], s[k + GZ], time * s[k + FZ])


@kernel
def kick_and_drift(block, lanes, kick_time, time, translation):
    """Kick, then move freely: p <- p + kick_time F, r <- r + time p / m."""
    s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
    for k in range(lanes):
        p, g = add_compensated(s[k + PX], s[k + GX], kick_time * s[k + FX])
        s[k + PX], s[k + GX] = p, g
        s[k + RX], s[k + EX] = add_compensated(s[k + RX], s[k + EX], time * s[k + IM] * p)
        p, g = add_compensated(s[k + PY], s[k + GY], kick_time * s[k + FY])
        s[k + PY], s[k + GY] = p, g
        s[k + RY], s[k + EY] = add_compensated(s[k + RY], s[k + EY], time * s[k + IM] * p)
        p, g = add_compensated(s[k + PZ], s[k + GZ], kick_time * s[k + FZ])
        s[k + PZ], s[k + GZ] = p, g
        s[k + RZ], s[k + EZ] = add_compensated(s[k + RZ], s[k + EZ], time * s[k + IM] * p)


@kernel
def kick_rotation(block, lanes, time, rotation):
    """Let the torques act for a time: L <- L + time torque."""
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    for k in range(lanes):
        s[k + LX] += time * s[k + TX]
        s[k + LY] += time * s[k + TY]
        s[k + LZ] += time * s[k + TZ]


@kernel
def finite(n_bodies, n_rigid, translation, rotation):
    """
    Return 0 if every position, momentum, orientation and angular momentum is finite, else NaN.
    """
    total = 0.0
    for block in range((n_bodies + 63) // 64):
        s = translation[block * TRANSLATION : block * TRANSLATION + TRANSLATION]
        for k in range(min(64, n_bodies - 64 * block)):
            total += 0.0 * (s[k + RX] + s[k + RY] + s[k + RZ] + s[k + PX] + s[k + PY] + s[k + PZ])
    for block in range((n_rigid + 63) // 64):
        s = rotation[block * ROTATION : block * ROTATION + ROTATION]
        for k in range(min(64, n_rigid - 64 * block)):
            total += 0.0 * (s[k + QX] + s[k + QY] + s[k + QZ] + s[k + QW])
            total += 0.0 * (s[k + LX] + s[k + LY] + s[k + LZ])
    return total
