# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifold reduction: up to four of many points that carry as well as all of them.

`keep_four`: the deepest; the one farthest from it; the two that span the largest triangles with
these, one on either side. `keep_four_flat`, for box on box: those that span the largest area, and
the deepest in place of one of them. Points that coincide with a chosen one are left out. Of points
nearly as good as another the first counts (`manifold.TIE`, `manifold.LEAD`).

`polyhedra.extreme_points` is the other reduction, for faces of many corners.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
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
COINCIDENT = 4e-6  # [-] the same for flat points, where edges cross that nearly coincide
EVEN = 1e-13  # [-] of the extent: depths of flat points that differ by less are rounding
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


@inline
def _outermost(found: Array, first: int, end: int) -> Any:
    """
    Return where the flat point begins that is farthest from the middle of all, where the deepest
    begins, and the extent of all [m].
    """
    extent, deepest, middle_u, middle_v = 0.0, first, 0.0, 0.0
    origin_u, origin_v = found[first + U], found[first + V]
    for place in range(first + FLAT_POINT, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - origin_u, found[place + V] - origin_v
        extent = max(extent, abs(arm_u), abs(arm_v))
        if found[place + HEIGHT] < found[deepest + HEIGHT]:
            deepest = place
        middle_u, middle_v = middle_u + arm_u, middle_v + arm_v
    share = FLAT_POINT / (end - first)
    middle_u, middle_v = origin_u + share * middle_u, origin_v + share * middle_v
    outermost, reach = first, -1.0
    for place in range(first, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - middle_u, found[place + V] - middle_v
        distance = arm_u * arm_u + arm_v * arm_v
        if distance > reach * (1.0 + LEAD):
            outermost, reach = place, distance
    return outermost, deepest, extent


@inline
def _widest(found: Array, first: int, end: int, origin: int, to: int, least: float) -> Any:
    """
    Find the flat points that span the largest triangles with two others, one on either side.
    Return where they begin, or NO_POINT, and the sum of the areas, twice [m^2].

    least : [m^2] twice an area that does not count
    """
    origin_u, origin_v = found[origin + U], found[origin + V]
    base_u, base_v = found[to + U] - origin_u, found[to + V] - origin_v
    left, right, most, fewest = NO_POINT, NO_POINT, least, -least
    for place in range(first, end, FLAT_POINT):
        area = base_u * (found[place + V] - origin_v) - base_v * (found[place + U] - origin_u)
        if area > most * (1.0 + LEAD):
            left, most = place, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = place, area
    return left, right, most - fewest


@inline
def _four_widest(found: Array, first: int, end: int, start: int, extent: float) -> Any:
    """
    Find the flat points that span the largest area with one of them; return where they begin, or
    NO_POINT: the one across, those on either side, and what is better than the first one.
    """
    least = COINCIDENT * extent * extent
    across, left, right, area = NO_POINT, NO_POINT, NO_POINT, least
    farthest, reach = NO_POINT, COINCIDENT * extent * (COINCIDENT * extent)
    for place in range(first, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - found[start + U], found[place + V] - found[start + V]
        distance = arm_u * arm_u + arm_v * arm_v
        if distance > reach * (1.0 + LEAD):
            farthest, reach = place, distance
        one, other, both = _widest(found, first, end, start, place, least)
        if both > area * (1.0 + LEAD):
            across, left, right, area = place, one, other, both
    if left != NO_POINT and right != NO_POINT:
        _, better, _ = _widest(found, first, end, left, right, least)
        start = better if better != NO_POINT else start
    return across if across != NO_POINT else farthest, left, right, start


@kernel
def keep_four_flat(found: Array, first: int, count: int, to: int) -> int:
    """
    Choose up to four of many flat points: those that span the largest area; if none of them is
    the deepest, it takes the place of the nearest of them. So few change while a body trembles.
    Return how many are kept, in the order in which they came.

        first : where they begin in `found`
        to    : where the chosen ones are written
    """
    end = first + FLAT_POINT * count
    start, deepest, extent = _outermost(found, first, end)
    across, left, right, start = _four_widest(found, first, end, start, extent)
    limit = found[deepest + HEIGHT] + EVEN * extent
    nearest, distance = start, math.inf
    for place in (start, across, left, right):
        if place != NO_POINT:
            arm_u = found[place + U] - found[deepest + U]
            arm_v = found[place + V] - found[deepest + V]
            square = arm_u * arm_u + arm_v * arm_v
            if found[place + HEIGHT] <= limit:
                nearest, distance = NO_POINT, -1.0  # one is the deepest
            elif square < distance:
                nearest, distance = place, square
    kept = 0
    for place in range(first, end, FLAT_POINT):
        chosen = place == start or place == across or place == left or place == right
        if (chosen and place != nearest) or (nearest != NO_POINT and place == deepest):
            for number in range(FLAT_POINT):
                found[to + FLAT_POINT * kept + number] = found[place + number]
            kept += 1
    return kept
