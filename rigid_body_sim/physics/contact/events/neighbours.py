# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whom a struck body may reach: its pairs with all that is near enough are added to the events, where
they are not known.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Indices
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.collision import bounds_record, collider_record, swept_aabbs
from rigid_body_sim.physics.contact.collision.collider import PLANE
from rigid_body_sim.physics.contact.collision.ignored_pairs import is_ignored
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET
from rigid_body_sim.physics.contact.events import event_lists, flight_record
from rigid_body_sim.physics.contact.events.event_lists import following
from rigid_body_sim.physics.contact.events.flight import Flights, body_of
from rigid_body_sim.physics.contact.events.pair_events import add_event, has_room_for_event
from rigid_body_sim.physics.vectors import dot, load, subtract

ROOMY = 2.0  # [-] of the way that a struck body may go: so far its neighbours are looked for


@inline
def _way_of(body: int, time: float, h: float, flights: Flights) -> Any:
    """Bound of how far a body may be, at the end of the tick, from where it began it [m]."""
    records, row = flights.records, body * flight_record.SIZE
    inverse_mass, left = records[row + flight_record.INVERSE_MASS], h - time
    momentum = load(records, row + flight_record.MOMENTUM)
    force = load(records, row + flight_record.FORCE)
    gone = subtract(
        load(records, row + flight_record.POSITION), load(records, row + flight_record.BEGUN_AT)
    )
    return (
        math.sqrt(dot(gone, gone))
        + inverse_mass * left * math.sqrt(dot(momentum, momentum))
        + inverse_mass * left * left * math.sqrt(dot(force, force))
    )


@inline
def _lists_pair(body: int, a: int, b: int, flights: Flights) -> bool:
    """Tell whether the events of a body hold a pair."""
    pairs, count = flights.pairs, flights.motion.body_count
    entry = flights.links[event_lists.FIRST * count + body]
    while entry > 1:
        row = entry // 2 * flight_record.EVENT
        if (
            pairs[row + flight_record.COLLIDER_A] == a
            and pairs[row + flight_record.COLLIDER_B] == b
            and pairs[row + flight_record.LOADED] == flight_record.NONE
        ):
            return True
        entry = following(entry, count, flights.links)
    return False


@inline
def _may_reach(own: int, other: int, way: float, body: int, h: float, flights: Flights) -> bool:
    """Tell whether a collider of a struck body may reach another one within the tick."""
    colliders, swept = flights.colliders, flights.colliders.swept_aabbs
    bounds = colliders.local_bounds
    arm = subtract(
        load(swept, own * swept_aabbs.SIZE + swept_aabbs.CENTER),
        load(flights.records, body * flight_record.SIZE + flight_record.BEGUN_AT),
    )
    lever = math.sqrt(dot(arm, arm)) + bounds[own * bounds_record.SIZE + bounds_record.RADIUS]
    begun = load(flights.records, body * flight_record.SIZE + flight_record.BEGUN_AT)
    kind = colliders.table[other * collider_record.SIZE + collider_record.TYPE]
    if kind == PLANE:
        shape = colliders.table[other * collider_record.SIZE + collider_record.PARAMETERS]
        normal = load(colliders.parameters, shape + NORMAL)
        height = dot(normal, begun) - colliders.parameters[shape + OFFSET]
        return height <= lever + way
    row = other * swept_aabbs.SIZE
    apart = subtract(load(swept, row + swept_aabbs.CENTER), begun)
    velocity = load(swept, row + swept_aabbs.VELOCITY)
    reach = lever + way + bounds[other * bounds_record.SIZE + bounds_record.RADIUS]
    reach += math.sqrt(dot(velocity, velocity)) * h + swept[row + swept_aabbs.TURNING]
    moved = body_of(other, flights)
    if moved >= 0:
        place = moved * flight_record.SIZE
        if flights.records[place + flight_record.TIME] != flight_record.NOT_LOADED:
            reach += flights.records[place + flight_record.REACH]
    return dot(apart, apart) <= reach * reach


def _ask_neighbours(body: int, time: float, h: float, flights: Flights, counts: Indices) -> bool:
    """
    Add the pairs of a struck body with all that it may reach from now on, unless they are known.
    Tell whether there was room.
    """
    records, row = flights.records, body * flight_record.SIZE
    table, count = flights.colliders.table, counts[tick_counts.COLLIDERS]
    way = _way_of(body, time, h, flights)
    asked = event_lists.ASKED * flights.motion.body_count + body
    if flights.links[asked] == 1 and way <= records[row + flight_record.REACH]:
        return True
    flights.links[asked] = 1
    way *= ROOMY
    records[row + flight_record.REACH] = way
    for own in range(counts[tick_counts.PLANES], count):
        if body_of(own, flights) != body:
            continue
        for other in range(count):
            moved = body_of(other, flights)
            kind = table[other * collider_record.SIZE + collider_record.TYPE]
            if moved == body:
                continue
            if not _may_reach(own, other, way, body, h, flights):
                continue
            a, b = own, other
            type_a = table[a * collider_record.SIZE + collider_record.TYPE]
            if type_a > kind or (type_a == kind and a > b):
                a, b = b, a
            pair_id = max(a, b) * count + min(a, b)
            if is_ignored(pair_id, flights.ignored) or _lists_pair(body, a, b, flights):
                continue
            if not has_room_for_event(counts):
                return False
            add_event(a, b, h, flights, counts)
    return True
