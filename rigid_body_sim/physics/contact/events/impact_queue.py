# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impacts of a tick, in the order of their instants.

    pairs that carry load, and such as touch slowly  ->  the solver, as without events
    all others: when do they meet in free flight?        never: they get no contact in this tick
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
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import solver_bodies, tick_counts, tick_settings
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import PLANE, SURFACE
from rigid_body_sim.physics.contact.collision.nearest_axis import radius_about_core
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET
from rigid_body_sim.physics.contact.events import (
    event_lists,
    flight_record,
    impact_list,
    joint_impact_record,
)
from rigid_body_sim.physics.contact.events.closest_axis import turn_of_axis
from rigid_body_sim.physics.contact.events.event_lists import enter, following
from rigid_body_sim.physics.contact.events.flight import Flights, body_of, put_down, take_off
from rigid_body_sim.physics.contact.events.flush_faces import is_of_same_bodies
from rigid_body_sim.physics.contact.events.free_points import hide_free_points
from rigid_body_sim.physics.contact.events.ground_parts import ask_part, is_ground, lever_of
from rigid_body_sim.physics.contact.events.impact import material_of
from rigid_body_sim.physics.contact.events.joint import NO_LOAD
from rigid_body_sim.physics.contact.events.on_ground import NO_MANIFOLD
from rigid_body_sim.physics.contact.events.time_of_impact import (
    MISSES,
    PLACE_ROUND_OFF,
    STAYS,
    extremes,
)
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.vectors import dot, load, store, subtract

NOTHING = 1e-9  # [-] of an approach, which is not met where the two touch
MOST_IMPACTS = 64  # [-] of a pair in a tick; then it is about to rest
LATE = (
    1.5  # [-] of the tick: so far is asked ahead of what the solver moves, whose forces bend its
)
# way; what does not arrive within the tick is no impact of it (`cuts`)
AHEAD = 1e-12  # [s] extreme points of then are those of now
TOUCHES = 1e-11  # [-] of the size: a smaller gap is none
ROOMY = 2.0  # [-] of the way that a struck body may go: so far its neighbours are looked for

NO_VECTOR = (0.0, 0.0, 0.0)
KEPT, DROPPED = 1.0, 0.0  # what becomes of a manifold

GROUND = slot('[-] whether some collider is ground of triangles')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
bring = slot('kernel (body, time, flights): takes a body in flight to an instant')
axis = slot('kernel (a, b, flights): the axis along which two colliders are farthest apart')
measure_free_points = slot('kernel (row, cache, flights): gap and approach of free points')
measure = slot('kernel (row, cache, flights, counts): gap and approach of a pair as it is now')
meet_with_load = slot(
    'kernel (row, threshold, number, cache, flights): lets two meet with their load'
)
next_of_cluster = slot('kernel (cache, flights, counts): the pair that meets next at this instant')
find_instant = slot('kernel (a, b, start, end, row, flights): tells whether two meet, and when')
find_on_ground = slot('kernel (a, b, start, end, row, ...): tells whether ground is met, and when')
measure_ground = slot('kernel (row, a, b, flights, counts): approach of what touches ground now')
strike = slot('kernel (row, time, threshold, tick, number, flights): lets two meet')
find_flush = slot('kernel (row, cache, flights, counts): notes pairs of the same two bodies')
find_events = slot('kernel (h, pair_ids, manifolds, flights, counts): asks all pairs')
follow_impacts = slot('kernel (tick, h, manifolds, flights, counts): lets impact follow impact')
ask_all = slot('kernel (h, manifolds, flights, counts): asks all pairs, and who is held anew')
begin_anew = slot('kernel (h, manifolds, flights, counts): asks all pairs once more')
closing_speed = slot('kernel (a, b, flights): bound of the speed of two against each other')
is_left_to_solver = slot('kernel (found, a, b, row, ...): tells whether the solver gets a pair')
wants_a_cut = slot('kernel (row, a, b, flights): tells whether an impact wants a cut')
ask_first = slot('kernel (row, held, h, ...): asks a pair from the start of the tick on')
ask_ground_first = slot('kernel (row, h, manifolds, flights, counts): the same of ground')
ask_again = slot('kernel (body, time, h, flights, counts): asks the pairs of a body anew')
ask_neighbours = slot(
    'kernel (body, time, h, flights, counts): finds whom a struck body may reach'
)


@inline
def _is_carried(body: int, flights: Flights) -> bool:
    count = flights.motion.body_count
    return body >= 0 and flights.links[event_lists.CARRIED * count + body] == 1


@inline
def _carry(body: int, flights: Flights) -> None:
    """Note that the solver moves a body: it does not fly."""
    count = flights.motion.body_count
    if body >= 0 and flights.links[event_lists.CARRIED * count + body] == 0:
        flights.links[event_lists.CARRIED * count + body] = 1
        flights.records[body * flight_record.SIZE + flight_record.TIME] = flight_record.NOT_LOADED


@inline
def _is_pulled(body: int, flights: Flights) -> bool:
    """Tell whether a force acts on a body that no flight in closed form has."""
    if body < 0:
        return False
    count = flights.motion.body_count
    return flights.links[event_lists.PULLED * count + body] == 1


@inline
def _held(a: int, b: int, flights: Flights) -> float:
    """Count the colliders of a pair whose bodies the solver moves."""
    held = 1.0 if _is_carried(body_of(a, flights), flights) else 0.0
    return held + (1.0 if _is_carried(body_of(b, flights), flights) else 0.0)


@inline
def _moves(collider: int, body: int, flights: Flights) -> bool:
    """Tell whether a collider that does not move freely is moved as told."""
    row = collider_record.solver_body(collider, flights.colliders.table) * solver_bodies.SIZE
    return body < 0 and flights.bodies[row + solver_bodies.INVERSE_MASS] != 0.0


@inline
def _is_covered(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold of the list is one without points that another one covers."""
    return bool(manifolds[record + manifold_record.PIECES] == manifold_record.COVERED)


@kernel
def _is_carried_before(record: int, manifolds: Array, counts: Indices) -> bool:
    """
    Tell whether something that covers a manifold carries load: then the two do not meet, for it
    keeps the body in front of a plane behind which the other one lies. What sinks in meanwhile
    would strike the side of a flush tile else.
    """
    if not _is_covered(record, manifolds):
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
        if _is_covered(record, manifolds):
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
            _carry(body_of(int(manifolds[record + manifold_record.COLLIDER_A]), flights), flights)
            _carry(body_of(int(manifolds[record + manifold_record.COLLIDER_B]), flights), flights)
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
    slow = _speed_of_carried(a, b, h, flights)
    instant, approach = hide_free_points(record, entry, slow, h, cache, manifolds, flights)
    if manifolds[record + manifold_record.POINT_COUNT] == 0.0:
        manifolds[record + manifold_record.STATE] = DROPPED
    if instant == flight_record.NEVER:
        return True
    if not _room_for_event(flights, counts):
        return False
    row = _add_event(a, b, h, flights, counts) * flight_record.EVENT
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


@kernel
def _speed_that_counts(a: int, b: int, h: float, flights: Flights) -> Any:
    """
    Return the approach below which two colliders do not meet in an impact [m/s]: where something
    bounces, that of the settings; else what forces do in a tick.
    """
    slow = flights.settings[tick_settings.IMPACT_SPEED]
    restitution, _ = material_of(a, b, flights)
    if restitution == 0.0:
        most = 0.0
        for collider in (a, b):
            row = collider_record.solver_body(collider, flights.colliders.table)
            place = row * solver_bodies.SIZE + solver_bodies.FREE_ACCELERATION
            force = load(flights.bodies, place)
            most = max(most, math.sqrt(dot(force, force)))
        slow = max(slow, most * h)
    return slow


@kernel
def _speed_of_carried(a: int, b: int, h: float, flights: Flights) -> Any:
    """The same of two that the solver holds [m/s]: what it may leave of their motion."""
    slow = flights.settings[tick_settings.RESTITUTION_THRESHOLD]
    for collider in (a, b):
        row = collider_record.solver_body(collider, flights.colliders.table)
        place = row * solver_bodies.SIZE + solver_bodies.FREE_ACCELERATION
        force = load(flights.bodies, place)
        slow = max(slow, math.sqrt(dot(force, force)) * h)
    return slow


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


@inline
def _room_for_event(flights: Flights, counts: Indices) -> bool:
    return counts[tick_counts.EVENTS] < counts[tick_counts.EVENT_ROOM]


@inline
def _room_for_impacts(flights: Flights, counts: Indices) -> int:
    """How long the list of impacts may be before those of one instant have no room in it."""
    of_one = len(flights.joint_points) // joint_impact_record.POINT_SIZE
    return counts[tick_counts.IMPACT_ROOM] - of_one


@inline
def _no_gap(a: int, b: int, flights: Flights) -> Any:
    """Return the gap of two colliders that is but round-off of their places [m]."""
    place = load(flights.colliders.swept_aabbs, a * swept_aabbs.SIZE + swept_aabbs.CENTER)
    size = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
    return PLACE_ROUND_OFF * (size + math.sqrt(dot(place, place)))


@inline
def _add_event(a: int, b: int, h: float, flights: Flights, counts: Indices) -> int:
    """Add a pair to the events; return its number."""
    event = counts[tick_counts.EVENTS]
    counts[tick_counts.EVENTS] = event + 1
    row, pairs = event * flight_record.EVENT, flights.pairs
    pairs[row + flight_record.COLLIDER_A] = float(a)
    pairs[row + flight_record.COLLIDER_B] = float(b)
    pairs[row + flight_record.STRUCK_SO_FAR] = 0.0
    pairs[row + flight_record.INSTANT] = flight_record.NEVER
    pairs[row + flight_record.APPROACH] = 0.0
    pairs[row + flight_record.SLOW] = _speed_that_counts(a, b, h, flights)
    pairs[row + flight_record.NO_GAP] = _no_gap(a, b, flights)
    pairs[row + flight_record.MANIFOLD] = flight_record.NONE
    pairs[row + flight_record.HELD] = flight_record.NONE
    pairs[row + flight_record.PART] = flight_record.NO_PART
    pairs[row + flight_record.LOADED] = flight_record.NONE
    store(pairs, row + flight_record.NORMAL, NO_VECTOR)
    count = flights.motion.body_count
    enter(event, body_of(a, flights), 0, count, flights.links)
    enter(event, body_of(b, flights), 1, count, flights.links)
    return event


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
    return (
        _is_pulled(body_a, flights)
        or _is_pulled(body_b, flights)
        or _is_carried(body_a, flights)
        or _is_carried(body_b, flights)
        or _moves(a, body_a, flights)
        or _moves(b, body_b, flights)
    )


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
            if _is_covered(m * manifold_record.SIZE, manifolds):  # the only one of its pair
                covered = _is_carried_before(m * manifold_record.SIZE, manifolds, counts)
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
                _carry(body_of(a, flights), flights)
                _carry(body_of(b, flights), flights)
            continue
        if not _room_for_event(flights, counts):
            return False
        row = _add_event(a, b, h, flights, counts) * flight_record.EVENT
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
            held, before = _held(a, b, flights), flights.pairs[row + flight_record.HELD]
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
    _carry(body_of(a, flights), flights)
    _carry(body_of(b, flights), flights)
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
        kept = closing_speed(a, b, flights) < _speed_of_carried(a, b, h, flights)
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
        _carry(body_a, flights)
        _carry(body_b, flights)


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
            _carry(body_of(a, flights), flights)
        m += 1


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
    body_a, body_b = body_of(a, flights), body_of(b, flights)
    return (
        _is_pulled(body_a, flights)
        or _is_pulled(body_b, flights)
        or _is_carried(body_a, flights)
        or _is_carried(body_b, flights)
        or _moves(a, body_a, flights)
        or _moves(b, body_b, flights)
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
        if counts[tick_counts.IMPACTS] >= _room_for_impacts(flights, counts):
            counts[tick_counts.STATUS] = tick_counts.SHORT_OF_IMPACTS
            return False
        time = pairs[row + flight_record.INSTANT]
        number = counts[tick_counts.IMPACTS]
        listed = strike(row, time, pairs[row + flight_record.SLOW], tick, number, flights)
        _take_listed(row, listed, flights, counts)
        pairs[row + flight_record.STRUCK_SO_FAR] += 1.0
        _join(body_a, body_b, flights)
        for body in (body_a, body_b):
            if body >= 0 and not ask_neighbours(body, time, h, flights, counts):
                counts[tick_counts.STATUS] = tick_counts.SHORT_OF_EVENTS
                return False
        ask_again(body_a, time, h, flights, counts)
        ask_again(body_b, time, h, flights, counts)


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
def _is_ignored(a: int, b: int, count: int, ignored: Indices) -> bool:
    """Tell whether the scene says that a pair does not meet."""
    pair_id = max(a, b) * count + min(a, b)
    low, high = 0, len(ignored)
    while low < high:
        middle = (low + high) // 2
        if ignored[middle] < pair_id:
            low = middle + 1
        else:
            high = middle
    return low < len(ignored) and ignored[low] == pair_id


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
            if _is_ignored(a, b, count, flights.ignored) or _lists_pair(body, a, b, flights):
                continue
            if not _room_for_event(flights, counts):
                return False
            _add_event(a, b, h, flights, counts)
    return True


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


@inline
def _share_taken(row: int, number: int, flights: Flights) -> float:
    """About which share of the approach of a pair an impact of the list takes; 0: no impulse."""
    pairs, inverse_mass = flights.pairs, 0.0
    for collider in (flight_record.COLLIDER_A, flight_record.COLLIDER_B):
        body = body_of(int(pairs[row + collider]), flights)
        if body >= 0:
            place = body * flight_record.SIZE + flight_record.INVERSE_MASS
            inverse_mass += flights.records[place]
    impulse = load(flights.impacts, number * impact_list.SIZE + impact_list.IMPULSE)
    taken = inverse_mass * math.sqrt(dot(impulse, impulse))
    return taken / pairs[row + flight_record.APPROACH] if taken > 0.0 else 0.0


@inline
def _take_listed(row: int, listed: int, flights: Flights, counts: Indices) -> None:
    """
    Count what an impact has listed, if it has an impulse. Of a pair of whose approach it takes
    nothing it was the last one: where the two touch they do not approach.
    """
    taken = _share_taken(row, counts[tick_counts.IMPACTS], flights)
    if taken <= NOTHING:
        flights.pairs[row + flight_record.STRUCK_SO_FAR] = float(MOST_IMPACTS)
    if listed > 1 or taken > 0.0:
        counts[tick_counts.IMPACTS] += listed


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
    while counts[tick_counts.IMPACTS] < _room_for_impacts(flights, counts):
        if pairs[row + flight_record.APPROACH] > 0.0:
            slow = pairs[row + flight_record.SLOW]
            number = counts[tick_counts.IMPACTS]
            find_flush(row, cache, flights, counts)
            listed = meet_with_load(row, slow, number, cache, flights)
            if listed == NO_LOAD:
                listed = strike(row, 0.0, slow, 0.0, number, flights)
            _take_listed(row, listed, flights, counts)
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
