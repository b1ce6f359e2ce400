# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which of the four held points gives way to one that is needed more, by what they bear.

A face of many corners stands on four of them. A load beside these four is borne by the two of the
side that it is beyond, and would tip the body over that side, though there are corners beyond it.
Then, once it tips, one of the other two gives way to the corner that lies farthest beyond. The
next tick sees by the loads whether that is enough: the four close in on the place of the load.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    HELD_COUNT,
    HELD_IMPULSES,
    LEAD,
    MOST,
)
from rigid_body_sim.physics.vectors import add_scaled, cross, dot, load, negate, scale, subtract

BY_TWO = 0.999  # [-] of the load: what two of four bear is not among the four, but for rounding
BY_ONE = 0.98  # [-] of the load: what one bears is at a corner, and beside neither of its sides
TIPS = 1e-8  # [-] of the extent by which a corner beyond is deeper than all four of what tips
NONE = -1  # in place of one of the four


@inline
def _bearers(found: Array) -> Any:
    """Return which two of the four held points bear most, and their shares of the load."""
    first, second, total = NONE, NONE, 0.0
    most, next_to_it = 0.0, 0.0
    for index in range(int(found[HELD_COUNT])):
        borne = found[HELD_IMPULSES + index]
        total += borne
        if borne > most:
            second, next_to_it = first, most
            first, most = index, borne
        elif borne > next_to_it:
            second, next_to_it = index, borne
    share = 1.0 / total if total > 0.0 else 0.0
    return first, second, share * most, share * next_to_it


@inline
def bear(found: Array) -> bool:
    """Tell whether the held points bear any load."""
    first, _, _, _ = _bearers(found)
    return first != NONE


@inline
def loaded_side(found: Array) -> Any:
    """Return which two of the four held points bear all of the load between them, or NONE."""
    first, second, most, next_to_it = _bearers(found)
    if second != NONE and most < BY_ONE and most + next_to_it > BY_TWO:
        return first, second
    return NONE, NONE


@inline
def one_of(index: int, a: Any, b: Any, c: Any, d: Any) -> Any:
    """Return one of four by its index."""
    if index < 2:
        return a if index == 0 else b
    return c if index == 2 else d


@inline
def _reach(
    points: Array, out: Any, level: float, one: int, other: int, a: int, b: int, c: int, d: int
) -> Any:  # fmt: skip
    """Return how far, along n from a level n . x, those of four lie that are not two: from, to."""
    inner, outer = 0.0, 0.0
    for index in range(MOST):
        if index != one and index != other:
            beyond = dot(out, load(points, one_of(index, a, b, c, d))) - level
            inner, outer = min(inner, beyond), max(outer, beyond)
    return inner, outer


@kernel
def gives_way(found: Array, points: Array, a: int, b: int, c: int, d: int, normal: Any) -> Any:
    """
    Find which of the four held points gives way to what lies beyond the side between two others.

        points     : [m]  where the points are written
        a, b, c, d : where they begin there, in the order of `manifold.HELD`
        normal     : across the face that they span
    Returns which, or NONE; the direction n out of the side, of any length; h = n . x on the side;
    and by how much more of h a point must be farther out than another.
    """
    one, other = loaded_side(found)
    nothing = NONE, (0.0, 0.0, 0.0), 0.0, 0.0
    if one == NONE:
        return nothing
    begin = load(points, one_of(one, a, b, c, d))
    side = subtract(load(points, one_of(other, a, b, c, d)), begin)
    out = cross(side, normal)
    level = dot(out, begin)
    inner, outer = _reach(points, out, level, one, other, a, b, c, d)
    if inner < 0.0 < outer:  # the two bear across
        return nothing
    borne = found[HELD_IMPULSES + other]
    borne_at = add_scaled(begin, borne / (borne + found[HELD_IMPULSES + one]), side)
    farthest, chosen = -1.0, NONE
    for index in range(MOST):
        away = subtract(load(points, one_of(index, a, b, c, d)), borne_at)
        if index != one and index != other and dot(away, away) > farthest:
            chosen, farthest = index, dot(away, away)
    if outer > 0.0:
        out, level = negate(out), -level
    return chosen, out, level, LEAD * (outer - inner)


@inline
def _place_of_load(found: Array, points: Array, a: int, b: int, c: int, d: int) -> Any:
    """Return where the load that four held points bear acts [m], and whether they bear any."""
    at, total = (0.0, 0.0, 0.0), 0.0
    for index in range(MOST):
        borne = found[HELD_IMPULSES + index]
        at = add_scaled(at, borne, load(points, one_of(index, a, b, c, d)))
        total += borne
    share = 1.0 / total if total > 0.0 else 0.0
    return scale(share, at), total > 0.0


@kernel
def bears_among(
    found: Array, points: Array, normal: Any, a: int, b: int, c: int, d: int, e: int, f: int,
    g: int, h: int,
) -> bool:  # fmt: skip
    """
    Tell whether the load that four held points bear lies among four others, or there is none.

        points     : [m]  where the points are written
        a, b, c, d : where the held ones begin there, in the order of `manifold.HELD`
        e, f, g, h : where the others begin
        normal     : across the face that they span
    """
    at, is_there = _place_of_load(found, points, a, b, c, d)
    if not is_there:
        return True
    for one in range(MOST - 1):
        for other in range(one + 1, MOST):
            begin = load(points, one_of(one, e, f, g, h))
            out = cross(subtract(load(points, one_of(other, e, f, g, h)), begin), normal)
            level = dot(out, begin)
            inner, outer = _reach(points, out, level, one, other, e, f, g, h)
            is_side = not inner < 0.0 < outer
            beyond = level - dot(out, at) if outer > 0.0 else dot(out, at) - level
            if is_side and beyond > LEAD * (outer - inner):
                return False
    return True
