# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The free points of a manifold that carries load elsewhere: the other edge of a box that rocks.

The solver moves such a pair. Those of its points that carry nothing, are apart and come nearer
faster than the solver leaves anything are hidden from it and fly along with the body; where one of
them may arrive within the tick that is an event, and the tick is cut there (`cuts`). Then all of
them that have arrived strike at once, together with the points that carry load
(`joint.meet_with_load`).
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FEATURE,
    MOST,
    NORMAL,
    POINT,
    POINTS,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    COUNT as RESULT_COUNT,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    NORMAL as RESULT_NORMAL,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    RESULT_POINTS,
)
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.flight import Flights, body_of, pose_of_side
from rigid_body_sim.physics.contact.events.ground_parts import is_ground, lever_of, result_of
from rigid_body_sim.physics.contact.events.impact import velocity_at
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.vectors import add, cross, dot, load, scale, store, subtract

FREE_POINT_GAP = 0.05  # [-] of the size: separation up to which free points are looked for
TOUCHES = 1e-9  # [-] of the size: what is nearer at the start of a tick is the solver's
TOGETHER = (
    1e-6  # [-] of the size: points that differ by less, the sink of their pair, arrive at once
)
LATER = 2.0  # [-] of the free acceleration: what may bring a point nearer within the tick

GROUND = slot('[-] whether some collider is ground of triangles')
collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
ask_surface = slot('kernel (a, b, margin, flights): finds all manifolds of a body and a surface')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
find_manifold = slot('kernel (a, b, pair_id, near, flights): finds a manifold as both are now')


@inline
def pushes(feature: float, entry: int, least: float, cache: Array) -> bool:
    """Tell whether a manifold of the cache has a feature that pushes by more [N s]."""
    for index in range(int(cache[entry + cache_record.POINTS])):
        place = entry + cache_record.MANIFOLD_HEAD + index * cache_record.POINT_SIZE
        if (
            cache[place + cache_record.FEATURE] == feature
            and cache[place + cache_record.NORMAL_IMPULSE] > least
        ):
            return True
    return False


@inline
def _velocity(collider: int, point: Any, flights: Flights) -> Any:
    """Velocity of a collider at a point at the start of the tick [m/s]."""
    row = collider_record.solver_body(collider, flights.colliders.table) * solver_bodies.SIZE
    bodies = flights.bodies
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    velocity = scale(bodies[row + solver_bodies.INVERSE_MASS], momentum)
    arm = subtract(point, load(bodies, row + solver_bodies.START_POSITION))
    return add(velocity, cross(solver_bodies.surface_spin(row, bodies), arm))


@kernel
def hide_free_points(
    record: int, entry: int, slow: float, h: float, cache: Array, manifolds: Array,
    flights: Flights,
) -> Any:  # fmt: skip
    """
    Take the free points out of a manifold; return how soon one of them may arrive [s], NEVER: not
    in this tick, and at what speed [m/s].

        record, entry : where it begins, in the list and in the cache
        slow          : [m/s] what comes nearer more slowly is the solver's
    """
    a = int(manifolds[record + manifold_record.COLLIDER_A])
    b = int(manifolds[record + manifold_record.COLLIDER_B])
    normal = load(manifolds, record + manifold_record.NORMAL)
    touches = TOUCHES * (lever_of(a, flights.colliders) + lever_of(b, flights.colliders))
    soonest, speed, kept = flight_record.NEVER, 0.0, 0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        gap = manifolds[place + SEPARATION]
        if gap > touches and not pushes(manifolds[place + FEATURE], entry, 0.0, cache):
            point = load(manifolds, place + POSITION)
            away = subtract(_velocity(b, point, flights), _velocity(a, point, flights))
            approach = -dot(normal, away)
            if approach > slow:
                if gap < (approach + LATER * slow) * h and gap < soonest * approach:
                    soonest, speed = min(gap / approach, h), approach
                continue
        if kept != index:
            target = record + manifold_record.POINTS + POINT * kept
            for entry_of_point in range(POINT):
                manifolds[target + entry_of_point] = manifolds[place + entry_of_point]
        kept += 1
    manifolds[record + manifold_record.POINT_COUNT] = float(kept)
    return soonest, speed


@kernel
def entry_of(pair_id: float, cache: Array) -> int:
    """Where the manifold of a pair id begins in the cache; below 0: it is not there."""
    entry = cache_record.HEAD
    for _manifold in range(int(cache[cache_record.MANIFOLDS])):
        if cache[entry + cache_record.PAIR_ID] == pair_id:
            return entry
        entry = cache_record.next_entry(entry, cache)
    return -1


def _find_manifold(a: int, b: int, pair_id: float, near: float, flights: Flights) -> Any:
    """
    Find the manifold of a pair that carries load as both are now; return where its normal and its
    points begin in the scratch, and how many there are.

        near : [-] of the size: separation up to which it is looked for
    """
    colliders, found = flights.colliders, flights.found
    look(0, a, 0.0, flights)
    look(1, b, 0.0, flights)
    margin = near * (lever_of(a, colliders) + lever_of(b, colliders))
    if GROUND and is_ground(b, colliders):
        ask_surface(a, b, margin, flights)
        at = result_of(pair_id, found)
        if at < 0:
            return NORMAL, POINTS, 0
        return at + RESULT_NORMAL, at + RESULT_POINTS, min(int(found[at + RESULT_COUNT]), MOST)
    row_a, row_b = a * collider_record.SIZE, b * collider_record.SIZE
    count = collide(
        colliders.table[row_a + collider_record.TYPE],
        colliders.table[row_b + collider_record.TYPE], colliders.parameters,
        colliders.table[row_a + collider_record.PARAMETERS],
        colliders.table[row_b + collider_record.PARAMETERS], colliders.poses,
        pose_of_side(0, flights), pose_of_side(1, flights), margin, found,
    )  # fmt: skip
    return NORMAL, POINTS, min(count, MOST)


@inline
def _approach_at(row: int, normal: Any, point: Any, flights: Flights) -> Any:
    """Return the approach of a pair, as it was looked at, at a point [m/s]."""
    pairs = flights.pairs
    body_a = body_of(int(pairs[row + flight_record.COLLIDER_A]), flights)
    body_b = body_of(int(pairs[row + flight_record.COLLIDER_B]), flights)
    velocity_a, _ = velocity_at(0, body_a, point, flights)
    velocity_b, _ = velocity_at(1, body_b, point, flights)
    return -dot(normal, subtract(velocity_b, velocity_a))


def _measure_free_points(row: int, cache: Array, flights: Flights) -> Any:
    """
    Return gap and approach of that free point of an event which arrives first; write the normal.
    """
    found, pairs = flights.found, flights.pairs
    pair_id = pairs[row + flight_record.LOADED]
    entry = entry_of(pair_id, cache)
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    normals, places, count = find_manifold(a, b, pair_id, FREE_POINT_GAP, flights)
    normal = load(found, normals)
    store(pairs, row + flight_record.NORMAL, normal)
    first_gap, first_speed = math.inf, 0.0
    for index in range(count):
        place = places + POINT * index
        if entry >= 0 and pushes(found[place + FEATURE], entry, 0.0, cache):
            continue
        approach = _approach_at(row, normal, load(found, place + POSITION), flights)
        gap = found[place + SEPARATION]
        if approach > 0.0 and not gap * first_speed >= first_gap * approach:
            first_gap, first_speed = gap, approach
    return first_gap, first_speed


def _list_free_points(row: int, cache: Array, flights: Flights) -> int:
    """List the free points of an event that have arrived; return how many."""
    found, pairs, count = flights.found, flights.pairs, 0
    colliders = flights.colliders
    pair_id = pairs[row + flight_record.LOADED]
    entry = entry_of(pair_id, cache)
    a, b = int(pairs[row + flight_record.COLLIDER_A]), int(pairs[row + flight_record.COLLIDER_B])
    normals, places, points = find_manifold(a, b, pair_id, FREE_POINT_GAP, flights)
    normal = load(found, normals)
    touches = TOGETHER * (lever_of(a, colliders) + lever_of(b, colliders))
    for index in range(points):
        place = places + POINT * index
        point = load(found, place + POSITION)
        if (
            found[place + SEPARATION] <= touches
            and not (entry >= 0 and pushes(found[place + FEATURE], entry, 0.0, cache))
            and _approach_at(row, normal, point, flights) > 0.0
        ):
            store(flights.views, flight_record.TOUCHING + 3 * count, point)
            count += 1
    return count
