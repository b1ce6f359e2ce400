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

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.state.blocks import (
    EX,
    FX,
    IM,
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

Array = NDArray[np.float64]

body = Record()
MOMENTUM = body.vector('kg m/s', '')
ANGULAR_MOMENTUM = body.vector('kg m^2/s', 'about the centre of mass')
INVERSE_MASS = body.number('1/kg', '')
INVERSE_INERTIA = body.symmetric('1/(kg m^2)', 'as the body stands now')
DISPLACEMENT = body.vector('m', 'd: since the start of the substep')
TURN = body.vector('-', 'u: vector part of the turn since the start of the substep')
TURN_SCALAR = body.number('-', 'w: its scalar part')
CARRIED = body.number('-', '1: some contact pushes it in this substep')
ENERGY = body.number('J', 'kinetic at the start of the tick and the work of forces since')
WARM_IMPULSE = body.vector('N s', 'half the warm-start impulses of its contacts')
WARM_ANGULAR_IMPULSE = body.vector('N m s', 'half the warm-start angular impulses')
START_POSITION = body.vector('m', 'at the start of the tick')
START_RESIDUAL = body.vector('m', 'what rounding lost of it')
START_ORIENTATION = body.quaternion('-', 'at the start of the tick')
SUBSTEP_POSITION = body.vector('m', 'at the start of the substep')
SUBSTEP_RESIDUAL = body.vector('m', 'what rounding lost of it')
SYMMETRY = body.number('-', 'how it turns, by the names below: `collision.axis_of_symmetry`')
SYMMETRY_AXIS = body.vector('-', 'principal axes')
FREE_ACCELERATION = body.vector('m/s^2', 'without contact, at the start of the tick, where wanted')
FREE_ANGULAR_ACCELERATION = body.vector('rad/s^2', 'the same')
SUBSTEP_ORIENTATION = body.quaternion('-', 'at the start of the substep')
MOMENTUM_BEFORE_RESTITUTION = body.vector('kg m/s', 'from which restitution starts')
ANGULAR_MOMENTUM_BEFORE_RESTITUTION = body.vector('kg m^2/s', 'the same')
SIZE = body.padding(64)  # eight cache lines

# how a body turns, the rounder the larger
FIXED, AS_IT_IS, ABOUT_AXIS, BALL, CENTRED_BALL = -1.0, 0.0, 1.0, 2.0, 3.0


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
    bodies[o + INVERSE_INERTIA] = xx
    bodies[o + INVERSE_INERTIA + 1] = xy
    bodies[o + INVERSE_INERTIA + 2] = xz
    bodies[o + INVERSE_INERTIA + 3] = yy
    bodies[o + INVERSE_INERTIA + 4] = yz
    bodies[o + INVERSE_INERTIA + 5] = zz


@kernel
def begin_tick(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Take over a body as it is at the start of a tick."""
    o = i * SIZE
    k = at(i, TRANSLATION)
    bodies[o + INVERSE_MASS] = translation[k + IM]
    for axis in range(3):
        bodies[o + START_POSITION + axis] = translation[k + RX + 64 * axis]
        bodies[o + START_RESIDUAL + axis] = translation[k + EX + 64 * axis]
        bodies[o + MOMENTUM + axis] = translation[k + PX + 64 * axis]
        bodies[o + FREE_ACCELERATION + axis] = (
            bodies[o + INVERSE_MASS] * translation[k + FX + 64 * axis]
        )
        bodies[o + ANGULAR_MOMENTUM + axis] = 0.0
        bodies[o + DISPLACEMENT + axis] = 0.0
        bodies[o + TURN + axis] = 0.0
        bodies[o + WARM_IMPULSE + axis] = 0.0
        bodies[o + WARM_ANGULAR_IMPULSE + axis] = 0.0
    bodies[o + TURN_SCALAR] = 1.0
    bodies[o + CARRIED] = 0.0
    for entry in range(6):
        bodies[o + INVERSE_INERTIA + entry] = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            bodies[o + ANGULAR_MOMENTUM + axis] = rotation[k + LX + 64 * axis]
        for entry in range(4):
            bodies[o + START_ORIENTATION + entry] = rotation[k + QX + 64 * entry]
        _put_inverse_inertia(bodies, o, rotation, k)


@kernel
def find_free_acceleration(i: int, n_rigid: int, rotation: Array, bodies: Array) -> None:
    """Find the angular acceleration of free motion: alpha = I^-1 (torque - omega x L)."""
    o = i * SIZE
    for axis in range(3):
        bodies[o + FREE_ANGULAR_ACCELERATION + axis] = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z = (
            bodies[o + ANGULAR_MOMENTUM],
            bodies[o + ANGULAR_MOMENTUM + 1],
            bodies[o + ANGULAR_MOMENTUM + 2],
        )
        xx, xy, xz = (
            bodies[o + INVERSE_INERTIA],
            bodies[o + INVERSE_INERTIA + 1],
            bodies[o + INVERSE_INERTIA + 2],
        )
        yy, yz, zz = (
            bodies[o + INVERSE_INERTIA + 3],
            bodies[o + INVERSE_INERTIA + 4],
            bodies[o + INVERSE_INERTIA + 5],
        )
        u, v, w = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
        a = rotation[k + TX] - (v * z - w * y)
        b = rotation[k + TY] - (w * x - u * z)
        c = rotation[k + TZ] - (u * y - v * x)
        bodies[o + FREE_ANGULAR_ACCELERATION] = xx * a + xy * b + xz * c
        bodies[o + FREE_ANGULAR_ACCELERATION + 1] = xy * a + yy * b + yz * c
        bodies[o + FREE_ANGULAR_ACCELERATION + 2] = xz * a + yz * b + zz * c


@kernel
def kick_and_warm_start(
    i: int, n_rigid: int, h: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """Let half of the forces of the instant act over a substep, and half of the loads."""
    o = i * SIZE
    k = at(i, TRANSLATION)
    bodies[o + CARRIED] = 0.0
    for axis in range(3):
        row = 64 * axis
        bodies[o + SUBSTEP_POSITION + axis] = translation[k + RX + row]
        bodies[o + SUBSTEP_RESIDUAL + axis] = translation[k + EX + row]
        free = translation[k + PX + row] + 0.5 * h * translation[k + FX + row]
        bodies[o + MOMENTUM + axis] = free + bodies[o + WARM_IMPULSE + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            free = rotation[k + LX + row] + 0.5 * h * rotation[k + TX + row]
            bodies[o + ANGULAR_MOMENTUM + axis] = free + bodies[o + WARM_ANGULAR_IMPULSE + axis]
        for entry in range(4):
            bodies[o + SUBSTEP_ORIENTATION + entry] = rotation[k + QX + 64 * entry]


@kernel
def scatter_angular_momentum(
    i: int, n_rigid: int, half: float, rotation: Array, bodies: Array
) -> None:
    """Give a carried body the momentum with which it turns, less the half kick of the drift."""
    o = i * SIZE
    if bodies[o + CARRIED] > 0.0 and i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            rotation[k + LX + row] = (
                bodies[o + ANGULAR_MOMENTUM + axis] - half * rotation[k + TX + row]
            )


@kernel
def integrate_position(
    i: int, n_rigid: int, h: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """
    Move a carried body by its own velocity, x += h v, and let the second half of the forces act.
    """
    o = i * SIZE
    k = at(i, TRANSLATION)
    carried = bodies[o + CARRIED] > 0.0
    for axis in range(3):
        row = 64 * axis
        if carried:
            translation[k + PX + row] = (
                bodies[o + MOMENTUM + axis] + 0.5 * h * translation[k + FX + row]
            )
            x, e = add_compensated(
                bodies[o + SUBSTEP_POSITION + axis],
                bodies[o + SUBSTEP_RESIDUAL + axis],
                h * bodies[o + INVERSE_MASS] * bodies[o + MOMENTUM + axis],
            )
            translation[k + RX + row] = x
            translation[k + EX + row] = e
    if carried and i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            row = 64 * axis
            rotation[k + LX + row] = (
                bodies[o + ANGULAR_MOMENTUM + axis] + 0.5 * h * rotation[k + TX + row]
            )


@kernel
def gather_body(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Read momenta, inverse inertia and the motion over the substep."""
    o = i * SIZE
    k = at(i, TRANSLATION)
    for axis in range(3):
        row = 64 * axis
        bodies[o + MOMENTUM + axis] = translation[k + PX + row]
        x = translation[k + RX + row] - bodies[o + SUBSTEP_POSITION + axis]
        bodies[o + DISPLACEMENT + axis] = x + (
            translation[k + EX + row] - bodies[o + SUBSTEP_RESIDUAL + axis]
        )
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            bodies[o + ANGULAR_MOMENTUM + axis] = rotation[k + LX + 64 * axis]
        _put_inverse_inertia(bodies, o, rotation, k)
        _put_turn(bodies, o, rotation, k)


@inline
def _put_turn(bodies: Array, o: int, rotation: Array, k: int) -> None:
    x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
    p, q, r, s = (
        bodies[o + SUBSTEP_ORIENTATION],
        bodies[o + SUBSTEP_ORIENTATION + 1],
        bodies[o + SUBSTEP_ORIENTATION + 2],
        bodies[o + SUBSTEP_ORIENTATION + 3],
    )
    kind = bodies[o + SYMMETRY]
    if kind == CENTRED_BALL:
        return
    if kind == ABOUT_AXIS:
        i, j, m = (
            bodies[o + SYMMETRY_AXIS],
            bodies[o + SYMMETRY_AXIS + 1],
            bodies[o + SYMMETRY_AXIS + 2],
        )
        a1, a2, a3 = rotate(p, q, r, s, i, j, m)
        b1, b2, b3 = rotate(x, y, z, w, i, j, m)
        half = math.sqrt(max(0.5 * (1.0 + (a1 * b1 + a2 * b2 + a3 * b3)), 1e-30))
        bodies[o + TURN] = 0.5 * (a2 * b3 - a3 * b2) / half
        bodies[o + TURN + 1] = 0.5 * (a3 * b1 - a1 * b3) / half
        bodies[o + TURN + 2] = 0.5 * (a1 * b2 - a2 * b1) / half
        bodies[o + TURN_SCALAR] = half
        return
    # q qs*
    bodies[o + TURN] = s * x - w * p - (y * r - z * q)
    bodies[o + TURN + 1] = s * y - w * q - (z * p - x * r)
    bodies[o + TURN + 2] = s * z - w * r - (x * q - y * p)
    bodies[o + TURN_SCALAR] = w * s + x * p + y * q + z * r


@kernel
def scatter_momenta(
    i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array
) -> None:
    """Write the momenta back."""
    o = i * SIZE
    k = at(i, TRANSLATION)
    for axis in range(3):
        translation[k + PX + 64 * axis] = bodies[o + MOMENTUM + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            rotation[k + LX + 64 * axis] = bodies[o + ANGULAR_MOMENTUM + axis]


@kernel
def clear_warm_start(i: int, bodies: Array) -> None:
    """Forget the loads of a body, before they are added up anew."""
    for axis in range(6):
        bodies[i * SIZE + WARM_IMPULSE + axis] = 0.0
