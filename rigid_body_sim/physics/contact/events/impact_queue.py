# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impacts of a tick, in the order of their instants.

    pairs that carry load, and such as touch slowly  ->  the solver, as without events
                                                         (`loaded_pairs`)
    all others: when do they meet in free flight?        never: they get no contact in this tick
                                                         (`first_instants`)
    the first impact: both bodies to its instant, impulse, then their pairs are asked anew;
    until nobody meets within the tick; then the bodies that were struck go to its end

Impacts at one instant come one after the other, the one with the greatest approach first, then in
the order of the colliders; and again, until nobody approaches. What is apart by no more than the
round-off of its place meets at the same instant.

A body that the solver moves, or on which a force acts that depends on the state or on time, cannot
fly by itself; where the scene has such forces on others does not matter to it. What meets it, and
what is about to rest, asks for a cut: the tick of its island is then advanced in pieces
that end at the impacts (`cuts`).
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.events import (
    event_lists,
    flight_record,
)
from rigid_body_sim.physics.contact.events.event_lists import following
from rigid_body_sim.physics.contact.events.first_instants import keep_manifolds, leaves
from rigid_body_sim.physics.contact.events.flight import Flights, body_of, put_down, take_off
from rigid_body_sim.physics.contact.events.ground_parts import is_ground
from rigid_body_sim.physics.contact.events.impact import material_of
from rigid_body_sim.physics.contact.events.loaded_pairs import (
    is_not_in_flight,
    mark_loaded,
)
from rigid_body_sim.physics.contact.events.on_ground import NO_MANIFOLD
from rigid_body_sim.physics.contact.events.pair_events import (
    MOST_IMPACTS,
    room_for_impacts,
    take_listed,
)
from rigid_body_sim.physics.contact.islands.union_find import find, unite

GROUND = slot('[-] whether some collider is ground of triangles')
bring = slot('kernel (body, time, flights): takes a body in flight to an instant')
find_instant = slot('kernel (a, b, start, end, row, flights): tells whether two meet, and when')
find_on_ground = slot('kernel (a, b, start, end, row, ...): tells whether ground is met, and when')
strike = slot('kernel (row, time, threshold, tick, number, flights): lets two meet')
find_events = slot('kernel (h, pair_ids, manifolds, flights, counts): asks all pairs')
follow_impacts = slot('kernel (tick, h, manifolds, flights, counts): lets impact follow impact')
begin_anew = slot('kernel (h, manifolds, flights, counts): asks all pairs once more')
wants_a_cut = slot('kernel (row, a, b, flights): tells whether an impact wants a cut')
ask_again = slot('kernel (body, time, h, flights, counts): asks the pairs of a body anew')
ask_neighbours = slot(
    'kernel (body, time, h, flights, counts): finds whom a struck body may reach'
)


@inline
def _earliest(flights: Flights, counts: Indices) -> int:
    """Find the next event, see the module; NO_EVENT: there is none."""
    pairs, best = flights.pairs, event_lists.NO_EVENT
    least, most = flight_record.NEVER, -math.inf
    for event in range(1, counts[tick_counts.EVENTS]):
        least = min(least, pairs[event * flight_record.EVENT + flight_record.INSTANT])
    if least == flight_record.NEVER:
        return best
    for event in range(1, counts[tick_counts.EVENTS]):
        row = event * flight_record.EVENT
        approach, later = pairs[row + flight_record.APPROACH], pairs[row + flight_record.INSTANT]
        later -= least
        is_now = later == 0.0 or (
            approach >= pairs[row + flight_record.SLOW]
            and later * approach <= pairs[row + flight_record.NO_GAP]
        )
        if is_now and approach > most:
            best, most = event, approach
    return best


@inline
def _concern(body: int, flights: Flights) -> None:
    if body >= 0:
        count = flights.motion.body_count
        root = find(body, flights.links)
        flights.links[event_lists.CONCERNED * count + root] = 1


@inline
def _is_concerned(body: int, flights: Flights) -> bool:
    if body < 0:
        return False
    count = flights.motion.body_count
    root = find(body, flights.links)
    return flights.links[event_lists.CONCERNED * count + root] == 1


@inline
def _join(body_a: int, body_b: int, flights: Flights) -> None:
    """Note that two bodies met."""
    if body_a < 0 or body_b < 0:
        return
    concerned = _is_concerned(body_a, flights) or _is_concerned(body_b, flights)
    unite(body_a, body_b, flights.links)
    if concerned:
        _concern(body_a, flights)


@inline
def _rests_then(a: int, b: int, flights: Flights, counts: Indices) -> bool:
    """
    Tell whether two do not part after their impact, where a cut can be made: from there on they
    are the solver's. To find that instant by what is left of their approach would be to divide
    round-off by round-off.
    """
    restitution, _ = material_of(a, b, flights)
    return restitution == 0.0 and counts[tick_counts.CUTTING] != tick_counts.LEAVES_CUTS


def _wants_a_cut(row: int, a: int, b: int, flights: Flights) -> bool:
    """Tell whether an impact is none that bodies in flight have among themselves."""
    pairs = flights.pairs
    return (
        is_not_in_flight(a, flights)
        or is_not_in_flight(b, flights)
        or pairs[row + flight_record.APPROACH] < pairs[row + flight_record.SLOW]
        or pairs[row + flight_record.STRUCK_SO_FAR] >= MOST_IMPACTS
    )


def _ask_again(body: int, time: float, h: float, flights: Flights, counts: Indices) -> None:
    """Ask the pairs of a body anew when they meet, from an instant on."""
    if body < 0:
        return
    pairs, count = flights.pairs, flights.motion.body_count
    entry = flights.links[event_lists.FIRST * count + body]
    while entry > 1:
        row = entry // 2 * flight_record.EVENT
        a = int(pairs[row + flight_record.COLLIDER_A])
        b = int(pairs[row + flight_record.COLLIDER_B])
        if pairs[row + flight_record.LOADED] != flight_record.NONE:
            entry = following(entry, count, flights.links)
            continue
        start = time
        for collider in (a, b):
            other = body_of(collider, flights)
            if other >= 0:
                take_off(other, flights)
                place = other * flight_record.SIZE + flight_record.TIME
                start = max(start, flights.records[place])
        if GROUND and is_ground(b, flights.colliders):
            find_on_ground(a, b, start, h, row, NO_MANIFOLD, flights.found, flights, counts)
        else:
            find_instant(a, b, start, h, row, flights)
        entry = following(entry, count, flights.links)


def _follow_impacts(
    tick: float, h: float, manifolds: Array, flights: Flights, counts: Indices
) -> bool:
    """
    Let impact follow impact. Tell whether there was room in all lists; counts[CUTS] tells whether
    a cut is wanted, and event 0 where. Where none is made it tells that one more pair is left to
    the solver, from the start of the tick on.
    """
    pairs = flights.pairs
    counts[tick_counts.CUTS] = 0
    while True:
        event = _earliest(flights, counts)
        if event == event_lists.NO_EVENT:
            return True
        row = event * flight_record.EVENT
        a = int(pairs[row + flight_record.COLLIDER_A])
        b = int(pairs[row + flight_record.COLLIDER_B])
        body_a, body_b = body_of(a, flights), body_of(b, flights)
        late = _is_concerned(body_a, flights) or _is_concerned(body_b, flights)
        if late or wants_a_cut(row, a, b, flights) or _rests_then(a, b, flights, counts):
            if leaves(row, a, b, manifolds, flights, counts):
                counts[tick_counts.CUTS] = 1
                return True
            if counts[tick_counts.CUTTING] == tick_counts.ASKS_FOR_CUTS:
                if counts[tick_counts.CUTS] == 0:
                    for entry in range(flight_record.EVENT):
                        pairs[entry] = pairs[row + entry]
                counts[tick_counts.CUTS] += 1
                _concern(body_a, flights)
                _concern(body_b, flights)
            _join(body_a, body_b, flights)
            pairs[row + flight_record.INSTANT] = flight_record.NEVER
            continue
        if counts[tick_counts.IMPACTS] >= room_for_impacts(flights, counts):
            counts[tick_counts.STATUS] = tick_counts.SHORT_OF_IMPACTS
            return False
        time = pairs[row + flight_record.INSTANT]
        number = counts[tick_counts.IMPACTS]
        listed = strike(row, time, pairs[row + flight_record.SLOW], tick, number, flights)
        take_listed(row, listed, flights, counts)
        pairs[row + flight_record.STRUCK_SO_FAR] += 1.0
        _join(body_a, body_b, flights)
        for body in (body_a, body_b):
            if body >= 0 and not ask_neighbours(body, time, h, flights, counts):
                counts[tick_counts.STATUS] = tick_counts.SHORT_OF_EVENTS
                return False
        ask_again(body_a, time, h, flights, counts)
        ask_again(body_b, time, h, flights, counts)


def _find_impacts(
    tick: float, h: float, cache: Array, pair_ids: Indices, manifolds: Array, flights: Flights,
    counts: Indices,
) -> bool:  # fmt: skip
    """
    Find the impacts of a tick and follow the bodies that fly through it; the solver is left the
    manifolds of the others. Tell whether the tick can go on; else counts[STATUS] tells why.

        cache : see `cache_record`;   pair_ids : that may meet;   manifolds : of the tick
    """
    count = flights.motion.body_count
    event_lists.clear(count, flights.links)
    flights.views[flight_record.UNDECIDED] = 0.0
    for body in range(count):
        flights.records[body * flight_record.SIZE + flight_record.TIME] = flight_record.NOT_LOADED
    before = counts[tick_counts.IMPACTS]
    counts[tick_counts.EVENTS] = 1
    if not mark_loaded(h, manifolds, cache, flights, counts) or not find_events(
        h, pair_ids, manifolds, flights, counts
    ):
        counts[tick_counts.STATUS] = tick_counts.SHORT_OF_EVENTS
        return False
    while True:
        if not follow_impacts(tick, h, manifolds, flights, counts):
            counts[tick_counts.IMPACTS] = before
            return False
        if counts[tick_counts.CUTTING] != tick_counts.LEAVES_CUTS:
            break
        if counts[tick_counts.CUTS] == 0:
            break
        counts[tick_counts.IMPACTS] = before
        begin_anew(h, manifolds, flights, counts)
    if counts[tick_counts.CUTS] > 0:
        counts[tick_counts.IMPACTS] = before
        counts[tick_counts.STATUS] = tick_counts.CUT
        return False
    keep_manifolds(manifolds, counts)
    return True


def _land(h: float, flights: Flights) -> None:
    """Take the bodies that were struck to the end of the tick, and back to the blocks."""
    records = flights.records
    for body in range(flights.motion.body_count):
        row = body * flight_record.SIZE
        if (
            records[row + flight_record.TIME] != flight_record.NOT_LOADED
            and records[row + flight_record.STRUCK] == 1.0
        ):
            bring(body, h, flights)
            put_down(body, flights)
