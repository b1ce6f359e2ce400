# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The axis along which two colliders, one of them a cylinder or a hull, are farthest apart, to the
last digit, also where they touch. Of unit vectors n the one with the greatest

    s(n) = min_B n . x - max_A n . x = min over pieces (a, b) of  n . (b - a)

A piece is a vertex, or an end of an axis, or one of the two rims of a cylinder, whose point turns
with n and bends the piece: with t along the rim and n_t the part of n across the axis

    d2 s = -R (t . dn)^2 / |n_t|

s is concave along n while the two are apart, so that one that is the best nearby is the best.
Pieces are found one by one, where the present axis is extreme; among those that are known the
best step in the plane across n is the best of few: where three of them are as far apart, or two,
or where one bends away. Where faces and edges touch that is their normal, exactly (a cutting-plane
method with curved cuts); GJK has no axis there, its vector ends at zero.

The axis of a cylinder is a cone of s, without derivative, and is asked by itself.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import support_points
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    Hull,
    vertex,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_EDGES,
    HALF_LENGTH,
    RADIUS,
)
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.collision_matrix import across
from rigid_body_sim.physics.contact.events.flight import Flights, pose_of_side
from rigid_body_sim.physics.contact.events.flight_record import (
    AHEAD,
    MOST_PIECES,
    PIECE,
    PIECE_OF_A,
    PIECE_OF_B,
    SLOPE_U,
    SLOPE_V,
)
from rigid_body_sim.physics.contact.events.ground_parts import lever_of
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    negate,
    scale,
    subtract,
)

BEST_AXIS_STEPS = 32  # [-] of the axis; 2 to 6 are needed
FARTHEST = 0.5  # [-] a step of the axis, as a tangent
GAIN_ROUND_OFF = 3e-16  # [-] of the size: a gain in gap that is none
LAST_STEP = 1e-7  # [-] of the axis: what is left after it is its square
LEAST_BEND = 1e-9  # [-] of the size: so much a piece bends at least
ON_AXIS = 1e-9  # [-] sine of the angle with the axis of a cylinder: no rim point is extreme
OFF_AXIS = 1e-3  # [-] so far off it the search begins, if it is not the best


@kernel
def _piece(collider: int, place: int, direction: Any, colliders: ColliderArrays) -> int:
    """Return which piece of a collider is extreme along a direction."""
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    local = pose.to_shape(colliders.poses, place, direction)
    if kind == BOX:
        piece = 1 if local[0] > 0.0 else 0
        piece += 2 if local[1] > 0.0 else 0
        return piece + (4 if local[2] > 0.0 else 0)
    if kind == HULL:
        shape = colliders.table[row + collider_record.PARAMETERS]
        hull = Hull(colliders.parameters, shape)
        return int(support_points.support(support_points.vertices_of(hull), local, 0))
    return 1 if local[2] > 0.0 else 0


@kernel
def _point(
    collider: int, place: int, piece: int, direction: Any, origin: Any, colliders: ColliderArrays
) -> Any:
    """Return the point of a piece, of a rim that which is extreme along a direction."""
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    shape = colliders.table[row + collider_record.PARAMETERS]
    parameters, poses = colliders.parameters, colliders.poses
    point = (0.0, 0.0, 0.0)
    if kind == BOX:
        half = load(parameters, shape + HALF_EDGES)
        point = (
            half[0] if piece & 1 else -half[0],
            half[1] if piece & 2 else -half[1],
            half[2] if piece & 4 else -half[2],
        )
    elif kind == HULL:
        hull = Hull(parameters, shape)
        point = add(load(parameters, shape + CENTER), vertex(hull, piece))
    elif kind == CAPSULE or kind == CYLINDER:
        half_length = parameters[shape + HALF_LENGTH]
        end = half_length if piece & 1 else -half_length
        out, local = 0.0, (0.0, 0.0, 0.0)
        if kind == CYLINDER:
            local = pose.to_shape(poses, place, direction)
            across = math.sqrt(local[0] * local[0] + local[1] * local[1])
            if across > ON_AXIS * abs(local[2]):
                out = parameters[shape + RADIUS] / across
        point = (out * local[0], out * local[1], end)
    middle = subtract(load(poses, place + pose.POSITION), origin)
    return add(middle, pose.to_world(poses, place, point))


@kernel
def _rim(collider: int, place: int, normal: Any, colliders: ColliderArrays) -> Any:
    """Return how much the pieces of a collider bend [m], and along what; see the module."""
    row = collider * collider_record.SIZE
    if colliders.table[row + collider_record.TYPE] != CYLINDER:
        return 0.0, normal
    along = cross(pose.axis(colliders.poses, place, 2), normal)
    across = math.sqrt(dot(along, along))
    if not across > ON_AXIS:
        return 0.0, normal
    radius = colliders.parameters[colliders.table[row + collider_record.PARAMETERS] + RADIUS]
    return radius / across, scale(1.0 / across, along)


@kernel
def _apart(a: int, b: int, piece_a: int, piece_b: int, normal: Any, flights: Flights) -> Any:
    """Return the vector from the point of one piece to that of another."""
    colliders = flights.colliders
    place_a, place_b = pose_of_side(0, flights), pose_of_side(1, flights)
    origin = load(colliders.poses, place_a + pose.POSITION)
    of_a = _point(a, place_a, piece_a, normal, origin, colliders)
    of_b = _point(b, place_b, piece_b, negate(normal), origin, colliders)
    return subtract(of_b, of_a)


@kernel
def gap_along(a: int, b: int, normal: Any, flights: Flights) -> Any:
    """Return s of an axis, and the vector between the points that are extreme along it."""
    colliders = flights.colliders
    piece_a = _piece(a, pose_of_side(0, flights), normal, colliders)
    piece_b = _piece(b, pose_of_side(1, flights), negate(normal), colliders)
    apart = _apart(a, b, piece_a, piece_b, normal, flights)
    return dot(normal, apart), apart


@kernel
def _enter_piece(a: int, b: int, count: int, normal: Any, flights: Flights) -> int:
    """
    List the piece that an axis shows, unless it is; return how many are. In a full list it takes
    the place of that which lies farthest ahead.
    """
    colliders, views = flights.colliders, flights.views
    piece_a = float(_piece(a, pose_of_side(0, flights), normal, colliders))
    piece_b = float(_piece(b, pose_of_side(1, flights), negate(normal), colliders))
    target, most = flight_record.PIECES + PIECE * count, -math.inf
    for index in range(count):
        row = flight_record.PIECES + PIECE * index
        if views[row + PIECE_OF_A] == piece_a and views[row + PIECE_OF_B] == piece_b:
            return count
        if count == MOST_PIECES and views[row + AHEAD] > most:
            target, most = row, views[row + AHEAD]
    views[target + PIECE_OF_A], views[target + PIECE_OF_B] = piece_a, piece_b
    return min(count + 1, MOST_PIECES)


@inline
def _value(count: int, bend: Any, x: float, y: float, views: Array) -> float:
    """Return what the known pieces promise after a step: the least, less what they bend."""
    least = math.inf
    for index in range(count):
        row = flight_record.PIECES + PIECE * index
        ahead = views[row + AHEAD] + x * views[row + SLOPE_U] + y * views[row + SLOPE_V]
        least = min(least, ahead)
    return least - 0.5 * (bend[0] * x * x + 2.0 * bend[1] * x * y + bend[2] * y * y)


@inline
def _better(
    best: Any, count: int, bend: Any, x: float, y: float, most: float, views: Array
) -> Any:
    """Return the better of the best step so far and another one, cut to the longest."""
    size = math.sqrt(x * x + y * y)
    if size > most:
        x, y = x * most / size, y * most / size
    value = _value(count, bend, x, y, views)
    return (x, y, value) if value > best[2] else best


@kernel
def _best_step(count: int, bend: Any, most: float, views: Array) -> Any:
    """
    Return the best step across the axis and what it promises.

        bend : xx, xy, yy of what all pieces bend, its determinant, and the least in any direction
        most : longest step
    """
    best = (0.0, 0.0, _value(count, bend, 0.0, 0.0, views))
    xx, xy, yy, det, least = bend
    for i in range(count):
        row = flight_record.PIECES + PIECE * i
        f, fu, fv = views[row + AHEAD], views[row + SLOPE_U], views[row + SLOPE_V]
        x = (yy * fu - xy * fv) / det
        y = (xx * fv - xy * fu) / det
        best = _better(best, count, bend, x, y, most, views)
        for j in range(i):
            row = flight_record.PIECES + PIECE * j
            g, gu, gv = (
                views[row + AHEAD] - f,
                fu - views[row + SLOPE_U],
                fv - views[row + SLOPE_V],
            )
            squared = gu * gu + gv * gv
            if squared == 0.0:
                continue
            x, y = gu * g / squared, gv * g / squared
            slope = -gv * fu + gu * fv + gv * (xx * x + xy * y)
            slope -= gu * (xy * x + yy * y)
            bent = gv * gv * xx - 2.0 * gu * gv * xy + gu * gu * yy
            way = slope / max(bent, least * squared)  # round-off of a sharp bend may leave none
            best = _better(best, count, bend, x - way * gv, y + way * gu, most, views)
            for k in range(j):
                row = flight_record.PIECES + PIECE * k
                r = views[row + AHEAD] - f
                ru, rv = fu - views[row + SLOPE_U], fv - views[row + SLOPE_V]
                cut = gu * rv - gv * ru
                if cut != 0.0:
                    x, y = (g * rv - r * gv) / cut, (gu * r - ru * g) / cut
                    best = _better(best, count, bend, x, y, most, views)
    return best


@kernel
def _linearise(a: int, b: int, count: int, normal: Any, frame: Any, flights: Flights) -> None:
    """Write how far apart the known pieces are along an axis, and how that changes across it."""
    views = flights.views
    for index in range(count):
        row = flight_record.PIECES + PIECE * index
        piece_a, piece_b = int(views[row + PIECE_OF_A]), int(views[row + PIECE_OF_B])
        apart = _apart(a, b, piece_a, piece_b, normal, flights)
        views[row + AHEAD] = dot(normal, apart)
        views[row + SLOPE_U], views[row + SLOPE_V] = dot(frame[0], apart), dot(frame[1], apart)


@kernel
def _bend_of(a: int, b: int, normal: Any, frame: Any, least: float, flights: Flights) -> Any:
    """
    Return how the pieces bend across an axis: xx, xy, yy [m], and the determinant

        det = least^2 + least (c_1 + c_2) + c_1 c_2 (t_1 x t_2)^2

    of a bend least 1 + sum c t t^T: from xx, xy and yy nothing of it may be left, as a rim whose
    axis is nearly n bends 1e9 times as much along t as across it.

        least : what the unit sphere bends them, all alike
    """
    colliders = flights.colliders
    c_1, along_1 = _rim(a, pose_of_side(0, flights), normal, colliders)
    c_2, along_2 = _rim(b, pose_of_side(1, flights), normal, colliders)
    x_1, y_1 = dot(frame[0], along_1), dot(frame[1], along_1)
    x_2, y_2 = dot(frame[0], along_2), dot(frame[1], along_2)
    turned = x_1 * y_2 - y_1 * x_2
    return (
        least + c_1 * x_1 * x_1 + c_2 * x_2 * x_2,
        c_1 * x_1 * y_1 + c_2 * x_2 * y_2,
        least + c_1 * y_1 * y_1 + c_2 * y_2 * y_2,
        least * least + least * (c_1 + c_2) + c_1 * c_2 * turned * turned,
        least,
    )


@kernel
def _end_of_cylinder(a: int, b: int, side: int, normal: Any, flights: Flights) -> Any:
    """
    Return the axis of a cylinder that is nearest to a direction, its gap, how far beside the disc
    the nearest point of the other one lies [m], and where; not a cylinder: a gap of -inf.
    """
    colliders = flights.colliders
    row = (a if side == 0 else b) * collider_record.SIZE
    if colliders.table[row + collider_record.TYPE] != CYLINDER:
        return normal, -math.inf, 0.0, normal
    axis = pose.axis(colliders.poses, pose_of_side(side, flights), 2)
    if dot(axis, normal) < 0.0:
        axis = negate(axis)
    gap, apart = gap_along(a, b, axis, flights)
    beside = add_scaled(apart, -gap, axis)
    radius = colliders.parameters[colliders.table[row + collider_record.PARAMETERS] + RADIUS]
    return axis, gap, math.sqrt(dot(beside, beside)) - radius, beside


@kernel
def best_axis(a: int, b: int, normal: Any, flights: Flights) -> Any:
    """
    Return the unit vector from A to B along which two colliders, as they were looked at, are
    farthest apart.

        normal : to begin with;   views[PIECES_KNOWN] pieces of the two are known from before
    """
    size = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
    best, (most, _) = normal, gap_along(a, b, normal, flights)
    for side in range(2):
        axis, gap, outside, beside = _end_of_cylinder(a, b, side, normal, flights)
        if outside <= 0.0 and gap >= most - GAIN_ROUND_OFF * size:
            return axis
        along = cross(axis, best)
        if outside > 0.0 and dot(along, along) < OFF_AXIS * OFF_AXIS:
            away = add_scaled(axis, OFF_AXIS / math.sqrt(dot(beside, beside)), beside)
            best = scale(1.0 / math.sqrt(dot(away, away)), away)
            most, _ = gap_along(a, b, best, flights)
    count = int(flights.views[flight_record.PIECES_KNOWN])
    count, longest = _enter_piece(a, b, count, best, flights), FARTHEST
    for _step in range(BEST_AXIS_STEPS):
        first = across(best)
        frame = first, cross(best, first)
        _linearise(a, b, count, best, frame, flights)
        bend = _bend_of(a, b, best, frame, max(most, LEAST_BEND * size), flights)
        x, y, promised = _best_step(count, bend, longest, flights.views)
        moved = add(best, add(scale(x, frame[0]), scale(y, frame[1])))
        moved = scale(1.0 / math.sqrt(dot(moved, moved)), moved)
        gap, _ = gap_along(a, b, moved, flights)
        way = math.sqrt(x * x + y * y)
        before = count
        count = _enter_piece(a, b, count, moved, flights)
        known = count == before and (
            count < MOST_PIECES or gap >= promised - GAIN_ROUND_OFF * size
        )
        last = known and way < LAST_STEP
        if gap > most or (last and gap >= most - GAIN_ROUND_OFF * size):
            best, most = moved, max(gap, most)
            longest = min(2.0 * longest, FARTHEST)
        elif known:
            longest = 0.25 * way
        if last:
            break
    flights.views[flight_record.PIECES_KNOWN] = float(count)
    for side in range(2):
        axis, gap, _, _ = _end_of_cylinder(a, b, side, best, flights)
        if gap >= most - GAIN_ROUND_OFF * size:
            return axis
    return best
