# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A face of one box against the other box: the patch in which they face each other.

The reference face is that of the separating axis; the incident face is the one of the other box
that faces it most, a parallelogram c + alpha p + beta q, |alpha|, |beta| <= 1, seen along the axes
u, v of the reference face. The patch is what the two have in common: corners of the incident face
over the reference face, points where its edges cross the edges of the reference face (clipping
after Liang and Barsky, ACM Trans. Graph. 3 (1984) 1), and corners of the reference face under it.
What lies within the margin of the reference face is the manifold.

Vectors u, v, w: along the two axes of the reference face, and its normal, from its middle [m].
"""

from __future__ import annotations

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

MOST_OF_PATCH = 12  # [-] corners of the patch, some of them twice

faces = Record(begin=SCRATCH)
INCIDENT = faces.numbers(4 * FLAT_POINT, 'm', 'corners of the incident face')
PATCH = faces.numbers(MOST_OF_PATCH * FLAT_POINT, 'm', 'corners of the patch')
CHOSEN = faces.numbers(MOST * FLAT_POINT, 'm', 'those that are kept')
ROUND = faces.numbers(MOST_OF_PATCH * FLAT_POINT, 'm', 'corners of the patch, one after the other')

CUTS, UNDER, NAMES = 4.0, 20.0, 24.0  # features: edge 0 … 3 cut by side 0 … 3, corners under it
DEEPEST = 40000.0  # features of corners that lie deepest
SQUARE = 1e-3  # [-] of the size: a patch that is off by less is a parallelogram
ROUNDING = 1e-12  # [-] of a half edge: a corner beyond an edge by less is over the face
UNCUT = -1.0  # an edge of the incident face that begins or ends over the reference face
LOW_U, HIGH_U, LOW_V, HIGH_V = 0.0, 1.0, 2.0, 3.0  # edges of the reference face


@inline
def _write(found: Array, at: int, corner: Any, name: float) -> None:
    store(found, at, corner)
    found[at + NAME] = name


@kernel
def _cut_edges(found: Array, half_u: float, half_v: float, margin: float) -> int:
    """Append the corners and cut points of the edges of the incident face; return their number."""
    count = 0
    limit_u, limit_v = half_u * (1.0 + ROUNDING), half_v * (1.0 + ROUNDING)
    for edge in range(4):
        begin = load(found, INCIDENT + edge * FLAT_POINT)
        along = subtract(load(found, INCIDENT + ((edge + 1) & 3) * FLAT_POINT), begin)
        first, last, enter, leave = 0.0, 1.0, UNCUT, UNCUT
        if along[0] != 0.0:
            near, far = (-limit_u - begin[0]) / along[0], (limit_u - begin[0]) / along[0]
            near_side, far_side = LOW_U, HIGH_U
            if near > far:
                near, far, near_side, far_side = far, near, HIGH_U, LOW_U
            if near > first:
                first, enter = near, near_side
            if far < last:
                last, leave = far, far_side
        elif abs(begin[0]) > limit_u:
            continue
        if along[1] != 0.0:
            near, far = (-limit_v - begin[1]) / along[1], (limit_v - begin[1]) / along[1]
            near_side, far_side = LOW_V, HIGH_V
            if near > far:
                near, far, near_side, far_side = far, near, HIGH_V, LOW_V
            if near > first:
                first, enter = near, near_side
            if far < last:
                last, leave = far, far_side
        elif abs(begin[1]) > limit_v:
            continue
        if first > last:
            continue
        corner = add_scaled(begin, first, along)
        if corner[2] <= margin:
            name = 1.0 * edge if enter == UNCUT else CUTS + 4.0 * edge + enter
            _write(found, PATCH + count * FLAT_POINT, corner, name)
            count += 1
        if leave == UNCUT or last == first:
            continue  # the next edge begins there, or this one only touches a corner
        corner = add_scaled(begin, last, along)
        if corner[2] <= margin:
            _write(found, PATCH + count * FLAT_POINT, corner, CUTS + 4.0 * edge + leave)
            count += 1
    return count


@inline
def _direction(u: float, v: float) -> float:
    """Return a number that grows with the angle of a vector, 0 to 4."""
    both = abs(u) + abs(v)
    along = u / (both if both > 0.0 else 1.0)
    return 1.0 - along if v >= 0.0 else 3.0 + along


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


@kernel
def _measure_patch(found: Array, count: int) -> None:
    """Put the corners of the patch in order about their mean, and measure its face."""
    mean_u, mean_v = 0.0, 0.0
    for at in range(PATCH, PATCH + FLAT_POINT * count, FLAT_POINT):
        mean_u += found[at + U] / count
        mean_v += found[at + V] / count
    for index in range(count):
        at = PATCH + FLAT_POINT * index
        corner = load(found, at)
        direction = _direction(corner[0] - mean_u, corner[1] - mean_v)
        place = index
        while place > 0 and found[ROUND + FLAT_POINT * (place - 1) + NAME] > direction:
            before, to = ROUND + FLAT_POINT * (place - 1), ROUND + FLAT_POINT * place
            _write(found, to, load(found, before), found[before + NAME])
            place -= 1
        _write(found, ROUND + FLAT_POINT * place, corner, direction)
    measure_face(found, ROUND, FLAT_POINT, count)


@kernel
def _patch(
    found: Array, center: Any, edge_p: Any, edge_q: Any, half_u: float, half_v: float,
    margin: float,
) -> Any:  # fmt: skip
    """
    Find up to four corners of the patch; return their number and where they begin.

        center, edge_p, edge_q : c, p, q of the incident face (u, v, w)
        half_u, half_v         : half edges of the reference face
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
    count = _cut_edges(found, half_u, half_v, margin)
    det = edge_p[0] * edge_q[1] - edge_p[1] * edge_q[0]
    if not inside and det != 0.0:
        for k in range(4):
            corner_u, corner_v = half_u if k & 1 else -half_u, half_v if k & 2 else -half_v
            arm_u, arm_v = corner_u - center[0], corner_v - center[1]
            alpha = arm_u * edge_q[1] - arm_v * edge_q[0]
            beta = arm_v * edge_p[0] - arm_u * edge_p[1]
            if abs(alpha) < abs(det) and abs(beta) < abs(det):
                separation = center[2] + (alpha / det * edge_p[2] + beta / det * edge_q[2])
                if separation <= margin:
                    corner = (corner_u, corner_v, separation)
                    _write(found, PATCH + count * FLAT_POINT, corner, UNDER + k)
                    count += 1
    kept, first = count, PATCH
    if count > 2:
        kept, first = keep_four_flat(found, PATCH, count, CHOSEN), CHOSEN
    if count > 2 and not _is_parallelogram(found, count, kept, first):
        _measure_patch(found, count)
    return kept, first


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
    count, first = _patch(found, center, edge_p, edge_q, half_u, half_v, margin)
    number = (((3.0 if of_b else 0.0) + axis) * 2.0 + (side > 0.0)) * 6.0
    number = number + 2.0 * facing_axis + facing
    origin = load(poses, pose_r)
    for k in range(count):
        at = first + k * FLAT_POINT
        separation = found[at + HEIGHT]
        in_face = add_scaled(scale(found[at + U], axis_u), found[at + V], axis_v)
        arm = add_scaled(in_face, half + 0.5 * separation, normal)
        write_point(found, k, add(origin, arm), separation, number * NAMES + found[at + NAME])
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
