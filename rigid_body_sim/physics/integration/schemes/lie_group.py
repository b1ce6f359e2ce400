# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The commutator-free Lie-group Runge–Kutta method of order four on (r, p, q, L).

Attitudes are composed of rotations, so that every stage is one and the last needs no projection:

    k_i = I^-1 R(q_i)^T L_i                      omega of a stage, body axes
    q2 = q exp(h k1/2),   q3 = q exp(h k2/2),   q4 = q2 exp(h (k3 - k1/2))
    q <- q exp(h (3 k1 + 2 k2 + 2 k3 - k4)/12) exp(h (-k1 + 2 k2 + 2 k3 + 3 k4)/12)

r, p and L' = torque take the classical method of order four, L_i = L + a_i h torque_(i-1).
Without torque L is not touched. The price of L in world axes: an error of the attitude changes
omega by up to I_max / I_min times itself, so a thin rod needs small steps.

Source: Celledoni, Marthinsen & Owren, Future Gener. Comput. Syst. 19 (2003); Hairer, Lubich &
Wanner, IV.8.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, specialise
from rigid_body_sim.physics.integration.free_rotation.euler import exponential
from rigid_body_sim.physics.integration.schemes import runge_kutta
from rigid_body_sim.physics.integration.schemes.state_space import no_rotation
from rigid_body_sim.physics.integration.schemes.state_space import points as points
from rigid_body_sim.physics.integration.schemes.state_space.points import POINT
from rigid_body_sim.physics.state.blocks import (
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

# the workspace of a block of rotations: q, L and q2, then k and torque of each stage
STAGE = 704
TURN = 384
SIZE = STAGE + 4 * TURN

# the classical tableau, which points take
CLASSICAL: dict[str, Any] = {
    'STAGES': 4,
    'A': (0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
    'B': (1 / 6, 1 / 3, 1 / 3, 1 / 6),
    'C': (0.0, 0.5, 0.5, 1.0),
    'BC': 0.5,
    'TOTAL': 0,
}


@inline
def _after(x, y, z, w, a, b, c):
    """q exp(a, b, c)."""
    ex, ey, ez, ew = exponential(0.5 * a, 0.5 * b, 0.5 * c)
    return (
        x * ew + w * ex + (y * ez - z * ey),
        y * ew + w * ey + (z * ex - x * ez),
        z * ew + w * ez + (x * ey - y * ex),
        w * ew - (x * ex + y * ey + z * ez),
    )


@inline
def _omega(x, y, z, w, l1, l2, l3, v1, v2, v3):
    """I^-1 R^T L."""
    a, b, c = rotate(-x, -y, -z, w, l1, l2, l3)
    return a * v1, b * v2, c * v3


@inline
def _last(x, y, z, w, h, a1, b1, c1, a2, b2, c2, a3, b3, c3, a4, b4, c4):
    """Attitude at the end of the step, of unit length."""
    g = h / 12.0
    a, b, c = 2.0 * (a2 + a3), 2.0 * (b2 + b3), 2.0 * (c2 + c3)
    x, y, z, w = _after(
        x, y, z, w, g * (a + (3.0 * a1 - a4)), g * (b + (3.0 * b1 - b4)), g * (c + (3.0 * c1 - c4))
    )
    x, y, z, w = _after(
        x, y, z, w, g * (a + (3.0 * a4 - a1)), g * (b + (3.0 * b4 - b1)), g * (c + (3.0 * c4 - c1))
    )
    f = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * f, y * f, z * f, w * f


@kernel
def step(lanes, h, s, y):
    """Step free or steadily torqued rotations."""
    half = 0.5 * h
    for k in range(lanes):
        x, u, v, w = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        l1, l2, l3 = s[k + LX], s[k + LY], s[k + LZ]
        v1, v2, v3 = s[k + J1], s[k + J2], s[k + J3]
        t1, t2, t3 = h * s[k + TX], h * s[k + TY], h * s[k + TZ]
        a1, b1, c1 = _omega(x, u, v, w, l1, l2, l3, v1, v2, v3)
        x2, u2, q2, w2 = _after(x, u, v, w, half * a1, half * b1, half * c1)
        l1, l2, l3 = l1 + 0.5 * t1, l2 + 0.5 * t2, l3 + 0.5 * t3
        a2, b2, c2 = _omega(x2, u2, q2, w2, l1, l2, l3, v1, v2, v3)
        x3, u3, q3, w3 = _after(x, u, v, w, half * a2, half * b2, half * c2)
        a3, b3, c3 = _omega(x3, u3, q3, w3, l1, l2, l3, v1, v2, v3)
        x4, u4, q4, w4 = _after(
            x2, u2, q2, w2, h * a3 - half * a1, h * b3 - half * b1, h * c3 - half * c1
        )
        l1, l2, l3 = s[k + LX] + t1, s[k + LY] + t2, s[k + LZ] + t3
        a4, b4, c4 = _omega(x4, u4, q4, w4, l1, l2, l3, v1, v2, v3)
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = _last(
            x, u, v, w, h, a1, b1, c1, a2, b2, c2, a3, b3, c3, a4, b4, c4
        )
        s[k + LX], s[k + LY], s[k + LZ] = l1, l2, l3


@kernel
def begin(lanes, s, y, method):
    """Remember the state at the start of the step."""
    for k in range(lanes):
        y[k], y[k + 64], y[k + 128], y[k + 192] = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        y[k + 256], y[k + 320], y[k + 384] = s[k + LX], s[k + LY], s[k + LZ]


@kernel
def slope(lanes, s, y, stage):
    """Keep omega and torque of a stage."""
    for k in range(lanes):
        stage[k], stage[k + 64], stage[k + 128] = _omega(
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW], s[k + LX], s[k + LY], s[k + LZ],
            s[k + J1], s[k + J2], s[k + J3],
        )  # fmt: skip
        stage[k + 192], stage[k + 256], stage[k + 320] = s[k + TX], s[k + TY], s[k + TZ]


@kernel
def _turn(lanes, start, factor, now, back, before, s):
    """Attitude start exp(factor now - back before)."""
    for k in range(lanes):
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = _after(
            start[k],
            start[k + 64],
            start[k + 128],
            start[k + 192],
            factor * now[k] - back * before[k],
            factor * now[k + 64] - back * before[k + 64],
            factor * now[k + 128] - back * before[k + 128],
        )


@kernel
def _push(lanes, factor, torque, y, s):
    """L of a stage: L at the start + factor torque."""
    for k in range(lanes):
        s[k + LX] = y[k + 256] + factor * torque[k]
        s[k + LY] = y[k + 320] + factor * torque[k + 64]
        s[k + LZ] = y[k + 384] + factor * torque[k + 128]


@kernel
def move(stage, lanes, h, s, y):
    """Make the state of a stage from those before it."""
    place = STAGE + TURN * (stage - 1)
    now = y[place : place + 192]
    torque = y[place + 192 : place + 384]
    first = y[STAGE : STAGE + 192]
    if stage == 3:
        _turn(lanes, y[448:704], h, now, 0.5 * h, first, s)
        _push(lanes, h, torque, y, s)
    else:
        _turn(lanes, y[0:256], 0.5 * h, now, 0.0, first, s)
        _push(lanes, 0.5 * h, torque, y, s)
    if stage == 1:
        for k in range(lanes):
            y[k + 448], y[k + 512] = s[k + QX], s[k + QY]
            y[k + 576], y[k + 640] = s[k + QZ], s[k + QW]


@kernel
def end(lanes, h, s, y, method):
    """Put the stages together."""
    k1 = y[STAGE : STAGE + TURN]
    k2 = y[STAGE + TURN : STAGE + 2 * TURN]
    k3 = y[STAGE + 2 * TURN : STAGE + 3 * TURN]
    k4 = y[STAGE + 3 * TURN : STAGE + 4 * TURN]
    sixth = h / 6.0
    for k in range(lanes):
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = _last(
            y[k], y[k + 64], y[k + 128], y[k + 192], h,
            k1[k], k1[k + 64], k1[k + 128], k2[k], k2[k + 64], k2[k + 128],
            k3[k], k3[k + 64], k3[k + 128], k4[k], k4[k + 64], k4[k + 128],
        )  # fmt: skip
        for j in range(3):
            m = k + 64 * j
            total = (k1[m + 192] + k4[m + 192]) + 2.0 * (k2[m + 192] + k3[m + 192])
            s[m + LX] = y[m + 256] + sixth * total


def _part(name: str, function: Any) -> Callable[..., Any]:
    """Bind a part of a step of points, to be compiled into it."""
    return specialise(function, name=name, inlined=True, **CLASSICAL)


@dataclass(frozen=True)
class LieRungeKutta4:
    """
    The commutator-free method of order four; points take the classical one.

    turning : False for point masses alone
    """

    turning: bool = True

    def for_points(self) -> LieRungeKutta4:
        """Return the same scheme without rotation."""
        return replace(self, turning=False)

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        return specialise(
            runge_kutta._advance_free,
            name=name,
            step_points=_part(name, points.step_under_held_force),
            step_turns=step if self.turning else no_rotation.step,
        )

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        return specialise(
            runge_kutta._advance_coupled,
            name=f'{name}__{scene}',
            evaluate=evaluate,
            move_points=_part(name, points.move),
            end_points=_part(name, points.end),
            begin_turns=begin if self.turning else no_rotation.begin,
            move_turns=move if self.turning else no_rotation.move,
            slope_of_turns=slope if self.turning else no_rotation.slope_of,
            end_turns=end if self.turning else no_rotation.end,
            TURN=TURN,
            TURN_START=STAGE,
            **CLASSICAL,
        )

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        return max(blocks, 1) * (POINT * 5 + SIZE)
