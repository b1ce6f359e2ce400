# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifold reduction: up to four of many points that carry as well as all of them.

The deepest; the one farthest from it; the two that span the largest triangles with these, one on
either side. Points that coincide with a chosen one are left out. Of points nearly as good as
another the first counts (`manifold.TIE`, `manifold.LEAD`).

`polyhedra.extreme_points` is the other reduction, for faces of many corners.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    LEAD,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    TIE,
    copy_point,
)
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]

SAME = 1e-9  # [-] of the extent: points nearer than this are one
NO_POINT = -1  # where a point begins that has not been found

flat_point = Record()  # a point over a plane
U = flat_point.number('m', 'along the first axis of the plane')
V = flat_point.number('m', 'along the second axis')
HEIGHT = flat_point.number('m', 'gap over the plane; negative: penetration')
NAME = flat_point.number('-', 'which parts of the shapes touch')
FLAT_POINT = flat_point.size


@kernel
def keep_four(found: Array, first: int, count: int) -> int:
    """
    Choose up to four of many points of a manifold.

        first : where the points begin in `found`, behind the manifold
        count : how many there are
    Returns how many are kept; they are written from POINTS on, the rest of `found` is unchanged.
    """
    if count <= 0:
        return 0
    extent = 0.0
    begin, end = load(found, first), first + POINT * count
    for place in range(first + POINT, end, POINT):
        arm = subtract(load(found, place), begin)
        extent = max(extent, abs(arm[0]), abs(arm[1]), abs(arm[2]))
    tie = TIE * extent
    deepest = first
    for place in range(first + POINT, end, POINT):
        if found[place + SEPARATION] < found[deepest + SEPARATION] - tie:
            deepest = place
    origin = load(found, deepest)
    farthest, reach = deepest, SAME * extent * (SAME * extent)
    for place in range(first, end, POINT):
        arm = subtract(load(found, place), origin)
        distance = dot(arm, arm)
        if distance > reach * (1.0 + LEAD):
            farthest, reach = place, distance
    copy_point(found, POINTS, deepest)
    if farthest == deepest:
        return 1
    copy_point(found, POINTS + POINT, farthest)
    normal, base = load(found, NORMAL), subtract(load(found, farthest), origin)
    least = SAME * reach
    left, right, most, fewest = NO_POINT, NO_POINT, least, -least
    for place in range(first, end, POINT):
        # twice the signed area of the triangle, seen against the normal
        area = dot(normal, cross(base, subtract(load(found, place), origin)))
        if area > most * (1.0 + LEAD):
            left, most = place, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = place, area
    kept = 2
    if left != NO_POINT:
        copy_point(found, POINTS + kept * POINT, left)
        kept += 1
    if right != NO_POINT:
        copy_point(found, POINTS + kept * POINT, right)
        kept += 1
    return kept


@kernel
def keep_four_flat(found: Array, first: int, count: int, to: int) -> int:
    """
    Choose like `keep_four` among flat points.

        first : where they begin in `found`
        to    : where the chosen ones are written
    """
    extent = 0.0
    second, end = first + FLAT_POINT, first + FLAT_POINT * count
    for place in range(second, end, FLAT_POINT):
        extent = max(
            extent,
            abs(found[place + U] - found[first + U]),
            abs(found[place + V] - found[first + V]),
        )
    tie = TIE * extent
    deepest, depth = first, found[first + HEIGHT]
    for place in range(second, end, FLAT_POINT):
        if found[place + HEIGHT] < depth - tie:
            deepest, depth = place, found[place + HEIGHT]
    origin_u, origin_v = found[deepest + U], found[deepest + V]
    farthest, reach = deepest, SAME * extent * (SAME * extent)
    base_u, base_v = 0.0, 0.0
    for place in range(first, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - origin_u, found[place + V] - origin_v
        distance = arm_u * arm_u + arm_v * arm_v
        if distance > reach * (1.0 + LEAD):
            farthest, reach, base_u, base_v = place, distance, arm_u, arm_v
    least = SAME * reach
    left, right, most, fewest = NO_POINT, NO_POINT, least, -least
    for place in range(first, end, FLAT_POINT):
        # twice the signed area of the triangle
        area = base_u * (found[place + V] - origin_v) - base_v * (found[place + U] - origin_u)
        if area > most * (1.0 + LEAD):
            left, most = place, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = place, area
    kept = 0
    for place in (deepest, farthest, left, right):
        if place != NO_POINT and (kept != 1 or farthest != deepest):
            for number in range(FLAT_POINT):
                found[to + FLAT_POINT * kept + number] = found[place + number]
            kept += 1
    return kept
