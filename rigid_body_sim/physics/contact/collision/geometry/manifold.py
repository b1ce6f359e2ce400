# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a pair kernel finds: one normal and up to four points.

    collide(numbers, a, b, poses, pa, pb, margin, found) -> count
        numbers, poses : see `collider`
        a, b           : where the sizes of the shapes begin in `numbers`; type of A <= type of B
        pa, pb         : where their poses begin in `poses`
        margin         : [m]  largest gap of a point that is reported
        found          : FOUND numbers, written: unit normal from A to B (3), world axes; then for
                         each point its place (3) [m], world, midway between the surfaces; its gap
                         [m], negative: penetration; its feature [-]
        count          : int  points, at most four; 0: farther apart than the margin

A feature is a number that stays the same from tick to tick while the same parts touch. What a
kernel leaves behind the fourth point is scratch.

Lengths are squared here. Nearer than SHORTEST two parts count as coincident, because the square
has lost digits there; two shapes larger than 1e154 m never meet, because it overflows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.vectors import store

Array = NDArray[np.float64]

POINTS = 3  # where the points begin in `found`
POINT = 5  # numbers of a point: x, y, z, gap, feature
SEPARATION, FEATURE = 3, 4
MOST = 4  # [-] points of a manifold
SCRATCH = POINTS + MOST * POINT  # where a kernel may keep what it likes
FOUND = 512  # numbers in `found`
SHORTEST = 1e-140  # [m] of a shorter way the direction is no direction
TINY = SHORTEST * SHORTEST  # [m^2] a component of 1e-13 of it still has a square with all digits
SAME = 1e-9  # [-] of the extent: points nearer than this are one
# Of points as good as another up to these shares the first counts: without them a resting body
# changes its points, and loses their impulses, with every tremble.
TIE = 1e-5  # [-] of the extent: depths
LEAD = 1e-3  # [-] distances squared and areas


@inline
def put_normal(found: Array, x: float, y: float, z: float) -> None:
    """Write the normal of the manifold, from A to B."""
    found[0] = x
    found[1] = y
    found[2] = z


@inline
def put_point(
    found: Array, at: int, x: float, y: float, z: float, gap: float, feature: float
) -> None:
    """Write a point that begins at a place of `found`."""
    found[at] = x
    found[at + 1] = y
    found[at + 2] = z
    found[at + SEPARATION] = gap
    found[at + FEATURE] = feature


@inline
def write_normal(found: Array, normal: Any) -> None:
    """Write the unit normal of the manifold, from A to B, world axes."""
    store(found, 0, normal)


@inline
def write_point(
    found: Array, index: int, position: Any, separation: float, feature: float
) -> None:
    """Write one of the points of the manifold, 0 to 3."""
    at = POINTS + index * POINT
    store(found, at, position)
    found[at + SEPARATION] = separation
    found[at + FEATURE] = feature


@inline
def _move_point(found: Array, to: int, source: int) -> None:
    for i in range(POINT):
        found[to + i] = found[source + i]


@inline
def _doubled_area(found: Array, a: int, b: int, c: int) -> Any:
    """Return twice the signed area of a triangle of points, seen against the normal."""
    ux, uy, uz = found[b] - found[a], found[b + 1] - found[a + 1], found[b + 2] - found[a + 2]
    vx, vy, vz = found[c] - found[a], found[c + 1] - found[a + 1], found[c + 2] - found[a + 2]
    return (
        found[0] * (uy * vz - uz * vy)
        + found[1] * (uz * vx - ux * vz)
        + found[2] * (ux * vy - uy * vx)
    )


@kernel
def keep_four(found: Array, first: int, count: int) -> int:
    """
    Choose up to four of many points: the manifold that carries as well as all of them.

    The deepest; the one farthest from it; the two that span the largest triangles with these, one
    on either side. Points that coincide with a chosen one are left out.
        first : where the points begin in `found`, at SCRATCH or behind
        count : how many there are
    Returns how many are kept; they are written from POINTS on, the rest of `found` is unchanged.
    """
    if count <= 0:
        return 0
    extent = 0.0
    for k in range(1, count):
        at = first + k * POINT
        extent = max(
            extent,
            abs(found[at] - found[first]),
            abs(found[at + 1] - found[first + 1]),
            abs(found[at + 2] - found[first + 2]),
        )
    tie = TIE * extent
    deepest = first
    for k in range(1, count):
        at = first + k * POINT
        if found[at + SEPARATION] < found[deepest + SEPARATION] - tie:
            deepest = at
    farthest, reach = deepest, SAME * extent * (SAME * extent)
    for k in range(count):
        at = first + k * POINT
        dx, dy, dz = (
            found[at] - found[deepest],
            found[at + 1] - found[deepest + 1],
            found[at + 2] - found[deepest + 2],
        )
        distance = dx * dx + dy * dy + dz * dz
        if distance > reach * (1.0 + LEAD):
            farthest, reach = at, distance
    _move_point(found, POINTS, deepest)
    if farthest == deepest:
        return 1
    _move_point(found, POINTS + POINT, farthest)
    least = SAME * reach
    left, right, most, fewest = -1, -1, least, -least
    for k in range(count):
        at = first + k * POINT
        area = _doubled_area(found, deepest, farthest, at)
        if area > most * (1.0 + LEAD):
            left, most = at, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = at, area
    kept = 2
    if left >= 0:
        _move_point(found, POINTS + kept * POINT, left)
        kept += 1
    if right >= 0:
        _move_point(found, POINTS + kept * POINT, right)
        kept += 1
    return kept


@kernel
def keep_four_flat(found: Array, first: int, count: int, to: int) -> int:
    """
    Choose like `keep_four` among points u, v, gap, feature over a plane.

        first : where they begin in `found`, four numbers each
        to    : where the chosen ones are written
    """
    extent = 0.0
    for at in range(first + 4, first + 4 * count, 4):
        extent = max(extent, abs(found[at] - found[first]), abs(found[at + 1] - found[first + 1]))
    tie = TIE * extent
    deepest, depth = first, found[first + 2]
    for at in range(first + 4, first + 4 * count, 4):
        if found[at + 2] < depth - tie:
            deepest, depth = at, found[at + 2]
    u, v = found[deepest], found[deepest + 1]
    farthest, reach, du, dv = deepest, SAME * extent * (SAME * extent), 0.0, 0.0
    for at in range(first, first + 4 * count, 4):
        x, y = found[at] - u, found[at + 1] - v
        distance = x * x + y * y
        if distance > reach * (1.0 + LEAD):
            farthest, reach, du, dv = at, distance, x, y
    least = SAME * reach
    left, right, most, fewest = -1, -1, least, -least
    for at in range(first, first + 4 * count, 4):
        area = du * (found[at + 1] - v) - dv * (found[at] - u)
        if area > most * (1.0 + LEAD):
            left, most = at, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = at, area
    kept = 0
    for at in (deepest, farthest, left, right):
        if at >= 0 and (kept != 1 or farthest != deepest):
            for i in range(4):
                found[to + 4 * kept + i] = found[at + i]
            kept += 1
    return kept
