# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at several points at once, from the bodies in flight to the tables of `joint_impact` and
back: the corners of a face, and what is struck together with the contacts that carry it.

A contact that carries load takes part with the points whose features the impulse cache knows as
such that push; it holds, and returns nothing of its own. So do those behind it, and so on.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FEATURE,
    POINT,
    POSITION,
)
from rigid_body_sim.physics.contact.events import event_lists, flight_record, impact_list
from rigid_body_sim.physics.contact.events import joint_impact_record as record
from rigid_body_sim.physics.contact.events.flight import (
    NO_VECTOR,
    Flights,
    body_of,
    orientation_of,
    spin_of,
    take_off,
)
from rigid_body_sim.physics.contact.events.free_points import pushes
from rigid_body_sim.physics.contact.events.ground_parts import (
    ask_part,
)
from rigid_body_sim.physics.contact.events.impact import (
    WORLD,
    add_work,
    inertia_of,
    material_of,
    push,
    rows_of_two,
    told_at,
    velocity_at,
    write_impact,
)
from rigid_body_sim.physics.contact.events.joint_impact import JointImpact, joint_impact
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    load,
    negate,
    scale,
    store,
)

LOADED_GAP = 1e-3  # [-] of the size: separation up to which contacts that carry are looked for
LIGHT = 1e-6  # [-] of the impulse that stops what strikes: a contact that pushes by less in a
# substep carries nothing
NO_LOAD = 0  # of an impact: nothing carries who is struck

find_manifold = slot('kernel (a, b, pair_id, near, flights): finds a manifold as both are now')
list_free_points = slot('kernel (row, cache, flights): lists free points that have arrived')
find_points = slot('kernel (a, b, normal, flights): lists the points at which two touch')
add_flush_points = slot('kernel (row, rows, number, ...): adds the points of the same face')
write_flush_impacts = slot('kernel (first, last, number, ...): lists the impacts of these')
add_carriers = slot(
    'kernel (number, least, cache, flights): adds the points of contacts with load'
)
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
    velocity = scale(records[begin + flight_record.INVERSE_MASS], momentum)
    store(bodies, place + record.VELOCITY, velocity)
    spin = NO_VECTOR
    if body < flights.motion.rigid_count:
        spin = spin_of(
            orientation_of(begin, records),
            load(records, begin + flight_record.ANGULAR_MOMENTUM),
            load(records, begin + flight_record.INVERSE_MOMENTS),
        )
    store(bodies, place + record.ANGULAR_VELOCITY, spin)


@inline
def put_point(
    number: int, colliders: Any, rows: Any, point: Any, normal: Any, material: Any,
    flights: Flights,
) -> None:  # fmt: skip
    """
    Write a point of two colliders, as they were looked at, into the table.

    rows : of the bodies A and B, or WORLD;   material : restitution and friction
    """
    points, place = flights.joint_points, number * record.POINT_SIZE
    a, b = colliders
    _, arm_a = velocity_at(0, body_of(a, flights), point, flights)
    _, arm_b = velocity_at(1, body_of(b, flights), point, flights)
    points[place + record.BODY_A], points[place + record.BODY_B] = rows
    store(points, place + record.ARM_A, arm_a)
    store(points, place + record.ARM_B, arm_b)
    store(points, place + record.NORMAL, normal)
    store(points, place + record.TOLD, told_at(a, b, point, normal, flights))
    points[place + record.RESTITUTION], points[place + record.FRICTION] = material


@kernel
def put_touching(count: int, a: int, b: int, normal: Any, material: Any, flights: Flights) -> None:
    """
    Write the bodies of two colliders, as they were looked at, into the table, with all points of
    the list.

    material : restitution and friction
    """
    views, body_a, body_b = flights.views, body_of(a, flights), body_of(b, flights)
    if body_a >= 0:
        _put_body(0, body_a, flights)
    if body_b >= 0:
        _put_body(1, body_b, flights)
    rows = rows_of_two(body_a, body_b)
    for index in range(count):
        point = load(views, flight_record.TOUCHING + 3 * index)
        put_point(index, (a, b), rows, point, normal, material, flights)


@kernel
def meet_at_points(count: int, all_points: int, bodies: Any, flights: Flights) -> Any:
    """
    Let two bodies of the table meet at all its points; return the impulse on B [N s] of the first
    ones.

    count, all_points : how many these are, and how many there are;   bodies : A and B
    """
    points = flights.joint_points
    joint_impact(JointImpact(2, all_points, flights.joint_bodies, points))
    total = NO_VECTOR
    for index in range(all_points):
        place = index * record.POINT_SIZE
        impulse = load(points, place + record.IMPULSE)
        first, second = points[place + record.BODY_A], points[place + record.BODY_B]
        if first != WORLD:
            body = bodies[0] if first == 0.0 else bodies[1]
            push(body, load(points, place + record.ARM_A), negate(impulse), flights)
        if second != WORLD:
            body = bodies[0] if second == 0.0 else bodies[1]
            push(body, load(points, place + record.ARM_B), impulse, flights)
        told = load(points, place + record.TOLD)
        add_work(max(bodies[0], bodies[1]), impulse, told, flights)
        if index < count:
            total = add(total, impulse)
    return total


@inline
def _row_of(body: int, flights: Flights) -> Any:
    """Row of a body in the table; WORLD: it is not in it."""
    if body < 0:
        return WORLD
    return float(flights.links[event_lists.ASKED * flights.motion.body_count + body]) - 1.0


@inline
def _enter(body: int, count: int, flights: Flights) -> int:
    """Put a body into the table, unless it is there; return how many are."""
    if body < 0 or _row_of(body, flights) != WORLD:
        return count
    take_off(body, flights)
    _put_body(count, body, flights)
    flights.links[event_lists.ASKED * flights.motion.body_count + body] = count + 1
    return count + 1


@inline
def _is_loaded(entry: int, least: float, cache: Array) -> bool:
    """Tell whether a manifold of the cache pushes by more than an impulse [N s] in a substep."""
    for index in range(int(cache[entry + cache_record.POINTS])):
        place = entry + cache_record.MANIFOLD_HEAD + index * cache_record.POINT_SIZE
        if cache[place + cache_record.NORMAL_IMPULSE] > least:
            return True
    return False


@inline
def _pair_of(entry: int, cache: Array, flights: Flights) -> Any:
    """Colliders of a manifold of the cache, type of A <= type of B."""
    table = flights.colliders.table
    count = len(table) // collider_record.SIZE
    pair_id = int(cache[entry + cache_record.PAIR_ID])
    a, b = pair_id // count, pair_id % count
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    if type_a > type_b or (type_a == type_b and a > b):
        return b, a
    return a, b


@kernel
def enter_carriers(count: int, least: float, cache: Array, flights: Flights) -> int:
    """
    Put all bodies into the table that contacts with load connect with those in it; return how
    many there are. NO_LOAD: no such contact.
    """
    loaded, grown = False, True
    while grown:
        grown, entry = False, cache_record.HEAD
        for _manifold in range(int(cache[cache_record.MANIFOLDS])):
            a, b = _pair_of(entry, cache, flights)
            body_a, body_b = body_of(a, flights), body_of(b, flights)
            known_a = body_a >= 0 and _row_of(body_a, flights) != WORLD
            known_b = body_b >= 0 and _row_of(body_b, flights) != WORLD
            if (known_a or known_b) and _is_loaded(entry, least, cache):
                loaded = True
                before = count
                count = _enter(body_b, _enter(body_a, count, flights), flights)
                grown |= count > before
            entry = cache_record.next_entry(entry, cache)
    return count if loaded else NO_LOAD


def _add_carriers(number: int, least: float, cache: Array, flights: Flights) -> int:
    """
    Add the points of all contacts with load between bodies of the table; return how many there
    are then.
    """
    found = flights.found
    room = len(flights.joint_points) // record.POINT_SIZE
    entry = cache_record.HEAD
    for _manifold in range(int(cache[cache_record.MANIFOLDS])):
        begin = entry
        entry = cache_record.next_entry(entry, cache)
        a, b = _pair_of(begin, cache, flights)
        body_a, body_b = body_of(a, flights), body_of(b, flights)
        row_a, row_b = _row_of(body_a, flights), _row_of(body_b, flights)
        if row_a == WORLD and row_b == WORLD:
            continue
        if not _is_loaded(begin, least, cache):
            continue
        pair_id = cache[begin + cache_record.PAIR_ID]
        normals, places, points = find_manifold(a, b, pair_id, LOADED_GAP, flights)
        normal = load(found, normals)
        _, friction = material_of(a, b, flights)
        for index in range(points):
            place = places + POINT * index
            if number < room and pushes(found[place + FEATURE], begin, least, cache):
                point = load(found, place + POSITION)
                put_point(number, (a, b), (row_a, row_b), point, normal, (0.0, friction), flights)
                flights.joint_points[number * record.POINT_SIZE + record.COLLIDER_A] = float(a)
                flights.joint_points[number * record.POINT_SIZE + record.COLLIDER_B] = float(b)
                number += 1
    return number


@inline
def _inverse_mass_at(side: int, body: int, normal: Any, flights: Flights) -> Any:
    """Inverse effective mass of a body along a normal at the first point of the list [1/kg]."""
    inverse_mass, inertia = inertia_of(body, flights)
    point = load(flights.views, flight_record.TOUCHING)
    _, arm = velocity_at(side, body, point, flights)
    lever = cross(arm, normal)
    return inverse_mass + dot(lever, apply_symmetric(inertia, lever))


def _meet_with_load(
    row: int, threshold: float, number: int, cache: Array, flights: Flights
) -> int:
    """
    Let the two colliders of an event meet now, together with the contacts that carry them. Return
    how many impacts that makes in the list; NO_LOAD: nothing happened.

        threshold : [m/s] slower approach returns nothing
        number    : of the first impact in the list
    """
    pairs, views, motion = flights.pairs, flights.views, flights.motion
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    for body in (body_a, body_b):
        if body >= 0:
            take_off(body, flights)
    look(0, a, 0.0, flights)
    look(1, b, 0.0, flights)
    normal = load(pairs, row + flight_record.NORMAL)
    ask_part(b, pairs[row + flight_record.PART], flights.colliders)
    free = pairs[row + flight_record.LOADED] != flight_record.NONE
    count = list_free_points(row, cache, flights) if free else 0
    if count == 0:
        count = find_points(a, b, normal, flights)
    ask_part(b, flight_record.NO_PART, flights.colliders)
    inverse = _inverse_mass_at(0, body_a, normal, flights)
    inverse += _inverse_mass_at(1, body_b, normal, flights)
    least = LIGHT * pairs[row + flight_record.APPROACH] / inverse
    for body in range(motion.body_count):
        flights.links[event_lists.ASKED * motion.body_count + body] = 0
    known = _enter(body_b, _enter(body_a, 0, flights), flights)
    carried = enter_carriers(known, least, cache, flights)
    if carried == NO_LOAD and not free:
        return NO_LOAD
    known = max(known, carried)
    restitution, friction = material_of(a, b, flights)
    if pairs[row + flight_record.APPROACH] < threshold:
        restitution = 0.0
    rows = (_row_of(body_a, flights), _row_of(body_b, flights))
    for index in range(count):
        point = load(views, flight_record.TOUCHING + 3 * index)
        put_point(index, (a, b), rows, point, normal, (restitution, friction), flights)
    struck = count if free else add_flush_points(row, rows, count, 0.0, flights)
    points = add_carriers(struck, least, cache, flights)
    tables = JointImpact(known, points, flights.joint_bodies, flights.joint_points)
    kind = impact_list.JOINT if joint_impact(tables) else impact_list.UNSETTLED
    total, mean = NO_VECTOR, NO_VECTOR
    listed = number + 1 + write_flush_impacts(count, struck, number + 1, 0.0, 0.0, kind, flights)
    for index in range(points):
        place = index * record.POINT_SIZE
        impulse = load(flights.joint_points, place + record.IMPULSE)
        _push_row(index, impulse, flights)
        if index < count:
            total = add(total, impulse)
            touching = load(views, flight_record.TOUCHING + 3 * index)
            mean = add_scaled(mean, 1.0 / count, touching)
        elif index >= struck and dot(impulse, impulse) > 0.0:
            _write_carrier(listed, kind, index, impulse, flights)
            listed += 1
    event = (0.0, 0.0, a, b, pairs[row + flight_record.APPROACH])
    write_impact(number, event, kind, mean, normal, total, flights)
    return listed - number


@inline
def _write_carrier(number: int, kind: float, index: int, impulse: Any, flights: Flights) -> None:
    """Write what a contact with load gave into the list of impacts."""
    points, place = flights.joint_points, index * record.POINT_SIZE
    a, b = int(points[place + record.COLLIDER_A]), int(points[place + record.COLLIDER_B])
    body = body_of(a, flights)
    arm = load(points, place + record.ARM_A)
    if body < 0:
        body = body_of(b, flights)
        arm = load(points, place + record.ARM_B)
    center = load(flights.records, body * flight_record.SIZE + flight_record.POSITION)
    normal = load(points, place + record.NORMAL)
    write_impact(number, (0.0, 0.0, a, b, 0.0), kind, add(center, arm), normal, impulse, flights)


@inline
def _push_row(index: int, impulse: Any, flights: Flights) -> None:
    """
    Let the impulse of a point act on the bodies in whose rows it is; what is driven has none, and
    works on the other one.
    """
    points, place = flights.joint_points, index * record.POINT_SIZE
    told = load(points, place + record.TOLD)
    count = flights.motion.body_count
    for body in range(count):
        row = _row_of(body, flights)
        if row == WORLD:
            continue
        if row == points[place + record.BODY_A]:
            push(body, load(points, place + record.ARM_A), negate(impulse), flights)
        elif row == points[place + record.BODY_B]:
            push(body, load(points, place + record.ARM_B), impulse, flights)
        else:
            continue
        add_work(body, impulse, told, flights)
        flights.records[body * flight_record.SIZE + flight_record.STRUCK] = 1.0
