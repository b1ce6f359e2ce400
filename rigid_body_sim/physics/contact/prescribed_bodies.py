# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of what is moved as told (`model.prescribed_motion`), and of belts.

Detection, groups and islands take such a collider for what cannot move: no force moves it. In the
solver it has a row of its own behind that of what cannot move, with the origin of its shape as
the point of reference, and 1/m = HELD: a velocity that no impulse changes. What contact sees of it
in a substep from t to t + h:

    solve        v = (x(t + h) - x(t))/h, omega likewise: what rests on it moves along exactly
    separations  d = x(t + h) - x(t), the turn from q(t) to q(t + h)
    relax        v = x'(t + h), omega(t + h)
    bounce       approach and restitution with x'(t), x''(t) and x'(t + h)

so a body at rest on it keeps its gap, and the contact force is m (g + x''). What work it does on
others: see `works_of_drives`.

What is round about an axis turns with that alone in all but friction: its surface does not move
along its normal however fast it spins, and points of contact follow it, as on a body that is free;
but points of what lies on its end, within the rim, go round with that.

A belt stands still, but its surface has a velocity along the faces that it runs in: where the
normal is not square to it, it counts as standing.

What moves as one rigid body is one, also where it is several: the parts of a union, tiles of a
deck that all have one motion, boxes with one surface velocity. They have one row, about the origin
of the first of them; so flush ones are one surface, as those that stand. What is round about an
axis has a row of its own, for its spin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from rigid_body_sim.physics.arrays import Array, Indices, Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import (
    CAPSULE,
    CYLINDER,
    SPHERE,
    ColliderArrays,
    type_of,
    world_aabb,
)
from rigid_body_sim.physics.contact.collision.face_normal import along_face
from rigid_body_sim.physics.contact.islands import sleep_record
from rigid_body_sim.physics.contact.solver import (
    constraint,
)
from rigid_body_sim.physics.contact.solver.wide_lanes import (
    put_vector,
    vector,
)
from rigid_body_sim.physics.contact.solver_bodies import HELD
from rigid_body_sim.physics.model import prescribed_motion as told
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    load_quaternion,
    scale,
    store,
    store_quaternion,
    subtract,
)


class PrescribedBodies(NamedTuple):
    """
    What is driven: one-dimensional arrays.

    drives : see `drive`: in the order of their rows the first, or only one, of each; behind them
             the others
    paths  : see `model.prescribed_motion`
    moment : scratch of that
    works  : (n,) [J] sum of the work that was done on each other body
    of_bodies : [J] of it what was last found of each body
    """

    drives: Array
    paths: Array
    moment: Array
    works: Array
    of_bodies: Array


drive = Record()
COLLIDER = drive.number('-', 'which collider is driven')
ROW = drive.number('-', 'its row among the solver bodies')
FOLLOWS = drive.number('-', '1: the row is that of another one, with which it moves as one')
PATH = drive.number('-', 'where its path begins; NO_PATH: a belt')
SURFACE = drive.vector('m/s', 'velocity of the surface of a belt, world axes')
MEAN_VELOCITY = drive.vector('m/s', 'over the substep under way')
MEAN_SPIN = drive.vector('rad/s', 'over the substep under way')
MOVES = drive.number('-', '1: it moves in this tick')
SIZE = drive.size

NO_PATH = -1.0
# [-] cosine: a normal nearer to that of a face is its own; it may turn by 0.04 rad in a tick
FACE = 0.999
ALONG = 1e-6  # [-] of the speed of a belt: how square to it the normal of a face is
NO_VECTOR = (0.0, 0.0, 0.0)
NO_TURN = (0.0, 0.0, 0.0, 1.0)
ROUND = (SPHERE, CYLINDER, CAPSULE)  # about an axis


def _is_same_vector(a: Array, b: Array) -> bool:
    """Tell whether two vectors are the same to round-off."""
    return bool(np.all(np.abs(a - b) <= told.ROUND_OFF * np.max(np.abs(a))))


def driven_bodies(parts: Sequence[Body], static: int) -> tuple[PrescribedBodies, Indices]:
    """
    Make the arrays of the driven colliders, and tell which solver body each collider is while it
    does not move freely.

    parts  : of each collider its body with its shape alone
    static : index of what cannot move
    """
    rows = np.full(len(parts), static, dtype=np.int64)
    firsts: list[Array] = []
    followers: list[Array] = []
    paths: list[Array] = []
    known: dict[bytes, list[tuple[int, Array]]] = {}  # rows, by what those that share one have
    for number, part in enumerate(parts):
        if part.motion is None and not any(part.surface_velocity):
            continue
        entry = np.zeros(SIZE)
        entry[COLLIDER] = number
        if part.motion is None:
            motion = so3.rotate(part.initial.orientation, np.array(part.surface_velocity))
            entry[PATH], entry[drive.span(SURFACE)] = NO_PATH, motion
            same, is_one = b'', _is_same_vector
        else:
            motion = told.path_of(part, part.shape_position, part.shape_orientation)
            entry[PATH] = sum(map(len, paths))
            paths.append(motion)
            same, is_one = told.what_is_common(motion), told.are_of_one_body
        alike = [] if type_of(part) in ROUND else known.setdefault(same, [])
        row = next((row for row, first in alike if is_one(first, motion)), None)
        if row is None:
            row = static + 1 + len(firsts)
            firsts.append(entry)
            alike.append((row, motion))
        else:
            entry[FOLLOWS] = 1.0
            followers.append(entry)
        entry[ROW] = rows[number] = row
    driven = PrescribedBodies(
        drives=np.concatenate([np.zeros(0), *firsts, *followers]),
        paths=np.concatenate([np.zeros(0), *paths]),
        moment=np.zeros(told.INSTANT),
        works=np.zeros(static),
        of_bodies=np.zeros(static if firsts else 0),
    )
    return driven, rows


@inline
def _put_velocity(row: int, velocity: Any, spin: Any, bodies: Array) -> None:
    """Let a solver body have a velocity."""
    store(bodies, row + solver_bodies.MOMENTUM, scale(1.0 / HELD, velocity))
    store(bodies, row + solver_bodies.ANGULAR_MOMENTUM, scale(1.0 / HELD, spin))


@inline
def _put_pose(place: int, out: Array, poses: Array) -> None:
    """Write the pose of a collider."""
    x, y, z, w = load_quaternion(out, told.AT_ORIENTATION)
    store(poses, place + pose.POSITION, load(out, told.AT_POSITION))
    row_x = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
    row_y = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
    row_z = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    store(poses, place + pose.ROW_X, row_x)
    store(poses, place + pose.ROW_Y, row_y)
    store(poses, place + pose.ROW_Z, row_z)


@inline
def _begin(row: int, kind: int, bodies: Array) -> None:
    """
    Let a solver body be one that no impulse moves; kind: of its collider, which may be round about
    the axis z of its shape: its surface does not turn with it.
    """
    for entry in range(solver_bodies.SIZE):
        bodies[row + entry] = 0.0
    bodies[row + solver_bodies.INVERSE_MASS] = HELD
    for diagonal in (0, 3, 5):
        bodies[row + solver_bodies.INVERSE_INERTIA + diagonal] = HELD
    bodies[row + solver_bodies.TURN_SCALAR] = 1.0
    symmetry = solver_bodies.AS_IT_IS
    if kind == SPHERE:
        symmetry = solver_bodies.CENTRED_BALL
    elif kind == CYLINDER or kind == CAPSULE:
        symmetry = solver_bodies.ABOUT_AXIS
    bodies[row + solver_bodies.SYMMETRY] = symmetry
    store(bodies, row + solver_bodies.SYMMETRY_AXIS, (0.0, 0.0, 1.0))


@inline
def _put_start(row: int, out: Array, bodies: Array) -> None:
    """Let a solver body be where a path has it at the start of the tick, and move so."""
    _put_velocity(row, load(out, told.AT_VELOCITY), load(out, told.AT_SPIN), bodies)
    change = load(out, told.AT_ANGULAR_ACCELERATION)
    store(bodies, row + solver_bodies.FREE_ACCELERATION, load(out, told.AT_ACCELERATION))
    store(bodies, row + solver_bodies.FREE_ANGULAR_ACCELERATION, change)
    store(bodies, row + solver_bodies.START_POSITION, load(out, told.AT_POSITION))
    orientation = load_quaternion(out, told.AT_ORIENTATION)
    store_quaternion(bodies, row + solver_bodies.START_ORIENTATION, orientation)


@inline
def _put_reach(
    collider: int, row: int, h: float, colliders: ColliderArrays, bodies: Array
) -> float:  # fmt: skip
    """Tell detection how a collider moves in a tick [s], by its row; 1: it does."""
    velocity = scale(HELD, load(bodies, row + solver_bodies.MOMENTUM))
    spin = scale(HELD, load(bodies, row + solver_bodies.ANGULAR_MOMENTUM))
    acceleration = load(bodies, row + solver_bodies.FREE_ACCELERATION)
    change = load(bodies, row + solver_bodies.FREE_ANGULAR_ACCELERATION)
    center, _ = world_aabb(colliders.local_bounds, collider, colliders.poses)
    arm = subtract(center, load(bodies, row + solver_bodies.START_POSITION))
    radius = colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.RADIUS]
    lever = math.sqrt(dot(arm, arm)) + radius
    turn = math.sqrt(dot(spin, spin)) + h * math.sqrt(dot(change, change))
    swept = collider * swept_aabbs.SIZE
    store(colliders.swept_aabbs, swept + swept_aabbs.VELOCITY, velocity)
    colliders.swept_aabbs[swept + swept_aabbs.TURNING] = (
        min(turn * h, 2.0) * lever + math.sqrt(dot(acceleration, acceleration)) * h * h
    )
    still = dot(velocity, velocity) + dot(spin, spin) + dot(acceleration, acceleration)
    return 1.0 if still + dot(change, change) > 0.0 else 0.0


@kernel
def begin_tick(
    time: float, h: float, driven: PrescribedBodies, colliders: ColliderArrays, bodies: Array
) -> None:
    """
    Put all driven colliders where they are at the start of a tick [s] of a length [s], and tell
    detection how they move.
    """
    drives, paths, out = driven.drives, driven.paths, driven.moment
    for number in range(len(drives) // SIZE):
        entry = number * SIZE
        collider, row = int(drives[entry + COLLIDER]), int(drives[entry + ROW])
        row *= solver_bodies.SIZE
        follows = drives[entry + FOLLOWS] == 1.0
        if not follows:
            kind = colliders.table[collider * collider_record.SIZE + collider_record.TYPE]
            _begin(row, kind, bodies)
        if drives[entry + PATH] == NO_PATH:
            velocity = load(drives, entry + SURFACE)
            store(drives, entry + MEAN_VELOCITY, velocity)
            drives[entry + MOVES] = 1.0
            if not follows:
                _put_velocity(row, velocity, NO_VECTOR, bodies)
                position = load(colliders.poses, collider * pose.SIZE + pose.POSITION)
                store(bodies, row + solver_bodies.START_POSITION, position)
                store(bodies, row + solver_bodies.SUBSTEP_POSITION, position)
            continue
        told.motion_at(paths, int(drives[entry + PATH]), time, out)
        _put_pose(collider * pose.SIZE, out, colliders.poses)
        if not follows:
            _put_start(row, out, bodies)
        drives[entry + MOVES] = _put_reach(collider, row, h, colliders, bodies)


@kernel
def begin_substep(time: float, h: float, driven: PrescribedBodies, bodies: Array) -> None:
    """Let driven bodies have the mean velocity and the motion of a substep from a time on [s]."""
    drives, paths, out = driven.drives, driven.paths, driven.moment
    for number in range(len(drives) // SIZE):
        entry = number * SIZE
        if drives[entry + PATH] == NO_PATH or drives[entry + FOLLOWS] == 1.0:
            continue
        row = int(drives[entry + ROW]) * solver_bodies.SIZE
        path = int(drives[entry + PATH])
        told.motion_at(paths, path, time, out)
        start = load(out, told.AT_POSITION)
        u_x, u_y, u_z, w = load_quaternion(out, told.AT_ORIENTATION)
        told.motion_at(paths, path, time + h, out)
        moved = subtract(load(out, told.AT_POSITION), start)
        v_x, v_y, v_z, s = load_quaternion(out, told.AT_ORIENTATION)
        # q(t + h) q(t)*
        u, v = (u_x, u_y, u_z), (v_x, v_y, v_z)
        turn = subtract(subtract(scale(w, v), scale(s, u)), cross(v, u))
        scalar = s * w + dot(v, u)
        if scalar < 0.0:
            turn, scalar = scale(-1.0, turn), -scalar
        length = math.sqrt(dot(turn, turn))
        rate = 2.0 * math.atan2(length, scalar) / (length * h) if length > 0.0 else 0.0
        mean, spin = scale(1.0 / h, moved), scale(rate, turn)
        store(drives, entry + MEAN_VELOCITY, mean)
        store(drives, entry + MEAN_SPIN, spin)
        _put_velocity(row, mean, spin, bodies)
        store(bodies, row + solver_bodies.SUBSTEP_POSITION, start)
        store(bodies, row + solver_bodies.DISPLACEMENT, moved)
        store_quaternion(bodies, row + solver_bodies.SUBSTEP_ORIENTATION, (u_x, u_y, u_z, w))
        if bodies[row + solver_bodies.SYMMETRY] == solver_bodies.AS_IT_IS:
            store(bodies, row + solver_bodies.TURN, turn)
            bodies[row + solver_bodies.TURN_SCALAR] = scalar
        else:
            solver_bodies.put_turn(bodies, row, (v_x, v_y, v_z, s))


@kernel
def end_substep(time: float, driven: PrescribedBodies, bodies: Array) -> None:
    """Let driven bodies have the velocity of the end of a substep [s]."""
    drives, paths, out = driven.drives, driven.paths, driven.moment
    for number in range(len(drives) // SIZE):
        entry = number * SIZE
        if drives[entry + FOLLOWS] == 1.0:
            continue
        row = int(drives[entry + ROW]) * solver_bodies.SIZE
        if drives[entry + PATH] == NO_PATH:
            _put_velocity(row, load(drives, entry + SURFACE), NO_VECTOR, bodies)
            continue
        told.motion_at(paths, int(drives[entry + PATH]), time, out)
        velocity, spin = load(out, told.AT_VELOCITY), load(out, told.AT_SPIN)
        _put_velocity(row, velocity, spin, bodies)


@inline
def _number_of_collider(collider: int, static: int, table: Indices) -> int:
    """Which driven body a collider is; below 0: none."""
    entry = collider * collider_record.SIZE
    if table[entry + collider_record.BODY] >= 0:
        return -1
    return table[entry + collider_record.FIXED_ROW] - static - 1


@inline
def _runs(entry: int, normal: Any, drives: Array) -> bool:
    """Tell whether a belt runs along a face with a normal."""
    surface = load(drives, entry + SURFACE)
    return abs(dot(surface, normal)) <= ALONG * math.sqrt(dot(surface, surface))


@kernel
def velocity_at(
    collider: int, point: Any, normal: Any, static: int, table: Indices, drives: Array,
    bodies: Array,
) -> Any:  # fmt: skip
    """
    Velocity of the material of a driven collider at a point of its surface, whose normal is given,
    at the start of the tick [m/s]; zero of what is not driven.
    """
    number = _number_of_collider(collider, static, table)
    if number < 0:
        return NO_VECTOR
    entry = number * SIZE
    if drives[entry + PATH] == NO_PATH:
        return load(drives, entry + SURFACE) if _runs(entry, normal, drives) else NO_VECTOR
    row = (static + 1 + number) * solver_bodies.SIZE
    arm = subtract(point, load(bodies, row + solver_bodies.START_POSITION))
    turning = cross(load(bodies, row + solver_bodies.ANGULAR_MOMENTUM), arm)
    return scale(HELD, add(load(bodies, row + solver_bodies.MOMENTUM), turning))


@kernel
def choose_belts(
    manifold_count: int, static: int, drives: Array, table: Indices, manifolds: Array, rows: Array
) -> None:
    """Let constraints with a belt have its velocity where it runs along their face, else none."""
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        for side in range(2):
            collider = int(manifolds[record + manifold_record.COLLIDER_A + side])
            number = _number_of_collider(collider, static, table)
            if number < 0 or drives[number * SIZE + PATH] != NO_PATH:
                continue
            normal = load(manifolds, record + manifold_record.NORMAL)
            chosen = static + 1 + number if _runs(number * SIZE, normal, drives) else static
            rows[lane + constraint.BODY_A + constraint.LANES * side] = float(
                chosen * solver_bodies.SIZE
            )


@inline
def number_of(lane: int, static: int, rows: Array) -> Any:
    """Which driven body a constraint has, -1: none; and 1 where that is A, -1 where it is B."""
    of_a = int(rows[lane + constraint.BODY_A]) // solver_bodies.SIZE - static - 1
    of_b = int(rows[lane + constraint.BODY_B]) // solver_bodies.SIZE - static - 1
    return (of_a, 1.0) if of_a >= 0 else (of_b, -1.0)


@inline
def half_turn_of(number: int, static: int, bodies: Array) -> Any:
    """Half the turn of a driven body over the substep, as vector and scalar of a quaternion."""
    row = (static + 1 + number) * solver_bodies.SIZE
    turn = load(bodies, row + solver_bodies.TURN)
    scalar = 1.0 + bodies[row + solver_bodies.TURN_SCALAR]
    length = math.sqrt(dot(turn, turn) + scalar * scalar)
    return turn[0] / length, turn[1] / length, turn[2] / length, scalar / length


@inline
def is_face(
    record: int, lane: int, whose: Any, drives: Array, colliders: ColliderArrays,
    constraints: Constraints,
) -> bool:  # fmt: skip
    """
    Tell whether the normal of a manifold (where it begins: record), and of its constraint, belongs
    to a face of a driven body that moves; whose: see `number_of`.
    """
    number, sign = whose
    if drives[number * SIZE + PATH] == NO_PATH:
        return False
    side = 0 if sign > 0.0 else 1
    collider = int(constraints.manifolds[record + manifold_record.COLLIDER_A + side])
    rows = constraints.rows
    return along_face(collider, vector(rows, lane + constraint.NORMAL), colliders) >= FACE


@kernel
def turn_faces(
    manifold_count: int, static: int, driven: PrescribedBodies, colliders: ColliderArrays,
    constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """
    Let normals and tangents that belong to a face of a driven body turn as it does in half of a
    substep: before separations are updated, which so see the normal of its middle, and after. Else
    what slides on it with v would sink by v omega h in a tick h.

    static    : index of what cannot move
    colliders : where they are at the start of the tick
    """
    manifolds, rows = constraints.manifolds, constraints.rows
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        number, sign = number_of(lane, static, rows)
        if number < 0 or not is_face(
            record, lane, (number, sign), driven.drives, colliders, constraints
        ):
            continue
        half = half_turn_of(number, static, bodies)
        for field in (constraint.NORMAL, constraint.TANGENT_1, constraint.TANGENT_2):
            put_vector(rows, lane + field, told.turned(half, vector(rows, lane + field)))


@kernel
def keep_awake(
    manifold_count: int, static: int, drives: Array, manifolds: Array, rows: Array,
    sleep_states: Array,
) -> None:  # fmt: skip
    """Let nothing that touches what moves grow tired."""
    for m in range(manifold_count):
        lane = int(manifolds[m * manifold_record.SIZE + manifold_record.LANE])
        number, sign = number_of(lane, static, rows)
        if number < 0 or drives[number * SIZE + MOVES] == 0.0:
            continue
        other = constraint.BODY_B if sign > 0.0 else constraint.BODY_A
        body = int(rows[lane + other]) // solver_bodies.SIZE
        if body < static:
            sleep_states[body * sleep_record.SIZE + sleep_record.TIMER] = 0.0


@kernel
def wake_touched(
    count: int, h: float, drives: Array, colliders: ColliderArrays, sleep_states: Array
) -> bool:
    """Mark the islands that something driven may touch in a tick; tell whether there are any."""
    some = False
    for number in range(len(drives) // SIZE):
        entry = number * SIZE
        if drives[entry + MOVES] == 0.0 or drives[entry + PATH] == NO_PATH:
            continue
        driven = int(drives[entry + COLLIDER])
        center, half = world_aabb(colliders.local_bounds, driven, colliders.poses)
        swept = driven * swept_aabbs.SIZE
        velocity = load(colliders.swept_aabbs, swept + swept_aabbs.VELOCITY)
        reach = math.sqrt(dot(velocity, velocity)) * h
        reach += colliders.swept_aabbs[swept + swept_aabbs.TURNING]
        for collider in range(count):
            core = colliders.table[collider * collider_record.SIZE + collider_record.BODY]
            if core >= collider_record.STATIC:
                continue
            other, edge = world_aabb(colliders.local_bounds, collider, colliders.poses)
            apart = subtract(other, center)
            near = add_scaled(add(half, edge), 1.0, (reach, reach, reach))
            if abs(apart[0]) <= near[0] and abs(apart[1]) <= near[1] and abs(apart[2]) <= near[2]:
                island = (-2 - core) * sleep_record.SIZE + sleep_record.ISLAND
                sleep_states[island] = -abs(sleep_states[island])
                some = True
    return some
