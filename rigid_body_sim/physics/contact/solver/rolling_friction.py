# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rolling and torsional friction of one batch of contacts, lane by lane.

    twist:   J_s <- J_s - g_s omega_n,  |J_s| <= spin J_n
    rolling: J_r <- J_r - g_r omega_t,  |J_r| <= roll J_n

omega = omega_B - omega_A; g: 1/(n-entry), 1/(largest eigenvalue of the tangential block) of
I_A^-1 + I_B^-1; spin, roll [m]: lengths, mu times the size of the patch for instance.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.wide_lanes import disc, turning, twist, vector

Array = NDArray[np.float64]


@inline
def _give(s, g, k, r, p, turn):
    """Give the bodies of a lane an angular impulse about the two tangents and the normal."""
    nx, ny, nz = vector(s, k + constraint.NORMAL)
    tx, ty, tz = vector(s, k + constraint.TANGENT_1)
    ox, oy, oz = vector(s, k + constraint.TANGENT_2)
    twist(
        g, k, r * tx + p * ox + turn * nx, r * ty + p * oy + turn * ny, r * tz + p * oz + turn * nz
    )


@kernel
def load(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Give one point of each lane the second half of its angular load, after the motion."""
    for k in range(lanes):
        _give(
            s,
            g,
            k,
            q[k + contact_point.WARM_ROLLING_1],
            q[k + contact_point.WARM_ROLLING_2],
            q[k + contact_point.WARM_TWIST],
        )


@kernel
def resist(lanes: int, s: Array, q: Array, g: Array) -> None:
    """Visit rolling and torsional friction of one point of each lane."""
    for k in range(lanes):
        nx, ny, nz = vector(s, k + constraint.NORMAL)
        tx, ty, tz = vector(s, k + constraint.TANGENT_1)
        ox, oy, oz = vector(s, k + constraint.TANGENT_2)
        fx, fy, fz = turning(
            s, k + constraint.INVERSE_INERTIA_A, g, k + lane_scratch.ANGULAR_MOMENTUM_A
        )
        wx, wy, wz = turning(
            s, k + constraint.INVERSE_INERTIA_B, g, k + lane_scratch.ANGULAR_MOMENTUM_B
        )
        x, y, z = wx - fx, wy - fy, wz - fz
        press = q[k + contact_point.NORMAL_IMPULSE]
        old_r, old_p, old_s = (
            q[k + contact_point.ROLLING_IMPULSE_1],
            q[k + contact_point.ROLLING_IMPULSE_2],
            q[k + contact_point.TWIST_IMPULSE],
        )
        gain = s[k + constraint.ROLLING_MASS]
        r = old_r - gain * (tx * x + ty * y + tz * z)
        p = old_p - gain * (ox * x + oy * y + oz * z)
        r, p = disc(r, p, s[k + constraint.ROLLING_FRICTION] * press)
        limit = s[k + constraint.TORSIONAL_FRICTION] * press
        turn = old_s - s[k + constraint.TWIST_MASS] * (nx * x + ny * y + nz * z)
        turn = turn if turn < limit else limit
        turn = turn if turn > -limit else -limit
        active = g[k + lane_scratch.ACTIVE] > 0.0
        r, p, turn = (r, p, turn) if active else (old_r, old_p, old_s)
        _give(s, g, k, r - old_r, p - old_p, turn - old_s)
        (
            q[k + contact_point.ROLLING_IMPULSE_1],
            q[k + contact_point.ROLLING_IMPULSE_2],
            q[k + contact_point.TWIST_IMPULSE],
        ) = r, p, turn


@kernel
def release(lanes: int, s: Array, q: Array, g: Array) -> None:
    """
    Bring the angular impulses of the last substep within what presses now; half of the load is
    still to come, of what presses.
    """
    for k in range(lanes):
        press = q[k + contact_point.NORMAL_IMPULSE]
        old_r, old_p, old_s = (
            q[k + contact_point.ROLLING_IMPULSE_1],
            q[k + contact_point.ROLLING_IMPULSE_2],
            q[k + contact_point.TWIST_IMPULSE],
        )
        r, p = disc(old_r, old_p, s[k + constraint.ROLLING_FRICTION] * press)
        limit = s[k + constraint.TORSIONAL_FRICTION] * press
        turn = old_s if old_s < limit else limit
        turn = turn if turn > -limit else -limit
        presses = press > 0.0
        old_hr, old_hq, old_hs = (
            q[k + contact_point.WARM_ROLLING_1],
            q[k + contact_point.WARM_ROLLING_2],
            q[k + contact_point.WARM_TWIST],
        )
        hr = old_hr if presses else 0.0
        hq = old_hq if presses else 0.0
        hs = old_hs if presses else 0.0
        active = g[k + lane_scratch.ACTIVE] > 0.0
        r, p, turn = (r, p, turn) if active else (old_r, old_p, old_s)
        hr, hq, hs = (hr, hq, hs) if active else (old_hr, old_hq, old_hs)
        _give(
            s,
            g,
            k,
            (r - hr) - (old_r - old_hr),
            (p - hq) - (old_p - old_hq),
            (turn - hs) - (old_s - old_hs),
        )
        (
            q[k + contact_point.ROLLING_IMPULSE_1],
            q[k + contact_point.ROLLING_IMPULSE_2],
            q[k + contact_point.TWIST_IMPULSE],
        ) = r, p, turn
        (
            q[k + contact_point.WARM_ROLLING_1],
            q[k + contact_point.WARM_ROLLING_2],
            q[k + contact_point.WARM_TWIST],
        ) = hr, hq, hs
