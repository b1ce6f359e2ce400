# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How an implicit step of one body begins and ends, how its state is kept, and how it is shifted for
differences.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.integration.schemes.implicit.stage import (
    BASE_M,
    BASE_P,
    BASE_Q,
    BASE_R,
    HELD,
    HELD_TORQUE,
    KEPT,
    MOVED,
    PUSHED,
    ROTATION_KEPT,
    START_L,
    START_P,
    START_R,
    TORQUE,
    D,
    W,
    set_stage,
    turned,
)
from rigid_body_sim.physics.state.blocks import (
    EX,
    FX,
    GX,
    HX,
    I1,
    I2,
    I3,
    IM,
    J1,
    J2,
    J3,
    KX,
    LX,
    LY,
    LZ,
    PX,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    add_compensated,
    at,
    rotate,
)

DELTA = 64  # step of a difference
HELD_THROUGH = 65  # 1 where only held forces acted in every stage
DIFFERENCE = (
    1e-8  # [-] relative step of the differences: the square root of the rounding of doubles
)


@kernel
def keep(i, n_rigid, b, translation, rotation):
    """Keep the state of a body at the start of a tick."""
    k = at(i, TRANSLATION)
    for quantity in range(12):  # r, p and their residuals
        b[KEPT + quantity] = translation[k + RX + 64 * quantity]
    if i < n_rigid:
        k = at(i, ROTATION)
        for quantity in range(7):
            b[ROTATION_KEPT + quantity] = rotation[k + QX + 64 * quantity]


@kernel
def restore(i, n_rigid, b, translation, rotation):
    """Go back to the state at the start of the tick."""
    k = at(i, TRANSLATION)
    for quantity in range(12):
        translation[k + RX + 64 * quantity] = b[KEPT + quantity]
    if i < n_rigid:
        k = at(i, ROTATION)
        for quantity in range(7):
            rotation[k + QX + 64 * quantity] = b[ROTATION_KEPT + quantity]


@kernel
def begin_part(i, n_rigid, b, translation, rotation):
    """Take the state of a body as base of the first stage, and as first guess."""
    k = at(i, TRANSLATION)
    for axis in range(3):
        r, p = translation[k + RX + 64 * axis], translation[k + PX + 64 * axis]
        b[BASE_R + axis] = r
        b[START_R + axis] = r
        b[BASE_P + axis] = p
        b[START_P + axis] = p
        b[MOVED + axis] = 0.0
        b[PUSHED + axis] = 0.0
        b[D + axis] = 0.0
    b[HELD_THROUGH] = 1.0
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        l1, l2, l3 = rotation[k + LX], rotation[k + LY], rotation[k + LZ]
        m1, m2, m3 = rotate(-x, -y, -z, w, l1, l2, l3)
        b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3] = x, y, z, w
        b[START_L], b[START_L + 1], b[START_L + 2] = l1, l2, l3
        b[BASE_M], b[BASE_M + 1], b[BASE_M + 2] = m1, m2, m3
        b[W], b[W + 1], b[W + 2] = (
            m1 * rotation[k + J1],
            m2 * rotation[k + J2],
            m3 * rotation[k + J3],
        )


@kernel
def _end_translation(k, h, b, translation):
    """Add the sums of the stages to the state at the start."""
    b[HELD_THROUGH] *= b[HELD]
    held = b[HELD_THROUGH] != 0.0
    for axis in range(3):
        place = k + 64 * axis
        pushed = h * translation[place + HX] if held else b[PUSHED + axis]
        translation[place + RX], translation[place + EX] = add_compensated(
            b[START_R + axis], translation[place + EX], b[MOVED + axis]
        )
        translation[place + PX], translation[place + GX] = add_compensated(
            b[START_P + axis], translation[place + GX], pushed
        )


@kernel
def end_stage(i, n_rigid, h, gamma, last, b, translation, rotation):
    """
    Make the base of the next stage of a Runge–Kutta method, or the new state.

        y0 + (1 - gamma) h K,   K = (Y - base) / (gamma h)
    """
    k = at(i, TRANSLATION)
    im = translation[k + IM]
    mass = 1.0 / im
    share = gamma if last else 1.0 - gamma
    for axis in range(3):
        moved = share * h * (b[BASE_P + axis] * im + b[D + axis])
        pushed = share / gamma * mass * b[D + axis]
        b[MOVED + axis] += moved
        b[PUSHED + axis] += pushed
        b[BASE_R + axis] += moved
        b[BASE_P + axis] += pushed
        b[D + axis] = 0.0
    if last:
        _end_translation(k, h, b, translation)
    else:
        b[HELD_THROUGH] *= b[HELD]
    if i < n_rigid:
        k = at(i, ROTATION)
        i1, i2, i3 = rotation[k + I1], rotation[k + I2], rotation[k + I3]
        w1, w2, w3 = b[W], b[W + 1], b[W + 2]
        f = 0.5 * share * h
        x, y, z, w = turned(
            b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3], f * w1, f * w2, f * w3
        )
        if last:
            rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW] = x, y, z, w
            rotation[k + LX], rotation[k + LY], rotation[k + LZ] = rotate(
                x, y, z, w, i1 * w1, i2 * w2, i3 * w3
            )
        else:
            b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3] = x, y, z, w
            f = share / gamma
            b[BASE_M] += f * (i1 * w1 - b[BASE_M])
            b[BASE_M + 1] += f * (i2 * w2 - b[BASE_M + 1])
            b[BASE_M + 2] += f * (i3 * w3 - b[BASE_M + 2])


@kernel
def end_of_midpoint(i, n_rigid, h, b, translation, rotation):
    """
    Make the new state from the one half-way.

        r1 = r0 + h v,   p1 = p0 + 2 m d,   q1 = q0 (a w, 1) / |(a w, 1)|,   L1 = L0 + 2 R0 (a
        T_B),   a = h/2
    """
    k = at(i, TRANSLATION)
    im = translation[k + IM]
    mass = 1.0 / im
    for axis in range(3):
        b[MOVED + axis] = h * (b[BASE_P + axis] * im + b[D + axis])
        b[PUSHED + axis] = 2.0 * mass * b[D + axis]
    _end_translation(k, h, b, translation)
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z, w = b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3]
        p, q, r = rotate(x, y, z, w, b[TORQUE], b[TORQUE + 1], b[TORQUE + 2])
        held = b[HELD_TORQUE] != 0.0
        rotation[k + LX] = b[START_L] + (h * rotation[k + KX] if held else 2.0 * p)
        rotation[k + LY] = b[START_L + 1] + (h * rotation[k + KX + 64] if held else 2.0 * q)
        rotation[k + LZ] = b[START_L + 2] + (h * rotation[k + KX + 128] if held else 2.0 * r)
        a = 0.5 * h
        x, y, z, w = turned(x, y, z, w, a * b[W], a * b[W + 1], a * b[W + 2])
        rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW] = x, y, z, w


@kernel
def correct_torque(i, a, b, rotation, e1, e2, e3):
    """
    Add to the torque what the Newton step w <- w - e changes in the inertial part of the
    equations.
    """
    k = at(i, ROTATION)
    w1, w2, w3 = b[W], b[W + 1], b[W + 2]
    i1, i2, i3 = rotation[k + I1], rotation[k + I2], rotation[k + I3]
    b[TORQUE] -= i1 * e1 + a * (i3 - i2) * (w3 * e2 + w2 * e3)
    b[TORQUE + 1] -= i2 * e2 + a * (i1 - i3) * (w1 * e3 + w3 * e1)
    b[TORQUE + 2] -= i3 * e3 + a * (i2 - i1) * (w2 * e1 + w1 * e2)


@kernel
def save_wrench(i, n_rigid, translation, rotation, saved):
    """Save force and torque on a body, to subtract them from shifted ones."""
    k = at(i, TRANSLATION)
    for axis in range(3):
        saved[12 * i + axis] = translation[k + FX + 64 * axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            saved[12 * i + 3 + axis] = rotation[k + TX + 64 * axis]


@kernel
def wrench_change(i, n_rigid, translation, rotation, saved):
    """Difference from the saved wrench."""
    k = at(i, TRANSLATION)
    f1 = translation[k + FX] - saved[12 * i]
    f2 = translation[k + FX + 64] - saved[12 * i + 1]
    f3 = translation[k + FX + 128] - saved[12 * i + 2]
    t1 = t2 = t3 = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        t1 = rotation[k + TX] - saved[12 * i + 3]
        t2 = rotation[k + TX + 64] - saved[12 * i + 4]
        t3 = rotation[k + TX + 128] - saved[12 * i + 5]
    return f1, f2, f3, t1, t2, t3


@kernel
def shift(midpoint, component, i, n_rigid, a, length, b, translation, rotation):
    """Change one unknown of a body a little; DELTA = 0 where it has no such unknown."""
    if component < 3:
        v = b[BASE_P + component] * translation[at(i, TRANSLATION) + IM] + b[D + component]
        reach = max(length, abs(b[BASE_R + component]))
        size = abs(v) + abs(b[D + component]) + reach / a
        place = D + component
    elif i < n_rigid:
        size = abs(b[W]) + abs(b[W + 1]) + abs(b[W + 2]) + 1.0 / a
        place = W + component - 3
    else:
        b[DELTA] = 0.0
        return
    before = b[place]
    delta = (before + DIFFERENCE * size) - before
    b[DELTA] = delta
    b[place] = before + delta
    set_stage(midpoint, i, n_rigid, a, b, translation, rotation)
    b[place] = before


@kernel
def unshift(midpoint, component, i, n_rigid, a, b, translation, rotation):
    """Return to the state of the stage."""
    set_stage(midpoint, i, n_rigid, a, b, translation, rotation)
