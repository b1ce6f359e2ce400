# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The axis along which two colliders are farthest apart, exact where they touch, and how it turns.

    s(n) = min_B n . x - max_A n . x <= distance           for every unit n

so any axis gives a lower bound of the gap, and the right one gives zero where the two touch. Pair
kernels (`collision.pairs`) let the axis of the last tick win over one that is a little better: a
manifold holds longer so. Here nothing is held, and the best one counts.

An axis stays the best one of features that touch only if it turns with them: each axis e of an
edge or a face that is across n stays across,

    n' . e = -n . (w x e)

Else the far end of an edge would come nearer along n while the edge goes away.
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
    CYLINDER,
    HULL,
    PLANE,
    SPHERE,
    SURFACE,
)
from rigid_body_sim.physics.contact.collision.conservative_advancement import asks_true_shapes
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import NORMAL as FOUND_NORMAL
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES, NORMAL
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.best_axis import best_axis
from rigid_body_sim.physics.contact.events.contact_points import corners
from rigid_body_sim.physics.contact.events.flight import Flights, pose_of_side
from rigid_body_sim.physics.contact.events.ground_parts import across_triangle, plane_of
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    dot,
    load,
    negate,
    scale,
    subtract,
)

NO_VECTOR = (0.0, 0.0, 0.0)
ACROSS = 1e-7  # [-] cosine of the angle of an axis with n below which it is across
SAME_PLANE = 1e-9  # [-] squared sine of the angle of two edges below which one speaks for both

GROUND = slot('[-] whether some collider is ground of triangles')
collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
axis_to_triangle = slot('kernel (a, b, flights): the axis between a body and one triangle')


@inline
def _reach_of_box(axes: Any, half: Any, n: Any) -> Any:
    return (
        half[0] * abs(dot(axes[0], n))
        + half[1] * abs(dot(axes[1], n))
        + half[2] * abs(dot(axes[2], n))
    )


@inline
def _axes(poses: Array, place: int) -> Any:
    return pose.axis(poses, place, 0), pose.axis(poses, place, 1), pose.axis(poses, place, 2)


@kernel
def _axis_of_boxes(shape_a: int, shape_b: int, place_a: int, place_b: int, arrays: Any) -> Any:
    """Return the best of the fifteen separating axes of two boxes, from A to B."""
    poses = arrays.poses
    axes_a, axes_b = _axes(poses, place_a), _axes(poses, place_b)
    half_a = load(arrays.parameters, shape_a + HALF_EDGES)
    half_b = load(arrays.parameters, shape_b + HALF_EDGES)
    offset = subtract(load(poses, place_b), load(poses, place_a))
    best, most = axes_a[0], -math.inf
    for side in range(2):
        axes = axes_a if side == 0 else axes_b
        for axis in axes:
            along = dot(axis, offset)
            apart = (
                abs(along)
                - _reach_of_box(axes_a, half_a, axis)
                - _reach_of_box(axes_b, half_b, axis)
            )
            if apart > most:
                most = apart
                best = axis if along >= 0.0 else negate(axis)
    for edge_a in axes_a:
        for edge_b in axes_b:
            normal = cross(edge_a, edge_b)
            squared = dot(normal, normal)
            if squared > NO_CROSS_PRODUCT:
                normal = scale(1.0 / math.sqrt(squared), normal)
                along = dot(normal, offset)
                apart = (
                    abs(along)
                    - _reach_of_box(axes_a, half_a, normal)
                    - _reach_of_box(axes_b, half_b, normal)
                )
                if apart > most:
                    most = apart
                    best = normal if along >= 0.0 else negate(normal)
    return best


def _axis(a: int, b: int, flights: Flights) -> Any:
    """
    Return a unit vector from A to B, as they were looked at, along which they are farthest apart.

        a, b : colliders; type of A <= type of B
    """
    arrays = flights.colliders
    table, poses = arrays.table, arrays.poses
    row_a, row_b = a * collider_record.SIZE, b * collider_record.SIZE
    type_a, type_b = table[row_a + collider_record.TYPE], table[row_b + collider_record.TYPE]
    shape_a = table[row_a + collider_record.PARAMETERS]
    shape_b = table[row_b + collider_record.PARAMETERS]
    plane = plane_of(b, flights.colliders)
    if plane >= 0:
        return negate(load(arrays.parameters, plane + NORMAL))
    if GROUND and type_b == SURFACE:
        return axis_to_triangle(a, b, flights)
    place_a, place_b = pose_of_side(0, flights), pose_of_side(1, flights)
    offset = subtract(load(poses, place_b), load(poses, place_a))
    size = math.sqrt(dot(offset, offset))
    between = (0.0, 0.0, 1.0)
    if size > 0.0:
        between = scale(1.0 / size, offset)
    if type_a == SPHERE and type_b == SPHERE:
        return between
    if type_a == BOX and type_b == BOX:
        return _axis_of_boxes(shape_a, shape_b, place_a, place_b, arrays)
    exact = type_a != SPHERE and asks_true_shapes(a, b, arrays.table)
    known = load(flights.views, flight_record.LAST_AXIS)
    squared = dot(known, known)
    if exact and squared > 0.0:
        return best_axis(a, b, scale(1.0 / math.sqrt(squared), known), flights)
    bounds = arrays.local_bounds
    margin = size
    for collider in (a, b):
        center = load(bounds, collider * bounds_record.SIZE + bounds_record.CENTER)
        margin += bounds[collider * bounds_record.SIZE + bounds_record.RADIUS] + math.sqrt(
            dot(center, center)
        )
    points = collide(
        type_a, type_b, arrays.parameters, shape_a, shape_b, poses, place_a, place_b, margin,
        flights.found,
    )  # fmt: skip
    normal = load(flights.found, FOUND_NORMAL) if points > 0 else between
    return best_axis(a, b, normal, flights) if exact else normal


@kernel
def _across(collider: int, place: int, out: Any, flights: Flights) -> Any:
    """
    Count the axes of a collider that are across its normal at the contact, out of it: 2 of a face,
    1 of an edge; and give one.
    """
    row = collider * collider_record.SIZE
    kind = flights.colliders.table[row + collider_record.TYPE]
    count, one = 0, NO_VECTOR
    if kind == BOX:
        for index in range(3):
            axis = pose.axis(flights.colliders.poses, place, index)
            if abs(dot(axis, out)) < ACROSS:
                count, one = count + 1, axis
    elif kind == CAPSULE or kind == CYLINDER:
        axis = pose.axis(flights.colliders.poses, place, 2)
        along = dot(axis, out)
        if abs(along) < ACROSS:
            count, one = 1, axis
        elif kind == CYLINDER and 1.0 - abs(along) < ACROSS * ACROSS:
            count = 2
    elif kind == HULL:
        found = corners(
            collider, place, out, flight_record.CORNERS_A, flights.colliders, flights.views
        )
        if found == 2:
            first = load(flights.views, flight_record.CORNERS_A)
            edge = subtract(load(flights.views, flight_record.CORNERS_A + 3), first)
            count, one = 1, scale(1.0 / math.sqrt(dot(edge, edge)), edge)
        elif found > 2:
            count = 2
    elif kind == PLANE or (kind == SURFACE and plane_of(collider, flights.colliders) >= 0):
        count = 2
    elif kind == SURFACE:
        count, one = across_triangle(collider, out, flights.colliders)
    return count, one


@kernel
def turn_of_axis(a: int, b: int, normal: Any, flights: Flights) -> Any:
    """Return how fast the axis turns with the features it belongs to [1/s]: see the module."""
    views = flights.views
    spin_a = load(views, flight_record.SPIN)
    spin_b = load(views, flight_record.VIEW + flight_record.SPIN)
    if dot(spin_a, spin_a) + dot(spin_b, spin_b) == 0.0:
        return NO_VECTOR
    count_b, edge_b = _across(b, pose_of_side(1, flights), negate(normal), flights)
    if count_b >= 2 and dot(spin_b, spin_b) == 0.0:
        return NO_VECTOR
    count_a, edge_a = _across(a, pose_of_side(0, flights), normal, flights)
    if count_a >= 2:
        return cross(spin_a, normal)
    if count_b >= 2:
        return cross(spin_b, normal)
    along_a = -dot(normal, cross(spin_a, edge_a))
    along_b = -dot(normal, cross(spin_b, edge_b))
    if count_a == 1 and count_b == 1:
        cosine = dot(edge_a, edge_b)
        squared = 1.0 - cosine * cosine
        if squared > SAME_PLANE:
            of_a = (along_a - cosine * along_b) / squared
            of_b = (along_b - cosine * along_a) / squared
            return add(scale(of_a, edge_a), scale(of_b, edge_b))
        return scale(along_a, edge_a)
    if count_a == 1:
        return scale(along_a, edge_a)
    if count_b == 1:
        return scale(along_b, edge_b)
    return NO_VECTOR
