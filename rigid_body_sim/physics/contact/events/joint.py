# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at several points at once, from the bodies in flight to the tables of `joint_impact` and
back: the corners of a face, and what is struck together with the contacts that carry it.

A contact that carries load takes part where the feature that touches is known to the impulse
cache as one that pushes; it holds, and returns nothing of its own.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events import joint_impact_record as record
from rigid_body_sim.physics.contact.events.flight import (
    NO_VECTOR,
    Flights,
    orientation_of,
    spin_of,
)
from rigid_body_sim.physics.contact.events.impact import (
    inertia_of,
    push,
    velocity_at,
)
from rigid_body_sim.physics.contact.events.joint_impact import JointImpact, joint_impact
from rigid_body_sim.physics.vectors import add, load, negate, scale, store

NEAR = 1e-3  # [-] of the size: separation up to which a contact that carries load is looked for
WORLD = -1.0  # in place of the row of a body

collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
find_points = slot('kernel (a, b, normal, flights): lists the points at which two touch')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')


@inline
def _put_body(row: int, body: int, flights: Flights) -> None:
    """Write a body in flight into a row of the table."""
    bodies, place = flights.joint_bodies, row * record.BODY_SIZE
    records, begin = flights.records, body * flight_record.SIZE
    inverse_mass, inertia = inertia_of(body, flights)
    bodies[place + record.INVERSE_MASS] = inverse_mass
    for entry in range(6):
        bodies[place + record.INVERSE_INERTIA + entry] = inertia[entry]
    momentum = load(records, begin + flight_record.MOMENTUM)
    store(bodies, place + record.VELOCITY, scale(inverse_mass, momentum))
    spin = NO_VECTOR
    if body < flights.motion.rigid_count:
        spin = spin_of(
            orientation_of(begin, records),
            load(records, begin + flight_record.ANGULAR_MOMENTUM),
            load(records, begin + flight_record.INVERSE_MOMENTS),
        )
    store(bodies, place + record.ANGULAR_VELOCITY, spin)


@inline
def _put_side(side: int, body: int, flights: Flights) -> None:
    """Write A or B, as it was looked at, into the row of its side; what is told has no mass."""
    if body >= 0:
        _put_body(side, body, flights)
        return
    bodies, place, view = flights.joint_bodies, side * record.BODY_SIZE, side * flight_record.VIEW
    for entry in range(record.BODY_SIZE):
        bodies[place + entry] = 0.0
    store(bodies, place + record.VELOCITY, load(flights.views, view + flight_record.VELOCITY))
    store(bodies, place + record.ANGULAR_VELOCITY, load(flights.views, view + flight_record.SPIN))


@inline
def _put_point(
    number: int, rows: Any, arms: Any, normal: Any, material: Any, flights: Flights
) -> None:
    """
    Write a point into the table.

    rows : of the bodies A and B, or WORLD;   material : restitution and friction
    """
    points, place = flights.joint_points, number * record.POINT_SIZE
    points[place + record.BODY_A], points[place + record.BODY_B] = rows
    store(points, place + record.ARM_A, arms[0])
    store(points, place + record.ARM_B, arms[1])
    store(points, place + record.NORMAL, normal)
    points[place + record.RESTITUTION], points[place + record.FRICTION] = material


@kernel
def meet_at_points(
    count: int, body_a: int, body_b: int, normal: Any, material: Any, flights: Flights
) -> Any:
    """
    Let two bodies, as they were looked at, meet at all points of the list; return the impulse on B
    [N s].

    material : restitution and friction
    """
    views, points = flights.views, flights.joint_points
    _put_side(0, body_a, flights)
    _put_side(1, body_b, flights)
    for index in range(count):
        point = load(views, flight_record.TOUCHING + 3 * index)
        _, arm_a = velocity_at(0, body_a, point, flights)
        _, arm_b = velocity_at(1, body_b, point, flights)
        _put_point(index, (0.0, 1.0), (arm_a, arm_b), normal, material, flights)
    joint_impact(JointImpact(2, count, flights.joint_bodies, points))
    total = NO_VECTOR
    for index in range(count):
        place = index * record.POINT_SIZE
        impulse = load(points, place + record.IMPULSE)
        push(body_a, load(points, place + record.ARM_A), negate(impulse), flights)
        push(body_b, load(points, place + record.ARM_B), impulse, flights)
        total = add(total, impulse)
    return total
