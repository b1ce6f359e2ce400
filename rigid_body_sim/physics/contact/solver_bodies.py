# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Solver bodies: what the solver keeps of a body during a tick, one row of numbers next to each other
in memory, gathered from the blocks and scattered back.

Row i belongs to the body with core index i. In the blocks it is body i, or body k while its group
passes its substeps: see `packed_bodies`. One more row for each group of islands stands for all
that cannot move: of what is read there all is zero.
World axes; p and L are the truth, velocities follow from them:

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

from rigid_body_sim.physics.arrays import Array, Indices, Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Group, Motion
from rigid_body_sim.physics.contact.packed_bodies import member
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import LANES, add_compensated, at, rotated
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    divide,
    dot,
    load,
    load_quaternion,
    load_strided,
    load_symmetric,
    scale,
    store,
    store_strided,
    store_symmetric,
    subtract,
)

HALF_TURN = 1e-30  # [-] cosine squared of half a turn: below, it is half a turn all the same

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

# while manifolds are asked what they are (`collision.ghosts`), before anything has moved: where
# the first of the body begins
FIRST_MANIFOLD = DISPLACEMENT
# and where the first begins in the impulse cache that it has lost (`solver.impulse_cache`)
FIRST_LOST = DISPLACEMENT + 1
# and then, until anything has moved, the line along which it meets a ball, how many it may meet,
# how fast that one and at most anybody is, what accelerates it until they meet, of how many it may
# meet some, and 1 if it does (`solver.ball_impacts`)
MEETS_ALONG, MEETINGS, PULL = DISPLACEMENT, TURN, SUBSTEP_ORIENTATION
PAIR_SPEED, FASTEST = TURN + 1, TURN + 2
NEAR, MEETS = SUBSTEP_ORIENTATION + 3, SUBSTEP_POSITION
# when the last substep is over, where something bounces (`islands.waiting`): what friction has
# given in it, and in the tick, what presses in it, and 1 if it lay on something at the beginning
RUBBED, RUBBED_IN_TICK = WARM_IMPULSE, MOMENTUM_BEFORE_RESTITUTION
PRESSED, LAY = WARM_ANGULAR_IMPULSE, WARM_ANGULAR_IMPULSE + 1

# [1/kg] in place of zero for what no impulse moves, but which has a velocity: see `solver.pivots`;
# a power of two, so that p = v / HELD gives v back to the bit
HELD = 2.0**-100

# how a body turns, the rounder the larger
FIXED, AS_IT_IS, ABOUT_AXIS, BALL, CENTRED_BALL = -1.0, 0.0, 1.0, 2.0, 3.0


@inline
def clear(body: int, bodies: Array) -> None:
    """Write zeros for what cannot move."""
    for entry in range(SIZE):
        bodies[body * SIZE + entry] = 0.0


@inline
def _vector(state: Array, place: int) -> Any:
    """Three numbers of a body in its block."""
    return load_strided(state, place, LANES)


@inline
def _put_vector(state: Array, place: int, v: Any) -> None:
    """Write three numbers of a body in its block."""
    store_strided(state, place, LANES, v)


@inline
def _orientation(rotation: Array, place: int) -> Any:
    """Quaternion (x, y, z, w) of a body in its block."""
    return (
        rotation[place + blocks.QX], rotation[place + blocks.QY], rotation[place + blocks.QZ],
        rotation[place + blocks.QW],
    )  # fmt: skip


@inline
def world_inverse_inertia(orientation: Any, principal: Any) -> Any:
    """
    World inverse inertia R diag(J) R^T of a rigid body: xx, xy, xz, yy, yz, zz.

    principal : inverses J of its principal moments
    """
    q_x, q_y, q_z, q_w = orientation
    row_x = (
        1.0 - 2.0 * (q_y * q_y + q_z * q_z), 2.0 * (q_x * q_y - q_w * q_z),
        2.0 * (q_x * q_z + q_w * q_y),
    )  # fmt: skip
    row_y = (
        2.0 * (q_x * q_y + q_w * q_z), 1.0 - 2.0 * (q_x * q_x + q_z * q_z),
        2.0 * (q_y * q_z - q_w * q_x),
    )  # fmt: skip
    row_z = (
        2.0 * (q_x * q_z - q_w * q_y), 2.0 * (q_y * q_z + q_w * q_x),
        1.0 - 2.0 * (q_x * q_x + q_y * q_y),
    )  # fmt: skip
    scaled_x = (principal[0] * row_x[0], principal[1] * row_x[1], principal[2] * row_x[2])
    scaled_y = (principal[0] * row_y[0], principal[1] * row_y[1], principal[2] * row_y[2])
    scaled_z = (principal[0] * row_z[0], principal[1] * row_z[1], principal[2] * row_z[2])
    return (
        dot(scaled_x, row_x), dot(scaled_x, row_y), dot(scaled_x, row_z),
        dot(scaled_y, row_y), dot(scaled_y, row_z), dot(scaled_z, row_z),
    )  # fmt: skip


@inline
def _put_inverse_inertia(bodies: Array, row: int, rotation: Array, place: int) -> None:
    """Write the world inverse inertia of a body as it stands."""
    principal = _vector(rotation, place + blocks.J1)
    first, second, third = principal
    if (first == second) & (second == third):  # a ball, a cube: the same in all axes
        inverse = (first, 0.0, 0.0, first, 0.0, first)
    else:
        inverse = world_inverse_inertia(_orientation(rotation, place), principal)
    store_symmetric(bodies, row + INVERSE_INERTIA, inverse)


@kernel
def begin_tick(i: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array) -> None:
    """Gather a body as it is at the start of a tick."""
    row = i * SIZE
    place = at(i, blocks.TRANSLATION)
    inverse_mass = translation[place + blocks.IM]
    zero = (0.0, 0.0, 0.0)
    bodies[row + INVERSE_MASS] = inverse_mass
    store(bodies, row + START_POSITION, _vector(translation, place + blocks.RX))
    store(bodies, row + START_RESIDUAL, _vector(translation, place + blocks.EX))
    store(bodies, row + MOMENTUM, _vector(translation, place + blocks.PX))
    force = _vector(translation, place + blocks.FX)
    store(bodies, row + FREE_ACCELERATION, scale(inverse_mass, force))
    store(bodies, row + ANGULAR_MOMENTUM, zero)
    store(bodies, row + DISPLACEMENT, zero)
    store(bodies, row + TURN, zero)
    store(bodies, row + WARM_IMPULSE, zero)
    store(bodies, row + WARM_ANGULAR_IMPULSE, zero)
    bodies[row + TURN_SCALAR] = 1.0
    bodies[row + CARRIED] = 0.0
    for entry in range(6):
        bodies[row + INVERSE_INERTIA + entry] = 0.0
    if i < n_rigid:
        place = at(i, blocks.ROTATION)
        store(bodies, row + ANGULAR_MOMENTUM, _vector(rotation, place + blocks.LX))
        for entry in range(4):
            bodies[row + START_ORIENTATION + entry] = rotation[place + blocks.QX + LANES * entry]
        _put_inverse_inertia(bodies, row, rotation, place)


@inline
def spin(row: int, bodies: Array) -> Any:
    """Angular velocity omega = I^-1 L of the body whose row begins there [rad/s]."""
    inverse = load_symmetric(bodies, row + INVERSE_INERTIA)
    return apply_symmetric(inverse, load(bodies, row + ANGULAR_MOMENTUM))


@inline
def start_axis(row: int, bodies: Array) -> Any:
    """Axis of symmetry of a body at the start of the tick, world axes."""
    orientation = load_quaternion(bodies, row + START_ORIENTATION)
    return rotated(orientation, load(bodies, row + SYMMETRY_AXIS))


@inline
def surface_spin(row: int, bodies: Array) -> Any:
    """
    Angular velocity with which the surface of a body turns at the start of the tick [rad/s]: of a
    body of revolution that of its axis, of a ball about its centre of mass none.
    """
    kind = bodies[row + SYMMETRY]
    omega = (0.0, 0.0, 0.0)
    if kind != CENTRED_BALL:
        omega = spin(row, bodies)
    if kind == ABOUT_AXIS:
        axis = start_axis(row, bodies)
        omega = cross(axis, cross(omega, axis))
    return omega


@kernel
def find_free_acceleration(i: int, n_rigid: int, rotation: Array, bodies: Array) -> None:
    """Find the angular acceleration of free motion: alpha = I^-1 (torque - omega x L)."""
    row = i * SIZE
    store(bodies, row + FREE_ANGULAR_ACCELERATION, (0.0, 0.0, 0.0))
    if i < n_rigid:
        torque = _vector(rotation, at(i, blocks.ROTATION) + blocks.TX)
        angular_momentum = load(bodies, row + ANGULAR_MOMENTUM)
        inverse = load_symmetric(bodies, row + INVERSE_INERTIA)
        omega = apply_symmetric(inverse, angular_momentum)
        change = subtract(torque, cross(omega, angular_momentum))
        store(bodies, row + FREE_ANGULAR_ACCELERATION, apply_symmetric(inverse, change))


@kernel
def kick_and_warm_start(h: float, group: Group, bodies: Array) -> None:
    """
    Let half of the forces of the instant act over a substep [s], and half of the warm start.
    """
    motion = group.motion
    for index in range(len(group.members)):
        i, k = member(index, group)
        row = i * SIZE
        place = at(k, blocks.TRANSLATION)
        bodies[row + CARRIED] = 0.0
        store(bodies, row + SUBSTEP_POSITION, _vector(motion.translation, place + blocks.RX))
        store(bodies, row + SUBSTEP_RESIDUAL, _vector(motion.translation, place + blocks.EX))
        momentum = _vector(motion.translation, place + blocks.PX)
        free = add_scaled(momentum, 0.5 * h, _vector(motion.translation, place + blocks.FX))
        store(bodies, row + MOMENTUM, add(free, load(bodies, row + WARM_IMPULSE)))
        if k < motion.rigid_count:
            place = at(k, blocks.ROTATION)
            momentum = _vector(motion.rotation, place + blocks.LX)
            free = add_scaled(momentum, 0.5 * h, _vector(motion.rotation, place + blocks.TX))
            store(
                bodies, row + ANGULAR_MOMENTUM, add(free, load(bodies, row + WARM_ANGULAR_IMPULSE))
            )
            for entry in range(4):
                bodies[row + SUBSTEP_ORIENTATION + entry] = motion.rotation[
                    place + blocks.QX + LANES * entry
                ]


@kernel
def scatter_angular_momentum(
    first: int, count: int, half: float, group: Group, bodies: Array
) -> None:
    """
    Give carried bodies the momentum with which they turn, less the half kick of the drift.

    first, count : which of the members
    """
    motion = group.motion
    for index in range(first, first + count):
        i, k = member(index, group)
        row = i * SIZE
        if bodies[row + CARRIED] > 0.0 and k < motion.rigid_count:
            place = at(k, blocks.ROTATION)
            kick = scale(half, _vector(motion.rotation, place + blocks.TX))
            turning = subtract(load(bodies, row + ANGULAR_MOMENTUM), kick)
            _put_vector(motion.rotation, place + blocks.LX, turning)


@kernel
def integrate_position(first: int, count: int, h: float, group: Group, bodies: Array) -> None:
    """
    Move carried bodies by their own velocity, x += h v, and let the second half of the forces act.

    first, count : which of the members
    """
    motion = group.motion
    for index in range(first, first + count):
        i, k = member(index, group)
        row = i * SIZE
        if not bodies[row + CARRIED] > 0.0:
            continue
        place = at(k, blocks.TRANSLATION)
        momentum = load(bodies, row + MOMENTUM)
        force = _vector(motion.translation, place + blocks.FX)
        _put_vector(motion.translation, place + blocks.PX, add_scaled(momentum, 0.5 * h, force))
        for axis in range(3):
            position, lost = add_compensated(
                bodies[row + SUBSTEP_POSITION + axis],
                bodies[row + SUBSTEP_RESIDUAL + axis],
                h * bodies[row + INVERSE_MASS] * bodies[row + MOMENTUM + axis],
            )
            motion.translation[place + blocks.RX + LANES * axis] = position
            motion.translation[place + blocks.EX + LANES * axis] = lost
        if k < motion.rigid_count:
            place = at(k, blocks.ROTATION)
            momentum = load(bodies, row + ANGULAR_MOMENTUM)
            torque = _vector(motion.rotation, place + blocks.TX)
            _put_vector(motion.rotation, place + blocks.LX, add_scaled(momentum, 0.5 * h, torque))


@inline
def shift(body: int, way: Any, motion: Motion, bodies: Array) -> None:
    """Move a body that touches by a way, in the blocks of the scene."""
    moved = body * SIZE + DISPLACEMENT
    store(bodies, moved, add(load(bodies, moved), way))
    place = at(body, blocks.TRANSLATION)
    for axis in range(3):
        lane = place + LANES * axis
        motion.translation[lane + blocks.RX], motion.translation[lane + blocks.EX] = (
            add_compensated(
                motion.translation[lane + blocks.RX], motion.translation[lane + blocks.EX],
                way[axis],
            )
        )  # fmt: skip


@kernel
def gather_moved(group: Group, bodies: Array) -> None:
    """Read momenta, inverse inertia and the motion over the substep."""
    motion = group.motion
    for index in range(len(group.members)):
        i, k = member(index, group)
        row = i * SIZE
        place = at(k, blocks.TRANSLATION)
        store(bodies, row + MOMENTUM, _vector(motion.translation, place + blocks.PX))
        moved = subtract(
            _vector(motion.translation, place + blocks.RX), load(bodies, row + SUBSTEP_POSITION)
        )
        residual = subtract(
            _vector(motion.translation, place + blocks.EX), load(bodies, row + SUBSTEP_RESIDUAL)
        )
        store(bodies, row + DISPLACEMENT, add(moved, residual))
        if k < motion.rigid_count:
            place = at(k, blocks.ROTATION)
            store(bodies, row + ANGULAR_MOMENTUM, _vector(motion.rotation, place + blocks.LX))
            _put_inverse_inertia(bodies, row, motion.rotation, place)
            put_turn(bodies, row, _orientation(motion.rotation, place))


@inline
def put_turn(bodies: Array, row: int, orientation: Any) -> None:
    """Write the turn of a body over the substep; of its axis alone where it is round about it."""
    kind = bodies[row + SYMMETRY]
    if kind == CENTRED_BALL:
        return
    start = load_quaternion(bodies, row + SUBSTEP_ORIENTATION)
    if kind == ABOUT_AXIS:
        axis = load(bodies, row + SYMMETRY_AXIS)
        before, after = rotated(start, axis), rotated(orientation, axis)
        half = math.sqrt(max(0.5 * (1.0 + dot(before, after)), HALF_TURN))
        store(bodies, row + TURN, divide(scale(0.5, cross(before, after)), half))
        bodies[row + TURN_SCALAR] = half
        return
    # q qs*
    q_x, q_y, q_z, q_w = orientation
    s_x, s_y, s_z, s_w = start
    now, before = (q_x, q_y, q_z), (s_x, s_y, s_z)
    turn = subtract(subtract(scale(s_w, now), scale(q_w, before)), cross(now, before))
    store(bodies, row + TURN, turn)
    bodies[row + TURN_SCALAR] = q_w * s_w + q_x * s_x + q_y * s_y + q_z * s_z


@kernel
def scatter_momenta(group: Group, bodies: Array) -> None:
    """Write the momenta back."""
    motion = group.motion
    for index in range(len(group.members)):
        i, k = member(index, group)
        row = i * SIZE
        place = at(k, blocks.TRANSLATION) + blocks.PX
        _put_vector(motion.translation, place, load(bodies, row + MOMENTUM))
        if k < motion.rigid_count:
            place = at(k, blocks.ROTATION) + blocks.LX
            _put_vector(motion.rotation, place, load(bodies, row + ANGULAR_MOMENTUM))


@kernel
def clear_warm_start(members: Indices, bodies: Array) -> None:
    """Forget the warm start of bodies, before that of the next substep is added up."""
    for index in range(len(members)):
        row = members[index] * SIZE
        store(bodies, row + WARM_IMPULSE, (0.0, 0.0, 0.0))
        store(bodies, row + WARM_ANGULAR_IMPULSE, (0.0, 0.0, 0.0))
