# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free flight over any part of a tick, from the instant of one impact to that of the next.

    p(t) = p + F t           r(t) = r + t (p + F t / 2) / m          exact: F is held over a tick
    L(t) = L + T t           q(t) : the free rotation of the scene's integrator over t, between two
                             halves of the torque

`look` shows a collider at an instant and leaves the body where it is; `bring` takes the body
there. Who is in no impact is neither: the blocks carry him through the tick, with the bits of
always.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Motion
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    free_motion,
    pose,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.events import event_lists, flight_record
from rigid_body_sim.physics.contact.prescribed_bodies import PrescribedBodies
from rigid_body_sim.physics.contact.solver import variable_mass
from rigid_body_sim.physics.integration.schemes import steps
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ROTATION,
    TRANSLATION,
    add_compensated,
    at,
    rotated,
    rotated_back,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    dot,
    load,
    load_quaternion,
    load_strided,
    scale,
    store,
    store_quaternion,
    store_strided,
    subtract,
)

NO_VECTOR = (0.0, 0.0, 0.0)
NO_TURN = (0.0, 0.0, 0.0, 1.0)

drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and turns q')


class Flights(NamedTuple):
    """
    The bodies of a tick that may meet others.

    motion, colliders, bodies : as of the tick
    local_poses : of the shapes in the axes of their bodies: see `collision.pose`
    found       : scratch of the pair kernels
    records     : a flight of each body: see `flight_record`
    views       : what was looked at last, of A and of B: see `flight_record`
    turning     : blocks of one body each, in which A and B are turned
    method      : numbers of the integrator beside them
    pairs       : events: see `flight_record`
    links       : see `event_lists`
    impacts     : see `impact_list`
    materials, pair_materials : of colliders and of pairs of them: see `model.material`
    ignored     : pairs that do not meet: see `collision.ignored_pairs`
    settings    : see `tick_settings`
    driven      : what is moved as told, and belts: see `prescribed_bodies`
    joint_bodies, joint_points : tables of impacts at several points: see `joint_impact_record`
    """

    motion: Motion
    colliders: ColliderArrays
    bodies: Array
    local_poses: Array
    found: Array
    materials: Array
    pair_materials: Array
    ignored: Indices
    settings: Array
    driven: PrescribedBodies
    joint_bodies: Array
    joint_points: Array
    records: Array
    views: Array
    turning: Array
    method: Array
    pairs: Array
    links: Indices
    impacts: Array


@inline
def body_of(collider: int, flights: Flights) -> int:
    """Index of the body of a collider among those that move; below 0: none."""
    return flights.colliders.table[collider * collider_record.SIZE + collider_record.BODY]


@inline
def pose_of_side(side: int, flights: Flights) -> int:
    """Where the pose of A or B begins that was looked at: behind those of all colliders."""
    return len(flights.colliders.poses) - (4 - side) * pose.SIZE


@kernel
def take_off(body: int, flights: Flights) -> None:
    """Load the flight of a body as it is at the start of the tick, unless it is under way."""
    records, row = flights.records, body * flight_record.SIZE
    if records[row + flight_record.TIME] != flight_record.NOT_LOADED:
        return
    motion = flights.motion
    translation, place = motion.translation, at(body, TRANSLATION)
    records[row + flight_record.TIME] = 0.0
    records[row + flight_record.STRUCK] = 0.0
    position = load_strided(translation, place + blocks.RX, LANES)
    store(records, row + flight_record.POSITION, position)
    store(records, row + flight_record.BEGUN_AT, position)
    residual = load_strided(translation, place + blocks.EX, LANES)
    store(records, row + flight_record.POSITION_RESIDUAL, residual)
    momentum = load_strided(translation, place + blocks.PX, LANES)
    store(records, row + flight_record.MOMENTUM, momentum)
    residual = load_strided(translation, place + blocks.GX, LANES)
    store(records, row + flight_record.MOMENTUM_RESIDUAL, residual)
    rests = flights.links[event_lists.CARRIED * motion.body_count + body] == 1
    force = load_strided(translation, place + blocks.FX, LANES)
    store(records, row + flight_record.FORCE, NO_VECTOR if rests else force)
    records[row + flight_record.INVERSE_MASS] = flights.bodies[
        body * solver_bodies.SIZE + solver_bodies.INVERSE_MASS
    ]
    store(records, row + flight_record.ANGULAR_MOMENTUM, NO_VECTOR)
    store(records, row + flight_record.TORQUE, NO_VECTOR)
    store(records, row + flight_record.INVERSE_MOMENTS, NO_VECTOR)
    store_quaternion(records, row + flight_record.ORIENTATION, NO_TURN)
    if body < motion.rigid_count:
        rotation, place = motion.rotation, at(body, ROTATION)
        momentum = load_strided(rotation, place + blocks.LX, LANES)
        store(records, row + flight_record.ANGULAR_MOMENTUM, momentum)
        torque = load_strided(rotation, place + blocks.TX, LANES)
        store(records, row + flight_record.TORQUE, NO_VECTOR if rests else torque)
        moments = load_strided(rotation, place + blocks.J1, LANES)
        store(records, row + flight_record.INVERSE_MOMENTS, moments)
        orientation = blocks.orientation(rotation, body)
        store_quaternion(records, row + flight_record.ORIENTATION, orientation)


@kernel
def take_mass_scales(flows: Array, flights: Flights) -> None:
    """Take over m0/m of now of bodies whose mass changes; flows: see `solver.variable_mass`."""
    for row in range(0, len(flows), variable_mass.SIZE):
        record = int(flows[row + variable_mass.BODY]) * flight_record.SIZE
        flights.records[record + flight_record.MASS_SCALE] = flows[row + variable_mass.SCALE]


@inline
def orientation_of(row: int, records: Array) -> Any:
    """Orientation of the flight that begins at a place."""
    return load_quaternion(records, row + flight_record.ORIENTATION)


@inline
def spin_of(q: Any, angular_momentum: Any, inverse_moments: Any) -> Any:
    """Angular velocity R J R^T L [rad/s], world axes."""
    own = rotated_back(q, angular_momentum)
    return rotated(
        q,
        (own[0] * inverse_moments[0], own[1] * inverse_moments[1], own[2] * inverse_moments[2]),
    )


@inline
def _method_rows(flights: Flights) -> int:
    """Numbers that the integrator keeps of a body."""
    return len(flights.method) // (2 * LANES)


def _turned(side: int, body: int, span: float, flights: Flights) -> Any:
    """
    Return orientation and angular momentum of a body in flight after a time [s].

    side : whose block is used for it
    """
    records, row = flights.records, body * flight_record.SIZE
    q = orientation_of(row, records)
    momentum = load(records, row + flight_record.ANGULAR_MOMENTUM)
    if span == 0.0 or body >= flights.motion.rigid_count:
        return q, momentum
    turning, lane = flights.turning, side * ROTATION
    source, from_lane = flights.motion.rotation, at(body, ROTATION)
    for entry in range(4):
        turning[lane + blocks.QX + LANES * entry] = q[entry]
    store_strided(turning, lane + blocks.LX, LANES, momentum)
    torque = load(records, row + flight_record.TORQUE)
    store_strided(turning, lane + blocks.TX, LANES, torque)
    moments = load_strided(source, from_lane + blocks.I1, LANES)
    store_strided(turning, lane + blocks.I1, LANES, moments)
    moments = load_strided(source, from_lane + blocks.J1, LANES)
    store_strided(turning, lane + blocks.J1, LANES, moments)
    rows = _method_rows(flights)
    begin = side * rows * LANES
    of_body = (body // LANES) * rows * LANES + body % LANES
    for entry in range(rows):
        flights.method[begin + LANES * entry] = flights.motion.method[of_body + LANES * entry]
    drift_rotation(side, 1, 0.5 * span, span, turning, flights.method)
    steps.kick_rotation(side, 1, 0.5 * span, turning)
    turned = (
        turning[lane + blocks.QX], turning[lane + blocks.QY], turning[lane + blocks.QZ],
        turning[lane + blocks.QW],
    )  # fmt: skip
    return turned, load_strided(turning, lane + blocks.LX, LANES)


@inline
def _put_pose(collider: int, target: int, position: Any, q: Any, flights: Flights) -> None:
    """Write the pose of a collider whose body stands somewhere: see `narrow_phase.find_poses`."""
    poses, local, place = flights.colliders.poses, flights.local_poses, collider * pose.SIZE
    for column in range(3):
        turned = rotated(q, pose.axis(local, place, column))
        store_strided(poses, target + pose.ROW_X + column, pose.ROW_Y - pose.ROW_X, turned)
    center = pose.to_world(poses, target, load(local, place + pose.POSITION))
    store(poses, target + pose.POSITION, subtract(position, center))


@kernel
def _look_at_fixed(side: int, collider: int, time: float, flights: Flights) -> None:
    """Show a collider that no force moves: it stands still, or is moved as told."""
    views, view = flights.views, side * flight_record.VIEW
    colliders = flights.colliders
    told = free_motion.free_motion(collider, colliders, flights.bodies)
    target = pose_of_side(side, flights)
    if told.bend == 0.0 and dot(told.velocity, told.velocity) == 0.0:
        for entry in range(pose.SIZE):
            colliders.poses[target + entry] = colliders.poses[collider * pose.SIZE + entry]
    else:
        free_motion.move(collider, target, time, told, colliders.poses)
    shift = add_scaled(scale(time, told.velocity), 0.5 * time * time, told.acceleration)
    store(views, view + flight_record.CENTER, add(told.center, shift))
    now = add_scaled(told.velocity, time, told.acceleration)
    store(views, view + flight_record.VELOCITY, now)
    store(views, view + flight_record.ACCELERATION, told.acceleration)
    store(views, view + flight_record.SPIN, add_scaled(told.spin, time, told.spin_change))
    views[view + flight_record.BEND] = told.bend
    views[view + flight_record.SPIN_BOUND] = math.sqrt(dot(told.spin, told.spin)) + time * (
        math.sqrt(dot(told.spin_change, told.spin_change))
    )


def _look(side: int, collider: int, time: float, flights: Flights) -> None:
    """Show a collider at an instant of the tick [s]: its pose, and how it moves."""
    body = body_of(collider, flights)
    if body < 0:
        _look_at_fixed(side, collider, time, flights)
        return
    take_off(body, flights)
    records, row = flights.records, body * flight_record.SIZE
    views, view = flights.views, side * flight_record.VIEW
    span = time - records[row + flight_record.TIME]
    inverse_mass = records[row + flight_record.INVERSE_MASS]
    force = load(records, row + flight_record.FORCE)
    momentum = load(records, row + flight_record.MOMENTUM)
    mean = scale(inverse_mass, add_scaled(momentum, 0.5 * span, force))
    way = add_scaled(load(records, row + flight_record.POSITION_RESIDUAL), span, mean)
    position = add(load(records, row + flight_record.POSITION), way)
    store(views, view + flight_record.CENTER, position)
    momentum = add_scaled(momentum, span, force)
    store(views, view + flight_record.VELOCITY, scale(inverse_mass, momentum))
    store(views, view + flight_record.ACCELERATION, scale(inverse_mass, force))
    store(views, view + flight_record.SPIN, NO_VECTOR)
    views[view + flight_record.BEND] = 0.0
    views[view + flight_record.SPIN_BOUND] = 0.0
    target = pose_of_side(side, flights)
    symmetry = flights.bodies[body * solver_bodies.SIZE + solver_bodies.SYMMETRY]
    if body >= flights.motion.rigid_count or symmetry == solver_bodies.CENTRED_BALL:
        poses = flights.colliders.poses
        for entry in range(pose.ROW_X, pose.SIZE):
            poses[target + entry] = poses[collider * pose.SIZE + entry]
        store(poses, target + pose.POSITION, position)
        return
    q, angular_momentum = turned(side, body, span, flights)
    _put_pose(collider, target, position, q, flights)
    moments = load(records, row + flight_record.INVERSE_MOMENTS)
    spin = spin_of(q, angular_momentum, moments)
    store(views, view + flight_record.SPIN, spin)
    _bound_turning(view, collider, row, spin, angular_momentum, flights)


turned = slot('kernel (side, body, span, flights): orientation and angular momentum after a time')


@inline
def _bound_turning(
    view: int, collider: int, row: int, spin: Any, angular_momentum: Any, flights: Flights
) -> None:
    """
    Bound how turning accelerates points of a collider: (w^2 + |alpha|) l, with

        w^2 <= 2 T J_max,   |alpha| <= J_max (|w| |L| + |torque|),   l : longest lever
    """
    records, views = flights.records, flights.views
    moments = load(records, row + flight_record.INVERSE_MOMENTS)
    torque = load(records, row + flight_record.TORQUE)
    most = max(moments[0], moments[1], moments[2])
    squared = max(dot(spin, angular_momentum) * most, dot(spin, spin))
    rate = math.sqrt(squared)
    change = most * math.sqrt(dot(torque, torque))
    if moments[0] != moments[1] or moments[1] != moments[2]:
        change += most * rate * math.sqrt(dot(angular_momentum, angular_momentum))
    bounds = collider * bounds_record.SIZE
    arm = load(flights.local_poses, collider * pose.SIZE + pose.POSITION)
    center = load(flights.colliders.local_bounds, bounds + bounds_record.CENTER)
    away = subtract(center, arm)
    lever = (
        math.sqrt(dot(away, away))
        + flights.colliders.local_bounds[bounds + bounds_record.RADIUS]
        - flights.colliders.local_bounds[bounds + bounds_record.ROUNDING]
    )
    views[view + flight_record.BEND] = (squared + change) * lever
    views[view + flight_record.SPIN_BOUND] = rate


def _bring(body: int, time: float, flights: Flights) -> None:
    """Take a body in flight to an instant of the tick [s]."""
    records, row = flights.records, body * flight_record.SIZE
    span = time - records[row + flight_record.TIME]
    q, angular_momentum = turned(0, body, span, flights)
    store_quaternion(records, row + flight_record.ORIENTATION, q)
    store(records, row + flight_record.ANGULAR_MOMENTUM, angular_momentum)
    inverse_mass = records[row + flight_record.INVERSE_MASS]
    for axis in range(3):
        force = records[row + flight_record.FORCE + axis]
        momentum = records[row + flight_record.MOMENTUM + axis]
        mean = inverse_mass * (momentum + 0.5 * span * force)
        position, lost = add_compensated(
            records[row + flight_record.POSITION + axis],
            records[row + flight_record.POSITION_RESIDUAL + axis],
            span * mean,
        )
        records[row + flight_record.POSITION + axis] = position
        records[row + flight_record.POSITION_RESIDUAL + axis] = lost
        momentum, lost = add_compensated(
            momentum, records[row + flight_record.MOMENTUM_RESIDUAL + axis], span * force
        )
        records[row + flight_record.MOMENTUM + axis] = momentum
        records[row + flight_record.MOMENTUM_RESIDUAL + axis] = lost
    records[row + flight_record.TIME] = time


@kernel
def put_down(body: int, flights: Flights) -> None:
    """Write the flight of a body back to the blocks."""
    records, row = flights.records, body * flight_record.SIZE
    translation, place = flights.motion.translation, at(body, TRANSLATION)
    for field, target in (
        (flight_record.POSITION, blocks.RX),
        (flight_record.POSITION_RESIDUAL, blocks.EX),
        (flight_record.MOMENTUM, blocks.PX),
        (flight_record.MOMENTUM_RESIDUAL, blocks.GX),
    ):
        store_strided(translation, place + target, LANES, load(records, row + field))
    if body < flights.motion.rigid_count:
        rotation, place = flights.motion.rotation, at(body, ROTATION)
        momentum = load(records, row + flight_record.ANGULAR_MOMENTUM)
        store_strided(rotation, place + blocks.LX, LANES, momentum)
        for entry in range(4):
            rotation[place + blocks.QX + LANES * entry] = records[
                row + flight_record.ORIENTATION + entry
            ]
