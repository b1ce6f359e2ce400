# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Parts of ground of triangles, as events take them: a facet is a plane, a triangle a convex body.

Which part is asked stands in the record of the surface (ASKED), and of an event in the event:

    below 0   minus the place of a facet
    above 0   the place of a triangle
    0         all of the surface, for the pair kernels of the narrow phase
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact.collision import bounds_record, collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    HULL,
    PLANE,
    SPHERE,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import NORMAL as FOUND_NORMAL
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    EDGE,
    EDGES,
    END,
    FACES,
    PLANE_NORMAL,
    START,
    Hull,
    edges_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    PLANE as FACE,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import corner_of
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    ASKED,
    NORMAL,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    KEY,
    RESULT,
    RESULTS,
    RESULTS_USED,
    key_of_pair_id,
)
from rigid_body_sim.physics.contact.collision.nearest_axis import (
    TOUCHING,
    core_point,
    nearest_axis,
)
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.flight import Flights, pose_of_side
from rigid_body_sim.physics.vectors import cross, dot, load, negate, scale, store, subtract

LEVEL = 1e-7  # [-] of an edge: corners whose heights differ by less are of one feature
NEARLY = 1e-6  # [rad] so little from an axis that touches, a better one is meant
NO_VECTOR = (0.0, 0.0, 0.0)
FAR = 1e300  # [m] the margin of a pair kernel that is to answer at any distance

collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')


@inline
def is_ground(collider: int, colliders: ColliderArrays) -> bool:
    """Tell whether a collider is ground of triangles."""
    return colliders.table[collider * collider_record.SIZE + collider_record.TYPE] == SURFACE


@inline
def surface_of(collider: int, colliders: ColliderArrays) -> int:
    """Where the record of a surface begins."""
    return colliders.table[collider * collider_record.SIZE + collider_record.PARAMETERS]


@kernel
def ask_part(b: int, part: float, colliders: ColliderArrays) -> None:
    """Let ground be a part of itself from now on, see the module; what is no ground stays."""
    if is_ground(b, colliders):
        colliders.parameters[surface_of(b, colliders) + ASKED] = part


@inline
def plane_of(collider: int, colliders: ColliderArrays) -> int:
    """
    Where the plane begins that a collider is, or the facet that is asked of it; below 0: none.
    """
    kind = colliders.table[collider * collider_record.SIZE + collider_record.TYPE]
    if kind == PLANE:
        return surface_of(collider, colliders)
    part = 0
    if kind == SURFACE:
        part = int(colliders.parameters[surface_of(collider, colliders) + ASKED])
    return -part if part < 0 else -1


@inline
def lever_of(collider: int, colliders: ColliderArrays) -> Any:
    """Radius of a collider; 0 of planes and ground [m]."""
    if colliders.table[collider * collider_record.SIZE + collider_record.TYPE] >= PLANE:
        return 0.0
    return colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.RADIUS]


@inline
def _edge_of(row: int, edge: int, colliders: ColliderArrays) -> Any:
    """Return an edge of a triangle, from its corner to the next one [m]."""
    start = corner_of(colliders.parameters, row, edge)
    return subtract(corner_of(colliders.parameters, row, edge + 1 if edge < 2 else 0), start)


@kernel
def across_triangle(collider: int, out: Any, colliders: ColliderArrays) -> Any:
    """
    Count the axes of the triangle that is asked which are across its normal at the contact, out of
    it: 2 of the face, 1 of an edge; and give one.
    """
    row = int(colliders.parameters[surface_of(collider, colliders) + ASKED])
    heights = (
        dot(out, corner_of(colliders.parameters, row, 0)),
        dot(out, corner_of(colliders.parameters, row, 1)),
        dot(out, corner_of(colliders.parameters, row, 2)),
    )
    top = max(heights[0], heights[1], heights[2])
    count, one = 0, out
    for edge in range(3):
        along = _edge_of(row, edge, colliders)
        size = math.sqrt(dot(along, along))
        after = heights[edge + 1 if edge < 2 else 0]
        if min(heights[edge], after) >= top - LEVEL * size:
            count, one = count + 1, scale(1.0 / size, along)
    return min(count, 2), one


@kernel
def corners_of_triangle(
    collider: int, out: Any, target: int, colliders: ColliderArrays, views: Array
) -> int:
    """List the corners of the triangle that is asked which lie farthest along a direction."""
    row = int(colliders.parameters[surface_of(collider, colliders) + ASKED])
    top, size, count = -math.inf, 0.0, 0
    for index in range(3):
        along = _edge_of(row, index, colliders)
        size = max(size, math.sqrt(dot(along, along)))
        top = max(top, dot(out, corner_of(colliders.parameters, row, index)))
    for index in range(3):
        corner = corner_of(colliders.parameters, row, index)
        if dot(out, corner) >= top - LEVEL * size:
            store(views, target + 3 * count, corner)
            count += 1
    return count


@inline
def _gap(a: int, b: int, normal: Any, flights: Flights) -> float:
    """Return the gap of a polyhedron and the triangle that is asked along an axis [m]."""
    place_a, place_b = pose_of_side(0, flights), pose_of_side(1, flights)
    origin = load(flights.colliders.poses, place_a + pose.POSITION)
    of_a = core_point(a, place_a, normal, origin, flights.colliders)
    of_b = core_point(b, place_b, negate(normal), origin, flights.colliders)
    return dot(normal, subtract(of_b, of_a))


@inline
def _better(a: int, b: int, normal: Any, known: Any, best: Any, flights: Flights) -> Any:
    """
    Return the better of an axis and its opposite with its gap, or the best one so far.

        known : a unit vector to which it is near; a zero vector: any
    """
    for turn in range(2):
        other = normal if turn == 0 else negate(normal)
        gap = _gap(a, b, other, flights)
        away = subtract(other, known)
        if gap > best[1] and (dot(known, known) == 0.0 or dot(away, away) < NEARLY * NEARLY):
            best = other, gap
    return best


@inline
def _better_across(
    a: int, b: int, row: int, edge: Any, known: Any, best: Any, flights: Flights
) -> Any:
    """The same of the common normals of an edge of A and those of a triangle."""
    for of_b in range(3):
        along = _edge_of(row, of_b, flights.colliders)
        normal = cross(edge, along)
        squared = dot(normal, normal)
        if squared > NO_CROSS_PRODUCT * dot(edge, edge) * dot(along, along):
            normal = scale(1.0 / math.sqrt(squared), normal)
            best = _better(a, b, normal, known, best, flights)
    return best


@kernel
def _axis_of_touch(a: int, b: int, known: Any, flights: Flights) -> Any:
    """
    Return the axis along which a polyhedron, or a cylinder, and the triangle that is asked are
    farthest apart, where they touch: the best of the separating axes, or a known one that will do
    where none is better nearby. What was followed from apart is off by what GJK leaves, and an
    edge of which it shows one end is no corner.
    """
    colliders = flights.colliders
    parameters, place = colliders.parameters, pose_of_side(0, flights)
    best, near = (known, _gap(a, b, known, flights)), known
    if not best[1] > -TOUCHING * lever_of(a, colliders):
        near = NO_VECTOR
    row = int(parameters[surface_of(b, colliders) + ASKED])
    kind = colliders.table[a * collider_record.SIZE + collider_record.TYPE]
    best = _better(a, b, load(parameters, row + NORMAL), near, best, flights)
    if kind == HULL:
        hull = Hull(parameters, surface_of(a, colliders))
        for face in range(int(parameters[hull.begin + FACES])):
            normal = load(parameters, planes_of(hull) + FACE * face + PLANE_NORMAL)
            normal = pose.to_world(colliders.poses, place, normal)
            best = _better(a, b, normal, near, best, flights)
        for index in range(int(parameters[hull.begin + EDGES])):
            edge = edges_of(hull) + EDGE * index
            start = vertex(hull, int(parameters[edge + START]))
            along = subtract(vertex(hull, int(parameters[edge + END])), start)
            along = pose.to_world(colliders.poses, place, along)
            best = _better_across(a, b, row, along, near, best, flights)
        return best[0]
    for index in range(3):
        if kind == BOX or index == 2:
            normal = pose.axis(colliders.poses, place, index)
            best = _better(a, b, normal, near, best, flights)
            best = _better_across(a, b, row, normal, near, best, flights)
    return best[0]


def _axis_to_triangle(a: int, b: int, flights: Flights) -> Any:
    """Return the axis along which a body and the triangle that is asked are farthest apart."""
    colliders = flights.colliders
    row = a * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    if kind == SPHERE or kind == CAPSULE:
        collide(
            kind, SURFACE, colliders.parameters,
            colliders.table[row + collider_record.PARAMETERS], surface_of(b, colliders),
            colliders.poses, pose_of_side(0, flights), pose_of_side(1, flights), FAR,
            flights.found,
        )  # fmt: skip
        return load(flights.found, FOUND_NORMAL)
    known = load(flights.views, flight_record.LAST_AXIS)
    size = math.sqrt(dot(known, known))
    triangle = int(colliders.parameters[surface_of(b, colliders) + ASKED])
    begin = negate(load(colliders.parameters, triangle + NORMAL))
    if size > 0.0:
        begin = scale(1.0 / size, known)
    found = nearest_axis(
        a, pose_of_side(0, flights), b, pose_of_side(1, flights), begin, colliders, flights.found
    )
    if found[0] != begin[0] or found[1] != begin[1] or found[2] != begin[2]:
        return found
    return _axis_of_touch(a, b, begin, flights)


@kernel
def result_of(pair_id: float, found: Array) -> int:
    """
    Where the manifold of a pair id begins among those that a surface was asked for last; below 0:
    it is not among them.
    """
    key = key_of_pair_id(pair_id)
    for at in range(RESULTS, RESULTS + RESULT * int(found[RESULTS_USED]), RESULT):
        if found[at + KEY] == key:
            return at
    return -1
