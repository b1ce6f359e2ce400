# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A face of one box against the other box: the patch in which they face each other.

The reference face is that of the separating axis; the incident face is the one of the other box
that faces it most, a parallelogram c + alpha p + beta q, |alpha|, |beta| <= 1, seen along the axes
u, v of the reference face. The patch is what the two have in common: corners of the incident face
over the reference face, points where its edges cross the edges of the reference face, and corners
of the reference face under it (clipping after Sutherland and Hodgman, Comm. ACM 17 (1974) 32).
What lies within the margin of the reference face is the manifold.

Vectors u, v, w: along the two axes of the reference face, and its normal, from its middle [m].
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import between
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    MOST,
    SCRATCH,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import (
    COINCIDENT,
    FLAT_POINT,
    HEIGHT,
    NAME,
    U,
    V,
    keep_four_flat,
)
from rigid_body_sim.physics.contact.collision.geometry.touching_face import measure_face
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

MOST_OF_PATCH = 12  # [-] corners of the patch: eight, and some twice by rounding

faces = Record(begin=SCRATCH)
INCIDENT = faces.numbers(4 * FLAT_POINT, 'm', 'corners of the incident face')
PATCH = faces.numbers(MOST_OF_PATCH * FLAT_POINT, 'm', 'corners of the patch, in order')
CHOSEN = faces.numbers(MOST * FLAT_POINT, 'm', 'those that are kept')
ROUND = faces.numbers(MOST_OF_PATCH * FLAT_POINT, 'm', 'what is left of it after every other side')

CUTS, UNDER, NAMES = 4.0, 20.0, 24.0  # features: edge 0 … 3 cut by side 0 … 3, corners under it
SIDES_OF_B = 36.0 * NAMES  # features from here on: the reference face is a side of B
DEEPEST = 40000.0  # features of corners that lie deepest
SQUARE = 1e-3  # [-] of the size: a patch that is off by less is a parallelogram
ROUNDING = 1e-12  # [-] of a half edge: a corner beyond an edge by less is over the face
LOW_U, HIGH_U, LOW_V, HIGH_V = 0.0, 1.0, 2.0, 3.0  # sides of the reference face
HIGH, SECOND = 1.0, 2.0  # its corner k at the ends of u, v
SIDES = 4.0  # edges of the patch: 0 … 3 of the incident face, from here on sides of the other
EDGES = 32.0  # while it is cut a name carries, times this, the edge that begins at the corner


@inline
def _write(found: Array, at: int, corner: Any, name: float) -> None:
    store(found, at, corner)
    found[at + NAME] = name


@kernel
def _clip(
    found: Array, source: int, count: int, axis: int, sign: float, half: float, side: float
) -> Any:  # fmt: skip
    """
    Cut off what of a polygon lies beyond a side of the reference face; return the number of its
    corners and where they begin now.

        source       : where its corners begin
        axis, sign   : U or V, and the end of it at which the side is
        half         : [m] distance of the side from the middle
        side         : its number
    """
    end, least = source + FLAT_POINT * count, -ROUNDING * half
    is_cut = False
    for at in range(source, end, FLAT_POINT):
        is_cut = is_cut | (half - sign * found[at + axis] < least)
    if not is_cut:
        return count, source
    to = ROUND if source == PATCH else PATCH
    place, before = to, end - FLAT_POINT
    inner = half - sign * found[before + axis]
    for at in range(source, end, FLAT_POINT):
        depth_before, inner = inner, half - sign * found[at + axis]
        if (depth_before < least) != (inner < least):
            # crosses the side between the two, one of them at most a rounding beyond it
            share = depth_before / (depth_before - inner)
            begin = load(found, before)
            way = subtract(load(found, at), begin)
            crossing = add_scaled(begin, min(1.0, max(0.0, share)), way)
            edge = found[before + NAME] // EDGES
            corner = UNDER + (HIGH if found[before + U] > 0.0 else 0.0)
            corner += SECOND if sign > 0.0 else 0.0
            name = corner if edge >= SIDES else CUTS + 4.0 * edge + side
            leads_on = side + SIDES if inner < least else edge
            _write(found, place, crossing, name + EDGES * leads_on)
            place += FLAT_POINT
        if not inner < least:
            _write(found, place, load(found, at), found[at + NAME])
            place += FLAT_POINT
        before = at
    return (place - to) // FLAT_POINT, to


@inline
def _common(found: Array, half_u: float, half_v: float, margin: float) -> int:
    """
    Find what the incident face has over the reference face (Sutherland and Hodgman): a polygon
    that loses no corner, whatever coincides. Write its corners within the margin as the patch,
    one after the other; return their number.
    """
    for k in range(4):
        found[INCIDENT + FLAT_POINT * k + NAME] += EDGES * k
    count, begin = _clip(found, INCIDENT, 4, U, -1.0, half_u, LOW_U)
    count, begin = _clip(found, begin, count, U, 1.0, half_u, HIGH_U)
    count, begin = _clip(found, begin, count, V, -1.0, half_v, LOW_V)
    count, begin = _clip(found, begin, count, V, 1.0, half_v, HIGH_V)
    kept = 0
    kept = 0
    for at in range(begin, begin + FLAT_POINT * count, FLAT_POINT):
        if found[at + HEIGHT] <= margin:
            name = found[at + NAME] % EDGES
            _write(found, PATCH + FLAT_POINT * kept, load(found, at), name)
            kept += 1
    return kept


@inline
def _is_parallelogram(found: Array, count: int, kept: int, begin: int) -> bool:
    """
    Tell whether the patch is as good as a parallelogram: opposite ones of its four corners
    balance, and all others are near one of them.

        kept, begin : corners that are kept, and where they begin
    """
    if kept != MOST:
        return False
    first, second = load(found, begin), load(found, begin + FLAT_POINT)
    third, last = load(found, begin + 2 * FLAT_POINT), load(found, begin + 3 * FLAT_POINT)
    limit = abs(third[0] - first[0]) + abs(third[1] - first[1])
    limit = SQUARE * (limit + abs(last[0] - second[0]) + abs(last[1] - second[1]))
    balanced = False
    for _ in range(3):
        off_u = first[0] + third[0] - second[0] - last[0]
        off_v = first[1] + third[1] - second[1] - last[1]
        balanced = balanced or abs(off_u) + abs(off_v) < limit
        second, third, last = third, last, second
    if count == kept or not balanced:
        return balanced
    for at in range(PATCH, PATCH + FLAT_POINT * count, FLAT_POINT):
        least = limit
        for corner in range(begin, begin + FLAT_POINT * MOST, FLAT_POINT):
            off_u, off_v = found[at + U] - found[corner + U], found[at + V] - found[corner + V]
            least = min(least, abs(off_u) + abs(off_v))
        if not least < limit:
            return False
    return True


@inline
def _neighbours_coincide(found: Array, count: int) -> bool:
    """Tell whether two corners of the patch that follow each other are one."""
    origin_u, origin_v = found[PATCH + U], found[PATCH + V]
    last_u, last_v, extent, shortest = origin_u, origin_v, 0.0, math.inf
    for at in range(PATCH + FLAT_POINT * (count - 1), PATCH, -FLAT_POINT):
        u, v = found[at + U], found[at + V]
        extent = max(extent, abs(u - origin_u), abs(v - origin_v))
        shortest = min(shortest, max(abs(u - last_u), abs(v - last_v)))
        last_u, last_v = u, v
    if count > 2:
        shortest = min(shortest, max(abs(last_u - origin_u), abs(last_v - origin_v)))
    return shortest < COINCIDENT * extent


@inline
def _in_order_of_names(found: Array, begin: int, count: int) -> None:
    """Write the points that are kept in the order of their names."""
    for index in range(count):
        at = begin + FLAT_POINT * index
        corner, name = load(found, at), found[at + NAME]
        place = CHOSEN + FLAT_POINT * index
        while place > CHOSEN and found[place - FLAT_POINT + NAME] > name:
            before = place - FLAT_POINT
            _write(found, place, load(found, before), found[before + NAME])
            place -= FLAT_POINT
        _write(found, place, corner, name)


@kernel
def _patch(
    found: Array, center: Any, edge_p: Any, edge_q: Any, half_u: float, half_v: float,
    margin: float, names: float,
) -> Any:  # fmt: skip
    """
    Find up to four corners of the patch; return their number and where they begin.

        center, edge_p, edge_q : c, p, q of the incident face (u, v, w)
        half_u, half_v         : half edges of the reference face
        names                  : see `keep_four_flat`
    """
    plus, minus = add(center, edge_p), subtract(center, edge_p)
    _write(found, INCIDENT, add(plus, edge_q), 0.0)
    _write(found, INCIDENT + FLAT_POINT, add(minus, edge_q), 1.0)
    _write(found, INCIDENT + 2 * FLAT_POINT, subtract(minus, edge_q), 2.0)
    _write(found, INCIDENT + 3 * FLAT_POINT, subtract(plus, edge_q), 3.0)
    inside = (
        abs(center[0]) + abs(edge_p[0]) + abs(edge_q[0]) <= half_u
        and abs(center[1]) + abs(edge_p[1]) + abs(edge_q[1]) <= half_v
    )
    if inside and center[2] + abs(edge_p[2]) + abs(edge_q[2]) <= margin:
        return 4, INCIDENT
    count = _common(found, half_u, half_v, margin)
    kept, first = count, PATCH
    if count > MOST or _neighbours_coincide(found, count):
        kept, first = keep_four_flat(found, PATCH, count, CHOSEN, names), CHOSEN
    if count > 2 and not _is_parallelogram(found, count, kept, first):
        measure_face(found, PATCH, FLAT_POINT, count)
    _in_order_of_names(found, first, kept)
    return kept, CHOSEN


@kernel
def face_contact(
    parameters: Array, reference: int, incident: int, poses: Array, pose_r: int, pose_i: int,
    margin: float, found: Array, of_b: bool, axis: int,
) -> int:  # fmt: skip
    """
    Find the manifold of a face of the reference box and the incident box; 0: none in the margin.

        of_b : the reference box is B
        axis : of the reference face
    """
    found[FACE_AREA] = 0.0
    along_u, along_v = (axis + 1) % 3, (axis + 2) % 3
    axis_u, axis_v = pose.axis(poses, pose_r, along_u), pose.axis(poses, pose_r, along_v)
    axis_w = pose.axis(poses, pose_r, axis)
    half = parameters[reference + axis]
    offset = between(poses, pose_r, pose_i)
    offset_w = dot(axis_w, offset)
    side = -1.0 if offset_w < 0.0 else 1.0
    normal = scale(side, axis_w)
    # the incident face: that of the axis nearest to the normal
    facing_axis = 0
    cosine = dot(pose.axis(poses, pose_i, 0), normal)
    for k in range(1, 3):
        along = dot(pose.axis(poses, pose_i, k), normal)
        if abs(along) > abs(cosine):
            facing_axis, cosine = k, along
    facing = cosine < 0.0
    height = parameters[incident + facing_axis]
    height = height if facing else -height
    toward = pose.axis(poses, pose_i, facing_axis)
    center = (
        dot(axis_u, offset) + height * dot(axis_u, toward),
        dot(axis_v, offset) + height * dot(axis_v, toward),
        side * offset_w + height * cosine - half,
    )
    one, other = (facing_axis + 1) % 3, (facing_axis + 2) % 3
    edge = scale(parameters[incident + one], pose.axis(poses, pose_i, one))
    edge_p = (dot(axis_u, edge), dot(axis_v, edge), dot(normal, edge))
    edge = scale(parameters[incident + other], pose.axis(poses, pose_i, other))
    edge_q = (dot(axis_u, edge), dot(axis_v, edge), dot(normal, edge))
    half_u, half_v = parameters[reference + along_u], parameters[reference + along_v]
    number = (((3.0 if of_b else 0.0) + axis) * 2.0 + (side > 0.0)) * 6.0
    names = (number + 2.0 * facing_axis + facing) * NAMES
    count, first = _patch(found, center, edge_p, edge_q, half_u, half_v, margin, names)
    origin = load(poses, pose_r)
    for k in range(count):
        at = first + k * FLAT_POINT
        separation = found[at + HEIGHT]
        in_face = add_scaled(scale(found[at + U], axis_u), found[at + V], axis_v)
        arm = add_scaled(in_face, half + 0.5 * separation, normal)
        write_point(found, k, add(origin, arm), separation, names + found[at + NAME])
    if found[FACE_AREA] > 0.0:
        middle = load(found, FACE_MIDDLE)
        arm = add_scaled(scale(middle[0], axis_u), middle[1], axis_v)
        store(found, FACE_MIDDLE, add(origin, add_scaled(arm, half, normal)))
    write_normal(found, negate(normal) if of_b else normal)
    return count


@kernel
def deepest_corner(
    parameters: Array, incident: int, poses: Array, pose_r: int, pose_i: int, found: Array,
    of_b: bool, axis: int, separation: float,
) -> int:  # fmt: skip
    """
    Report the corner of the incident box that lies deepest behind a face of the reference box.

        separation : [m]  along the axis of that face; that of the point, too
    """
    normal = pose.axis(poses, pose_r, axis)
    if dot(normal, between(poses, pose_r, pose_i)) < 0.0:
        normal = negate(normal)
    arm = scale(-0.5 * separation, normal)
    number = 0.0
    for k in range(3):
        edge = pose.axis(poses, pose_i, k)
        down = dot(normal, edge) > 0.0
        half = -parameters[incident + k] if down else parameters[incident + k]
        arm = add_scaled(arm, half, edge)
        number = 2.0 * number + down
    write_normal(found, negate(normal) if of_b else normal)
    feature = DEEPEST + 8.0 * of_b + number
    write_point(found, 0, add(load(poses, pose_i), arm), separation, feature)
    return 1
