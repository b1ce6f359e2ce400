# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The motion of a group of bodies that its contacts cannot change: what a bound on its energy has to
leave as it is.

    floats      its motion as one rigid body: p = m (V + Omega x d), L = I Omega, with
                M V = sum p,   Omega = (sum I + m (d^2 - d d^T))^-1 sum (L + d x p)
                    d : [m] from the centre of mass of the group to that of the body
    on a plane  without friction: of that, V along the plane and the turn about its normal n,
                Omega = n (n . sum (L + d x p))/(n . (sum I + m (d^2 - d d^T)) n)
    in a trough of planes without friction: V along it
    gripped     nothing: by friction, by planes on all sides, or by a pivot

All that as seen from what holds the group: where that is one body that moves as told, or a belt,
its motion v_H + omega_H x d is taken off before, and belongs to what is kept.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Motion
from rigid_body_sim.physics.contact.energy import gain_record
from rigid_body_sim.physics.contact.energy.pressing_groups import group_of
from rigid_body_sim.physics.contact.solver import batch_record, constraint, wide_lanes
from rigid_body_sim.physics.contact.touching import bodies_of
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    XX,
    XY,
    XZ,
    YY,
    YZ,
    ZZ,
    add,
    add_scaled,
    apply_symmetric,
    cross,
    divide,
    dot,
    invert_symmetric,
    load,
    load_strided,
    load_symmetric,
    scale,
    store,
    subtract,
)

ONE_PLANE = 1e-9  # [-] sine squared of an angle: normals that are one, or lie in one plane


@inline
def _grip(gain: int, normal: Any, friction: float, gains: Array) -> None:
    """Let what cannot move hold a group along a normal."""
    held, axis = gains[gain + gain_record.HELD], load(gains, gain + gain_record.AXIS)
    if friction > 0.0:
        held = gain_record.GRIPPED
    elif held == gain_record.FLOATS:
        held, axis = gain_record.ON_PLANE, normal
    elif held == gain_record.ON_PLANE:
        along = cross(axis, normal)
        length = dot(along, along)
        if length > ONE_PLANE:
            held, axis = gain_record.IN_TROUGH, divide(along, math.sqrt(length))
    elif held == gain_record.IN_TROUGH and dot(axis, normal) * dot(axis, normal) > ONE_PLANE:
        held = gain_record.GRIPPED
    gains[gain + gain_record.HELD] = held
    store(gains, gain + gain_record.AXIS, axis)


@inline
def _note_holder(gain: int, holder: int, gains: Array, bodies: Array) -> None:
    """Note which solver body holds a group, if it is one that moves."""
    place = gain + gain_record.HOLDER
    moves = bodies[holder * solver_bodies.SIZE + solver_bodies.INVERSE_MASS] > 0.0
    before = gains[place]
    if not moves or not (before == gain_record.NOBODY or before == holder):
        gains[place] = gain_record.STANDS
    else:
        gains[place] = float(holder)


@inline
def _find_what_holds(
    batch_count: int, static: int, batches: Indices, rows: Array, roots: Indices, gains: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """Find what holds each group: see `gain_record.HELD` and `HOLDER`."""
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if rows[lane + constraint.TOUCHED] > 0.0 and (body_a == static or body_b == static):
                gain = group_of(body_a, body_b, static, roots) * gain_record.SIZE
                normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
                _grip(gain, normal, rows[lane + constraint.FRICTION], gains)
                place = lane + (constraint.BODY_A if body_a == static else constraint.BODY_B)
                _note_holder(gain, int(rows[place]) // solver_bodies.SIZE, gains, bodies)


@inline
def position_of(body: int, motion: Motion) -> Any:
    """Position of a body that touches, in the blocks of the scene."""
    return load_strided(
        motion.translation, blocks.at(body, blocks.TRANSLATION) + blocks.RX, blocks.LANES
    )


@inline
def force_on(body: int, motion: Motion, bodies: Array) -> Any:
    """
    Force on a body that touches, beside contact. The blocks have that on the mass of the start:
    m0/m of it, see `solver.variable_mass`.
    """
    place = blocks.at(body, blocks.TRANSLATION)
    of_start = motion.translation[place + blocks.IM]
    ratio = of_start / bodies[body * solver_bodies.SIZE + solver_bodies.INVERSE_MASS]
    return scale(ratio, load_strided(motion.translation, place + blocks.FX, blocks.LANES))


@inline
def held_force_on(body: int, motion: Motion) -> Any:
    """Weight of a body, and what is held on it over the tick."""
    return load_strided(
        motion.translation, blocks.at(body, blocks.TRANSLATION) + blocks.HX, blocks.LANES
    )


@inline
def is_carried(gain: int, gains: Array) -> bool:
    """Tell whether something that moves as told holds a group, alone."""
    return gains[gain + gain_record.HOLDER] > gain_record.NOBODY


@inline
def carrying_motion(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> Any:
    """Velocity and spin that a body has if it moves along with what carries its group."""
    holder = int(gains[gain + gain_record.HOLDER]) * solver_bodies.SIZE
    velocity = scale(solver_bodies.HELD, load(bodies, holder + solver_bodies.MOMENTUM))
    spin = scale(solver_bodies.HELD, load(bodies, holder + solver_bodies.ANGULAR_MOMENTUM))
    origin = add(
        load(bodies, holder + solver_bodies.SUBSTEP_POSITION),
        load(bodies, holder + solver_bodies.DISPLACEMENT),
    )
    return add(velocity, cross(spin, subtract(position_of(body, motion), origin))), spin


@inline
def _seen_momenta(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> Any:
    """Momenta of a body as seen from what carries its group: p, L."""
    row = body * solver_bodies.SIZE
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
    if is_carried(gain, gains):
        velocity, spin = carrying_motion(body, gain, motion, gains, bodies)
        along = divide(velocity, bodies[row + solver_bodies.INVERSE_MASS])
        momentum = subtract(momentum, along)
        angular_momentum = subtract(angular_momentum, _apply_inertia(row, spin, bodies))
    return momentum, angular_momentum


@inline
def _apply_inertia(row: int, v: Any, bodies: Array) -> Any:
    """Return I v of a body; zero of a point mass."""
    inverse = load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA)
    if not inverse[0] > 0.0:
        return 0.0, 0.0, 0.0
    return apply_symmetric(invert_symmetric(inverse), v)


@inline
def _add_mass(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> None:
    """Add mass, mass times position, momentum and force of a body to those of its group."""
    row = body * solver_bodies.SIZE
    mass = 1.0 / bodies[row + solver_bodies.INVERSE_MASS]
    momentum, _ = _seen_momenta(body, gain, motion, gains, bodies)
    center = add_scaled(load(gains, gain + gain_record.CENTER), mass, position_of(body, motion))
    gains[gain + gain_record.MASS] += mass
    store(gains, gain + gain_record.CENTER, center)
    store(
        gains, gain + gain_record.VELOCITY, add(load(gains, gain + gain_record.VELOCITY), momentum)
    )
    force = add(load(gains, gain + gain_record.FORCE), held_force_on(body, motion))
    store(gains, gain + gain_record.FORCE, force)


@inline
def _add_inertia(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> None:
    """Add inertia and angular momentum of a body about the centre of its group."""
    row, inertia = body * solver_bodies.SIZE, gain + gain_record.INERTIA
    mass = 1.0 / bodies[row + solver_bodies.INVERSE_MASS]
    arm = subtract(position_of(body, motion), load(gains, gain + gain_record.CENTER))
    momentum, angular_momentum = _seen_momenta(body, gain, motion, gains, bodies)
    own = add(angular_momentum, cross(arm, momentum))
    store(gains, gain + gain_record.SPIN, add(load(gains, gain + gain_record.SPIN), own))
    column_x = _apply_inertia(row, (1.0, 0.0, 0.0), bodies)
    column_y = _apply_inertia(row, (0.0, 1.0, 0.0), bodies)
    column_z = _apply_inertia(row, (0.0, 0.0, 1.0), bodies)
    square = dot(arm, arm)
    gains[inertia + XX] += column_x[0] + mass * (square - arm[0] * arm[0])
    gains[inertia + XY] += column_x[1] - mass * arm[0] * arm[1]
    gains[inertia + XZ] += column_x[2] - mass * arm[0] * arm[2]
    gains[inertia + YY] += column_y[1] + mass * (square - arm[1] * arm[1])
    gains[inertia + YZ] += column_y[2] - mass * arm[1] * arm[2]
    gains[inertia + ZZ] += column_z[2] + mass * (square - arm[2] * arm[2])


@inline
def _leave_what_is_free(gain: int, gains: Array) -> None:
    """Leave what nothing holds of the motion of a group; SPIN is its angular momentum before."""
    held, axis = gains[gain + gain_record.HELD], load(gains, gain + gain_record.AXIS)
    inertia = load_symmetric(gains, gain + gain_record.INERTIA)
    velocity = load(gains, gain + gain_record.VELOCITY)
    spin = load(gains, gain + gain_record.SPIN)
    along = scale(dot(axis, velocity), axis)
    if held == gain_record.FLOATS:
        if inertia[0] > 0.0:
            spin = apply_symmetric(invert_symmetric(inertia), spin)
    elif held == gain_record.ON_PLANE:
        velocity = subtract(velocity, along)
        about = dot(axis, apply_symmetric(inertia, axis))
        spin = scale(dot(axis, spin) / about if about > 0.0 else 0.0, axis)
    else:
        velocity, spin = along, (0.0, 0.0, 0.0)
    store(gains, gain + gain_record.VELOCITY, velocity)
    store(gains, gain + gain_record.SPIN, spin)


@kernel
def find_kept_motion(
    batch_count: int, static: int, touching: Indices, motion: Motion, batches: Indices,
    rows: Array, roots: Indices, gains: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Find mass, centre and force of each group, what holds it, and the motion as one rigid body that
    this leaves to it.

    static : index of what cannot move;   roots : the first body of the group of each
    gains  : see `gain_record`, all zero
    """
    _find_what_holds(batch_count, static, batches, rows, roots, gains, bodies)
    for index in range(len(touching)):
        body = touching[index]
        if bodies[body * solver_bodies.SIZE + solver_bodies.INVERSE_MASS] <= solver_bodies.HELD:
            gains[roots[body] * gain_record.SIZE + gain_record.HELD] = gain_record.GRIPPED
            gains[roots[body] * gain_record.SIZE + gain_record.HOLDER] = gain_record.STANDS
    for index in range(len(touching)):
        body = touching[index]
        if bodies[body * solver_bodies.SIZE + solver_bodies.INVERSE_MASS] > solver_bodies.HELD:
            _add_mass(body, roots[body] * gain_record.SIZE, motion, gains, bodies)
    for index in range(len(touching)):
        gain = touching[index] * gain_record.SIZE
        mass = gains[gain + gain_record.MASS]
        if mass > 0.0:
            for place in (gain + gain_record.CENTER, gain + gain_record.VELOCITY):
                store(gains, place, divide(load(gains, place), mass))
    for index in range(len(touching)):
        body = touching[index]
        gain = roots[body] * gain_record.SIZE
        if gains[gain + gain_record.HELD] != gain_record.GRIPPED:
            _add_inertia(body, gain, motion, gains, bodies)
    for index in range(len(touching)):
        gain = touching[index] * gain_record.SIZE
        held = gains[gain + gain_record.HELD]
        if gains[gain + gain_record.MASS] > 0.0 and held != gain_record.GRIPPED:
            _leave_what_is_free(gain, gains)


@inline
def changeable_momenta(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> Any:
    """Momenta of a body beyond the motion that its contacts cannot change: p - p_c, L - L_c."""
    row = body * solver_bodies.SIZE
    momentum, angular_momentum = _seen_momenta(body, gain, motion, gains, bodies)
    if gains[gain + gain_record.HELD] == gain_record.GRIPPED:
        return momentum, angular_momentum
    spin = load(gains, gain + gain_record.SPIN)
    arm = subtract(position_of(body, motion), load(gains, gain + gain_record.CENTER))
    velocity = add(load(gains, gain + gain_record.VELOCITY), cross(spin, arm))
    kept = divide(velocity, bodies[row + solver_bodies.INVERSE_MASS])
    return (
        subtract(momentum, kept),
        subtract(angular_momentum, _apply_inertia(row, spin, bodies)),
    )


@inline
def held_part(gain: int, v: Any, gains: Array) -> Any:
    """Return the part of a vector along which something that cannot move holds a group."""
    held, axis = gains[gain + gain_record.HELD], load(gains, gain + gain_record.AXIS)
    if held == gain_record.FLOATS:
        return 0.0, 0.0, 0.0
    if held == gain_record.GRIPPED:
        return v
    along = scale(dot(axis, v), axis)
    return along if held == gain_record.ON_PLANE else subtract(v, along)
