# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Faces that several colliders share: the parts of a union, tiles of a floor.

Two bodies, or a body and what cannot move, are two rigid bodies however many colliders they have.
Pairs of colliders of the same two that touch at one instant along one normal are one face: they
strike at once, with all their points, as the corners of a box do. Struck one after the other, a
union that falls flat would be turned by its first part, and thrown about by the next ones.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.events import event_lists, flight_record, impact_list
from rigid_body_sim.physics.contact.events import joint_impact_record as record
from rigid_body_sim.physics.contact.events.contact_points import ONE_HEIGHT
from rigid_body_sim.physics.contact.events.event_lists import following
from rigid_body_sim.physics.contact.events.flight import NO_VECTOR, Flights, body_of
from rigid_body_sim.physics.contact.events.ground_parts import ask_part, lever_of
from rigid_body_sim.physics.contact.events.impact import WORLD, material_of, write_impact
from rigid_body_sim.physics.contact.events.joint import put_point
from rigid_body_sim.physics.vectors import add, add_scaled, cross, dot, load

ONE_NORMAL = 1e-24  # [-] squared sine of the angle of normals that are one: the same as a tilt

look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
find_points = slot('kernel (a, b, normal, flights): lists the points at which two touch')


@inline
def _side_of(collider: int, flights: Flights) -> int:
    """
    Name the rigid body that a collider is of: all that stands still is one, and all that is moved
    as one (`prescribed_bodies`).
    """
    body = body_of(collider, flights)
    if body != event_lists.NOBODY:
        return body
    row = collider_record.solver_body(collider, flights.colliders.table)
    if flights.bodies[row * solver_bodies.SIZE + solver_bodies.INVERSE_MASS] == 0.0:
        return event_lists.NOBODY
    return row  # it is moved as told; those that move freely come before


@inline
def _sides_of(row: int, flights: Flights) -> Any:
    pairs = flights.pairs
    return (
        _side_of(int(pairs[row + flight_record.COLLIDER_A]), flights),
        _side_of(int(pairs[row + flight_record.COLLIDER_B]), flights),
    )


@kernel
def is_of_same_bodies(row: int, other: int, flights: Flights) -> bool:
    """Tell whether another pair of colliders is of the same two bodies."""
    pairs = flights.pairs
    if (
        pairs[row + flight_record.COLLIDER_A] == pairs[other + flight_record.COLLIDER_A]
        and pairs[row + flight_record.COLLIDER_B] == pairs[other + flight_record.COLLIDER_B]
    ) or pairs[other + flight_record.LOADED] != flight_record.NONE:
        return False
    a, b = _sides_of(row, flights)
    other_a, other_b = _sides_of(other, flights)
    return (a == other_a and b == other_b) or (a == other_b and b == other_a)


@kernel
def _is_of_the_face(row: int, other: int, time: float, flights: Flights) -> bool:
    """Tell whether another pair strikes at the same instant [s], along the same normal."""
    pairs = flights.pairs
    a = int(pairs[other + flight_record.COLLIDER_A])
    b = int(pairs[other + flight_record.COLLIDER_B])
    size = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
    approach = pairs[other + flight_record.APPROACH]
    gap = abs(pairs[other + flight_record.INSTANT] - time) * approach
    if not (approach > 0.0 and gap <= max(ONE_HEIGHT * size, pairs[other + flight_record.NO_GAP])):
        return False
    off = cross(load(pairs, row + flight_record.NORMAL), load(pairs, other + flight_record.NORMAL))
    return dot(off, off) <= ONE_NORMAL and is_of_same_bodies(row, other, flights)


@inline
def _row_of(collider: int, sides: Any, rows: Any, flights: Flights) -> float:
    """Row of the table of bodies in which the body of a collider is, one of two."""
    side = _side_of(collider, flights)
    return WORLD if side == event_lists.NOBODY else (rows[0] if side == sides[0] else rows[1])


@kernel
def restitution_of(row: int, flights: Flights) -> Any:
    """Restitution and friction of the pair of an event; what is slow returns nothing."""
    pairs = flights.pairs
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    restitution, friction = material_of(a, b, flights)
    is_slow = pairs[row + flight_record.APPROACH] < pairs[row + flight_record.SLOW]
    return 0.0 if is_slow else restitution, friction


def _add_flush_points(row: int, rows: Any, number: int, time: float, flights: Flights) -> int:
    """
    Add the points of all pairs that are of the same face as an event; return how many points there
    are then.

        rows   : of the two bodies of the event in the table
        number : of points in the table;   time : [s] of the impact
    """
    pairs, views, points = flights.pairs, flights.views, flights.joint_points
    count = flights.motion.body_count
    room = len(points) // record.POINT_SIZE
    body = max(
        body_of(int(pairs[row + flight_record.COLLIDER_A]), flights),
        body_of(int(pairs[row + flight_record.COLLIDER_B]), flights),
    )
    sides = _sides_of(row, flights)
    entry = flights.links[event_lists.FIRST * count + body]
    while entry > 1:
        other = entry // 2 * flight_record.EVENT
        entry = following(entry, count, flights.links)
        if number + flight_record.MOST_POINTS > room:
            break
        if not _is_of_the_face(row, other, time, flights):
            continue
        a = int(pairs[other + flight_record.COLLIDER_A])
        b = int(pairs[other + flight_record.COLLIDER_B])
        look(0, a, time, flights)
        look(1, b, time, flights)
        normal = load(pairs, other + flight_record.NORMAL)
        ask_part(b, pairs[other + flight_record.PART], flights.colliders)
        found = find_points(a, b, normal, flights)
        ask_part(b, flight_record.NO_PART, flights.colliders)
        of_pair = (_row_of(a, sides, rows, flights), _row_of(b, sides, rows, flights))
        material = restitution_of(other, flights)
        for index in range(found):
            point = load(views, flight_record.TOUCHING + 3 * index)
            put_point(number, (a, b), of_pair, point, normal, material, flights)
            points[number * record.POINT_SIZE + record.OF_EVENT] = float(other)
            number += 1
    return number


@kernel
def write_flush_impacts(
    first: int, last: int, number: int, tick: float, time: float, kind: float, flights: Flights
) -> int:
    """
    Write the impacts of the points that a face has beside those of its first pair into the list;
    return how many impacts that makes.

        first, last : points in the table;   number : of the first impact in the list
        kind        : of these impacts, IMPACT also where one is the last of a sequence
    """
    pairs, points, index, listed = flights.pairs, flights.joint_points, first, 0
    while index < last:
        row = int(points[index * record.POINT_SIZE + record.OF_EVENT])
        a = int(pairs[row + flight_record.COLLIDER_A])
        b = int(pairs[row + flight_record.COLLIDER_B])
        body, arm = body_of(a, flights), record.ARM_A
        if body < 0:
            body, arm = body_of(b, flights), record.ARM_B
        center = load(flights.records, body * flight_record.SIZE + flight_record.POSITION)
        total, mean, count = NO_VECTOR, NO_VECTOR, 0
        normal = load(pairs, row + flight_record.NORMAL)
        while index < last and points[index * record.POINT_SIZE + record.OF_EVENT] == row:
            place = index * record.POINT_SIZE
            total = add(total, load(points, place + record.IMPULSE))
            mean = add(mean, load(points, place + arm))
            count += 1
            index += 1
        restitution, _ = restitution_of(row, flights)
        of_pair = kind
        if kind == impact_list.IMPACT and restitution < material_of(a, b, flights)[0]:
            of_pair = impact_list.SUMMED
        event = (tick, time, a, b, pairs[row + flight_record.APPROACH])
        point = add_scaled(center, 1.0 / count, mean)
        write_impact(number + listed, event, of_pair, point, normal, total, flights)
        pairs[row + flight_record.STRUCK_SO_FAR] += 1.0
        listed += 1
    return listed
