# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder on a face of a box, with its true round rim: it rolls, spins and stands as on a plane.

The separating axes that are exact for both are tried: the faces of the box, the ends of the
cylinder, and the cross products of its axis with the edges of the box. Where a face separates them
most, the points are those of a cylinder on a plane as far as they lie over the face, and the ends
of what hangs over: the lowest line of a lying cylinder, cut at the edges of the face; where the
circle of a standing one crosses the edges; the corners of the face under it. All other cases (an
edge or a corner at the mantle, at the rim or at an end, deep overlap) are left to other kernels.

Over the face, points and ways are (u, v, w): along the two axes of the face from its middle, and
the gap over it [m]. The lower end of the cylinder is the disc

    c + x e_x + y e_y,  x^2 + y^2 <= r^2        c its middle, e_x, e_y the axes of the end
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import (
    lies,
    rim_directions,
    rim_feature,
)
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_COMMON_NORMAL
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import one_of
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    FACE_MIDDLE,
    MOST,
    POINT,
    POINTS,
    RIM,
    SCRATCH,
    SHAPE_B,
    copy_point,
    write_normal,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import (
    FLAT_POINT,
    HEIGHT,
    NAME,
    U,
    V,
    keep_four,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import clip_by_side
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    CORNER,
    MOST_CORNERS,
)
from rigid_body_sim.physics.contact.collision.geometry.touching_face import (
    measure_face,
    write_disc,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, scale, store, subtract

Array = NDArray[np.float64]

HANGING = 0.01  # [-] of the radius: how much higher than the lowest point what is over the face is
SHALLOW = 0.2  # [-] of the smallest size: deeper, the rim may leave sooner over an edge
STANDS_ON_FACE = 0.99  # [-] cosine between the axis and a face on which the cylinder stands
# cosine and sine of the turn from one chord to the next, and radius of corners whose polygon has
# the area of the circle
TURN_X, TURN_Y = 0.9659258262890683, 0.25881904510252074
WIDER = 1.0057410998499876
ROUNDING = 1e-12  # [-] a point beyond an edge by less is over the face
CUTS, CORNERS = 30.0, 40.0  # features: where edges cut, corners of the face
FAR_END = 100.0  # added to the feature of a point fixed in the end at the other end of its line

ROW = 3  # numbers of a row of TURN
MOST_POINTS = 16  # [-] of the rim, where it crosses the edges, and corners: 4 + 8 + 4

on_box = Record(begin=SCRATCH)
TURN = on_box.matrix('-', 'axes of the cylinder (columns) in those of the box')
OFFSET = on_box.vector('m', 'middle of the cylinder from that of the box, box axes')
OVER_FACE = on_box.numbers(MOST_POINTS * FLAT_POINT, 'm', 'points over the face, (u, v, w)')
CANDIDATES = on_box.numbers(MOST_POINTS * POINT, 'm', 'the same as points of a manifold')
CHORDS = 24  # [-] of a circle that is cut
ARC = on_box.numbers(MOST_CORNERS * CORNER, 'm', 'corners of the end over the face')
CUT = on_box.numbers(MOST_CORNERS * CORNER, 'm', 'the same, clipped by one more side')


@inline
def _row(found: Array, axis: int) -> Any:
    """Axis of the box in the axes of the cylinder."""
    return load(found, TURN + ROW * axis)


@inline
def _along_axis(found: Array, axis: int) -> Any:
    """Component of the axis of the cylinder along an axis of the box."""
    return found[TURN + ROW * axis + 2]


@kernel
def _relate(poses: Array, pose_a: int, pose_b: int, found: Array) -> None:
    offset = subtract(load(poses, pose_b), load(poses, pose_a))
    for i in range(3):
        axis = pose.axis(poses, pose_a, i)
        found[OFFSET + i] = dot(axis, offset)
        store(found, TURN + ROW * i, pose.to_shape(poses, pose_b, axis))


@kernel
def on_face(
    parameters: Array, box: int, cylinder: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of a box and a cylinder, or return UNDECIDED; else see `manifold`."""
    _relate(poses, pose_a, pose_b, found)
    radius, half = parameters[cylinder + RADIUS], parameters[cylinder + HALF_LENGTH]
    best, face = -math.inf, 0
    smallest = min(radius, half)
    along, spread = 0.0, half
    for k in range(3):
        across_x, across_y, rise = _row(found, k)
        sine = math.sqrt(across_x * across_x + across_y * across_y)
        half_edge = parameters[box + k]
        separation = abs(found[OFFSET + k]) - (half_edge + half * abs(rise) + radius * sine)
        if not separation <= margin:
            return 0
        if separation > best:
            best, face = separation, k
        smallest = min(smallest, half_edge)
        along += found[OFFSET + k] * rise
        spread += half_edge * abs(rise)
    to_beat = best + EDGE_LEAD * smallest + EDGE_SHARE * abs(best)
    separation = abs(along) - spread
    if separation > margin:
        return 0
    by_end = separation > to_beat
    by_edge = False
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        normal_i, normal_j = -_along_axis(found, j), _along_axis(found, i)  # e_k x a
        squared = normal_i * normal_i + normal_j * normal_j
        if squared < NO_COMMON_NORMAL:
            continue
        separation = abs(normal_i * found[OFFSET + i] + normal_j * found[OFFSET + j])
        separation = (
            separation - parameters[box + i] * abs(normal_i) - parameters[box + j] * abs(normal_j)
        ) / math.sqrt(squared) - radius
        if separation > margin:
            return 0
        if separation > to_beat:
            to_beat, by_edge = separation, True
    if (to_beat if by_edge else best) < -SHALLOW * smallest:
        return UNDECIDED
    if by_edge or by_end:
        return UNDECIDED
    count = _over_face(parameters, box, cylinder, margin, found, face)
    if not _least_gap(found, count) <= best + HANGING * radius:
        return UNDECIDED
    _to_world(parameters, box, poses, pose_a, found, face, count)
    if count > 2 and abs(_along_axis(found, face)) > STANDS_ON_FACE:
        _measure_end(parameters, box, cylinder, poses, pose_a, found, face, count)
    found[RIM] = SHAPE_B
    if count > MOST or not _is_rim(found, count):
        return keep_four(found, CANDIDATES, count)
    for k in range(count):
        copy_point(found, POINTS + k * POINT, CANDIDATES + k * POINT)
    return count


@kernel
def _measure_end(
    parameters: Array, box: int, cylinder: int, poses: Array, pose_a: int, found: Array,
    face: int, count: int,
) -> None:  # fmt: skip
    """Measure the end of a cylinder as far as it is over a face of the box: its arcs as chords."""
    along_u, along_v = (face + 1) % 3, (face + 2) % 3
    end = parameters[cylinder + HALF_LENGTH]
    rise = -_along_axis(found, face) if found[OFFSET + face] > 0.0 else _along_axis(found, face)
    end = end if rise > 0.0 else -end
    u = found[OFFSET + along_u] + end * _along_axis(found, along_u)
    v = found[OFFSET + along_v] + end * _along_axis(found, along_v)
    half_u, half_v = parameters[box + along_u], parameters[box + along_v]
    if _is_rim(found, count):
        write_disc(found, parameters[cylinder + RADIUS], (u, v, 0.0))
    else:
        radius = WIDER * parameters[cylinder + RADIUS]
        cosine, sine = 1.0, 0.0
        for corner in range(CHORDS):
            place = ARC + CORNER * corner
            store(found, place, (u + radius * cosine, v + radius * sine, 0.0))
            cosine, sine = cosine * TURN_X - sine * TURN_Y, sine * TURN_X + cosine * TURN_Y
        corners = clip_by_side(found, ARC, CUT, CHORDS, (1.0, 0.0, 0.0), half_u, 0.0)
        corners = clip_by_side(found, CUT, ARC, corners, (-1.0, 0.0, 0.0), half_u, 0.0)
        corners = clip_by_side(found, ARC, CUT, corners, (0.0, 1.0, 0.0), half_v, 0.0)
        corners = clip_by_side(found, CUT, ARC, corners, (0.0, -1.0, 0.0), half_v, 0.0)
        measure_face(found, ARC, CORNER, corners)
    middle = load(found, FACE_MIDDLE)
    level = -parameters[box + face] if found[OFFSET + face] < 0.0 else parameters[box + face]
    place = add_scaled(load(poses, pose_a), level, pose.axis(poses, pose_a, face))
    place = add_scaled(place, middle[0], pose.axis(poses, pose_a, along_u))
    store(found, FACE_MIDDLE, add_scaled(place, middle[1], pose.axis(poses, pose_a, along_v)))


@inline
def _is_rim(found: Array, count: int) -> bool:
    """Tell whether all points are of the rim."""
    is_rim = True
    for k in range(count):
        is_rim = is_rim and found[OVER_FACE + k * FLAT_POINT + NAME] < CUTS
    return is_rim


@inline
def _least_gap(found: Array, count: int) -> Any:
    least = math.inf
    for k in range(count):
        least = min(least, found[OVER_FACE + k * FLAT_POINT + HEIGHT])
    return least


@inline
def _to_world(
    parameters: Array, box: int, poses: Array, pose_a: int, found: Array, face: int, count: int
) -> None:
    """Write the normal, and make the points over a face of the box points of a manifold."""
    side = -1.0 if found[OFFSET + face] < 0.0 else 1.0
    level = side * parameters[box + face]
    axis_w = pose.axis(poses, pose_a, face)
    axis_u = pose.axis(poses, pose_a, (face + 1) % 3)
    axis_v = pose.axis(poses, pose_a, (face + 2) % 3)
    write_normal(found, scale(side, axis_w))
    origin = load(poses, pose_a)
    for k in range(count):
        at = OVER_FACE + k * FLAT_POINT
        separation = found[at + HEIGHT]
        height = level + (0.5 * separation if level > 0.0 else -0.5 * separation)
        in_face = add_scaled(scale(found[at + U], axis_u), found[at + V], axis_v)
        position = add(origin, add_scaled(in_face, height, axis_w))
        write_point_at(found, CANDIDATES + k * POINT, position, separation, found[at + NAME])


@inline
def _append(found: Array, count: int, over_face: Any, margin: float, feature: float) -> Any:
    """Append a point (u, v, w), if it is within the margin; return the new count."""
    if not over_face[2] <= margin:
        return count
    at = OVER_FACE + count * FLAT_POINT
    store(found, at, over_face)
    found[at + NAME] = feature
    return count + 1


@inline
def _on_disc(center: Any, end_x: Any, end_y: Any, x: float, y: float) -> Any:
    """Point of the plane of an end: c + x e_x + y e_y."""
    return add_scaled(add_scaled(center, x, end_x), y, end_y)


@kernel
def _over_face(
    parameters: Array, box: int, cylinder: int, margin: float, found: Array, face: int
) -> int:
    """Collect the points over a face of the box; return their number."""
    radius, half = parameters[cylinder + RADIUS], parameters[cylinder + HALF_LENGTH]
    along_u, along_v = (face + 1) % 3, (face + 2) % 3
    half_u, half_v = parameters[box + along_u], parameters[box + along_v]
    limit_u, limit_v = half_u * (1.0 + ROUNDING), half_v * (1.0 + ROUNDING)
    side = -1.0 if found[OFFSET + face] < 0.0 else 1.0
    tilt_x, tilt_y, rise = scale(side, _row(found, face))
    u_of_x, u_of_y, u_of_axis = _row(found, along_u)
    v_of_x, v_of_y, v_of_axis = _row(found, along_v)
    lowest, after, before, last = rim_directions(tilt_x, tilt_y, found)
    upper_end = rise < 0.0  # the end at +z is the lower one
    end = half if upper_end else -half
    center = (
        found[OFFSET + along_u] + end * u_of_axis,
        found[OFFSET + along_v] + end * v_of_axis,
        side * found[OFFSET + face] - parameters[box + face] - half * abs(rise),
    )
    end_x, end_y = (u_of_x, v_of_x, tilt_x), (u_of_y, v_of_y, tilt_y)
    sine = tilt_x * lowest[0] + tilt_y * lowest[1]
    is_lying = lies(rise, sine, half, radius * sine, center[2], margin)
    count = 0
    for k in range(3 if is_lying else 4):
        x, y, fixed = one_of(k, lowest, after, before, last)
        point = _on_disc(center, end_x, end_y, -radius * x, -radius * y)
        feature = rim_feature(k, fixed, upper_end)
        if k == 0 and is_lying:
            line = (-2.0 * end * u_of_axis, -2.0 * end * v_of_axis, 2.0 * half * abs(rise))
            count = _line(found, point, line, limit_u, limit_v, margin, feature)
        elif abs(point[0]) <= limit_u and abs(point[1]) <= limit_v:
            count = _append(found, count, point, margin, feature)
    if is_lying:
        return count
    count = _cuts(found, count, center, end_x, end_y, radius, limit_u, limit_v, margin)
    return _corners(found, count, center, end_x, end_y, radius, half_u, half_v, margin)


@kernel
def _cuts(
    found: Array, count: int, center: Any, end_x: Any, end_y: Any, radius: float,
    limit_u: float, limit_v: float, margin: float,
) -> int:  # fmt: skip
    """
    Append the points where the circle of an end crosses the edges of the face.

    Along u or v the edge is at D = p cos + q sin.
    """
    for cut in range(4):
        across_v = cut < 2  # an edge at a value of u
        p, q, middle, limit = end_x[1], end_y[1], center[1], limit_v
        if across_v:
            p, q, middle, limit = end_x[0], end_y[0], center[0], limit_u
        distance = ((limit if cut & 1 else -limit) - middle) / radius
        squared = p * p + q * q
        if not distance * distance < squared:
            continue
        root = math.sqrt(squared - distance * distance)
        for turn in range(2):
            sign = -1.0 if turn else 1.0
            cosine = (p * distance - sign * q * root) / squared
            sine = (q * distance + sign * p * root) / squared
            point = _on_disc(center, end_x, end_y, radius * cosine, radius * sine)
            if (abs(point[1]) <= limit_v) if across_v else (abs(point[0]) <= limit_u):
                count = _append(found, count, point, margin, CUTS + 2.0 * cut + turn)
    return count


@kernel
def _corners(
    found: Array, count: int, center: Any, end_x: Any, end_y: Any, radius: float,
    half_u: float, half_v: float, margin: float,
) -> int:  # fmt: skip
    """Append the corners of the face below the end: straight up to the plane of the end."""
    det = end_x[0] * end_y[1] - end_y[0] * end_x[1]
    if det == 0.0:
        return count
    for corner in range(4):
        corner_u = half_u if corner & 1 else -half_u
        corner_v = half_v if corner & 2 else -half_v
        arm_u, arm_v = corner_u - center[0], corner_v - center[1]
        x = (arm_u * end_y[1] - arm_v * end_y[0]) / det
        y = (arm_v * end_x[0] - arm_u * end_x[1]) / det
        if x * x + y * y <= radius * radius:
            separation = center[2] + x * end_x[2] + y * end_y[2]
            count = _append(
                found, count, (corner_u, corner_v, separation), margin, CORNERS + corner
            )
    return count


@kernel
def _line(
    found: Array, begin: Any, line: Any, limit_u: float, limit_v: float, margin: float,
    feature: float,
) -> int:  # fmt: skip
    """Write the ends of the lowest line of a lying cylinder, as far as it is over the face."""
    first, last = 0.0, 1.0
    start, stop = feature, 1.0 - feature if feature < 2.0 else feature + FAR_END
    for direction in range(2):
        from_middle, along, limit = begin[0], line[0], limit_u
        if direction:
            from_middle, along, limit = begin[1], line[1], limit_v
        if along == 0.0:
            if abs(from_middle) > limit:
                return 0
            continue
        near, far = (-limit - from_middle) / along, (limit - from_middle) / along
        if near > far:
            near, far = far, near
        if near > first:
            first, start = near, CUTS + 2.0 * direction + (along > 0.0)
        if far < last:
            last, stop = far, CUTS + 2.0 * direction + (along < 0.0)
    if first > last:
        return 0
    count = _append(found, 0, add_scaled(begin, first, line), margin, start)
    return _append(found, count, add_scaled(begin, last, line), margin, stop)
