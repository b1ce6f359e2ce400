# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How far a collider reaches along a direction n: max over its points of n . x, the support function
of convex geometry, in closed form but for hulls; and whether a point lies inside.

    ball      n . x + r
    capsule   n . x + l |n . a| + r                      a : axis;  l : half length
    box       n . x + sum_k h_k |n . a_k|
    cylinder  n . x + l |n . a| + r sqrt(1 - (n . a)^2)  of the true mantle, not of a prism
    hull      the largest n . v of its vertices
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    SPHERE,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import support_points
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    FACES,
    PLANE,
    PLANE_NORMAL,
    PLANE_OFFSET,
    Hull,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    triangle_reach,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_EDGES,
    HALF_LENGTH,
    RADIUS,
)
from rigid_body_sim.physics.vectors import add, dot, load, subtract


@kernel
def reach(collider: int, place: int, direction: Any, colliders: ColliderArrays) -> float:
    """
    Return how far a collider, no plane, reaches along a unit direction [m]; ground of triangles,
    the one triangle that is asked.

        place : where the pose begins in which it is taken
    """
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    shape = colliders.table[row + collider_record.PARAMETERS]
    parameters, poses = colliders.parameters, colliders.poses
    middle = dot(direction, load(poses, place + pose.POSITION))
    if kind == SPHERE:
        return middle + parameters[shape + RADIUS]
    local = pose.to_shape(poses, place, direction)
    if kind == SURFACE:
        return triangle_reach(parameters, shape, direction)
    if kind == BOX:
        half = load(parameters, shape + HALF_EDGES)
        return middle + half[0] * abs(local[0]) + half[1] * abs(local[1]) + half[2] * abs(local[2])
    if kind == CAPSULE:
        along = parameters[shape + HALF_LENGTH] * abs(local[2])
        return middle + along + parameters[shape + RADIUS]
    if kind == CYLINDER:
        across = math.sqrt(local[0] * local[0] + local[1] * local[1])
        along = parameters[shape + HALF_LENGTH] * abs(local[2])
        return middle + along + parameters[shape + RADIUS] * across
    hull = Hull(parameters, shape)
    best = support_points.support(support_points.vertices_of(hull), local, 0)
    return middle + dot(local, add(load(parameters, shape + CENTER), vertex(hull, best)))


@kernel
def gap_along(
    a: int, pose_a: int, b: int, pose_b: int, normal: Any, colliders: ColliderArrays
) -> float:
    """Return the gap of two colliders along a unit normal from A to B [m]; negative: none."""
    back = (-normal[0], -normal[1], -normal[2])
    return -reach(b, pose_b, back, colliders) - reach(a, pose_a, normal, colliders)


@kernel
def is_inside(
    point: Any, margin: float, collider: int, place: int, colliders: ColliderArrays
) -> Any:
    """Tell whether a point lies in a collider, no plane, and deeper than a margin [m]."""
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    shape = colliders.table[row + collider_record.PARAMETERS]
    parameters, poses = colliders.parameters, colliders.poses
    local = pose.to_shape(poses, place, subtract(point, load(poses, place + pose.POSITION)))
    if kind == BOX:
        half = load(parameters, shape + HALF_EDGES)
        return (
            abs(local[0]) < half[0] - margin
            and abs(local[1]) < half[1] - margin
            and abs(local[2]) < half[2] - margin
        )
    if kind == HULL:
        hull = Hull(parameters, shape)
        from_center = subtract(local, load(parameters, shape + CENTER))
        planes = planes_of(hull)
        for face in range(int(parameters[shape + FACES])):
            plane = planes + PLANE * face
            height = dot(load(parameters, plane + PLANE_NORMAL), from_center)
            if not height < parameters[plane + PLANE_OFFSET] - margin:
                return False
        return True
    across = local[0] * local[0] + local[1] * local[1]
    along = abs(local[2])
    radius = parameters[shape + RADIUS] - margin
    if kind == CYLINDER:
        if not along < parameters[shape + HALF_LENGTH] - margin:
            return False
        along = 0.0
    elif kind == CAPSULE:
        along = max(along - parameters[shape + HALF_LENGTH], 0.0)
    return radius > 0.0 and across + along * along < radius * radius
