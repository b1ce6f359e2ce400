# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at the present instant, at which a tick was cut (`cuts`): the pair of event 0, and what
follows from it at the same instant, the greatest approach first.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import slot
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.collision.nearest_axis import radius_about_core
from rigid_body_sim.physics.contact.events import event_lists, flight_record
from rigid_body_sim.physics.contact.events.closest_axis import turn_of_axis
from rigid_body_sim.physics.contact.events.flight import Flights, body_of, put_down
from rigid_body_sim.physics.contact.events.flush_faces import is_of_same_bodies
from rigid_body_sim.physics.contact.events.ground_parts import ask_part, is_ground, lever_of
from rigid_body_sim.physics.contact.events.joint import NO_LOAD
from rigid_body_sim.physics.contact.events.pair_events import (
    MOST_IMPACTS,
    room_for_impacts,
    take_listed,
)
from rigid_body_sim.physics.contact.events.time_of_impact import extremes
from rigid_body_sim.physics.vectors import load, store

AHEAD = 1e-12  # [s] extreme points of then are those of now
TOUCHES = 1e-11  # [-] of the size: a smaller gap is none

GROUND = slot('[-] whether some collider is ground of triangles')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
axis = slot('kernel (a, b, flights): the axis along which two colliders are farthest apart')
measure_free_points = slot('kernel (row, cache, flights): gap and approach of free points')
measure = slot('kernel (row, cache, flights, counts): gap and approach of a pair as it is now')
meet_with_load = slot(
    'kernel (row, threshold, number, cache, flights): lets two meet with their load'
)
next_of_cluster = slot('kernel (cache, flights, counts): the pair that meets next at this instant')
measure_ground = slot('kernel (row, a, b, flights, counts): approach of what touches ground now')
strike = slot('kernel (row, time, threshold, tick, number, flights): lets two meet')
find_flush = slot('kernel (row, cache, flights, counts): notes pairs of the same two bodies')


def _measure(row: int, cache: Array, flights: Flights, counts: Indices) -> Any:
    """Return gap and approach of the pair of an event as both are now; write its axis."""
    pairs = flights.pairs
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    if pairs[row + flight_record.LOADED] != flight_record.NONE:
        return measure_free_points(row, cache, flights)
    if GROUND and is_ground(b, flights.colliders):
        if row > 0:
            return measure_ground(row, a, b, flights, counts)
        ask_part(b, pairs[row + flight_record.PART], flights.colliders)
    store(flights.views, flight_record.LAST_AXIS, load(pairs, row + flight_record.NORMAL))
    flights.views[flight_record.PIECES_KNOWN] = 0.0
    look(0, a, 0.0, flights)
    look(1, b, 0.0, flights)
    normal = axis(a, b, flights)
    store(pairs, row + flight_record.NORMAL, normal)
    turn = turn_of_axis(a, b, normal, flights)
    rounding = radius_about_core(a, flights.colliders) + radius_about_core(b, flights.colliders)
    gap, rate = extremes(a, b, normal, turn, AHEAD, rounding, flights)
    ask_part(b, flight_record.NO_PART, flights.colliders)
    return gap, -rate


def _next_of_cluster(cache: Array, flights: Flights, counts: Indices) -> int:
    """Find the touching pair with the greatest approach; NO_EVENT: there is none."""
    pairs = flights.pairs
    best, most = event_lists.NO_EVENT, 0.0
    for event in range(1, counts[tick_counts.EVENTS]):
        row = event * flight_record.EVENT
        a = int(pairs[row + flight_record.COLLIDER_A])
        b = int(pairs[row + flight_record.COLLIDER_B])
        if body_of(a, flights) < event_lists.NOBODY or body_of(b, flights) < event_lists.NOBODY:
            continue
        if pairs[row + flight_record.STRUCK_SO_FAR] >= MOST_IMPACTS:
            continue
        gap, approach = measure(row, cache, flights, counts)
        size = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
        if gap <= TOUCHES * size and approach > max(most, pairs[row + flight_record.SLOW]):
            best, most = event, approach
            pairs[row + flight_record.APPROACH] = approach
    return best


def _find_flush(row: int, cache: Array, flights: Flights, counts: Indices) -> None:
    """Note which other pairs of the two bodies of an event touch now, and approach."""
    pairs = flights.pairs
    for event in range(1, counts[tick_counts.EVENTS]):
        other = event * flight_record.EVENT
        pairs[other + flight_record.INSTANT] = flight_record.NEVER
        if not is_of_same_bodies(row, other, flights):
            continue
        gap, approach = measure(other, cache, flights, counts)
        a = int(pairs[other + flight_record.COLLIDER_A])
        b = int(pairs[other + flight_record.COLLIDER_B])
        size = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
        if gap <= TOUCHES * size and approach > 0.0:
            pairs[other + flight_record.INSTANT] = 0.0
            pairs[other + flight_record.APPROACH] = approach


def _meet_now(strikes: bool, cache: Array, flights: Flights, counts: Indices) -> None:
    """
    Look at event 0 with the bodies as they are: its gap and its approach; or let it happen, and
    what follows from it at the same instant, the greatest approach first.

        cache : see `cache_record`: which contacts carry load
    """
    pairs, count = flights.pairs, flights.motion.body_count
    for body in range(count):
        flights.links[event_lists.CARRIED * count + body] = 0
        flights.records[body * flight_record.SIZE + flight_record.TIME] = flight_record.NOT_LOADED
    pairs[flight_record.GAP], pairs[flight_record.APPROACH] = measure(0, cache, flights, counts)
    if not strikes:
        return
    for event in range(1, counts[tick_counts.EVENTS]):
        pairs[event * flight_record.EVENT + flight_record.STRUCK_SO_FAR] = 0.0
    row = 0
    while counts[tick_counts.IMPACTS] < room_for_impacts(flights, counts):
        if pairs[row + flight_record.APPROACH] > 0.0:
            slow = pairs[row + flight_record.SLOW]
            number = counts[tick_counts.IMPACTS]
            find_flush(row, cache, flights, counts)
            listed = meet_with_load(row, slow, number, cache, flights)
            if listed == NO_LOAD:
                listed = strike(row, 0.0, slow, 0.0, number, flights)
            take_listed(row, listed, flights, counts)
        pairs[row + flight_record.STRUCK_SO_FAR] += 1.0
        event = next_of_cluster(cache, flights, counts)
        if event == event_lists.NO_EVENT:
            break
        row = event * flight_record.EVENT
    for body in range(count):
        place = body * flight_record.SIZE
        if (
            flights.records[place + flight_record.TIME] != flight_record.NOT_LOADED
            and flights.records[place + flight_record.STRUCK] == 1.0
        ):
            put_down(body, flights)
