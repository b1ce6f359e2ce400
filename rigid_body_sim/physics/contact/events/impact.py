# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One impact of a pair: both bodies are brought to the instant, get their impulse, and the list of
impacts an entry.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import prescribed_bodies
from rigid_body_sim.physics.contact.events import flight_record, impact_list
from rigid_body_sim.physics.contact.events.collision_matrix import StruckBody
from rigid_body_sim.physics.contact.events.flight import (
    NO_VECTOR,
    Flights,
    body_of,
    orientation_of,
    spin_of,
)
from rigid_body_sim.physics.contact.events.ground_parts import ask_part
from rigid_body_sim.physics.contact.events.point_impact import point_impact
from rigid_body_sim.physics.contact.solver_bodies import world_inverse_inertia
from rigid_body_sim.physics.model.material import FRICTION, RESTITUTION, material_of_pair
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

WORLD = -1.0  # in place of the row of a body, of what no impulse moves
NO_INERTIA = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

bring = slot('kernel (body, time, flights): takes a body in flight to an instant')
put_touching = slot('kernel (count, a, b, normal, ...): writes two and their points')
meet_at_points = slot('kernel (count, all_points, bodies, flights): lets two meet at points')
add_flush_points = slot('kernel (row, rows, number, ...): adds the points of the same face')
write_flush_impacts = slot('kernel (first, last, number, ...): lists the impacts of these')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
find_points = slot('kernel (a, b, normal, flights): lists the points at which two touch')


@kernel
def material_of(a: int, b: int, flights: Flights) -> Any:
    """Restitution and friction of a pair of colliders."""
    given = material_of_pair(a, b, flights.materials, flights.pair_materials)
    return given[RESTITUTION], given[FRICTION]


@inline
def inertia_of(body: int, flights: Flights) -> Any:
    """Inverse mass and world inverse inertia of a body now; zero of what cannot move."""
    if body < 0:
        return 0.0, NO_INERTIA
    records, row = flights.records, body * flight_record.SIZE
    of_now = records[row + flight_record.MASS_SCALE]
    moments = scale(of_now, load(records, row + flight_record.INVERSE_MOMENTS))
    inverse = (moments[0], 0.0, 0.0, moments[0], 0.0, moments[0])
    if moments[0] != moments[1] or moments[1] != moments[2]:
        inverse = world_inverse_inertia(orientation_of(row, records), moments)
    return of_now * records[row + flight_record.INVERSE_MASS], inverse


@inline
def velocity_at(side: int, body: int, point: Any, flights: Flights) -> Any:
    """Velocity of a body at a point [m/s], as it was looked at; and the arm of the point [m]."""
    views, view = flights.views, side * flight_record.VIEW
    arm = subtract(point, load(views, view + flight_record.CENTER))
    spin = load(views, view + flight_record.SPIN)
    if 0 <= body < flights.motion.rigid_count:
        records, row = flights.records, body * flight_record.SIZE
        moments = load(records, row + flight_record.INVERSE_MOMENTS)
        momentum = load(records, row + flight_record.ANGULAR_MOMENTUM)
        if moments[0] != moments[1] or moments[1] != moments[2]:
            spin = spin_of(orientation_of(row, records), momentum, moments)
        else:
            spin = scale(moments[0], momentum)
    return add(load(views, view + flight_record.VELOCITY), cross(spin, arm)), arm


@inline
def told_at(a: int, b: int, point: Any, normal: Any, flights: Flights) -> Any:
    """
    Return what of the velocity of collider B against A at a point [m/s] no impulse changes: that
    of what is moved as told, and of belts along the faces that they run in.
    """
    motion, table = flights.motion, flights.colliders.table
    drives, bodies = flights.driven.drives, flights.bodies
    of_a = prescribed_bodies.velocity_at(
        a, point, normal, motion.body_count, table, drives, bodies
    )
    of_b = prescribed_bodies.velocity_at(
        b, point, normal, motion.body_count, table, drives, bodies
    )
    return subtract(of_b, of_a)


@inline
def add_work(body: int, impulse: Any, told: Any, flights: Flights) -> None:
    """
    Add the work that what is driven does on a body by an impulse on B [N s], whichever of the two
    is the body; told: see `told_at`.
    """
    flights.driven.works[body] -= dot(impulse, told)


@inline
def push(body: int, arm: Any, impulse: Any, flights: Flights) -> None:
    """
    Let an impulse [N s] act on a body in flight at an arm [m]: its momenta are those of the mass
    that it began with.
    """
    if body < 0:
        return
    records, row = flights.records, body * flight_record.SIZE
    impulse = scale(records[row + flight_record.MASS_SCALE], impulse)
    momentum = add(load(records, row + flight_record.MOMENTUM), impulse)
    store(records, row + flight_record.MOMENTUM, momentum)
    if body < flights.motion.rigid_count:
        momentum = load(records, row + flight_record.ANGULAR_MOMENTUM)
        momentum = add(momentum, cross(arm, impulse))
        store(records, row + flight_record.ANGULAR_MOMENTUM, momentum)


@inline
def _rest_of_sequence(restitution: float, approach: float, normal: Any, flights: Flights) -> Any:
    """
    Return how long a sequence of ever smaller impacts lasts from one of them on [s]: the sum of
    its flights, 2 e u / (a (1 - e)), a the acceleration at which the two fall back.
    """
    views = flights.views
    pull = subtract(
        load(views, flight_record.VIEW + flight_record.ACCELERATION),
        load(views, flight_record.ACCELERATION),
    )
    back = -dot(normal, pull)
    if not (back > 0.0 and restitution < 1.0):
        return 0.0
    return 2.0 * restitution * approach / (back * (1.0 - restitution))


@inline
def _struck(body: int, arm: Any, flights: Flights) -> StruckBody:
    """Return a body as the laws of impact take it."""
    inverse_mass, inverse_inertia = inertia_of(body, flights)
    return StruckBody(inverse_mass, inverse_inertia, arm)


@inline
def rows_of_two(body_a: int, body_b: int) -> Any:
    """Rows in the table of bodies of two that meet alone; WORLD: of what no impulse moves."""
    return 0.0 if body_a >= 0 else WORLD, 1.0 if body_b >= 0 else WORLD


@kernel
def _meet_at_a_point(a: int, b: int, normal: Any, material: Any, flights: Flights) -> Any:
    """Let two colliders meet at the first point of the list; return the impulse on B [N s]."""
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    point = load(flights.views, flight_record.TOUCHING)
    velocity_a, arm_a = velocity_at(0, body_a, point, flights)
    velocity_b, arm_b = velocity_at(1, body_b, point, flights)
    told = told_at(a, b, point, normal, flights)
    velocity = told
    if body_b >= 0:
        velocity = add(velocity, velocity_b)
    if body_a >= 0:
        velocity = subtract(velocity, velocity_a)
    impulse = point_impact(
        _struck(body_a, arm_a, flights),
        _struck(body_b, arm_b, flights),
        normal,
        velocity,
        material[0],
        material[1],
    )
    push(body_a, arm_a, negate(impulse), flights)
    push(body_b, arm_b, impulse, flights)
    add_work(max(body_a, body_b), impulse, told, flights)
    return impulse


@kernel
def write_impact(
    number: int, event: Any, kind: float, point: Any, normal: Any, impulse: Any, flights: Flights
) -> None:  # fmt: skip
    """
    Write an impact into the list.

    event : tick, part of it [s], collider A, collider B, approach [m/s]
    """
    entry, impacts = number * impact_list.SIZE, flights.impacts
    tick, part, collider_a, collider_b, approach = event
    impacts[entry + impact_list.TICK] = tick
    impacts[entry + impact_list.PART] = part
    impacts[entry + impact_list.COLLIDER_A] = float(collider_a)
    impacts[entry + impact_list.COLLIDER_B] = float(collider_b)
    impacts[entry + impact_list.APPROACH] = approach
    impacts[entry + impact_list.KIND] = kind
    store(impacts, entry + impact_list.POINT, point)
    store(impacts, entry + impact_list.NORMAL, normal)
    store(impacts, entry + impact_list.IMPULSE, impulse)


def _strike(
    row: int, time: float, threshold: float, tick: float, number: int, flights: Flights
) -> int:  # fmt: skip
    """
    Let the two colliders of an event meet at an instant [s], and with them all that are of the
    same face (`flush_faces`); return how many impacts that makes in the list.

        threshold : [m/s] slower approach returns nothing
        tick      : number of the tick;   number : of the impact in the list
    """
    pairs, views = flights.pairs, flights.views
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    for body in (body_a, body_b):
        if body >= 0:
            bring(body, time, flights)
            flights.records[body * flight_record.SIZE + flight_record.STRUCK] = 1.0
    look(0, a, time, flights)
    look(1, b, time, flights)
    normal = load(pairs, row + flight_record.NORMAL)
    ask_part(b, pairs[row + flight_record.PART], flights.colliders)
    count = find_points(a, b, normal, flights)
    ask_part(b, flight_record.NO_PART, flights.colliders)
    restitution, friction = material_of(a, b, flights)
    kind, rest = impact_list.IMPACT, 0.0
    approach = pairs[row + flight_record.APPROACH]
    if approach < threshold and restitution > 0.0:
        kind = impact_list.SUMMED
        rest = _rest_of_sequence(restitution, approach, normal, flights)
        restitution = 0.0
    mean = NO_VECTOR
    for index in range(count):
        point = load(views, flight_record.TOUCHING + 3 * index)
        mean = add_scaled(mean, 1.0 / count, point)
    material = (restitution, friction)
    put_touching(count, a, b, normal, material, flights)
    points = add_flush_points(row, rows_of_two(body_a, body_b), count, time, flights)
    if points == 1:
        impulse = _meet_at_a_point(a, b, normal, material, flights)
    else:
        impulse = meet_at_points(count, points, (body_a, body_b), flights)
    event = (tick, time + rest, a, b, approach)
    write_impact(number, event, kind, mean, normal, impulse, flights)
    return 1 + write_flush_impacts(
        count, points, number + 1, tick, time, impact_list.IMPACT, flights
    )
