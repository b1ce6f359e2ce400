# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifold reduction: up to four of many points that carry as well as all of them.

`keep_four`: the deepest; the one farthest from it; the two that span the largest triangles with
these, one on either side. `keep_four_flat`, for box on box: those that span the largest area, and
the deepest in place of one of them. Points that coincide with a chosen one are left out. Of points
nearly as good as another the first counts (`manifold.TIE`, `manifold.LEAD`).
`polyhedra.extreme_points` is the other reduction, for faces of many corners.

Of flat points and extremes what is near, up to SKIN, comes before what is apart: up to four such
points are all kept, each in place of the nearest that is apart; of more, four are chosen, and no
other. Else a body that stands on two corners of a face would now and then lose one of them, and
its load, to corners that are millimetres away. What rolls has points that come and go with it.

What was held in the last tick is held again, while all four are there and span half of what others
would (`manifold.HELD`); the deepest takes the place of one of them only if it is DEEPER than all
of them. Points that change with every tremble give the same force and torque by other springs, at
another height and attitude: a pile of boxes with eight corners to a face never came to rest.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import (
    NONE,
    TIPS,
    bears_among,
    gives_way,
    one_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    HELD,
    HELD_COUNT,
    LEAD,
    MOST,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    TIE,
    copy_point,
)
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]

SKIN = 1e-3  # [-] of the extent: what is no farther apart presses, or is about to
ONE_PLACE = 1e-9  # [-] of the extent: points nearer than this are one
COINCIDENT = 4e-6  # [-] the same for flat points, where edges cross that nearly coincide
EVEN = 1e-13  # [-] of the extent: depths of flat points that differ by less are rounding
DEEPER = 1e-4  # [-] of the extent: so much deeper than all that are held a point takes a place
SPANS = 0.5  # [-] of the largest area: what was held is held while it spans as much
OUT = 0.0, 0.0, 1.0  # [-] across flat points
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
    farthest, reach = deepest, ONE_PLACE * extent * (ONE_PLACE * extent)
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
    least = ONE_PLACE * reach
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
def _extent_of(found: Array, first: int, end: int) -> Any:
    """Return the extent of flat points [m], where the deepest begins, and how many are near."""
    extent, deepest, near = 0.0, first, 0
    for place in range(first + FLAT_POINT, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - found[first + U], found[place + V] - found[first + V]
        extent = max(extent, abs(arm_u), abs(arm_v))
        if found[place + HEIGHT] < found[deepest + HEIGHT]:
            deepest = place
    for place in range(first, end, FLAT_POINT):
        near += 1 if found[place + HEIGHT] <= SKIN * extent else 0
    return extent, deepest, near


@inline
def _outermost(found: Array, first: int, end: int, limit: float) -> Any:
    """Return where the flat point begins that is farthest from the middle of all."""
    count, middle_u, middle_v = 0.0, 0.0, 0.0
    origin_u, origin_v = found[first + U], found[first + V]
    for place in range(first, end, FLAT_POINT):
        if found[place + HEIGHT] <= limit:
            arm_u, arm_v = found[place + U] - origin_u, found[place + V] - origin_v
            count, middle_u, middle_v = count + 1.0, middle_u + arm_u, middle_v + arm_v
    share = 1.0 / count
    middle_u, middle_v = origin_u + share * middle_u, origin_v + share * middle_v
    outermost, reach = first, -1.0
    for place in range(first, end, FLAT_POINT):
        arm_u, arm_v = found[place + U] - middle_u, found[place + V] - middle_v
        distance = arm_u * arm_u + arm_v * arm_v
        if found[place + HEIGHT] <= limit and distance > reach * (1.0 + LEAD):
            outermost, reach = place, distance
    return outermost


@inline
def _widest(
    found: Array, first: int, end: int, origin: int, to: int, least: float, limit: float
) -> Any:
    """
    Find the flat points that span the largest triangles with two others, one on either side.
    Return where they begin, or NO_POINT, and the sum of the areas, twice [m^2].

    least : [m^2] twice an area that does not count
    """
    origin_u, origin_v = found[origin + U], found[origin + V]
    base_u, base_v = found[to + U] - origin_u, found[to + V] - origin_v
    left, right, most, fewest = NO_POINT, NO_POINT, least, -least
    for place in range(first, end, FLAT_POINT):
        if found[place + HEIGHT] > limit:
            continue
        area = base_u * (found[place + V] - origin_v) - base_v * (found[place + U] - origin_u)
        if area > most * (1.0 + LEAD):
            left, most = place, area
        if area < fewest * (1.0 + LEAD):
            right, fewest = place, area
    return left, right, most - fewest


@inline
def _four_widest(
    found: Array, first: int, end: int, start: int, extent: float, limit: float
) -> Any:
    """
    Find the flat points that span the largest area with one of them; return where they begin, or
    NO_POINT: the one across, those on either side, and what is better than the first one.
    """
    least = COINCIDENT * extent * extent
    across, left, right, area = NO_POINT, NO_POINT, NO_POINT, least
    farthest, reach = NO_POINT, COINCIDENT * extent * (COINCIDENT * extent)
    for place in range(first, end, FLAT_POINT):
        if found[place + HEIGHT] > limit:
            continue
        arm_u, arm_v = found[place + U] - found[start + U], found[place + V] - found[start + V]
        distance = arm_u * arm_u + arm_v * arm_v
        if distance > reach * (1.0 + LEAD):
            farthest, reach = place, distance
        one, other, both = _widest(found, first, end, start, place, least, limit)
        if both > area * (1.0 + LEAD):
            across, left, right, area = place, one, other, both
    if left != NO_POINT and right != NO_POINT:
        _, better, _ = _widest(found, first, end, left, right, least, limit)
        start = better if better != NO_POINT else start
    return across if across != NO_POINT else farthest, left, right, start


@inline
def _with_flat(
    found: Array, first: int, end: int, place: int, chosen: int, above: float, least: float
) -> int:
    """
    Let a flat point have the place of the nearest of those chosen that are higher than `above`, or
    a free one, unless it coincides with one of them. Return a bit for each that is chosen.
    """
    count, replaced, reach = 0, NO_POINT, math.inf
    for other in range(first, end, FLAT_POINT):
        if (chosen >> ((other - first) // FLAT_POINT)) & 1:
            arm_u, arm_v = found[other + U] - found[place + U], found[other + V] - found[place + V]
            square = arm_u * arm_u + arm_v * arm_v
            count += 1
            if square <= least:
                return chosen
            if found[other + HEIGHT] > above and square < reach:
                replaced, reach = other, square
    bit = 1 << ((place - first) // FLAT_POINT)
    if count < MOST:
        return chosen | bit
    if replaced == NO_POINT:
        return chosen
    return (chosen | bit) ^ (1 << ((replaced - first) // FLAT_POINT))


@inline
def four_span(a: Any, b: Any, c: Any, d: Any) -> Any:
    """Return twice the area that four points span, in any order, squared [m^4]."""
    across = cross(subtract(b, a), subtract(d, c))
    most = dot(across, across)
    across = cross(subtract(c, a), subtract(d, b))
    most = max(most, dot(across, across))
    across = cross(subtract(d, a), subtract(c, b))
    return max(most, dot(across, across))


@inline
def _span_of(found: Array, first: int, end: int, chosen: int) -> Any:
    """Return what `four_span` does of the flat points that are chosen; 0: they are not four."""
    a = b = c = d = (0.0, 0.0, 0.0)
    count = 0
    for place in range(first, end, FLAT_POINT):
        if (chosen >> ((place - first) // FLAT_POINT)) & 1:
            a, b, c, d = b, c, d, (found[place + U], found[place + V], 0.0)
            count += 1
    return four_span(a, b, c, d) if count == MOST else 0.0


@inline
def _named(found: Array, first: int, end: int, names: float, feature: float, limit: float) -> int:
    """Return where the flat point with a feature begins, up to a height; NO_POINT: nowhere."""
    named = NO_POINT
    for place in range(first, end, FLAT_POINT):
        if names + found[place + NAME] == feature and found[place + HEIGHT] <= limit:
            named = place
    return named


@kernel
def _held_flat(
    found: Array, first: int, end: int, names: float, limit: float, tips: float, e: int, f: int,
    g: int, h: int, most: float,
) -> int:  # fmt: skip
    """
    Return a bit for each flat point that was held in the last tick, with what takes the place of
    one that bears no load (`loaded_side`), if it is deeper by `tips`; 0: they are not four, or
    span less and bear no load that is not among others.

        e, f, g, h : where the others begin
        most       : what `_span_of` returns of these
    """
    if int(found[HELD_COUNT]) != MOST:
        return 0
    a = _named(found, first, end, names, found[HELD], limit)
    b = _named(found, first, end, names, found[HELD + 1], limit)
    c = _named(found, first, end, names, found[HELD + 2], limit)
    d = _named(found, first, end, names, found[HELD + 3], limit)
    if min(a, b, c, d) == NO_POINT:
        return 0
    held = 1 << ((a - first) // FLAT_POINT) | 1 << ((b - first) // FLAT_POINT)
    held |= 1 << ((c - first) // FLAT_POINT) | 1 << ((d - first) // FLAT_POINT)
    index, out, height, lead = gives_way(found, found, a, b, c, d, OUT)
    needed = NO_POINT
    if index != NONE:
        deep = min(found[a + HEIGHT], found[b + HEIGHT]) - tips
        deep = min(deep, min(found[c + HEIGHT], found[d + HEIGHT]) - tips)
        for place in range(first, end, FLAT_POINT):
            beyond = out[0] * found[place + U] + out[1] * found[place + V]
            if beyond > height + lead and found[place + HEIGHT] < deep:
                needed, height = place, beyond
    if needed != NO_POINT:
        place = one_of(index, a, b, c, d)
        held ^= 1 << ((place - first) // FLAT_POINT)
        return held | 1 << ((needed - first) // FLAT_POINT)
    is_narrow = not _span_of(found, first, end, held) >= SPANS * SPANS * most
    if is_narrow and bears_among(found, found, OUT, a, b, c, d, e, f, g, h):
        return 0
    return held


@kernel
def keep_four_flat(found: Array, first: int, count: int, to: int, names: float) -> int:
    """
    Choose up to four of many flat points: those that were held in the last tick, or else that span
    the largest area; near ones that are not among them take the place of others; if none of them
    is the deepest, it takes the place of the nearest; of those that were held, but for DEEPER, it
    takes that of the highest, if it spans enough without. So few change while a body trembles.
    Return how many are kept, in the order in which they came.

        first : where they begin in `found`
        to    : where the chosen ones are written
        names : with NAME, the feature of a point
    """
    end = first + FLAT_POINT * count
    extent, deepest, near = _extent_of(found, first, end)
    limit = SKIN * extent if near > MOST else math.inf
    start = _outermost(found, first, end, limit)
    across, left, right, start = _four_widest(found, first, end, start, extent, limit)
    chosen = 0
    for place in (start, across, left, right):
        if place != NO_POINT:
            chosen |= 1 << ((place - first) // FLAT_POINT)
    most = _span_of(found, first, end, chosen)
    held = _held_flat(
        found, first, end, names, limit, TIPS * extent, start, across, left, right, most
    )
    holds = held != 0
    chosen = held if holds else chosen
    deep = found[deepest + HEIGHT] + (DEEPER if holds else EVEN) * extent
    least = (COINCIDENT * extent) * (COINCIDENT * extent)
    if 0 < near <= MOST:
        for place in range(first, end, FLAT_POINT):
            if found[place + HEIGHT] <= SKIN * extent:
                chosen = _with_flat(found, first, end, place, chosen, SKIN * extent, least)
    highest, has_deepest = NO_POINT, False
    for place in range(first, end, FLAT_POINT):
        if (chosen >> ((place - first) // FLAT_POINT)) & 1:
            height = found[place + HEIGHT]
            has_deepest = has_deepest or height <= deep
            if highest == NO_POINT or height > found[highest + HEIGHT]:
                highest = place
    if not has_deepest:
        instead = chosen ^ (1 << ((highest - first) // FLAT_POINT))
        instead |= 1 << ((deepest - first) // FLAT_POINT)
        if holds and _span_of(found, first, end, instead) >= SPANS * SPANS * most:
            chosen = instead
        else:
            chosen = _with_flat(found, first, end, deepest, chosen, -math.inf, -1.0)
    kept = 0
    for place in range(first, end, FLAT_POINT):
        if (chosen >> ((place - first) // FLAT_POINT)) & 1:
            for number in range(FLAT_POINT):
                found[to + FLAT_POINT * kept + number] = found[place + number]
            kept += 1
    return kept
