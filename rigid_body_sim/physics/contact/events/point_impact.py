# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulse of an impact at one point: Coulomb friction through slip and stick, and Stronge's rule
for its end.

    compression until u_n = 0, having done the work -W_c;   restitution until W = e^2 W_c

    u_n : normal velocity of B against A        W : work of the normal impulse, from u_n = 0 on

While it slips, friction is mu p_n against the slip, whose direction turns (`slip_path`). Where
slip stops, it stays so if mu >= |K_tt^-1 K_tn|, the friction that sticking needs; else it starts
anew in the one direction that it then keeps. Both, and slip whose direction does not turn, are
straight lines in the normal impulse. Balls, and all that is struck along the line of the centres
of mass, have a closed form.

Energy never rises, whatever e <= 1 and mu: friction takes, and the normal impulse returns e^2 of
what it took. (Newton's rule, u_n' = -e u_n, gains where friction turns the slip.) Where rigid
bodies jam (Painleve: f_n < 0 while it slips), the path itself says what happens: compression goes
on until slip stops or turns.

W. J. Stronge, Impact Mechanics, 2nd ed. (2018), ch. 3 to 5. K: `collision_matrix`.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.events import slip_path
from rigid_body_sim.physics.contact.events.collision_matrix import (
    CollisionMatrix,
    StruckBody,
    across,
    in_axes,
)
from rigid_body_sim.physics.contact.events.slip_path import Slip
from rigid_body_sim.physics.vectors import add, add_scaled, apply_symmetric, cross, dot, scale

STILL = 1e-14  # [-] of the speed: slower slip is none
MOST_PHASES = 16  # compressions, restitutions, slips and sticks of one impact: 2 to 5
NEWTON_STEPS = 30  # 4 to 6 are needed
SECULAR_ACCURACY = 1e-15  # [-] of the length of a direction


@inline
def _axes(velocity: Any, pull: Any, normal: Any) -> Any:
    """
    Give tangents to the normal: the first along the slip, or where there is none, along the slip
    that the normal impulse starts; so what mirrors the bodies, or swaps them, mirrors all digits.
    """
    slip = add_scaled(velocity, -dot(normal, velocity), normal)
    along = math.sqrt(dot(slip, slip))
    if along * along <= STILL * STILL * dot(velocity, velocity):
        slip = add_scaled(pull, -dot(normal, pull), normal)
        along = math.sqrt(dot(slip, slip))
        if along <= slip_path.MATRIX_ROUND_OFF * math.sqrt(dot(pull, pull)):
            slip, along = across(normal), 1.0
    first = scale(1.0 / along, slip)
    first = add_scaled(first, -dot(normal, first), normal)  # slip may be small beside approach
    first = scale(1.0 / math.sqrt(dot(first, first)), first)
    return first, cross(normal, first), normal


@inline
def _pull(body: StruckBody, normal: Any) -> Any:
    """Return what a unit normal impulse does to the velocity of a body at the point."""
    return cross(apply_symmetric(body.inverse_inertia, cross(body.arm, normal)), body.arm)


@inline
def _sticking(matrix: CollisionMatrix) -> Any:
    """Return (x, y) = -K_tt^-1 K_tn: the tangential impulse that keeps a point from slipping."""
    k = matrix
    determinant = k.k_11 * k.k_22 - k.k_12 * k.k_12
    return (
        (k.k_12 * k.k_2n - k.k_22 * k.k_1n) / determinant,
        (k.k_12 * k.k_1n - k.k_11 * k.k_2n) / determinant,
    )


@kernel
def _new_slip(matrix: CollisionMatrix, friction: float) -> Any:
    """
    Return the direction (c, s) in which slip starts from rest and stays.

    K_tn - mu K_tt d = growth d with growth > 0: d = (growth + mu K_tt)^-1 K_tn, |d| = 1. In the
    principal axes of K_tt the length falls with growth, so there is one; 1/|d| is nearly straight
    in it (the secular equation of trust regions).
    """
    k = matrix
    mean, unlike = 0.5 * (k.k_11 + k.k_22), 0.5 * (k.k_11 - k.k_22)
    radius = math.sqrt(unlike * unlike + k.k_12 * k.k_12)
    angle = 0.5 * math.atan2(k.k_12, unlike)
    c, s = math.cos(angle), math.sin(angle)
    x, y = c * k.k_1n + s * k.k_2n, c * k.k_2n - s * k.k_1n
    stiff, soft = friction * (mean + radius), friction * (mean - radius)
    growth = 0.0
    for _ in range(NEWTON_STEPS):
        a, b = x / (growth + stiff), y / (growth + soft)
        squared = a * a + b * b
        slope = a * a / (growth + stiff) + b * b / (growth + soft)
        change = squared * (math.sqrt(squared) - 1.0) / slope
        growth += change
        if abs(change) <= SECULAR_ACCURACY * (growth + stiff):
            break
    a, b = x / (growth + stiff), y / (growth + soft)
    length = math.sqrt(a * a + b * b)
    a, b = a / length, b / length
    return c * a - s * b, s * a + c * b


@inline
def _line(slip: Slip, returned: float, rates: Any, tangent: Any) -> Any:
    """
    Go straight on in the normal impulse to the end of a phase, or to where slip stops, or to where
    the bodies are pressed together again.

    rates   : growth of the speed of slip and of u_n, per p_n
    tangent : p_t per p_n
    """
    growth, f_n = rates
    speed, missing = slip.normal_velocity, returned - slip.work
    inside = speed * speed + 2.0 * f_n * missing
    way, ended = math.inf, slip_path.DONE
    if returned >= 0.0 and inside >= 0.0:
        way = 2.0 * missing / (speed + math.sqrt(inside))
    elif returned >= 0.0:
        way, ended = -speed / f_n, slip_path.PRESSED
    elif f_n > 0.0:
        way = -speed / f_n
    if growth < 0.0 and -slip.speed / growth <= way:
        way, ended = -slip.speed / growth, slip_path.STOPPED
    after = Slip(
        slip.cosine, slip.sine, slip.speed + way * growth, speed + way * f_n,
        slip.work + way * (speed + 0.5 * way * f_n), slip.normal_impulse + way,
        slip.tangent_1 + way * tangent[0], slip.tangent_2 + way * tangent[1],
    )  # fmt: skip
    return slip_path.stopped(after) if ended == slip_path.STOPPED else after, ended


@inline
def _straight_slip(slip: Slip, returned: float, matrix: CollisionMatrix, friction: float) -> Any:
    """Follow slip that keeps its direction."""
    c, s = slip.cosine, slip.sine
    f_1, f_2, f_n = slip_path.push(matrix, friction, c, s)
    return _line(slip, returned, (c * f_1 + s * f_2, f_n), (-friction * c, -friction * s))


@inline
def _go_on(slip: Slip, returned: float, size: float, matrix: CollisionMatrix, mu: float) -> Any:
    """Follow the path to where something changes: slip, stick, or the phase of the impact."""
    if slip.speed > 0.0:
        if slip_path.turns_no_more(slip, size, matrix, mu):
            return _straight_slip(slip, returned, matrix, mu)
        return slip_path.follow(slip, returned, size, matrix, mu)
    x, y = _sticking(matrix)
    if x * x + y * y <= mu * mu:
        f_n = matrix.k_1n * x + matrix.k_2n * y + matrix.k_nn
        return _line(slip, returned, (0.0, f_n), (x, y))
    c, s = _new_slip(matrix, mu)
    started = Slip(
        c, s, 0.0, slip.normal_velocity, slip.work, slip.normal_impulse, slip.tangent_1,
        slip.tangent_2,
    )  # fmt: skip
    return _straight_slip(started, returned, matrix, mu)


@inline
def _next_phase(slip: Slip) -> Slip:
    """Return a path whose compression has just ended: its work counts from here on."""
    return Slip(
        slip.cosine, slip.sine, slip.speed, 0.0, 0.0, slip.normal_impulse, slip.tangent_1,
        slip.tangent_2,
    )  # fmt: skip


@kernel
def _whole_path(approach: Any, matrix: CollisionMatrix, restitution: float, mu: float) -> Any:
    """
    Return the impulse (p_1, p_2, p_n) of an impact with slip along axis 1.

    approach : u_n < 0, slip [m/s], and the speed of the point, by which round-off is judged
    """
    u_n, start, size = approach
    slip = Slip(1.0, 0.0, start, u_n, 0.0, 0.0, 0.0, 0.0)
    returned, kept = -1.0, 0.0
    for _ in range(MOST_PHASES):
        slip, ended = _go_on(slip, returned, size, matrix, mu)
        if ended == slip_path.PRESSED:
            returned, kept = -1.0, returned - slip.work
            slip = Slip(
                slip.cosine, slip.sine, slip.speed, slip.normal_velocity, 0.0,
                slip.normal_impulse, slip.tangent_1, slip.tangent_2,
            )  # fmt: skip
        elif ended == slip_path.DONE:
            if returned >= 0.0:
                break
            returned = kept - restitution * restitution * slip.work
            slip = _next_phase(slip)
            if returned <= 0.0:
                break
    if slip.speed > 0.0:
        return slip.tangent_1, slip.tangent_2, slip.normal_impulse
    x, y = _sticking(matrix)  # it does not slip afterwards: what that needs, to the last digit
    k, p_n = matrix, slip.normal_impulse
    determinant = k.k_11 * k.k_22 - k.k_12 * k.k_12
    return (
        p_n * x - start * (k.k_22 / determinant), p_n * y + start * (k.k_12 / determinant), p_n,
    )  # fmt: skip


@kernel
def point_impact(
    a: StruckBody, b: StruckBody, normal: Any, velocity: Any, restitution: float, friction: float
) -> Any:
    """
    Return the impulse on B [N s], world axes; A takes the opposite.

    normal   : from A to B, unit length
    velocity : of B against A at the point [m/s]
    """
    u_n = dot(normal, velocity)
    if not u_n < 0.0:
        return 0.0, 0.0, 0.0
    axes = _axes(velocity, add(_pull(a, normal), _pull(b, normal)), normal)
    matrix = in_axes(a, b, axes)
    slip, size = dot(axes[0], velocity), math.sqrt(dot(velocity, velocity))
    slip = slip if slip > STILL * size else 0.0
    p_1, p_2, p_n = 0.0, 0.0, -(1.0 + restitution) * u_n / matrix.k_nn
    small = slip_path.MATRIX_ROUND_OFF * (matrix.k_11 + matrix.k_22 + matrix.k_nn)
    central = abs(matrix.k_1n) <= small and abs(matrix.k_2n) <= small
    if central and abs(matrix.k_12) <= small:
        p_1 = -min(friction * p_n, slip / matrix.k_11)
    elif friction > 0.0:
        p_1, p_2, p_n = _whole_path((u_n, slip, size), matrix, restitution, friction)
    return add_scaled(add_scaled(scale(p_1, axes[0]), p_2, axes[1]), p_n, normal)
