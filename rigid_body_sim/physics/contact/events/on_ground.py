# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
When a body in flight meets ground of triangles, and along which normal.

Each facet (all triangles in one plane: `surfaces.surface_records`) is asked as a plane first:

    never reached                                     it is not met, whatever its triangles are
    reached, and something lies over the facet there  it is met, to the last digit as a plane is
    reached beside it, or the body begins behind it   its triangles are asked one by one, each a
                                                      convex body, from that instant on

So a flat part is one surface however it is tiled, and costs what a plane does. A triangle is met
only along a normal that the surface has there (`polyhedron_on_triangle.is_outer`): neither an edge
between two triangles of one plane nor one in a valley is ever struck.

The solver may have some of the parts: facets that carry load, or touch slowly. They are not asked.
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
    pose,
)
from rigid_body_sim.physics.contact.collision.collider import SURFACE
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    END,
    ROOT,
    lies_over,
    list_near,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.polyhedron_on_triangle import (
    is_outer,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    ASKED,
    FACET,
    FACET_OF,
    FLATNESS,
    PLANES,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    COUNT,
    FREE,
    KEY,
    LISTED,
    MOTION,
    QUERY_HIGH,
    QUERY_LOW,
    REST,
    RESULT,
    RESULT_POINTS,
    RESULTS,
    RESULTS_USED,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    NORMAL as FOUND_NORMAL,
)
from rigid_body_sim.physics.contact.collision.ground_misses import is_of, key_of
from rigid_body_sim.physics.contact.collision.nearest_axis import radius_about_core
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.contact_points import ONE_HEIGHT
from rigid_body_sim.physics.contact.events.flight import Flights, pose_of_side
from rigid_body_sim.physics.contact.events.ground_parts import lever_of, plane_of, surface_of
from rigid_body_sim.physics.contact.events.time_of_impact import (
    MEETS,
    MISSES,
    OVERLAP,
    PLACE_ROUND_OFF,
    extremes,
)
from rigid_body_sim.physics.vectors import dot, load, negate, store, subtract

OVER_FACET_GAP = 1e-9  # [-] of the size: separation up to which something lies over a facet
TOGETHER = 1e-9  # [-] of the time: parts met so little apart are compared
NOW = 1e-11  # [s] what meets within it meets now
ALONG = 1e-12  # [-] 1 - cos of an angle of 1e-6: manifolds along one normal
NO_VECTOR = (0.0, 0.0, 0.0)
NO_MANIFOLD = -1
NO_FACET = -1.0
UNASKED = flight_record.NEVER  # of a facet: its triangles need not be asked

KEPT = 1.0  # what becomes of a manifold: the solver has it

collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
find_instant = slot('kernel (a, b, start, end, row, flights): tells whether two meet, and when')
ask_surface = slot('kernel (a, b, margin, flights): finds all manifolds of a body and a surface')
lies_over_facet = slot('kernel (a, b, facet, flights): tells whether something lies over it')
is_left_to_solver = slot('kernel (found, a, b, row, ...): tells whether the solver gets a pair')
take_part = slot('kernel (found, a, b, row, part, ...): takes a part that is met, or keeps it')
find_on_facets = slot('kernel (a, b, start, end, row, ...): asks the facets')
find_on_triangles = slot('kernel (a, b, start, end, row, ...): asks the triangles')
find_on_ground = slot('kernel (a, b, start, end, row, ...): tells whether ground is met, and when')


def _ask_surface(a: int, b: int, margin: float, flights: Flights) -> int:
    """
    Find all manifolds of a body and a surface within a margin [m], in RESULTS of the scratch, and
    return the points of the nearest.
    """
    colliders, found = flights.colliders, flights.found
    row = a * collider_record.SIZE
    surface = surface_of(b, flights.colliders)
    store(found, MOTION, NO_VECTOR)
    found[REST] = margin
    part = colliders.parameters[surface + ASKED]
    colliders.parameters[surface + ASKED] = flight_record.NO_PART
    points = collide(
        colliders.table[row + collider_record.TYPE], SURFACE, colliders.parameters,
        colliders.table[row + collider_record.PARAMETERS], surface, colliders.poses,
        pose_of_side(0, flights), pose_of_side(1, flights), margin, found,
    )  # fmt: skip
    colliders.parameters[surface + ASKED] = part
    return points


@inline
def margin_of(a: int, flights: Flights) -> Any:
    """Separation of what touches, but for rounding, where A was looked at [m]."""
    center = load(flights.views, flight_record.CENTER)
    size = lever_of(a, flights.colliders)
    return max(
        OVER_FACET_GAP * size, 8.0 * PLACE_ROUND_OFF * (size + math.sqrt(dot(center, center)))
    )


def _lies_over_facet(a: int, b: int, facet: float, flights: Flights) -> bool:
    """Tell whether something of a body that touches the plane of a facet lies over the facet."""
    found = flights.found
    ask_surface(a, b, margin_of(a, flights), flights)
    for at in range(RESULTS, RESULTS + RESULT * int(found[RESULTS_USED]), RESULT):
        if found[at + KEY] == facet:
            return True
    return False


@kernel
def _ask_along_way(a: int, span: float, flights: Flights) -> None:
    """Ask for the triangles that a body, as it was looked at, may meet within a time [s]."""
    views, found, bounds = flights.views, flights.found, a * bounds_record.SIZE
    away = subtract(
        load(flights.colliders.local_bounds, bounds + bounds_record.CENTER),
        load(flights.local_poses, a * pose.SIZE + pose.POSITION),
    )
    around = flights.colliders.local_bounds[bounds + bounds_record.RADIUS]
    around += math.sqrt(dot(away, away))
    for axis in range(3):
        begin = views[flight_record.CENTER + axis]
        way = span * views[flight_record.VELOCITY + axis]
        bend = 0.5 * span * span * abs(views[flight_record.ACCELERATION + axis])
        found[QUERY_LOW + axis] = begin - around + min(way, 0.0) - bend
        found[QUERY_HIGH + axis] = begin + around + max(way, 0.0) + bend


@kernel
def _place_of_facet(facet: float, listed: int, views: Array) -> int:
    """Where a facet stands in the list; below 0: it does not."""
    for index in range(listed):
        place = flight_record.FACETS + flight_record.FACET_SIZE * index
        if views[place + flight_record.FACET] == facet:
            return place
    return -1


@kernel
def _list_facets(b: int, flights: Flights) -> int:
    """List the facets of the triangles that are asked for, as many as there is room for."""
    colliders, views = flights.colliders, flights.views
    parameters, surface = colliders.parameters, surface_of(b, colliders)
    count, node = 0, ROOT
    while node != END:
        listed, node = list_near(parameters, surface, node, flights.found)
        for entry in range(LISTED, LISTED + listed):
            facet = parameters[int(flights.found[entry]) + FACET_OF]
            if _place_of_facet(facet, count, views) < 0 and count < flight_record.MOST_FACETS:
                place = flight_record.FACETS + flight_record.FACET_SIZE * count
                views[place + flight_record.FACET] = facet
                views[place + flight_record.LEFT_FROM] = UNASKED
                count += 1
    return count


@inline
def _is_of_part(record: int, facet: float, part: int, surface: int, flights: Flights,
                manifolds: Array) -> bool:  # fmt: skip
    """Tell whether a manifold is of a facet; NO_FACET: of the triangle at a place."""
    if facet >= 0.0:
        return math.floor(key_of(record, manifolds)) == facet
    return is_of(record, part, surface, flights.colliders.parameters, manifolds)


@kernel
def is_kept(
    facet: float, part: int, surface: int, first: int, manifolds: Array, flights: Flights,
    counts: Indices,
) -> bool:  # fmt: skip
    """
    Tell whether the solver has a part already.

        facet : its number; NO_FACET: a triangle is asked, at the place `part`
        first : manifold of the pair; NO_MANIFOLD
    """
    m = first
    while m != NO_MANIFOLD and m < counts[tick_counts.MANIFOLDS]:
        record, begin = m * manifold_record.SIZE, first * manifold_record.SIZE
        if math.floor(manifolds[record]) != math.floor(manifolds[begin]):
            return False
        if (
            manifolds[record + manifold_record.STATE] == KEPT
            and (facet >= 0.0 or key_of(record, manifolds) >= FREE)
            and _is_of_part(record, facet, part, surface, flights, manifolds)
        ):
            return True
        m += 1
    return False


@kernel
def _keep(
    facet: float, part: int, surface: int, first: int, manifolds: Array, flights: Flights,
    counts: Indices,
) -> None:  # fmt: skip
    """Leave what a body may touch of a part to the solver; arguments of `is_kept`."""
    m = first
    while m < counts[tick_counts.MANIFOLDS]:
        record, begin = m * manifold_record.SIZE, first * manifold_record.SIZE
        if math.floor(manifolds[record]) != math.floor(manifolds[begin]):
            return
        if _is_of_part(record, facet, part, surface, flights, manifolds):
            manifolds[record + manifold_record.STATE] = KEPT
        m += 1


def _take_part(
    found: int, a: int, b: int, row: int, part: float, facet: float, first: int,
    manifolds: Array, flights: Flights, counts: Indices,
) -> None:  # fmt: skip
    """
    Leave a part that is met to the solver, if it should have it; else take it, if it is the first
    one so far.
    """
    if found == MISSES:
        return
    pairs, views, best = flights.pairs, flights.views, flight_record.FIRST_PART
    if first != NO_MANIFOLD and is_left_to_solver(found, a, b, row, flights, counts):
        _keep(
            facet, int(part), surface_of(b, flights.colliders), first, manifolds, flights, counts
        )
        return
    instant, approach = pairs[row + flight_record.INSTANT], pairs[row + flight_record.APPROACH]
    so_far = views[best + flight_record.INSTANT]
    if instant < so_far or (instant == so_far and approach > views[best + flight_record.APPROACH]):
        views[best + flight_record.INSTANT] = instant
        views[best + flight_record.APPROACH] = approach
        views[best + flight_record.PART] = part
        views[best + flight_record.HELD] = float(found)
        store(views, best + flight_record.NORMAL, load(pairs, row + flight_record.NORMAL))


@inline
def _end_of(start: float, end: float, views: Array) -> float:
    """Until when a part is of interest [s]: one is met already."""
    so_far = views[flight_record.FIRST_PART + flight_record.INSTANT]
    return min(end, so_far + TOGETHER * (end - start))


def _find_on_facets(
    a: int, b: int, start: float, end: float, row: int, first: int, listed: int,
    manifolds: Array, flights: Flights, counts: Indices,
) -> bool:  # fmt: skip
    """Ask the listed facets as planes; tell whether the triangles of some are to be asked."""
    parameters, pairs, views = flights.colliders.parameters, flights.pairs, flights.views
    surface, left = surface_of(b, flights.colliders), False
    rounding = radius_about_core(a, flights.colliders)
    for index in range(listed):
        place = flight_record.FACETS + flight_record.FACET_SIZE * index
        facet = views[place + flight_record.FACET]
        if is_kept(facet, 0, surface, first, manifolds, flights, counts):
            continue
        plane = surface + int(parameters[surface + PLANES]) + FACET * int(facet)
        parameters[surface + ASKED] = -float(plane)
        look(0, a, start, flights)
        look(1, b, start, flights)
        normal = negate(load(parameters, plane + NORMAL))
        gap, _ = extremes(a, b, normal, NO_VECTOR, 0.0, rounding, flights)
        if gap < -OVERLAP * lever_of(a, flights.colliders):
            views[place + flight_record.LEFT_FROM] = start
            left = True
            continue
        found = find_instant(a, b, start, _end_of(start, end, views), row, flights)
        if found == MISSES:
            continue
        instant = pairs[row + flight_record.INSTANT]
        look(0, a, instant, flights)
        if lies_over_facet(a, b, facet, flights):
            take_part(found, a, b, row, -float(plane), facet, first, manifolds, flights, counts)
        else:
            views[place + flight_record.LEFT_FROM] = instant
            left = True
    return left


def _find_on_triangles(
    a: int, b: int, start: float, end: float, row: int, first: int, listed: int,
    manifolds: Array, flights: Flights, counts: Indices,
) -> None:  # fmt: skip
    """Ask the triangles of the facets that are left, each from where that is."""
    parameters, pairs, views = flights.colliders.parameters, flights.pairs, flights.views
    surface, node = surface_of(b, flights.colliders), ROOT
    struck = load(pairs, row + flight_record.NORMAL)
    look(0, a, start, flights)
    _ask_along_way(a, end - start, flights)
    while node != END:
        count, node = list_near(parameters, surface, node, flights.found)
        for entry in range(LISTED, LISTED + count):
            part = int(flights.found[entry])
            place = _place_of_facet(parameters[part + FACET_OF], listed, views)
            begin = views[place + flight_record.LEFT_FROM] if place >= 0 else start
            until = _end_of(start, end, views)
            if not begin < until or is_kept(
                NO_FACET, part, surface, first, manifolds, flights, counts
            ):
                continue
            parameters[surface + ASKED] = float(part)
            store(views, flight_record.LAST_AXIS, struck)
            found = find_instant(a, b, begin, until, row, flights)
            normal = negate(load(pairs, row + flight_record.NORMAL))
            if found != MISSES and is_outer(normal, parameters, surface, part):
                take_part(
                    found, a, b, row, float(part), NO_FACET, first, manifolds, flights, counts
                )


def _find_on_ground(
    a: int, b: int, start: float, end: float, row: int, first: int, manifolds: Array,
    flights: Flights, counts: Indices,
) -> int:  # fmt: skip
    """
    Tell whether a body meets ground between two instants of the tick [s], and write what
    `find_instant` does into the event, and the part.

        first : manifold of the pair: what the solver should have of it is kept then; NO_MANIFOLD
    """
    parameters, pairs, views = flights.colliders.parameters, flights.pairs, flights.views
    surface, best = surface_of(b, flights.colliders), flight_record.FIRST_PART
    struck = load(pairs, row + flight_record.NORMAL)
    views[best + flight_record.INSTANT] = flight_record.NEVER
    views[best + flight_record.APPROACH] = 0.0
    views[best + flight_record.PART] = flight_record.NO_PART
    views[best + flight_record.HELD] = float(MISSES)
    store(views, best + flight_record.NORMAL, struck)
    look(0, a, start, flights)
    look(1, b, start, flights)
    _ask_along_way(a, end - start, flights)
    listed = _list_facets(b, flights)
    left = listed == flight_record.MOST_FACETS
    if find_on_facets(a, b, start, end, row, first, listed, manifolds, flights, counts):
        left = True
    store(pairs, row + flight_record.NORMAL, struck)
    if left:
        find_on_triangles(a, b, start, end, row, first, listed, manifolds, flights, counts)
    parameters[surface + ASKED] = flight_record.NO_PART
    for field in (flight_record.INSTANT, flight_record.APPROACH, flight_record.PART):
        pairs[row + field] = views[best + field]
    store(pairs, row + flight_record.NORMAL, load(views, best + flight_record.NORMAL))
    return int(views[best + flight_record.HELD])


def _measure_ground(row: int, a: int, b: int, flights: Flights, counts: Indices) -> Any:
    """
    Return gap and approach of an event with ground as both are now; of what meets now the fastest.
    """
    pairs = flights.pairs
    found = find_on_ground(a, b, 0.0, NOW, row, NO_MANIFOLD, flights.found, flights, counts)
    if found == MEETS:
        return 0.0, pairs[row + flight_record.APPROACH]
    return math.inf, 0.0


@kernel
def all_lie_over(b: int, count: int, flights: Flights) -> bool:
    """Tell whether the listed corners of a body that touches a facet as a plane lie over it."""
    parameters, found, views = flights.colliders.parameters, flights.found, flights.views
    surface, plane = surface_of(b, flights.colliders), plane_of(b, flights.colliders)
    if plane < 0:
        return False
    seam, normal = parameters[surface + FLATNESS], load(parameters, plane + NORMAL)
    facet = (plane - surface - int(parameters[surface + PLANES])) // FACET
    for axis in range(3):
        low, high = math.inf, -math.inf
        for index in range(count):
            x = views[flight_record.CORNERS_A + 3 * index + axis]
            low, high = min(low, x), max(high, x)
        found[QUERY_LOW + axis], found[QUERY_HIGH + axis] = low - seam, high + seam
    over, node = 0, ROOT
    while node != END and over != (1 << count) - 1:
        listed, node = list_near(parameters, surface, node, found)
        for entry in range(LISTED, LISTED + listed):
            row = int(found[entry])
            if int(parameters[row + FACET_OF]) != facet:
                continue
            for index in range(count):
                corner = load(views, flight_record.CORNERS_A + 3 * index)
                if lies_over(parameters, row, normal, corner, 0.0, seam, seam):
                    over |= 1 << index
    return over == (1 << count) - 1


def _points_on_ground(a: int, b: int, normal: Any, flights: Flights) -> int:
    """
    List the points at which a body touches ground along a normal, out of all its manifolds; return
    how many.
    """
    found, views = flights.found, flights.views
    ask_surface(a, b, margin_of(a, flights), flights)
    least, count = math.inf, 0
    for turn in range(2):
        for at in range(RESULTS, RESULTS + RESULT * int(found[RESULTS_USED]), RESULT):
            if 1.0 - dot(normal, load(found, at + FOUND_NORMAL)) > ALONG:
                continue
            for index in range(int(found[at + COUNT])):
                point = at + RESULT_POINTS + POINT * index
                if turn == 0:
                    least = min(least, found[point + SEPARATION])
                elif count < flight_record.MOST_POINTS and found[
                    point + SEPARATION
                ] <= least + ONE_HEIGHT * lever_of(a, flights.colliders):
                    position = load(found, point + POSITION)
                    store(views, flight_record.TOUCHING + 3 * count, position)
                    count += 1
    return count
