# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifold reduction of a patch: up to four points that stay the same from tick to tick while the
bodies rest.

What was held in the last tick, or else the farthest points along four directions u, n x u, -u,
n x (-u) that are fixed in one of the bodies, and the lowest in what places are left; near ones
before those that are apart (`manifold_reduction`). The deepest, if it is deeper than these by more
than a tremble, takes the place of the higher one of its neighbours: no four corners span a
pentagon, and with the nearest it would be the other one that carries. A choice that begins with
the deepest point (`manifold_reduction.keep_four`) picks other ones with every tremble among the
many corners of a round face.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import (
    NONE,
    TIPS,
    bears_among,
    gives_way,
    one_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FEATURE,
    HELD,
    HELD_COUNT,
    LEAD,
    MOST,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    copy_point,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import (
    NO_POINT,
    ONE_PLACE,
    SKIN,
    SPANS,
    four_span,
)
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]

# [-] of the extent, as `manifold_reduction.DEEPER`: what four of five corners carry leans towards
# the fifth; with a third of this stacks of five pentagons and more lean round for ever
MUCH_DEEPER = 3e-4
BESIDE = 2.0  # [-] of the least distance squared: neighbours


@inline
def _limit_of(found: Array, first: int, end: int, near: float) -> Any:
    """Return the separation up to which points are chosen [m]: more than four that are near."""
    count = 0
    for place in range(first, end, POINT):
        count += 1 if found[place + SEPARATION] <= near else 0
    return near if count > MOST else math.inf


@kernel
def _with_near(found: Array, first: int, end: int, kept: int, near: float) -> int:
    """
    Let each near point that is not among those kept take a place that is free, or that of the
    nearest of them that is not near. Return how many are kept; near: SKIN of the extent.
    """
    least = (ONE_PLACE / SKIN * near) * (ONE_PLACE / SKIN * near)
    for _ in range(MOST):
        lowest, height = NO_POINT, near
        for place in range(first, end, POINT):
            if not found[place + SEPARATION] <= height:
                continue
            missing = True
            for other in range(POINTS, POINTS + kept * POINT, POINT):
                way = subtract(load(found, other), load(found, place))
                missing = missing and dot(way, way) > least
            if missing:
                lowest, height = place, found[place + SEPARATION]
        if lowest == NO_POINT:
            break
        replaced, reach = (POINTS + kept * POINT if kept < MOST else NO_POINT), math.inf
        for other in range(POINTS, POINTS + kept * POINT if kept == MOST else POINTS, POINT):
            way = subtract(load(found, other), load(found, lowest))
            if found[other + SEPARATION] > near and dot(way, way) < reach:
                replaced, reach = other, dot(way, way)
        if replaced == NO_POINT:
            break
        copy_point(found, replaced, lowest)
        kept = min(kept + 1, MOST)
    return kept


@inline
def _neighbour(found: Array, deepest: int, kept: int) -> int:
    """Return that of those kept whose place a point takes: of its neighbours the highest."""
    nearest = math.inf
    origin = load(found, deepest)
    for place in range(POINTS, POINTS + POINT * kept, POINT):
        arm = subtract(load(found, place), origin)
        nearest = min(nearest, dot(arm, arm))
    best, highest = POINTS, -math.inf
    for place in range(POINTS, POINTS + POINT * kept, POINT):
        arm = subtract(load(found, place), origin)
        if dot(arm, arm) <= BESIDE * nearest and found[place + SEPARATION] > highest:
            best, highest = place, found[place + SEPARATION]
    return best


@inline
def _span_of(found: Array, a: int, b: int, c: int, d: int) -> Any:
    """Return what `four_span` does of points that begin at four places."""
    return four_span(load(found, a), load(found, b), load(found, c), load(found, d))


@inline
def _named(found: Array, first: int, end: int, name: float, limit: float) -> int:
    """Return where the point with a feature begins, up to a separation; NO_POINT: nowhere."""
    named = NO_POINT
    for place in range(first, end, POINT):
        if found[place + FEATURE] == name and found[place + SEPARATION] <= limit:
            named = place
    return named


@kernel
def _hold(found: Array, first: int, end: int, kept: int, limit: float, tips: float) -> int:
    """
    Write the points that were held in the last tick in place of those kept, if there are four that
    span as much, or bear a load that is not among those; and what takes the place of one that
    bears none (`loaded_side`), if it is deeper by `tips`. Return how many are kept.
    """
    if int(found[HELD_COUNT]) != MOST:
        return kept
    a = _named(found, first, end, found[HELD], limit)
    b = _named(found, first, end, found[HELD + 1], limit)
    c = _named(found, first, end, found[HELD + 2], limit)
    d = _named(found, first, end, found[HELD + 3], limit)
    if min(a, b, c, d) == NO_POINT:
        return kept
    normal = load(found, NORMAL)
    index, out, height, lead = gives_way(found, found, a, b, c, d, normal)
    needed = NO_POINT
    if index != NONE:
        deep = min(found[a + SEPARATION], found[b + SEPARATION]) - tips
        deep = min(deep, min(found[c + SEPARATION], found[d + SEPARATION]) - tips)
        for place in range(first, end, POINT):
            beyond = dot(out, load(found, place))
            if beyond > height + lead and found[place + SEPARATION] < deep:
                needed, height = place, beyond
    if needed == NO_POINT and kept == MOST:
        e, f, g, h = POINTS, POINTS + POINT, POINTS + 2 * POINT, POINTS + 3 * POINT
        enough = SPANS * SPANS * _span_of(found, e, f, g, h)
        is_narrow = not _span_of(found, a, b, c, d) >= enough
        if is_narrow and bears_among(found, found, normal, a, b, c, d, e, f, g, h):
            return kept
    left_out = NO_POINT if needed == NO_POINT else one_of(index, a, b, c, d)
    kept = 0
    for place in range(first, end, POINT):
        is_held = place == a or place == b or place == c or place == d
        if place == needed or (is_held and place != left_out):
            copy_point(found, POINTS + kept * POINT, place)
            kept += 1
    return kept


@kernel
def keep_extremes(found: Array, first: int, count: int, direction: Any) -> int:
    """
    Choose up to four of the points of a patch.

    first     : where the points begin in `found`, not before the fourth point of the manifold
    count     : how many there are; no two with the same feature
    direction : u, fixed in a body, of any length
    Returns how many are kept; they are written from POINTS on.
    """
    if count <= MOST:
        for index in range(count):
            copy_point(found, POINTS + index * POINT, first + index * POINT)
        return count
    begin, end = load(found, first), first + POINT * count
    extent = 0.0
    deepest = first
    for place in range(first + POINT, end, POINT):
        arm = subtract(load(found, place), begin)
        extent = max(extent, abs(arm[0]), abs(arm[1]), abs(arm[2]))
        if found[place + SEPARATION] < found[deepest + SEPARATION]:
            deepest = place
    limit = _limit_of(found, first, end, SKIN * extent)
    lead = LEAD * extent * (abs(direction[0]) + abs(direction[1]) + abs(direction[2]))
    normal = load(found, NORMAL)
    kept = 0
    for _ in range(MOST):
        best, top = first, -math.inf
        for place in range(first, end, POINT):
            height = dot(direction, load(found, place))
            if found[place + SEPARATION] <= limit and height > top + lead:
                best, top = place, height
        fresh = True
        for index in range(kept):
            fresh = fresh and found[POINTS + index * POINT + FEATURE] != found[best + FEATURE]
        if fresh:
            copy_point(found, POINTS + kept * POINT, best)
            kept += 1
        direction = cross(normal, direction)
    kept = _hold(found, first, end, kept, limit, TIPS * extent)
    kept = _with_near(found, first, end, kept, SKIN * extent)
    least = found[POINTS + SEPARATION]
    for index in range(1, kept):
        least = min(least, found[POINTS + index * POINT + SEPARATION])
    if found[deepest + SEPARATION] < least - MUCH_DEEPER * extent:
        copy_point(found, _neighbour(found, deepest, kept), deepest)
    return kept
