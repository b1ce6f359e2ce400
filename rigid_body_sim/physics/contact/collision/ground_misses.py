# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What passes near ground of triangles: the proof that a body misses what a manifold is of.

Each triangle is convex, so that the proof for two convex bodies (`conservative_advancement`) holds
for the body and one triangle at a time, which the surface is asked for alone. A manifold of a
facet is missed where all triangles of the facet near the body are; one of an edge or a vertex
where those are that its points lie on. What moves far in a tick is asked of all triangles along
its way: those near it at the start are not those that it hits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.conservative_advancement import (
    motion_of,
    stays_apart_finder,
)
from rigid_body_sim.physics.contact.collision.free_motion import free_motion
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    NORMAL,
    POINT,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    END,
    ROOT,
    corner_of,
    edge_side,
    list_near,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    ASKED,
    FACET,
    FACET_HIGH,
    FACET_LOW,
    FACET_OF,
    FLATNESS,
    PLANES,
    RING,
    TRIANGLE,
    TRIANGLES,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    NORMAL as TRIANGLE_NORMAL,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    FREE,
    LISTED,
    QUERY_HIGH,
    QUERY_LOW,
    key_of_pair_id,
)
from rigid_body_sim.physics.vectors import add_scaled, dot, load, subtract

Array = NDArray[np.float64]

AROUND = 5e-3  # [-] of the separation: so far beside a triangle a point may lie that is of it

ALL = -1  # in place of a manifold: any triangle

collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
stays_apart = slot('kernel (a, b, count, horizon, normal, ...): tells whether an axis separates')


@inline
def key_of(record: int, manifolds: Array) -> float:
    """Return the key of a manifold of ground among those of its pair, see `surface_scratch`."""
    return key_of_pair_id(manifolds[record + manifold_record.PAIR_ID])


@kernel
def reach_of_manifold(
    record: int, surface: int, direction: Any, parameters: Array, manifolds: Array
) -> float:
    """
    Bound how far along a direction that reaches of a surface which a manifold is of [m]: the AABB
    of its facet; or all triangles around the one whose edge or vertex it is.
    """
    key = key_of(record, manifolds)
    if key < FREE:
        plane = surface + int(parameters[surface + PLANES]) + FACET * int(key)
        reach = 0.0
        for axis in range(3):
            along = direction[axis]
            reach += along * parameters[plane + axis + (FACET_HIGH if along > 0.0 else FACET_LOW)]
        return reach
    row = surface + int(parameters[surface + TRIANGLES]) + TRIANGLE * int(key - FREE)
    reach = -math.inf
    for corner in range(3):
        reach = max(reach, dot(direction, corner_of(parameters, row, corner)))
        ring = surface + int(parameters[row + RING + corner])
        for index in range(int(parameters[ring])):
            reach = max(reach, dot(direction, load(parameters, ring + 1 + 3 * index)))
    return reach


@kernel
def is_of(record: int, row: int, surface: int, parameters: Array, manifolds: Array) -> bool:
    """Tell whether a manifold is of a triangle."""
    key = key_of(record, manifolds)
    if key < FREE:
        return parameters[row + FACET_OF] == math.floor(key)
    if row == surface + int(parameters[surface + TRIANGLES]) + TRIANGLE * int(key - FREE):
        return True
    normal = load(manifolds, record + manifold_record.NORMAL)
    out = load(parameters, row + TRIANGLE_NORMAL)
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        gap = manifolds[place + SEPARATION]
        point = add_scaled(load(manifolds, place + POSITION), 0.5 * gap, normal)
        near = parameters[surface + FLATNESS] + AROUND * abs(gap)
        lies = abs(dot(out, subtract(point, corner_of(parameters, row, 0)))) <= near
        for edge in range(3):
            side = edge_side(parameters, row, edge, out)
            beyond = dot(side, subtract(point, corner_of(parameters, row, edge)))
            lies = lies and beyond <= near * math.sqrt(dot(side, side))
        if lies:
            return True
    return False


@kernel
def _ask_along_way(
    a: int, reach: float, horizon: float, colliders: ColliderArrays, found: Array
) -> None:
    """Ask for the triangles that a collider may come near to within a time [s]."""
    swept, row = colliders.swept_aabbs, a * swept_aabbs.SIZE
    for axis in range(3):
        center, half = swept[row + swept_aabbs.CENTER + axis], swept[row + swept_aabbs.HALF + axis]
        way = horizon * swept[row + swept_aabbs.VELOCITY + axis]
        found[QUERY_LOW + axis] = center - half - reach + min(way, 0.0)
        found[QUERY_HIGH + axis] = center + half + reach + max(way, 0.0)


@kernel
def _passes_plane(
    a: int, row: int, reach: float, horizon: float, colliders: ColliderArrays
) -> bool:
    """Tell whether the ball about a collider stays on one side of the plane of a triangle."""
    parameters, swept = colliders.parameters, colliders.swept_aabbs
    normal, place = load(parameters, row + TRIANGLE_NORMAL), a * swept_aabbs.SIZE
    start = load(swept, place + swept_aabbs.CENTER)
    height = dot(normal, subtract(start, corner_of(parameters, row, 0)))
    last = height + horizon * dot(normal, load(swept, place + swept_aabbs.VELOCITY))
    room = reach + colliders.local_bounds[a * bounds_record.SIZE + bounds_record.RADIUS]
    return (height > room and last > room) or (height < -room and last < -room)


def _ground_misses(
    a: int, b: int, record: int, count: int, horizon: float, colliders: ColliderArrays,
    bodies: Array, found: Array, manifolds: Array,
) -> bool:  # fmt: skip
    """
    Tell whether collider A misses, in free motion, that of the surface B which a manifold is of.

        record  : where the manifold begins; ALL: all of the surface
        count   : of colliders
        horizon : [s] from the start of the tick
    """
    parameters, table, poses = colliders.parameters, colliders.table, colliders.poses
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    shape_a = table[a * collider_record.SIZE + collider_record.PARAMETERS]
    surface = table[b * collider_record.SIZE + collider_record.PARAMETERS]
    # what turning and forces add; of two ticks at most
    reach = 4.0 * colliders.swept_aabbs[a * swept_aabbs.SIZE + swept_aabbs.TURNING]
    motion = 2.0 * motion_of(colliders.swept_aabbs, a, b, horizon)
    _ask_along_way(a, reach, horizon, colliders, found)
    of_a, of_b = free_motion(a, colliders, bodies), free_motion(b, colliders, bodies)
    missed, node = True, ROOT
    while node != END and missed:
        listed, node = list_near(parameters, surface, node, found)
        for entry in range(LISTED, LISTED + listed):
            row = int(found[entry])
            if not (
                missed and (record == ALL or is_of(record, row, surface, parameters, manifolds))
            ):
                continue
            if not _passes_plane(a, row, reach, horizon, colliders):
                parameters[surface + ASKED] = row
                near = collide(
                    type_a, type_b, parameters, shape_a, surface, poses, a * pose.SIZE,
                    b * pose.SIZE, motion, found,
                )  # fmt: skip
                missed = near == 0 or stays_apart(
                    a, b, count, horizon, load(found, NORMAL), of_a, of_b, colliders, found
                )
                parameters[surface + ASKED] = 0.0
    return missed


def ground_miss_finder(
    name: str, collide: Callable[..., Any], *, true_shapes: bool
) -> Callable[..., Any]:
    """
    Make the kernel that tells whether a body misses ground, with the kernels of a scene.

        true_shapes : whether some collider is a cylinder or a hull
    """
    stays_apart = stays_apart_finder(name, collide, true_shapes=true_shapes)
    return specialise(_ground_misses, name=name, collide=collide, stays_apart=stays_apart)
