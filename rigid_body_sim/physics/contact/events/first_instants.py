# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
When pairs meet, asked from the start of the tick on, and which of them the solver gets: what comes
nearer slowly, what it moves anyway, and what it is left by a cut that is not made.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
)
from rigid_body_sim.physics.contact.collision.collider import SURFACE
from rigid_body_sim.physics.contact.events import event_lists, flight_record
from rigid_body_sim.physics.contact.events.flight import Flights, body_of
from rigid_body_sim.physics.contact.events.ground_parts import is_ground
from rigid_body_sim.physics.contact.events.loaded_pairs import (
    KEPT,
    carry,
    count_carried,
    is_carried_before,
    is_covered,
    is_not_in_flight,
)
from rigid_body_sim.physics.contact.events.pair_events import (
    add_event,
    has_room_for_event,
    speed_of_carried,
)
from rigid_body_sim.physics.contact.events.time_of_impact import MISSES, STAYS
from rigid_body_sim.physics.vectors import dot, load, subtract

# [-] of the tick: so far is asked ahead of what the solver moves, whose forces bend its way; what
# does not arrive within the tick is no impact of it (`cuts`)
LATE = 1.5

GROUND = slot('[-] whether some collider is ground of triangles')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
find_instant = slot('kernel (a, b, start, end, row, flights): tells whether two meet, and when')
find_on_ground = slot('kernel (a, b, start, end, row, ...): tells whether ground is met, and when')
ask_all = slot('kernel (h, manifolds, flights, counts): asks all pairs, and who is held anew')
closing_speed = slot('kernel (a, b, flights): bound of the speed of two against each other')
is_left_to_solver = slot('kernel (found, a, b, row, ...): tells whether the solver gets a pair')
ask_first = slot('kernel (row, held, h, ...): asks a pair from the start of the tick on')
ask_ground_first = slot('kernel (row, h, manifolds, flights, counts): the same of ground')


def _closing_speed(a: int, b: int, flights: Flights) -> Any:
    """Bound of the speed of points of two colliders against each other [m/s], now."""
    views, bounds = flights.views, flights.colliders.local_bounds
    look(0, a, 0.0, flights)
    look(1, b, 0.0, flights)
    way = subtract(
        load(views, flight_record.VIEW + flight_record.VELOCITY),
        load(views, flight_record.VELOCITY),
    )
    speed = math.sqrt(dot(way, way))
    for side in range(2):
        radius = bounds[(a if side == 0 else b) * bounds_record.SIZE + bounds_record.RADIUS]
        if radius < math.inf:
            spin = views[side * flight_record.VIEW + flight_record.SPIN_BOUND]
            speed += 2.0 * radius * spin
    return speed


def _is_left_to_solver(
    found: int, a: int, b: int, row: int, flights: Flights, counts: Indices
) -> bool:
    """Tell whether a pair that has been asked when it meets is left to the solver."""
    if found == MISSES:
        return False
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    if (
        found == STAYS
        or flights.pairs[row + flight_record.APPROACH] < flights.pairs[row + flight_record.SLOW]
    ):
        return True
    if body_a < event_lists.NOBODY or body_b < event_lists.NOBODY:  # wakes who sleeps
        return True
    if counts[tick_counts.CUTTING] != tick_counts.LEAVES_CUTS:
        return False
    return is_not_in_flight(a, flights) or is_not_in_flight(b, flights)


def _find_events(
    h: float, pair_ids: Indices, manifolds: Array, flights: Flights, counts: Indices
) -> bool:
    """
    Ask all pairs that carry no load when they meet, and keep the manifolds of those that are left
    to the solver. Tell whether there was room for the events.
    """
    table = flights.colliders.table
    count, manifold_count = counts[tick_counts.COLLIDERS], counts[tick_counts.MANIFOLDS]
    m = 0
    for index in range(counts[tick_counts.PAIRS]):
        pair_id = pair_ids[index]
        a, b = pair_id // count, pair_id % count
        type_a = table[a * collider_record.SIZE + collider_record.TYPE]
        type_b = table[b * collider_record.SIZE + collider_record.TYPE]
        if type_a > type_b or (type_a == type_b and a > b):
            a, b = b, a
            type_a, type_b = type_b, type_a
        first, kept, parts, covered = m, False, 0, False
        while (
            m < manifold_count
            and int(manifolds[m * manifold_record.SIZE + manifold_record.PAIR_ID]) == pair_id
        ):
            if is_covered(m * manifold_record.SIZE, manifolds):  # the only one of its pair
                covered = is_carried_before(m * manifold_record.SIZE, manifolds, counts)
                first = m + 1
            elif manifolds[m * manifold_record.SIZE + manifold_record.STATE] == KEPT:
                kept = True
            else:
                parts += 1
            m += 1
        if GROUND and type_b == SURFACE:  # some of its parts may be the solver's, others not
            kept = kept and parts == 0
        if (
            table[a * collider_record.SIZE + collider_record.STANDS_BACK]
            + table[b * collider_record.SIZE + collider_record.STANDS_BACK]
            == 2
            or covered
        ):
            continue
        if kept:
            for place in range(first, m):
                manifolds[place * manifold_record.SIZE + manifold_record.STATE] = KEPT
                carry(body_of(a, flights), flights)
                carry(body_of(b, flights), flights)
            continue
        if not has_room_for_event(counts):
            return False
        row = add_event(a, b, h, flights, counts) * flight_record.EVENT
        if first < m:
            flights.pairs[row + flight_record.MANIFOLD] = float(first)
    ask_all(h, manifolds, flights, counts)
    return True


def _ask_all(h: float, manifolds: Array, flights: Flights, counts: Indices) -> None:
    """Ask all pairs when they meet, anew where one of the two is found to be the solver's."""
    asked = True
    while asked:
        asked = False
        for event in range(1, counts[tick_counts.EVENTS]):
            row = event * flight_record.EVENT
            a = int(flights.pairs[row + flight_record.COLLIDER_A])
            b = int(flights.pairs[row + flight_record.COLLIDER_B])
            held, before = count_carried(a, b, flights), flights.pairs[row + flight_record.HELD]
            if before != flight_record.KEPT and before != held:
                ask_first(row, held, h, manifolds, flights, counts)
                asked = True


@kernel
def leaves(row: int, a: int, b: int, manifolds: Array, flights: Flights, counts: Indices) -> bool:
    """
    Leave a pair that wants a cut to the solver, where none is made; tell whether it has a manifold
    that the solver could get.
    """
    pairs = flights.pairs
    first = pairs[row + flight_record.MANIFOLD]
    if (
        counts[tick_counts.CUTTING] != tick_counts.LEAVES_CUTS
        or first == flight_record.NONE
        or pairs[row + flight_record.HELD] == flight_record.KEPT
    ):
        return False
    pairs[row + flight_record.HELD] = flight_record.KEPT
    _keep_pair(int(first), manifolds, counts)
    carry(body_of(a, flights), flights)
    carry(body_of(b, flights), flights)
    return True


def _begin_anew(h: float, manifolds: Array, flights: Flights, counts: Indices) -> None:
    """Ask all pairs that are not left to the solver once more, from the start of the tick on."""
    pairs, count = flights.pairs, flights.motion.body_count
    for body in range(count):
        flights.records[body * flight_record.SIZE + flight_record.TIME] = flight_record.NOT_LOADED
        flights.links[event_lists.PARENT * count + body] = body
    for event in range(1, counts[tick_counts.EVENTS]):
        row = event * flight_record.EVENT
        pairs[row + flight_record.STRUCK_SO_FAR] = 0.0
        pairs[row + flight_record.INSTANT] = flight_record.NEVER
        if pairs[row + flight_record.HELD] != flight_record.KEPT:
            pairs[row + flight_record.HELD] = flight_record.NONE
    ask_all(h, manifolds, flights, counts)


@inline
def _within(h: float, instant: float) -> float:
    """Return an instant [s], if it is one, within a tick."""
    return min(instant, h) if instant < flight_record.NEVER else instant


def _ask_first(
    row: int, held: float, h: float, manifolds: Array, flights: Flights, counts: Indices
) -> None:
    """
    Ask a pair when it meets, from the start of the tick on; keep its manifold where it is left to
    the solver.

        held : how many of the two the solver moves
    """
    pairs = flights.pairs
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    has_manifold = pairs[row + flight_record.MANIFOLD] != flight_record.NONE
    free = (1.0 if body_a >= 0 else 0.0) + (1.0 if body_b >= 0 else 0.0)
    end = h if held == 0.0 else LATE * h
    kept = False
    if has_manifold and held == free:
        kept = closing_speed(a, b, flights) < speed_of_carried(a, b, h, flights)
    if GROUND and is_ground(b, flights.colliders) and not kept:
        pairs[row + flight_record.HELD] = held
        pairs[row + flight_record.INSTANT] = flight_record.NEVER
        if has_manifold:
            ask_ground_first(row, end, manifolds, flights, counts)
        pairs[row + flight_record.INSTANT] = _within(h, pairs[row + flight_record.INSTANT])
        return
    if not kept:
        found = find_instant(a, b, 0.0, end, row, flights)
        pairs[row + flight_record.INSTANT] = _within(h, pairs[row + flight_record.INSTANT])
        kept = is_left_to_solver(found, a, b, row, flights, counts)
    pairs[row + flight_record.HELD] = held
    if not kept:
        return
    pairs[row + flight_record.INSTANT] = flight_record.NEVER
    pairs[row + flight_record.HELD] = flight_record.KEPT
    if has_manifold:
        _keep_pair(int(pairs[row + flight_record.MANIFOLD]), manifolds, counts)
        carry(body_a, flights)
        carry(body_b, flights)


@inline
def _goes_on(first: int, m: int, manifolds: Array, counts: Indices) -> bool:
    """Tell whether a manifold is of the pair whose first one is given."""
    if m >= counts[tick_counts.MANIFOLDS]:
        return False
    pair = manifolds[first * manifold_record.SIZE + manifold_record.PAIR_ID]
    return math.floor(manifolds[m * manifold_record.SIZE + manifold_record.PAIR_ID]) == (
        math.floor(pair)
    )


@inline
def _keep_pair(first: int, manifolds: Array, counts: Indices) -> None:
    """Leave all manifolds of a pair to the solver."""
    m = first
    while _goes_on(first, m, manifolds, counts):
        manifolds[m * manifold_record.SIZE + manifold_record.STATE] = KEPT
        m += 1


def _ask_ground_first(
    row: int, h: float, manifolds: Array, flights: Flights, counts: Indices
) -> None:
    """
    Ask a body and ground when they meet, from the start of the tick on; the solver keeps the parts
    that carry load, or that it is left.
    """
    pairs = flights.pairs
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    first = int(pairs[row + flight_record.MANIFOLD])
    find_on_ground(a, b, 0.0, h, row, first, manifolds, flights, counts)
    m = first
    while _goes_on(first, m, manifolds, counts):
        if manifolds[m * manifold_record.SIZE + manifold_record.STATE] == KEPT:
            carry(body_of(a, flights), flights)
        m += 1


@kernel
def keep_manifolds(manifolds: Array, counts: Indices) -> None:
    """
    Leave only the manifolds that the solver gets, and none whose points all are hidden; count the
    pieces that they ask for.
    """
    kept, pieces = 0, 1
    for m in range(counts[tick_counts.MANIFOLDS]):
        record = m * manifold_record.SIZE
        hidden = manifolds[record + manifold_record.POINT_COUNT] == 0.0
        if manifolds[record + manifold_record.STATE] != KEPT or hidden:
            continue
        if kept != m:
            for entry in range(manifold_record.LANE):  # the lane stays that of the place
                manifolds[kept * manifold_record.SIZE + entry] = manifolds[record + entry]
        pieces = max(pieces, int(manifolds[record + manifold_record.PIECES]))
        kept += 1
    counts[tick_counts.MANIFOLDS] = kept
    counts[tick_counts.PIECES] = pieces
