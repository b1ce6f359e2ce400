# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One stage of an implicit step, body by body: its state, what is missing in its equations, and their
Jacobian.

Unknown are d = v - v0 [m/s], world axes, and the angular velocity w [rad/s], body axes. The stage
lies a = gamma h after its base (r0, p0, q0, m0):

    r = r0 + a (v0 + d),   q = q0 cayley(a w)
    0 = m d - a F(r, q, v, w)
    0 = I w + a w x I w - m0 - a T_B(r, q, v, w)        m0 = R0^T L0 or I w0

For the Runge–Kutta methods on (q, omega) cayley(x) = (x/2, 1) / |(x/2, 1)| and T_B = R^T T. For
the midpoint rule, which keeps L in world axes, the attitude is half-way to q0 (a w, 1) /
|(a w, 1)|, and T_B = R0^T T, so that L1 = L0 + h T. The argument `midpoint` tells which.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import (
    DAMPING_MATRIX,
    ROW,
    TORQUE_ROWS,
    TURN_COLUMNS,
    block_place,
    first_block,
    partner,
)
from rigid_body_sim.physics.integration.schemes.implicit.banded import (
    add_to_row,
    entry,
    subtract_from_column,
    weigh,
)
from rigid_body_sim.physics.integration.schemes.implicit.coupling import (
    BODY,
    POINT,
    SCRATCH,
    UNKNOWN,
)
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    multiply,
    nearly_normalised,
    read_vector,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    INVERSE_MASS,
    LANES,
    MOMENTS,
    MOMENTUM,
    ORIENTATION,
    POSITION,
    ROTATION,
    ROTATION_STATE,
    TORQUE,
    TRANSLATION,
    TRANSLATION_STATE,
    at,
    orientation,
    rotated,
    rotated_back,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    load_strided,
    scale,
    store,
    subtract,
)

TRANSLATION_NUMBERS = TRANSLATION_STATE // LANES  # of a body
ROTATION_NUMBERS = ROTATION_STATE // LANES

scratch = Record(
    begin=SCRATCH
)  # up to `coupling.BODY`: of a body, beyond what `coupling` keeps there
BASE_POSITION = scratch.vector('m', 'r0, base of the stage')
BASE_MOMENTUM = scratch.vector('kg m/s', 'p0')
BASE_ORIENTATION = scratch.quaternion('-', 'q0')
BASE_SPIN = scratch.vector('kg m^2/s', 'm0, body axes')
VELOCITY_CHANGE = scratch.vector('m/s', 'unknown d')
RATE = scratch.vector('rad/s', 'unknown w, body axes')
IMPULSE = scratch.vector('kg m^2/s', 'a T_B that belongs to the solution')
MOVED = scratch.vector('m', 'change of r, sum over the stages')
KICKED = scratch.vector('kg m/s', 'change of p, sum over the stages')
START_POSITION = scratch.vector('m', 'r at the start of the step')
START_MOMENTUM = scratch.vector('kg m/s', 'p at the start of the step')
START_ANGULAR_MOMENTUM = scratch.vector('kg m^2/s', 'L at the start of the step, world axes')
KEPT_TRANSLATION = scratch.numbers(TRANSLATION_NUMBERS, 'SI', 'state at the start of the tick')
KEPT_ROTATION = scratch.numbers(ROTATION_NUMBERS, 'SI', 'state at the start of the tick')
HALF_ANGLE = scratch.vector('-', 'c of the rotation (c, 1) of the stage')
ONLY_HELD_FORCE = scratch.number('-', '1 where only held forces act')
ONLY_HELD_TORQUE = scratch.number('-', '1 where only held torques act')
DELTA = scratch.number('SI', 'step of a difference; 0 for none')
HELD_THROUGH = scratch.number('-', '1 where only held forces acted in every stage')

SCALAR = 3  # where the scalar part of a quaternion stands


class Blocks(NamedTuple):
    """The state of a scene in blocks, see `state.blocks`: the first `n_rigid` bodies are rigid."""

    n_bodies: int
    n_rigid: int
    translation: Any
    rotation: Any


@inline
def load_quaternion(array, place):
    """Read four numbers that follow each other."""
    return array[place], array[place + 1], array[place + 2], array[place + SCALAR]


@inline
def store_quaternion(array, place, q):
    """Write four numbers that follow each other."""
    array[place], array[place + 1], array[place + 2], array[place + SCALAR] = q


@inline
def along(axis, value):
    """Vector along an axis."""
    return (
        value if axis == 0 else 0.0,
        value if axis == 1 else 0.0,
        value if axis == 2 else 0.0,
    )


@kernel
def set_stage(midpoint, i, a, b, blocks):
    """Write the state of a stage for the forces to read; b is the row of the body."""
    translation, place = blocks.translation, at(i, TRANSLATION)
    over_mass = translation[place + INVERSE_MASS]
    base, change = load(b, BASE_MOMENTUM), load(b, VELOCITY_CHANGE)
    velocity = add(scale(over_mass, base), change)
    position = add_scaled(load(b, BASE_POSITION), a, velocity)
    write_vector(translation, place + POSITION, position)
    write_vector(translation, place + MOMENTUM, add_scaled(base, 1.0 / over_mass, change))
    if i < blocks.n_rigid:
        rotation, place = blocks.rotation, at(i, ROTATION)
        rate = load(b, RATE)
        if midpoint:
            factor = a / (1.0 + math.sqrt(1.0 + a * a * dot(rate, rate)))
        else:
            factor = 0.5 * a
        half_angle = scale(factor, rate)
        store(b, HALF_ANGLE, half_angle)
        attitude = turned(load_quaternion(b, BASE_ORIENTATION), half_angle)
        write_quaternion(rotation, place + ORIENTATION, attitude)
        spin = multiply(read_vector(rotation, place + MOMENTS), rate)
        write_vector(rotation, place + ANGULAR_MOMENTUM, rotated(attitude, spin))


@kernel
def turned(q, half_angle):
    """Attitude q (c, 1), normalised."""
    x, y, z, w = q
    axis = (x, y, z)
    over = 1.0 / math.sqrt(1.0 + dot(half_angle, half_angle))
    product = add(axis, add(scale(w, half_angle), cross(axis, half_angle)))
    x, y, z = scale(over, product)
    return nearly_normalised((x, y, z, (w - dot(axis, half_angle)) * over))


@kernel
def torque_attitude(midpoint, i, b, blocks):
    """Attitude that brings torques into the body axes of the equations."""
    if midpoint:
        return load_quaternion(b, BASE_ORIENTATION)
    return orientation(blocks.rotation, i)


@kernel
def attitude_change(midpoint, b, a, axis):
    """Rotation of the stage, body axes, per unit of one component of w."""
    half_angle = load(b, HALF_ANGLE)
    square = dot(half_angle, half_angle)
    if midpoint:  # c = u / (1 + n), n^2 = 1 + u^2 and so c^2 = (n - 1) / (n + 1)
        n = (1.0 + square) / (1.0 - square)
        factor = a / (1.0 + n)
        change = scale(-a * b[HALF_ANGLE + axis] * (1.0 / n), half_angle)
    else:
        factor = 0.5 * a
        change = (0.0, 0.0, 0.0)
    change = add(change, along(axis, factor))
    return scale(2.0 / (1.0 + square), subtract(change, cross(half_angle, change)))


@kernel
def start_equations(midpoint, i, a, b, blocks, system):
    """
    Write what is missing in the equations of a body, and the inertial part of their Jacobian.
    """
    translation, place = blocks.translation, at(i, TRANSLATION)
    mass = 1.0 / translation[place + INVERSE_MASS]
    unknown = int(b[UNKNOWN]) - system.first
    held = True
    for axis in range(3):
        component = place + LANES * axis
        force = translation[component + FORCE]
        held = held and force == translation[component + HELD_FORCE]
        system.rhs[unknown + axis] = mass * b[VELOCITY_CHANGE + axis] - a * force
        system.matrix[entry(system.band, unknown + axis, unknown + axis)] += mass
        weigh(system.band, system.matrix, unknown + axis, mass)
    b[ONLY_HELD_FORCE] = 1.0 if held else 0.0
    if i < blocks.n_rigid:
        _start_equations_of_rotation(midpoint, i, a, b, blocks, system)


@inline
def _start_equations_of_rotation(midpoint, i, a, b, blocks, system):
    rotation, place = blocks.rotation, at(i, ROTATION)
    unknown = int(b[UNKNOWN]) - system.first + POINT
    attitude = torque_attitude(midpoint, i, b, blocks)
    torque = read_vector(rotation, place + TORQUE)
    impulse = scale(a, rotated_back(attitude, torque))
    w1, w2, w3 = load(b, RATE)
    i1, i2, i3 = read_vector(rotation, place + MOMENTS)
    g1, g2, g3 = a * (i3 - i2), a * (i1 - i3), a * (i2 - i1)
    spin, gyroscopic = (i1 * w1, i2 * w2, i3 * w3), (g1 * w2 * w3, g2 * w3 * w1, g3 * w1 * w2)
    missing = subtract(subtract(add(spin, gyroscopic), load(b, BASE_SPIN)), impulse)
    store(system.rhs, unknown, missing)
    # with what `correct_impulse` adds: a T_B after the Newton step
    store(b, IMPULSE, add(impulse, missing))
    band, matrix = system.band, system.matrix
    add_to_row(band, matrix, unknown, unknown, (i1, g1 * w3, g1 * w2))
    add_to_row(band, matrix, unknown + 1, unknown, (g2 * w3, i2, g2 * w1))
    add_to_row(band, matrix, unknown + 2, unknown, (g3 * w2, g3 * w1, i3))
    weigh(band, matrix, unknown, i1)
    weigh(band, matrix, unknown + 1, i2)
    weigh(band, matrix, unknown + 2, i3)
    if not midpoint:  # the rotation of R^T T: (R^T T) x theta
        for axis in range(3):
            change = cross(impulse, attitude_change(midpoint, b, a, axis))
            subtract_from_column(band, matrix, unknown, unknown + axis, change)
    hx, hy, hz = read_vector(rotation, place + HELD_TORQUE)
    held = torque[0] == hx and torque[1] == hy and torque[2] == hz
    b[ONLY_HELD_TORQUE] = 1.0 if held else 0.0


@kernel
def subtract_wrench(midpoint, i, a, column, b, blocks, system, force, torque):
    """
    Subtract a times the change of force and torque on body i, world axes, from one column of the
    Jacobian.
    """
    row = int(b[UNKNOWN]) - system.first
    subtract_from_column(system.band, system.matrix, row, column, scale(a, force))
    if i < blocks.n_rigid:
        torque = rotated_back(torque_attitude(midpoint, i, b, blocks), torque)
        subtract_from_column(system.band, system.matrix, row + POINT, column, scale(a, torque))


@inline
def _column(table, place, a):
    """Three entries of a column of a K + C."""
    return add_scaled(
        load_strided(table, place + DAMPING_MATRIX, ROW), a, load_strided(table, place, ROW)
    )


@inline
def _product(table, place, theta, change):
    """Row of K times theta plus row of C times the change of the angular velocity."""
    damping = load(table, place + DAMPING_MATRIX)
    return (
        dot(load(table, place), theta)
        + damping[0] * change[0]
        + damping[1] * change[1]
        + damping[2] * change[2]
    )


@inline
def _products(table, place, theta, change):
    """Three rows of K times theta plus those of C times the change of the angular velocity."""
    return (
        _product(table, place, theta, change),
        _product(table, place + ROW, theta, change),
        _product(table, place + 2 * ROW, theta, change),
    )


@kernel
def subtract_blocks(midpoint, i, a, bodies, table, blocks, system):
    """Subtract what the elements know of the derivatives of the wrench on body i."""
    b = bodies[BODY * i : BODY * (i + 1)]
    for pair in range(first_block(table, i), first_block(table, i + 1)):
        j, place = partner(table, pair), block_place(table, pair)
        other = bodies[BODY * j : BODY * (j + 1)]
        column = int(other[UNKNOWN]) - system.first
        for axis in range(3):
            force = _column(table, place + axis, a)
            torque = _column(table, place + TORQUE_ROWS + axis, a)
            subtract_wrench(midpoint, i, a, column + axis, b, blocks, system, force, torque)
        if j >= blocks.n_rigid:
            continue
        attitude = orientation(blocks.rotation, j)
        rate = rotated(attitude, load(other, RATE))
        turning = place + TURN_COLUMNS
        for axis in range(3):
            # theta: rotation of the stage; change: that of the angular velocity; world axes
            theta = rotated(attitude, attitude_change(midpoint, other, a, axis))
            change = add(rotated(attitude, along(axis, 1.0)), cross(theta, rate))
            force = _products(table, turning, theta, change)
            torque = _products(table, turning + TORQUE_ROWS, theta, change)
            subtract_wrench(
                midpoint, i, a, column + POINT + axis, b, blocks, system, force, torque
            )
