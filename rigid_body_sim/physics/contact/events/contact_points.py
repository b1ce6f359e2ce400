# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The points at which two colliders touch at the instant of an impact: what their extreme features
along the common normal have in common.

    corner                    itself
    edge and edge             where they cross; parallel: the ends of their common stretch
    face, edge                the manifold of the pair kernel

Corners that differ by less than ONE_HEIGHT along the normal count as one feature: a flat box falls
on four points, with a tilt of 1e-9 on one.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact.collision import collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    PLANE,
    SPHERE,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import support_points
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    COUNT,
    Hull,
    vertex,
)
from rigid_body_sim.physics.contact.collision.nearest_axis import core_point, radius_about_core
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_EDGES,
    HALF_LENGTH,
    RADIUS,
)
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.flight import Flights, pose_of_side
from rigid_body_sim.physics.contact.events.ground_parts import (
    corners_of_triangle,
    lever_of,
    plane_of,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    dot,
    load,
    negate,
    store,
    subtract,
)

ONE_HEIGHT = 1e-12  # [-] of the size: heights of corners that are of one feature
FACE = flight_record.MOST_POINTS  # corners: as many as there is room for, or more
TOUCHING_GAP = 1e-9  # [-] of the size: separation up to which the pair kernel is asked for points

GROUND = slot('[-] whether some collider is ground of triangles')
collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
all_lie_over = slot('kernel (b, count, flights): tells whether corners of A lie over a facet')
points_on_ground = slot('kernel (a, b, normal, flights): lists the points on ground')


@kernel
def corners(
    collider: int, place: int, out: Any, target: int, colliders: ColliderArrays, views: Array
) -> int:
    """
    List the corners of a collider, or of its core, that lie farthest along a direction; return how
    many, at most FACE.
    """
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    shape = colliders.table[row + collider_record.PARAMETERS]
    parameters, poses = colliders.parameters, colliders.poses
    if plane_of(collider, colliders) >= 0:
        return FACE
    if kind == SURFACE:
        return corners_of_triangle(collider, out, target, colliders, views)
    middle = load(poses, place + pose.POSITION)
    if kind == SPHERE:
        store(views, target, middle)
        return 1
    local = pose.to_shape(poses, place, out)
    least = ONE_HEIGHT * lever_of(collider, colliders)
    count = 0
    if kind == BOX or kind == CAPSULE:
        half = (0.0, 0.0, parameters[shape + HALF_LENGTH])
        if kind == BOX:
            half = load(parameters, shape + HALF_EDGES)
        most = half[0] * abs(local[0]) + half[1] * abs(local[1]) + half[2] * abs(local[2])
        for corner in range(8):
            if kind == CAPSULE and corner & 3 != 0:
                continue
            point = (
                half[0] if corner & 1 else -half[0],
                half[1] if corner & 2 else -half[1],
                half[2] if corner & 4 else -half[2],
            )
            if dot(point, local) >= most - least and count < FACE:
                world = add(middle, pose.to_world(poses, place, point))
                store(views, target + 3 * count, world)
                count += 1
        return count
    if kind == CYLINDER:
        across = math.sqrt(local[0] * local[0] + local[1] * local[1])
        radius, length = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
        if 2.0 * radius * across <= least:
            return FACE
        end = math.copysign(length, local[2])
        share = radius / across
        for _end in range(2):
            point = (share * local[0], share * local[1], end)
            store(views, target + 3 * count, add(middle, pose.to_world(poses, place, point)))
            count += 1
            end = -end
            if 2.0 * length * abs(local[2]) > least:
                break
        return count
    hull = Hull(parameters, shape)
    center = load(parameters, shape + CENTER)
    best = support_points.support(support_points.vertices_of(hull), local, 0)
    most = dot(local, vertex(hull, best))
    for number in range(int(parameters[shape + COUNT])):
        point = vertex(hull, number)
        if dot(local, point) >= most - least and count < FACE:
            world = add(middle, pose.to_world(poses, place, add(center, point)))
            store(views, target + 3 * count, world)
            count += 1
    return count


@inline
def _put(index: int, point: Any, views: Array) -> None:
    store(views, flight_record.TOUCHING + 3 * index, point)


@kernel
def _of_two_edges(views: Array) -> int:
    """List where two edges cross, or the ends of the common stretch of parallel ones."""
    start_a, start_b = load(views, flight_record.CORNERS_A), load(views, flight_record.CORNERS_B)
    along_a = subtract(load(views, flight_record.CORNERS_A + 3), start_a)
    along_b = subtract(load(views, flight_record.CORNERS_B + 3), start_b)
    squared_a, squared_b = dot(along_a, along_a), dot(along_b, along_b)
    both = dot(along_a, along_b)
    way = subtract(start_b, start_a)
    det = squared_a * squared_b - both * both
    if det > NO_CROSS_PRODUCT * squared_a * squared_b:
        share = (dot(along_a, way) * squared_b - dot(along_b, way) * both) / det
        _put(0, add_scaled(start_a, min(max(share, 0.0), 1.0), along_a), views)
        return 1
    first = dot(along_a, way) / squared_a
    last = first + both / squared_a
    low, high = max(min(first, last), 0.0), min(max(first, last), 1.0)
    if not high > low:
        middle = min(max(0.5 * (low + high), 0.0), 1.0)
        _put(0, add_scaled(start_a, middle, along_a), views)
        return 1
    _put(0, add_scaled(start_a, low, along_a), views)
    _put(1, add_scaled(start_a, high, along_a), views)
    return 2


def _find_points(a: int, b: int, normal: Any, flights: Flights) -> int:
    """
    List the points at which two colliders, as they were looked at, touch along a normal; return
    how many, at least one.
    """
    colliders, views = flights.colliders, flights.views
    place_a, place_b = pose_of_side(0, flights), pose_of_side(1, flights)
    radius_a, radius_b = radius_about_core(a, colliders), radius_about_core(b, colliders)
    count_a = corners(a, place_a, normal, flight_record.CORNERS_A, colliders, views)
    out = negate(normal)
    count_b = corners(b, place_b, out, flight_record.CORNERS_B, colliders, views)
    row_b = b * collider_record.SIZE
    type_b = colliders.table[row_b + collider_record.TYPE]
    count = 0
    flat = type_b == PLANE
    if GROUND and type_b == SURFACE and count_a > 1:
        flat = all_lie_over(b, min(count_a, FACE), flights)
    if count_a == 1 or (flat and count_a < FACE):
        for index in range(count_a):
            corner = load(views, flight_record.CORNERS_A + 3 * index)
            _put(index, add_scaled(corner, radius_a, normal), views)
        return count_a
    if count_b == 1:
        corner = load(views, flight_record.CORNERS_B)
        _put(0, add_scaled(corner, -radius_b, normal), views)
        return 1
    if count_a == 2 and count_b == 2:
        count = _of_two_edges(views)
        for index in range(count):
            point = load(views, flight_record.TOUCHING + 3 * index)
            _put(index, add_scaled(point, radius_a, normal), views)
        return count
    if GROUND and type_b == SURFACE:
        count = points_on_ground(a, b, normal, flights)
        if count > 0:
            return count
    row_a = a * collider_record.SIZE
    size = lever_of(a, colliders) + lever_of(b, colliders)
    found = collide(
        colliders.table[row_a + collider_record.TYPE], type_b, colliders.parameters,
        colliders.table[row_a + collider_record.PARAMETERS],
        colliders.table[row_b + collider_record.PARAMETERS], colliders.poses, place_a, place_b,
        TOUCHING_GAP * size, flights.found,
    )  # fmt: skip
    least = math.inf
    for index in range(min(found, 4)):
        least = min(least, flights.found[POINTS + POINT * index + SEPARATION])
    for index in range(min(found, 4)):
        place = POINTS + POINT * index
        if flights.found[place + SEPARATION] <= least + ONE_HEIGHT * size:
            _put(count, load(flights.found, place + POSITION), views)
            count += 1
    if count == 0:
        origin = load(colliders.poses, place_a + pose.POSITION)
        point = add(origin, core_point(a, place_a, normal, origin, colliders))
        _put(0, add_scaled(point, radius_a, normal), views)
        count = 1
    return count
