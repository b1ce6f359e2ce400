# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The events of a tick: pairs that may meet in it, each with its instant and the approach below which
they do not meet in an impact (`flight_record.event`); the room for them, and what impacts list.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies, tick_counts, tick_settings
from rigid_body_sim.physics.contact.collision import collider_record, swept_aabbs
from rigid_body_sim.physics.contact.events import flight_record, impact_list, joint_impact_record
from rigid_body_sim.physics.contact.events.event_lists import enter
from rigid_body_sim.physics.contact.events.flight import Flights, body_of
from rigid_body_sim.physics.contact.events.ground_parts import lever_of
from rigid_body_sim.physics.contact.events.impact import material_of
from rigid_body_sim.physics.contact.events.time_of_impact import PLACE_ROUND_OFF
from rigid_body_sim.physics.vectors import dot, load, store

NOTHING = 1e-9  # [-] of an approach, which is not met where the two touch
MOST_IMPACTS = 64  # [-] of a pair in a tick; then it is about to rest
NO_VECTOR = (0.0, 0.0, 0.0)


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
def speed_of_carried(a: int, b: int, h: float, flights: Flights) -> Any:
    """The same of two that the solver holds [m/s]: what it may leave of their motion."""
    slow = flights.settings[tick_settings.RESTITUTION_THRESHOLD]
    for collider in (a, b):
        row = collider_record.solver_body(collider, flights.colliders.table)
        place = row * solver_bodies.SIZE + solver_bodies.FREE_ACCELERATION
        force = load(flights.bodies, place)
        slow = max(slow, math.sqrt(dot(force, force)) * h)
    return slow


@inline
def has_room_for_event(counts: Indices) -> bool:
    """Tell whether the list of events takes one more."""
    return counts[tick_counts.EVENTS] < counts[tick_counts.EVENT_ROOM]


@inline
def room_for_impacts(flights: Flights, counts: Indices) -> int:
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
def add_event(a: int, b: int, h: float, flights: Flights, counts: Indices) -> int:
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
def take_listed(row: int, listed: int, flights: Flights, counts: Indices) -> None:
    """
    Count what an impact has listed, if it has an impulse. Of a pair of whose approach it takes
    nothing it was the last one: where the two touch they do not approach.
    """
    taken = _share_taken(row, counts[tick_counts.IMPACTS], flights)
    if taken <= NOTHING:
        flights.pairs[row + flight_record.STRUCK_SO_FAR] = float(MOST_IMPACTS)
    if listed > 1 or taken > 0.0:
        counts[tick_counts.IMPACTS] += listed
