# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pairs that carry load, and whom the solver moves by them: such a body is carried, and does not
fly. Their free points, which are apart, are events (`free_points`).
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies, tick_counts
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.events import event_lists, flight_record
from rigid_body_sim.physics.contact.events.flight import Flights, body_of
from rigid_body_sim.physics.contact.events.free_points import hide_free_points
from rigid_body_sim.physics.contact.events.pair_events import (
    add_event,
    has_room_for_event,
    speed_of_carried,
)
from rigid_body_sim.physics.contact.solver import cache_record

KEPT, DROPPED = 1.0, 0.0  # what becomes of a manifold


@inline
def is_carried(body: int, flights: Flights) -> bool:
    """Tell whether the solver moves a body."""
    count = flights.motion.body_count
    return body >= 0 and flights.links[event_lists.CARRIED * count + body] == 1


@inline
def carry(body: int, flights: Flights) -> None:
    """Note that the solver moves a body: it does not fly."""
    count = flights.motion.body_count
    if body >= 0 and flights.links[event_lists.CARRIED * count + body] == 0:
        flights.links[event_lists.CARRIED * count + body] = 1
        flights.records[body * flight_record.SIZE + flight_record.TIME] = flight_record.NOT_LOADED


@inline
def is_pulled(body: int, flights: Flights) -> bool:
    """Tell whether a force acts on a body that no flight in closed form has."""
    if body < 0:
        return False
    count = flights.motion.body_count
    return flights.links[event_lists.PULLED * count + body] == 1


@inline
def count_carried(a: int, b: int, flights: Flights) -> float:
    """Count the colliders of a pair whose bodies the solver moves."""
    held = 1.0 if is_carried(body_of(a, flights), flights) else 0.0
    return held + (1.0 if is_carried(body_of(b, flights), flights) else 0.0)


@inline
def moves_as_told(collider: int, body: int, flights: Flights) -> bool:
    """Tell whether a collider that does not move freely is moved as told."""
    row = collider_record.solver_body(collider, flights.colliders.table) * solver_bodies.SIZE
    return body < 0 and flights.bodies[row + solver_bodies.INVERSE_MASS] != 0.0


@inline
def is_not_in_flight(collider: int, flights: Flights) -> bool:
    """Tell whether something else than a flight in closed form moves a collider."""
    body = body_of(collider, flights)
    return bool(
        is_pulled(body, flights)
        or is_carried(body, flights)
        or moves_as_told(collider, body, flights)
    )


@inline
def is_covered(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold of the list is one without points that another one covers."""
    return bool(manifolds[record + manifold_record.PIECES] == manifold_record.COVERED)


@kernel
def is_carried_before(record: int, manifolds: Array, counts: Indices) -> bool:
    """
    Tell whether something that covers a manifold carries load: then the two do not meet, for it
    keeps the body in front of a plane behind which the other one lies. What sinks in meanwhile
    would strike the side of a flush tile else.
    """
    if not is_covered(record, manifolds):
        return False
    for m in range(counts[tick_counts.MANIFOLDS]):
        place = m * manifold_record.SIZE
        if manifolds[place + manifold_record.STATE] != KEPT:
            continue
        for cover in range(int(manifolds[record + manifold_record.COVER_COUNT])):
            pair = manifolds[record + manifold_record.COVERS + cover]
            if manifolds[place + manifold_record.PAIR_ID] == pair:
                return True
    return False


@kernel
def mark_loaded(
    h: float, manifolds: Array, cache: Array, flights: Flights, counts: Indices
) -> bool:
    """
    Keep the manifolds that carry load: what they hold is carried. Their free points are events.
    Tell whether there was room for these.
    """
    count = counts[tick_counts.MANIFOLDS]
    left, old = int(cache[cache_record.MANIFOLDS]), cache_record.HEAD
    for m in range(count):
        record = m * manifold_record.SIZE
        manifolds[record + manifold_record.STATE] = DROPPED
        if is_covered(record, manifolds):
            continue
        pair = manifolds[record + manifold_record.PAIR_ID]
        while left > 0 and cache[old + cache_record.PAIR_ID] < pair:
            old = cache_record.next_entry(old, cache)
            left -= 1
        if left == 0 or cache[old + cache_record.PAIR_ID] != pair:
            continue
        load_carried = 0.0
        for index in range(int(cache[old + cache_record.POINTS])):
            place = old + cache_record.MANIFOLD_HEAD + index * cache_record.POINT_SIZE
            load_carried += cache[place + cache_record.NORMAL_IMPULSE]
        if load_carried > 0.0:
            manifolds[record + manifold_record.STATE] = KEPT
            carry(body_of(int(manifolds[record + manifold_record.COLLIDER_A]), flights), flights)
            carry(body_of(int(manifolds[record + manifold_record.COLLIDER_B]), flights), flights)
            if counts[tick_counts.CUTTING] != tick_counts.LEAVES_CUTS and not _free_points_fly(
                record, old, h, manifolds, cache, flights, counts
            ):
                return False
    return True


@kernel
def _free_points_fly(
    record: int, entry: int, h: float, manifolds: Array, cache: Array, flights: Flights,
    counts: Indices,
) -> bool:  # fmt: skip
    """
    Hide the free points of a manifold that carries load, and make an event of the one that arrives
    first in this tick. Tell whether there was room for it.
    """
    points = int(manifolds[record + manifold_record.POINT_COUNT])
    known = int(cache[entry + cache_record.POINTS])
    if points <= known and _all_push(entry, cache):
        return True
    a = int(manifolds[record + manifold_record.COLLIDER_A])
    b = int(manifolds[record + manifold_record.COLLIDER_B])
    slow = speed_of_carried(a, b, h, flights)
    instant, approach = hide_free_points(record, entry, slow, h, cache, manifolds, flights)
    if manifolds[record + manifold_record.POINT_COUNT] == 0.0:
        manifolds[record + manifold_record.STATE] = DROPPED
    if instant == flight_record.NEVER:
        return True
    if not has_room_for_event(counts):
        return False
    row = add_event(a, b, h, flights, counts) * flight_record.EVENT
    flights.pairs[row + flight_record.INSTANT] = instant
    flights.pairs[row + flight_record.APPROACH] = approach
    flights.pairs[row + flight_record.HELD] = flight_record.KEPT
    flights.pairs[row + flight_record.LOADED] = manifolds[record + manifold_record.PAIR_ID]
    return True


@inline
def _all_push(entry: int, cache: Array) -> bool:
    """Tell whether all points of a manifold of the cache push."""
    for index in range(int(cache[entry + cache_record.POINTS])):
        place = entry + cache_record.MANIFOLD_HEAD + index * cache_record.POINT_SIZE
        if not cache[place + cache_record.NORMAL_IMPULSE] > 0.0:
            return False
    return True
