# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball or a capsule against a convex polyhedron: a core, a point or a segment, with a layer around.

gap = distance of the core from the polyhedron - radius

Where the core itself overlaps the polyhedron, the axis of least overlap takes the place of the
nearest points: a face normal of the polyhedron or the cross product of core and edge (`EDGE_LEAD`,
`EDGE_SHARE` of `two_polyhedra`). A capsule that lies on a face touches at both ends of the part of
its core that is over the face.

The polyhedron is A of `relative_pose`, the core B: the manifold's own normal is the opposite one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    POINT,
    TINY,
    write_normal,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import keep_four
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import (
    STEEP,
    facing,
    side_of,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    EDGE,
    EDGES,
    END,
    FACES,
    HALF,
    LEFT,
    PLANE,
    PLANE_OFFSET,
    RADIUS,
    RIGHT,
    START,
    VERTEX,
    Hull,
    edges_of,
    loop_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    axis_of_b,
    relate,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    AXIS,
    AXIS_B,
    CANDIDATES,
    CORE_END,
    CORE_IN_B,
    CORE_START,
    OFFSET,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    Vertices,
    support,
    vertices_of,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    EXACT,
    LARGEST,
    nearest_to_axis,
    to_world,
)
from rigid_body_sim.physics.vectors import (
    add_scaled,
    divide,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

CENTER_OF_CORE = (0.0, 0.0, 0.0)  # [m] its own axes
NEAREST_POINT = -1.0  # feature of the point that is nearest to the polyhedron
AT_START, AT_END = 1.0, 0.0  # features, on a face, of the ends of the core; its sides follow
SIDES_FROM = 2.0  # features of the sides of a face begin here
ROUNDED = 5e-11  # [-] 1 - cosine of 1e-5: a normal as near to that of a face is that of the face
FLUSH_ANGLE = 5e-9  # [-] of 1e-4: it is, too, but the distance is the true one
FACE_NAMES = 64.0  # [-] most sides of a face that have names of their own


@kernel
def collide_core(
    radius: float, half_length: float, numbers: Array, begin: int, poses: Array, pose_core: int,
    pose_hull: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the manifold of a core and a record of `hull_records`.

    radius, half_length  : [m]  of the core along its z axis; half_length 0: a ball
    begin                : where the record begins in `numbers`
    pose_core, pose_hull : where the poses of core and polyhedron begin
    Normal from the core to the polyhedron; else see `manifold`.
    """
    hull = Hull(numbers, begin)
    center = load(numbers, begin + CENTER)
    relate(center, CENTER_OF_CORE, poses, pose_hull, pose_core, found)
    offset = load(found, OFFSET)
    size = numbers[begin + RADIUS] + half_length + radius
    reach = size + margin
    if not (dot(offset, offset) <= reach * reach and size < LARGEST):
        return 0
    is_segment = half_length > 0.0
    axis = axis_of_b(found, 2)
    store(found, CORE_IN_B, (0.0, 0.0, half_length))
    store(found, CORE_IN_B + VERTEX, (0.0, 0.0, -half_length))
    store(found, CORE_START, add_scaled(offset, half_length, axis))
    store(found, CORE_END, add_scaled(offset, -half_length, axis))
    core = Vertices(found, CORE_IN_B, 2 if is_segment else 1, 0)
    state, _ = closest(vertices_of(hull), core, margin + radius, size, found)
    if state == FAR:
        return 0
    if state == GAP:
        along = _take_face_normal(hull, nearest_to_axis(found), found)
    else:
        along = _overlap(hull, is_segment, found)
    gap = along - radius
    if not gap <= margin:
        return 0
    normal = load(found, AXIS)
    count, least = 0, math.inf
    if is_segment:
        count, least = _part_over_face(hull, radius, along, margin, found)
    if not least <= gap + EXACT * size:
        position = add_scaled(load(found, AXIS_B), -(radius + 0.5 * gap), normal)
        write_point_at(found, CANDIDATES + POINT * count, position, gap, NEAREST_POINT)
        count += 1
    write_normal(found, negate(normal))
    count = keep_four(found, CANDIDATES, count)
    to_world(center, poses, pose_hull, found, count)
    return count


@inline
def _take_face_normal(hull: Hull, distance: float, work: Array) -> float:
    """
    Let AXIS be the normal of a face to the last digit where it is that of a face but for
    rounding, or by less than tiles are flush; return the distance.
    """
    axis = load(work, AXIS)
    plane = planes_of(hull) + PLANE * facing(hull, axis)
    normal, offset = load(hull.numbers, plane), hull.numbers[plane + PLANE_OFFSET]
    cosine = dot(axis, normal)
    if cosine > 1.0 - FLUSH_ANGLE:
        store(work, AXIS, normal)
    if not cosine > 1.0 - ROUNDED:
        return distance
    start, stop = dot(normal, load(work, CORE_START)), dot(normal, load(work, CORE_END))
    return min(start, stop) - offset


@kernel
def _overlap(hull: Hull, is_segment: bool, work: Array) -> float:
    """Write to AXIS the normal of least overlap and, behind, the core's point; return s."""
    start, stop = load(work, CORE_START), load(work, CORE_END)
    numbers, planes = hull.numbers, planes_of(hull)
    most, end = -math.inf, 0.0
    normal = (0.0, 0.0, 0.0)
    for face in range(int(numbers[hull.begin + FACES])):
        plane = planes + PLANE * face
        face_normal, offset = load(numbers, plane), numbers[plane + PLANE_OFFSET]
        at_start, at_stop = dot(face_normal, start) - offset, dot(face_normal, stop) - offset
        if min(at_start, at_stop) > most:
            most = min(at_start, at_stop)
            end = 0.5 if at_start == at_stop else 0.0 if at_start < at_stop else 1.0
            normal = face_normal
    if is_segment:
        most, end, normal = _overlap_of_edges(hull, start, stop, most, end, normal)
    store(work, AXIS, normal)
    store(work, AXIS_B, add_scaled(start, end, subtract(stop, start)))
    return most


@kernel
def _overlap_of_edges(
    hull: Hull, start: Any, stop: Any, most: float, end: float, normal: Any
) -> Any:
    """
    Find whether a cross product of core and edge separates better than a face.

    start, stop : ends of the core
    end         : share of the core at which its nearest point lies
    Returns s, that share and the normal; those of the face are given.
    """
    numbers, planes, edges = hull.numbers, planes_of(hull), edges_of(hull)
    vertices = vertices_of(hull)
    floor = most + EDGE_LEAD * numbers[hull.begin + HALF] + EDGE_SHARE * abs(most)
    core = subtract(stop, start)
    squared_core = dot(core, core)
    for edge in range(edges, edges + EDGE * int(numbers[hull.begin + EDGES]), EDGE):
        left_normal = load(numbers, planes + PLANE * int(numbers[edge + LEFT]))
        right_normal = load(numbers, planes + PLANE * int(numbers[edge + RIGHT]))
        left, right = dot(core, left_normal), dot(core, right_normal)
        if not left * right < 0.0:  # no normal between the two faces is across the core
            continue
        # The normal between them that is: the combination without a part along the core.
        across = add_scaled(scale(abs(right), left_normal), abs(left), right_normal)
        size = math.sqrt(dot(across, across))
        if not size * size > max(NO_CROSS_PRODUCT * squared_core, TINY):
            continue
        across = divide(across, size)
        along = min(dot(start, across), dot(stop, across))
        first = int(numbers[edge + START])
        begin = vertex(hull, first)
        if not along - dot(begin, across) > floor:
            continue
        along -= dot(vertex(hull, support(vertices, across, first)), across)
        if along > floor:
            most = floor = along
            normal = across
            run = subtract(vertex(hull, int(numbers[edge + END])), begin)
            way = subtract(begin, start)
            squared, both = dot(run, run), dot(core, run)
            det = squared_core * squared - both * both
            end = 0.5
            if det > NO_CROSS_PRODUCT * squared_core * squared:
                end = (dot(core, way) * squared - dot(run, way) * both) / det
                end = min(max(end, 0.0), 1.0)
    return most, end, normal


@kernel
def _part_over_face(
    hull: Hull, radius: float, along: float, margin: float, work: Array
) -> tuple[int, float]:
    """Write the ends of the part of the core over the face that looks along AXIS."""
    normal, start = load(work, AXIS), load(work, CORE_START)
    core = subtract(load(work, CORE_END), start)
    face = facing(hull, normal)
    plane = planes_of(hull) + PLANE * face
    face_normal, offset = load(hull.numbers, plane), hull.numbers[plane + PLANE_OFFSET]
    steep = dot(face_normal, normal)
    if not steep > STEEP:
        return 0, math.inf
    begin, end = 0.0, 1.0
    begin_name, end_name = AT_START, AT_END
    loop = loop_of(hull, face)
    sides = int(hull.numbers[loop])
    for index in range(sides):
        side, limit = side_of(hull, loop, sides, index, False, normal, work)
        room = limit - dot(side, start)
        rate = dot(side, core)
        if rate > 0.0:
            if room < end * rate:
                end, end_name = room / rate, SIDES_FROM + index
        elif rate < 0.0:
            if room < begin * rate:
                begin, begin_name = room / rate, SIDES_FROM + index
        elif room < 0.0:
            return 0, math.inf
    if not begin <= end:
        return 0, math.inf
    kept, least = 0, math.inf
    for share, name in ((begin, begin_name), (end, end_name)):
        point = add_scaled(start, share, core)
        gap = max((dot(face_normal, point) - offset) / steep, along) - radius
        if gap <= margin:
            position = add_scaled(point, -(radius + 0.5 * gap), normal)
            feature = float(face) * FACE_NAMES + name
            write_point_at(work, CANDIDATES + POINT * kept, position, gap, feature)
            kept += 1
            least = min(least, gap)
    return kept, least
