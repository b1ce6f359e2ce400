# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The axis along which two colliders are farthest apart, for pairs with a cylinder or a hull: by GJK
over the true shapes (`geometry.polyhedra.gjk`), of which no prism stands for a cylinder.

The kernels of such pairs give a normal at which a manifold can hold: that of a prism where rim
meets rim, of a face or a mantle where those are near. What passes by less than a prism differs
from its cylinder, or past the end of a mantle, needs the true one:

    v = the point of B - A nearest to the origin,  n = v / |v|

A ball is its centre here and a capsule its axis: the same v, without their radii.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    SPHERE,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import support_points
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import (
    nearest_of_simplex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    Hull,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    DIFFERENCE,
    NEAREST,
    SIMPLEX,
    SIMPLEX_CORNER,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    farthest_corner,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_EDGES,
    HALF_LENGTH,
    RADIUS,
)
from rigid_body_sim.physics.vectors import add, dot, load, negate, scale, store, subtract

Array = NDArray[np.float64]

NEAREST_AXIS_STEPS = 48  # [-] most steps; what is undecided then has the best axis so far
AXIS_SLACK = 1e-3  # [-] of the gap: an axis may separate by so much less than the farthest one
TOUCHING = 1e-9  # [m] nearer is not apart
EVEN = 1e-12  # [-] of a unit vector: what looks so little across a face looks along its middle


@kernel
def core_point(
    collider: int, place: int, direction: Any, origin: Any, colliders: ColliderArrays
) -> Any:
    """Return the point of a collider, or of its core, that is farthest along a direction."""
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    shape = colliders.table[row + collider_record.PARAMETERS]
    parameters, poses = colliders.parameters, colliders.poses
    if kind == SURFACE:
        return subtract(farthest_corner(parameters, shape, direction), origin)
    middle = subtract(load(poses, place + pose.POSITION), origin)
    if kind == SPHERE:
        return middle
    local = pose.to_shape(poses, place, direction)
    if kind == BOX:
        half = load(parameters, shape + HALF_EDGES)
        point = (
            math.copysign(half[0], local[0]),
            math.copysign(half[1], local[1]),
            math.copysign(half[2], local[2]),
        )
    elif kind == CAPSULE or kind == CYLINDER:
        across = math.sqrt(local[0] * local[0] + local[1] * local[1])
        out = 0.0
        if kind == CYLINDER and across > EVEN * abs(local[2]):
            out = parameters[shape + RADIUS] / across
        end = math.copysign(parameters[shape + HALF_LENGTH], local[2])
        point = (out * local[0], out * local[1], end)
    else:
        hull = Hull(parameters, shape)
        best = support_points.support(support_points.vertices_of(hull), local, 0)
        point = add(load(parameters, shape + CENTER), vertex(hull, best))
    return add(middle, pose.to_world(poses, place, point))


@kernel
def radius_about_core(collider: int, colliders: ColliderArrays) -> Any:
    """Return the radius about the core of a collider [m]."""
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    if kind == SPHERE or kind == CAPSULE:
        return colliders.parameters[colliders.table[row + collider_record.PARAMETERS] + RADIUS]
    return 0.0


@kernel
def nearest_axis(
    a: int, pose_a: int, b: int, pose_b: int, normal: Any, colliders: ColliderArrays, work: Array
) -> Any:
    """
    Return the unit vector from A to B along which two colliders are farthest apart; where they are
    not apart, the one that is given.

        pose_a, pose_b : where the poses begin in which they are taken
        normal         : to begin with
        work           : scratch of a pair kernel
    """
    origin = load(colliders.poses, pose_a + pose.POSITION)
    rounded = radius_about_core(a, colliders) + radius_about_core(b, colliders)
    way, size = normal, math.inf
    corners = 0
    for _ in range(NEAREST_AXIS_STEPS):
        of_b = core_point(b, pose_b, negate(way), origin, colliders)
        difference = subtract(of_b, core_point(a, pose_a, way, origin, colliders))
        length = math.sqrt(dot(way, way))
        along = dot(way, difference) / length
        if corners > 0 and size - along <= AXIS_SLACK * (size - rounded):
            break
        store(work, SIMPLEX + SIMPLEX_CORNER * corners + DIFFERENCE, difference)
        corners = nearest_of_simplex(work, corners + 1)
        if corners == 0:
            return normal
        nearest = load(work, NEAREST)
        distance = math.sqrt(dot(nearest, nearest))
        if not distance > rounded + TOUCHING:
            return normal
        if not distance < size:  # round-off
            break
        way, size = nearest, distance
    if size == math.inf:
        return normal
    return scale(1.0 / size, way)
