# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A polyhedron on a triangle of a surface.

Apart, the nearest points tell the normal; overlapping, the axis of least overlap does, among those
normals that the surface has there:

    the face of the triangle
    faces of the body           only where the surface is highest along it at this triangle
    edge against edge           only convex edges, between the normals of the two triangles

so that neither an edge between two triangles of one plane nor one in a valley is ever touched
(Terdiman and Semrau filter contacts afterwards to the same end). The patch is that of two
polyhedra (`polyhedra.two_polyhedra`), of which one is flat.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    FEATURE,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    TINY,
    copy_point,
    write_normal,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hull_records
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import facing
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    CLIP,
    EDGE,
    EDGES,
    END,
    FACES,
    HALF,
    LEFT,
    PLANE,
    RADIUS,
    RIGHT,
    START,
    VERTEX,
    VERTICES,
    Hull,
    edges_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import ROW, from_b
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    AXIS,
    MOST_CORNERS,
    OFFSET,
    ROTATION,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.separating_axes import (
    NONE,
    OF_A,
    OF_B,
    nearest_on_edges,
    separation,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import vertices_of
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    nearest_to_axis,
    to_world,
    write_patch,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.core_on_triangle import is_summit
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    corner_of,
    lies_over,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.results import add_contact
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    BEYOND,
    BORDER,
    CONCAVE,
    CONVEX,
    EDGE_KIND,
    FACET,
    FACET_OF,
    FLATNESS,
    PLANES,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    NORMAL as TRIANGLE_NORMAL,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    BY_FACES,
    FREE,
    OVERLAP,
    OVERLAP_KEY,
    OVERLAP_NORMAL,
    OVERLAP_POINT,
    TRIANGLE_HULL,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL as FACET_NORMAL
from rigid_body_sim.physics.contact.collision.shape_parameters import OFFSET as FACET_OFFSET
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    divide,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

CONE_SLACK = 1e-3  # [-] sine within which a direction is a normal of the face, or lies in a cone
BESIDE = 0.05  # [-] of the radius of the body: an overlap that is less by more is one with others
FRONT, BACK = 0, 1  # faces of the flat polyhedron

PLANES_AT = VERTICES + 3 * VERTEX
LOOPS_AT = PLANES_AT + 2 * PLANE
EDGES_AT = LOOPS_AT + 2 * 4


@kernel
def write_triangle(parameters: Array, row: int, plane: int, found: Array) -> Any:
    """Write a triangle as a flat polyhedron of two faces; return its centre, world [m]."""
    at = TRIANGLE_HULL
    corners = (
        corner_of(parameters, row, 0),
        corner_of(parameters, row, 1),
        corner_of(parameters, row, 2),
    )
    normal = load(parameters, plane + FACET_NORMAL)
    center = scale(1.0 / 3.0, add(add(corners[0], corners[1]), corners[2]))
    farthest, shortest = 0.0, math.inf
    for index in range(3):
        arm = subtract(corners[index], center)
        side = subtract(corners[index + 1 if index < 2 else 0], corners[index])
        farthest, shortest = max(farthest, dot(arm, arm)), min(shortest, dot(side, side))
        store(found, at + VERTICES + VERTEX * index, arm)
        edge = at + EDGES_AT + EDGE * index
        found[edge + START], found[edge + END] = index, (index + 1) % 3
        found[edge + LEFT], found[edge + RIGHT] = FRONT, BACK
        found[at + LOOPS_AT + 1 + index] = index
        found[at + LOOPS_AT + 5 + index] = 2 - index
    height = parameters[plane + FACET_OFFSET] - dot(normal, center)
    store(found, at + PLANES_AT, normal)
    store(found, at + PLANES_AT + PLANE, negate(normal))
    found[at + PLANES_AT + 3], found[at + PLANES_AT + PLANE + 3] = height, -height
    found[at + LOOPS_AT] = found[at + LOOPS_AT + 4] = 3.0
    found[at + hull_records.COUNT], found[at + FACES], found[at + EDGES] = 3.0, 2.0, 3.0
    found[at + hull_records.PLANES], found[at + hull_records.LOOPS] = PLANES_AT, LOOPS_AT
    found[at + hull_records.EDGE_LIST], found[at + hull_records.NEAR] = EDGES_AT, 0.0
    found[at + hull_records.LOOP] = 4.0
    found[at + RADIUS], found[at + HALF] = math.sqrt(farthest), 0.5 * math.sqrt(shortest)
    return center


@kernel
def is_outer(normal: Any, parameters: Array, surface: int, row: int) -> bool:
    """
    Tell whether the surface is highest along a direction at this triangle, seen from outside: on
    its face, on one of its edges, or at one of its corners.
    """
    heights = (
        dot(normal, corner_of(parameters, row, 0)),
        dot(normal, corner_of(parameters, row, 1)),
        dot(normal, corner_of(parameters, row, 2)),
    )
    top = 0
    for index in range(1, 3):
        if heights[index] > heights[top]:
            top = index
    after, before = (top + 1) % 3, (top + 2) % 3
    summit = corner_of(parameters, row, top)
    way_after = subtract(corner_of(parameters, row, after), summit)
    way_before = subtract(corner_of(parameters, row, before), summit)
    drop_after, drop_before = heights[top] - heights[after], heights[top] - heights[before]
    square = CONE_SLACK * CONE_SLACK
    level_after = drop_after * drop_after <= square * dot(way_after, way_after)
    level_before = drop_before * drop_before <= square * dot(way_before, way_before)
    out = dot(normal, load(parameters, row + TRIANGLE_NORMAL))
    if level_after and level_before:
        return out > 0.0
    if level_after or level_before:
        edge = top if level_after else before
        kind = parameters[row + EDGE_KIND + edge]
        if kind == BORDER:
            return out > -CONE_SLACK
        if kind == CONCAVE:
            return False
        beyond = subtract(load(parameters, row + BEYOND + 3 * edge), summit)
        rise = dot(normal, beyond)
        return (kind == CONVEX or out > 0.0) and (
            rise <= 0.0 or rise * rise <= CONE_SLACK * CONE_SLACK * dot(beyond, beyond)
        )
    return is_summit(normal, parameters, surface, row, top, CONE_SLACK)


@inline
def _world(direction: Any, poses: Array, pose_a: int) -> Any:
    return pose.to_world(poses, pose_a, direction)


@kernel
def _axis_apart(
    a: Hull, b: Hull, half: float, poses: Array, pose_a: int, parameters: Array, surface: int,
    row: int, work: Array,
) -> tuple[int, int, float]:  # fmt: skip
    """
    Take the normal of the face of the triangle, or of the body, if it separates as well as the
    way between the nearest points does; OF_A with a face below 0: the surface is nearer elsewhere.
    """
    distance = nearest_to_axis(work)
    axis = load(work, AXIS)
    if not is_outer(negate(_world(axis, poses, pose_a)), parameters, surface, row):
        return OF_A, -1, distance
    floor = distance - EDGE_LEAD * half
    front = negate(from_b(work, load(b.numbers, planes_of(b))))
    along, _, _ = separation(a, b, work, front, 0, 0)
    if along > floor:
        return OF_B, FRONT, along
    face = facing(a, axis)
    normal = load(a.numbers, planes_of(a) + PLANE * face)
    along, _, _ = separation(a, b, work, normal, 0, 0)
    if along > floor and is_outer(negate(_world(normal, poses, pose_a)), parameters, surface, row):
        return OF_A, face, along
    return NONE, 0, distance


@kernel
def _axis_overlapping(
    a: Hull, b: Hull, half: float, poses: Array, pose_a: int, parameters: Array, surface: int,
    row: int, work: Array,
) -> tuple[int, int, float]:  # fmt: skip
    """
    Find the normal of least overlap among those that the surface has at this triangle; OF_A with a
    face below 0, where some face of the body tells that it is in the triangle by far less: there
    it touches what lies beside.
    """
    out = from_b(work, load(b.numbers, planes_of(b)))
    most, guess_a, guess_b = separation(a, b, work, negate(out), 0, 0)
    side, face, floor = OF_B, FRONT, most + EDGE_LEAD * half + EDGE_SHARE * abs(most)
    nearest = most
    for index in range(int(a.numbers[a.begin + FACES])):
        normal = load(a.numbers, planes_of(a) + PLANE * index)
        along, guess_a, guess_b = separation(a, b, work, normal, guess_a, guess_b)
        nearest = max(nearest, along)
        if along > floor and is_outer(
            negate(_world(normal, poses, pose_a)), parameters, surface, row
        ):
            side, face, most, floor = OF_A, index, along, along
    edge_a, edge_b, along = _best_edges(a, b, floor, poses, pose_a, parameters, surface, row, work)
    if max(most, along) < nearest - BESIDE * a.numbers[a.begin + RADIUS]:
        return OF_A, -1, most
    if edge_a >= 0:
        nearest_on_edges(a, b, work, edge_a, edge_b)
        return NONE, 0, along
    return side, face, most


@kernel
def _best_edges(
    a: Hull, b: Hull, floor: float, poses: Array, pose_a: int, parameters: Array, surface: int,
    row: int, work: Array,
) -> tuple[int, int, float]:  # fmt: skip
    """Find the edge of the body and the convex edge of the triangle that overlap least."""
    edge_a, edge_b, most = -1, -1, floor
    guess_a = guess_b = 0
    numbers, planes = a.numbers, planes_of(a)
    for of_b in range(3):
        kind = parameters[row + EDGE_KIND + of_b]
        if kind != CONVEX and kind != BORDER:
            continue
        start_b, stop_b = vertex(b, of_b), vertex(b, (of_b + 1) % 3)
        along_b = from_b(work, subtract(stop_b, start_b))
        for of_a in range(int(numbers[a.begin + EDGES])):
            edge = edges_of(a) + EDGE * of_a
            left = load(numbers, planes + PLANE * int(numbers[edge + LEFT]))
            right = load(numbers, planes + PLANE * int(numbers[edge + RIGHT]))
            if not dot(along_b, left) * dot(along_b, right) < 0.0:
                continue
            along_a = subtract(
                vertex(a, int(numbers[edge + END])), vertex(a, int(numbers[edge + START]))
            )
            normal = cross(along_a, along_b)
            squared = dot(normal, normal)
            if not squared > max(
                NO_CROSS_PRODUCT * dot(along_a, along_a) * dot(along_b, along_b), TINY
            ):
                continue
            length = math.sqrt(squared)
            if dot(normal, add(left, right)) < 0.0:
                length = -length
            normal = divide(normal, length)
            along, guess_a, guess_b = separation(a, b, work, normal, guess_a, guess_b)
            if along > most and is_outer(
                negate(_world(normal, poses, pose_a)), parameters, surface, row
            ):
                edge_a, edge_b, most = of_a, of_b, along
                store(work, AXIS, normal)
    return edge_a, edge_b, most


@kernel
def _nearest_points(
    a: Hull, b: Hull, center: Any, parameters: Array, row: int, plane: int, poses: Array,
    pose_a: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """Write a triangle as b, and find the points of the two that are nearest: see `gjk`."""
    center_b = write_triangle(parameters, row, plane, found)
    apart = subtract(subtract(center_b, load(poses, pose_a)), _world(center, poses, pose_a))
    for index in range(3):
        axis = pose.axis(poses, pose_a, index)
        found[OFFSET + index] = dot(axis, apart)
        store(found, ROTATION + ROW * index, axis)
    size = a.numbers[a.begin + RADIUS] + found[TRIANGLE_HULL + RADIUS]
    reach = size + margin
    if not dot(apart, apart) <= reach * reach:
        return FAR
    state, _ = closest(vertices_of(a), vertices_of(b), margin, size, found)
    return state


@kernel
def axis_to_triangle(
    numbers_a: Array, hull_a: int, parameters: Array, surface: int, row: int, poses: Array,
    pose_a: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Write the normal from a polyhedron to a triangle along their least distance; that of the face
    where they touch. Return 0 beyond the margin.
    """
    a, b = Hull(numbers_a, hull_a), Hull(found, TRIANGLE_HULL)
    plane = surface + int(parameters[surface + PLANES]) + FACET * int(parameters[row + FACET_OF])
    center = load(numbers_a, hull_a + CENTER)
    state = _nearest_points(a, b, center, parameters, row, plane, poses, pose_a, margin, found)
    if state == FAR:
        return 0
    normal = negate(load(parameters, row + TRIANGLE_NORMAL))
    if state == GAP:
        nearest_to_axis(found)
        normal = _world(load(found, AXIS), poses, pose_a)
    write_normal(found, normal)
    return 1


@kernel
def polyhedron_on_triangle(
    numbers_a: Array, hull_a: int, parameters: Array, surface: int, row: int, plane: int,
    number: float, poses: Array, pose_a: int, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """
    Add the contacts of a polyhedron with a triangle. An overlap that is one with other triangles,
    or is told elsewhere, is held along the face in case nothing else touches: `_hold_overlap`.

    numbers_a, hull_a : the array of its record, and where that begins
    row, plane        : where the triangle and the plane of its facet begin
    number            : of the triangle
    along             : a direction fixed in the body, see `results.add_contact`
    """
    a, b = Hull(numbers_a, hull_a), Hull(found, TRIANGLE_HULL)
    center = load(numbers_a, hull_a + CENTER)
    state = _nearest_points(a, b, center, parameters, row, plane, poses, pose_a, margin, found)
    if state == FAR:
        return
    half = numbers_a[hull_a + HALF]
    if state == GAP:
        side, face, least = _axis_apart(a, b, half, poses, pose_a, parameters, surface, row, found)
    else:
        side, face, least = _axis_overlapping(
            a, b, half, poses, pose_a, parameters, surface, row, found
        )
    elsewhere = face < 0 or (side == OF_B and found[BY_FACES] == 0.0)
    if not least <= margin or (elsewhere and (state == GAP or found[OVERLAP] >= least)):
        return
    if face < 0:
        front = negate(from_b(found, load(b.numbers, planes_of(b))))
        least, _, _ = separation(a, b, found, front, 0, 0)
        side, face = OF_B, FRONT
    count = write_patch(a, b, side, face, least, state, margin, half, found)
    to_world(center, poses, pose_a, found, count)
    key = parameters[row + FACET_OF] if side == OF_B else FREE + number
    normal, seam = load(found, NORMAL), parameters[surface + FLATNESS]
    held = False
    for place in range(POINTS, POINTS + POINT * (0 if elsewhere else count), POINT):
        point, gap = load(found, place), found[place + SEPARATION]
        if side == OF_B and not lies_over(
            parameters, row, negate(normal), point, -gap, seam, max(gap, seam)
        ):
            continue
        held = True
        feature = found[place + FEATURE]
        edges = feature % (MOST_CORNERS * MOST_CORNERS)
        of_body = side == OF_B and feature >= 0.0
        if not (of_body and edges // MOST_CORNERS < CLIP and edges % MOST_CORNERS < CLIP):
            feature += number / FREE  # the sides of each triangle have the same names
        add_contact(key, normal, point, gap, feature, along, found)
    if not held and count > 0 and 0.0 >= least > found[OVERLAP]:
        found[OVERLAP], found[OVERLAP_KEY] = least, key
        store(found, OVERLAP_NORMAL, normal)
        copy_point(found, OVERLAP_POINT, POINTS)
