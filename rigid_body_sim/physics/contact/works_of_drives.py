# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The work that driven bodies do on others (`prescribed_bodies`): the impulse times the mean velocity
of its point, both in the middle of the substep,

    W = sum over substeps of J . (v + omega x r) + J_r . omega,   and that of restitution with the
        velocity then
        J_r : [N m s] of rolling and torsional friction
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.prescribed_bodies import (
    MEAN_SPIN,
    MEAN_VELOCITY,
    NO_TURN,
    NO_VECTOR,
    SIZE,
    PrescribedBodies,
    half_turn_of,
    is_face,
    number_of,
)
from rigid_body_sim.physics.contact.solver import constraint, contact_point, friction_patch
from rigid_body_sim.physics.contact.solver.wide_lanes import contact_frame, impulse_of, vector
from rigid_body_sim.physics.contact.solver_bodies import HELD
from rigid_body_sim.physics.model import prescribed_motion as told
from rigid_body_sim.physics.vectors import add, cross, dot, load, scale, subtract

SUBSTEP, BOUNCE = range(2)  # of what works are asked for


@inline
def _of_frame(lane: int, along: Any, rows: Array) -> Any:
    """Make a vector of its components along the normal and the two tangents of a constraint."""
    return impulse_of(along[0], along[1], along[2], *contact_frame(rows, lane))


@inline
def _acted(lane: int, impulse: Any, warm: Any, back: Any, rows: Array) -> Any:
    """
    Impulse of a substep, of which half the warm start acts before the motion, half in its middle
    and the rest after it, with the axes of then.

    impulse, warm : of the substep, and half its warm start: along normal and tangents
    back          : by which the axes turn back over half of the motion
    """
    after = _of_frame(lane, subtract(subtract(impulse, warm), warm), rows)
    half = _of_frame(lane, warm, rows)
    return add(after, told.turned(back, add(half, told.turned(back, half))))


@inline
def _impulse_of_point(
    when: int, is_alone: bool, lane: int, place: int, back: Any, rows: Array
) -> Any:  # fmt: skip
    """Impulse on B of a point; of several, friction is that of their face."""
    if when == BOUNCE:
        return _of_frame(lane, vector(rows, place + contact_point.RESTITUTION_NORMAL), rows)
    impulse = vector(rows, place + contact_point.NORMAL_IMPULSE)
    warm = vector(rows, place + contact_point.WARM_NORMAL)
    if not is_alone:
        impulse, warm = (impulse[0], 0.0, 0.0), (warm[0], 0.0, 0.0)
    return _acted(lane, impulse, warm, back, rows)


@inline
def _work_of_patch(
    when: int, lane: int, width: int, arm_field: int, velocity: Any, spin: Any, backs: Any,
    rows: Array,
) -> Any:  # fmt: skip
    """Work of the friction of a face on B; backs: see `find_works`."""
    face = lane + constraint.SIZE + MOST * width
    of_arm, of_axes = backs
    arm = told.turned(of_arm, vector(rows, face + arm_field))
    if when == BOUNCE:
        wrench, warm = vector(rows, face + friction_patch.RESTITUTION_1), NO_VECTOR
    else:
        wrench = vector(rows, face + friction_patch.IMPULSE_1)
        warm = vector(rows, face + friction_patch.WARM_1)
    impulse = _acted(lane, (0.0, wrench[0], wrench[1]), (0.0, warm[0], warm[1]), of_axes, rows)
    twist = _acted(lane, (wrench[2], 0.0, 0.0), (warm[2], 0.0, 0.0), of_axes, rows)
    return dot(impulse, add(velocity, cross(spin, arm))) + dot(twist, spin)


@inline
def _work_of_rolling(lane: int, place: int, spin: Any, back: Any, rows: Array) -> Any:
    """Work of rolling and torsional friction of a point on B over a substep."""
    about = vector(rows, place + contact_point.ROLLING_IMPULSE_1)
    warm = vector(rows, place + contact_point.WARM_ROLLING_1)
    about, warm = (about[2], about[0], about[1]), (warm[2], warm[0], warm[1])
    return dot(_acted(lane, about, warm, back, rows), spin)


@kernel
def find_works(
    when: int, manifold_count: int, static: int, width: int, angular: bool,
    colliders: ColliderArrays, driven: PrescribedBodies, constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """
    Find the work of driven bodies on each other body. In a substep it is that of each impulse at
    the place, and along the axes, of when it acts, at the mean velocity.

    when    : `SUBSTEP`: of that under way, before the next one starts; `BOUNCE`: that of
              restitution, at the velocities of now
    static  : index of what cannot move;   width : numbers of a point
    angular : whether anything rolls or twists with friction
    colliders : where they are at the start of the tick
    """
    drives, manifolds, rows = driven.drives, constraints.manifolds, constraints.rows
    for body in range(len(driven.of_bodies)):
        driven.of_bodies[body] = 0.0
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        number, sign = number_of(lane, static, rows)
        if number < 0:
            continue
        other = constraint.BODY_B if sign > 0.0 else constraint.BODY_A
        row = (static + 1 + number) * solver_bodies.SIZE
        entry = number * SIZE
        velocity, spin = load(drives, entry + MEAN_VELOCITY), load(drives, entry + MEAN_SPIN)
        of_arm, of_axes = NO_TURN, NO_TURN  # back over half of the motion
        if when == BOUNCE:
            velocity = scale(HELD, load(bodies, row + solver_bodies.MOMENTUM))
            spin = scale(HELD, load(bodies, row + solver_bodies.ANGULAR_MOMENTUM))
        else:
            x, y, z, w = half_turn_of(number, static, bodies)
            of_arm = (-x, -y, -z, w)
            if is_face(record, lane, (number, sign), drives, colliders, constraints):
                of_axes = of_arm
        points = int(manifolds[record + manifold_record.POINT_COUNT])
        work = 0.0
        if points > 1:
            arm_field = friction_patch.ARM_A if sign > 0.0 else friction_patch.ARM_B
            work = _work_of_patch(
                when, lane, width, arm_field, velocity, spin, (of_arm, of_axes), rows
            )
        arm_field = contact_point.ARM_A if sign > 0.0 else contact_point.ARM_B
        for point in range(points):
            place = lane + constraint.SIZE + point * width
            arm = told.turned(of_arm, vector(rows, place + arm_field))
            impulse = _impulse_of_point(when, points == 1, lane, place, of_axes, rows)
            work += dot(impulse, add(velocity, cross(spin, arm)))
            if angular and when != BOUNCE:
                work += _work_of_rolling(lane, place, spin, of_axes, rows)
        driven.of_bodies[int(rows[lane + other]) // solver_bodies.SIZE] += sign * work


@kernel
def add_works(touching: Indices, driven: PrescribedBodies, bodies: Array) -> None:
    """Add what `find_works` found to the energy that bodies may have, and to the sum."""
    for index in range(len(touching)):
        work = driven.of_bodies[touching[index]]
        bodies[touching[index] * solver_bodies.SIZE + solver_bodies.ENERGY] += work
        driven.works[touching[index]] += work
