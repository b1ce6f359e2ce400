# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the solver keeps of a body during a tick: one row of numbers, next to each other in memory.

Row i belongs to the body with core index i; one more row, of zeros, stands for all that cannot
move. World axes; p and L are the truth, velocities follow from them:

    v = p / m        omega = I^-1 L        I^-1 = R diag(J) R^T

The motion over a substep moves a point at arm r from the centre of mass by

    d + D r,   D r = w t + u x t,   t = 2 u x r

    u, w : quaternion of the turn

Rolling moves the points of a body of revolution but not the point of its surface that is nearest:
such a body turns with its axis alone, and a ball about its centre of mass not at all.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.state.blocks import (
    EX,
    FX,
    J1,
    J2,
    J3,
    LX,
    PX,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    TY,
    TZ,
    add_compensated,
    at,
    rotate,
)
from rigid_body_sim.physics.state.blocks import IM as INVERSE_MASS

Array = NDArray[np.float64]

P, L = 0, 3  # [kg m/s], [kg m^2/s] momenta
IM, II = 6, 7  # [1/kg]; [1/(kg m^2)] inverse inertia xx, xy, xz, yy, yz, zz
D, U, W = 13, 16, 19  # motion since the start of the substep: d [m], u, w [-]
CARRIED = 21  # [-] 1: some contact pushes it in this substep
ENERGY = 22  # [J] kinetic at the start of the tick and the work of forces since
P_HELD, L_HELD = 23, 26  # half the loads; at the end of a tick, scratch
X0, E0, Q0 = 29, 32, 35  # position, its residual and attitude at the start of the tick
XS, ES = 39, 42  # position and its residual at the start of the substep
ROUND = 45  # [-] 0: turns as it is; 1: a body of revolution about AXIS; 2: a ball, 3: about
# its centre of mass
AXIS = 46  # (3) [-] principal axes
ACC, ALPHA = 49, 52  # [m/s^2], [rad/s^2] of free motion at the start of the tick, where wanted
QS = 55  # (4) attitude at the start of the substep
BODY = 64


@inline
def inverse_inertia(rotation: Array, k: int) -> Any:
    """World inverse inertia of the rigid body at a place of the blocks: xx, xy, xz, yy, yz, zz."""
    x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
    a, b, c = rotation[k + J1], rotation[k + J2], rotation[k + J3]
    xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    return (
        a * xx * xx + b * xy * xy + c * xz * xz,
        a * xx * yx + b * xy * yy + c * xz * yz,
        a * xx * zx + b * xy * zy + c * xz * zz,
        a * yx * yx + b * yy * yy + c * yz * yz,
        a * yx * zx + b * yy * zy + c * yz * zz,
        a * zx * zx + b * zy * zy + c * zz * zz,
    )


@inline
def _put_inverse_inertia(bodies: Array, o: int, rotation: Array, k: int) -> None:
    a, b, c = rotation[k + J1], rotation[k + J2], rotation[k + J3]
    if (a == b) & (b == c):  # a ball, a cube: the same in all axes
        xx, xy, xz, yy, yz, zz = a, 0.0, 0.0, a, 0.0, a
    else:
        xx, xy, xz, yy, yz, zz = inverse_inertia(rotation, k)
    bodies[o + II] = xx
    bodies[o + II + 1] = xy
    bodies[o + II + 2] = xz
    bodies[o + II + 3] = yy
    bodies[o + II + 4] = yz
    bodies[o + II + 5] = zz


@kernel
def begin_tick(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Take over a body as it is at the start of a tick."""
    o = i * BODY
    k = at(i, TRANSLATION)
    bodies[o + IM] = translation[k + INVERSE_MASS]
    for axis in range(3):
        bodies[o + X0 + axis] = translation[k + RX + 64 * axis]
        bodies[o + E0 + axis] = translation[k + EX + 64 * axis]
        bodies[o + P + axis] = translation[k + PX + 64 * axis]
        bodies[o + ACC + axis] = bodies[o + IM] * translation[k + FX + 64 * axis]
        bodies[o + L + axis] = 0.0
        bodies[o + D + axis] = 0.0
        bodies[o + U + axis] = 0.0
        bodies[o + P_HELD + axis] = 0.0
        bodies[o + L_HELD + axis] = 0.0
    bodies[o + W] = 1.0
    bodies[o + CARRIED] = 0.0
    for entry in range(6):
        bodies[o + II + entry] = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            bodies[o + L + axis] = rotation[k + LX + 64 * axis]
        for entry in range(4):
            bodies[o + Q0 + entry] = rotation[k + QX + 64 * entry]
        _put_inverse_inertia(bodies, o, rotation, k)


@kernel
def accelerate(i: int, n_rigid: int, rotation: Array, bodies: Array) -> None:
    """Find the angular acceleration of free motion: alpha = I^-1 (torque - omega x L)."""
    o = i * BODY
    for axis in range(3):
        bodies[o + ALPHA + axis] = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z = bodies[o + L], bodies[o + L + 1], bodies[o + L + 2]
        xx, xy, xz = bodies[o + II], bodies[o + II + 1], bodies[o + II + 2]
        yy, yz, zz = bodies[o + II + 3], bodies[o + II + 4], bodies[o + II + 5]
        u, v, w = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
        a = rotation[k + TX] - (v * z - w * y)
        b = rotation[k + TY] - (w * x - u * z)
        c = rotation[k + TZ] - (u * y - v * x)
        bodies[o + ALPHA] = xx * a + xy * b + xz * c
        bodies[o + ALPHA + 1] = xy * a + yy * b + yz * c
        bodies[o + ALPHA + 2] = xz * a + yz * b + zz * c


@kernel
def kick(
    i: int, n_rigid: int, h: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """Let half of the forces of the instant act over a substep, and half of the loads."""
    o = i * BODY
    k = at(i, TRANSLATION)
    bodies[o + CARRIED] = 0.0
    for axis in range(3):
        row = 64 * axis
        bodies[o + XS + axis] = translation[k + RX + row]
        bodies[o + ES + axis] = translation[k + EX + row]
        free = translation[k + PX + row] + 0.5 * h * translation[k + FX + row]
        bodies[o + P + axis] = free + bodies[o + P_HELD + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            free = rotation[k + LX + row] + 0.5 * h * rotation[k + TX + row]
            bodies[o + L + axis] = free + bodies[o + L_HELD + axis]
        for entry in range(4):
            bodies[o + QS + entry] = rotation[k + QX + 64 * entry]


@kernel
def before_turn(i: int, n_rigid: int, half: float, rotation: Array, bodies: Array) -> None:
    """Give a carried body the momentum with which it turns, less the half kick of the drift."""
    o = i * BODY
    if bodies[o + CARRIED] > 0.0 and i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            rotation[k + LX + row] = bodies[o + L + axis] - half * rotation[k + TX + row]


@kernel
def after_turn(
    i: int, n_rigid: int, h: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """
    Move a carried body by its own velocity, x += h v, and let the second half of the forces act.
    """
    o = i * BODY
    k = at(i, TRANSLATION)
    carried = bodies[o + CARRIED] > 0.0
    for axis in range(3):
        row = 64 * axis
        if carried:
            translation[k + PX + row] = bodies[o + P + axis] + 0.5 * h * translation[k + FX + row]
            x, e = add_compensated(
                bodies[o + XS + axis],
                bodies[o + ES + axis],
                h * bodies[o + IM] * bodies[o + P + axis],
            )
            translation[k + RX + row] = x
            translation[k + EX + row] = e
    if carried and i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            rotation[k + LX + row] = bodies[o + L + axis] + 0.5 * h * rotation[k + TX + row]


@kernel
def take_over(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Read momenta, inverse inertia and the motion over the substep."""
    o = i * BODY
    k = at(i, TRANSLATION)
    for axis in range(3):
        row = 64 * axis
        bodies[o + P + axis] = translation[k + PX + row]
        x = translation[k + RX + row] - bodies[o + XS + axis]
        bodies[o + D + axis] = x + (translation[k + EX + row] - bodies[o + ES + axis])
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            bodies[o + L + axis] = rotation[k + LX + 64 * axis]
        _put_inverse_inertia(bodies, o, rotation, k)
        _put_turn(bodies, o, rotation, k)


@inline
def _put_turn(bodies: Array, o: int, rotation: Array, k: int) -> None:
    x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
    p, q, r, s = bodies[o + QS], bodies[o + QS + 1], bodies[o + QS + 2], bodies[o + QS + 3]
    kind = bodies[o + ROUND]
    if kind == 3.0:
        return
    if kind == 1.0:
        i, j, m = bodies[o + AXIS], bodies[o + AXIS + 1], bodies[o + AXIS + 2]
        a1, a2, a3 = rotate(p, q, r, s, i, j, m)
        b1, b2, b3 = rotate(x, y, z, w, i, j, m)
        half = math.sqrt(max(0.5 * (1.0 + (a1 * b1 + a2 * b2 + a3 * b3)), 1e-30))
        bodies[o + U] = 0.5 * (a2 * b3 - a3 * b2) / half
        bodies[o + U + 1] = 0.5 * (a3 * b1 - a1 * b3) / half
        bodies[o + U + 2] = 0.5 * (a1 * b2 - a2 * b1) / half
        bodies[o + W] = half
        return
    # q qs*
    bodies[o + U] = s * x - w * p - (y * r - z * q)
    bodies[o + U + 1] = s * y - w * q - (z * p - x * r)
    bodies[o + U + 2] = s * z - w * r - (x * q - y * p)
    bodies[o + W] = w * s + x * p + y * q + z * r


@kernel
def hand_back(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Write the momenta back."""
    o = i * BODY
    k = at(i, TRANSLATION)
    for axis in range(3):
        translation[k + PX + 64 * axis] = bodies[o + P + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            rotation[k + LX + 64 * axis] = bodies[o + L + axis]


@kernel
def let_go(i: int, bodies: Array) -> None:
    """Forget the loads of a body, before they are added up anew."""
    for axis in range(6):
        bodies[i * BODY + P_HELD + axis] = 0.0
