# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The manifold of two convex polyhedra.

Apart, the nearest points (`gjk`) give gap and normal; overlapping, the axis of least overlap
(`separating_axes`) does. The face of each body that looks along the normal is clipped against the
other (`face_clipping`); where no face lies there, the nearest points themselves are the contact.

So that the normal does not jump to and fro between two equal choices, a face of B must beat the
faces of A by FACE_LEAD of a half width, or they those of B, if the normal was that of one of these
in the last tick; and edges, corners or nearest points must beat the faces
by EDGE_LEAD of it, plus EDGE_SHARE of the overlap: so much, at most, is a gap smaller, and a
depth larger, than the exact one. A corner of a round face that the patch lacks joins it when it is
deeper by DEEPER of a half width.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    FACE_LEAD,
    FACE_MIDDLE,
    FACE_OF_A,
    FACE_OF_B,
    NEITHER,
    NORMAL,
    NORMAL_OWNER,
    OF_EDGES,
    OF_NEAREST,
    POINT,
    POINTS,
    TURNED,
    write_normal,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import (
    keep_extremes,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import (
    FACE_NAMES,
    across,
    facing,
    holds_face_of_b,
    is_over,
    patch,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    HALF,
    PLANE,
    RADIUS,
    Hull,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    from_b,
    point_of_b,
    relate,
    to_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    AXIS,
    AXIS_A,
    AXIS_B,
    CANDIDATES,
    MOST_CORNERS,
    NEAREST,
    NEAREST_A,
    NEAREST_B,
    OFFSET,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.separating_axes import (
    NO_EDGE,
    NONE,
    OF_A,
    OF_B,
    best_edges,
    best_face,
    nearest_on_edges,
    separation,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    support,
    vertices_of,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    divide,
    dot,
    load,
    negate,
    scale,
    store,
)

Array = NDArray[np.float64]

DEEPER = 1e-4  # [-] of the half width; less lets a patch at rest change with every tremble
EXACT = 1e-9  # [-] of the half width: a patch this near to the gap holds the nearest points
LARGEST = 1e40  # [m] beyond, products of lengths overflow; such bodies never meet


@kernel
def collide_records(
    numbers_a: Array, hull_a: int, numbers_b: Array, hull_b: int, poses: Array, pose_a: int,
    pose_b: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two records of `hull_records`; see `manifold` for the arguments."""
    a, b = Hull(numbers_a, hull_a), Hull(numbers_b, hull_b)
    size = numbers_a[hull_a + RADIUS] + numbers_b[hull_b + RADIUS]
    center = load(numbers_a, hull_a + CENTER)
    relate(center, load(numbers_b, hull_b + CENTER), poses, pose_a, pose_b, found)
    offset = load(found, OFFSET)
    reach = size + margin
    if not (dot(offset, offset) <= reach * reach and size < LARGEST):
        return 0
    state, corners = closest(vertices_of(a), vertices_of(b), margin, size, found)
    if state == FAR:
        return 0
    half = min(numbers_a[hull_a + HALF], numbers_b[hull_b + HALF])
    side, face, along = _axis(a, b, state, corners, half, found)
    if not along <= margin:
        return 0
    count = write_patch(a, b, side, face, along, state, margin, half, found)
    found[NORMAL_OWNER], found[TURNED] = _owner(side, state), NEITHER
    to_world(center, poses, pose_a, found, count)
    return count


@inline
def _owner(side: int, state: int) -> float:
    """Tell whose the normal is."""
    if side == NONE:
        return OF_NEAREST if state == GAP else OF_EDGES
    return FACE_OF_B if side == OF_B else FACE_OF_A


@inline
def _gain_of_b(half: float, work: Array) -> float:
    """By how much a face of B must beat the faces of A [m]."""
    return -FACE_LEAD * half if holds_face_of_b(work) else FACE_LEAD * half


@kernel
def _axis(
    a: Hull, b: Hull, state: int, corners: int, half: float, work: Array
) -> tuple[int, int, float]:
    """Choose the normal: of a face of A or B, or (NONE) the one at AXIS; return also s."""
    if state == GAP:
        return _axis_apart(a, b, half, work)
    side, face, along, known = best_face(a, b, work, corners, _gain_of_b(half, work))
    floor = along + EDGE_LEAD * half + EDGE_SHARE * abs(along)
    edge_a, edge_b, along_edges = best_edges(a, b, work, known, floor)
    if edge_a != NO_EDGE:
        nearest_on_edges(a, b, work, edge_a, edge_b)
        return NONE, 0, along_edges
    return side, face, along


@kernel
def _axis_apart(a: Hull, b: Hull, half: float, work: Array) -> tuple[int, int, float]:
    """Take the normal of the face that looks along v best, if it separates as well as v."""
    distance = nearest_to_axis(work)
    axis = load(work, AXIS)
    winner, best, most, floor = NONE, 0, distance, distance - EDGE_LEAD * half
    for side in range(OF_A, OF_B + 1):
        hull = b if side == OF_B else a
        face = facing(hull, to_b(work, negate(axis)) if side == OF_B else axis)
        normal = load(hull.numbers, planes_of(hull) + PLANE * face)
        if side == OF_B:
            normal = from_b(work, negate(normal))
        along, _, _ = separation(a, b, work, normal, 0, 0)
        if along > floor:
            winner, best, most, floor = side, face, along, along + _gain_of_b(half, work)
    return winner, best, most


@inline
def nearest_to_axis(work: Array) -> Any:
    """Copy normal and points of NEAREST to AXIS; return the distance."""
    way = load(work, NEAREST)
    distance = math.sqrt(dot(way, way))
    store(work, AXIS, divide(way, distance))
    store(work, AXIS_A, load(work, NEAREST_A))
    store(work, AXIS_B, load(work, NEAREST_B))
    return distance


@kernel
def write_patch(
    a: Hull, b: Hull, side: int, face: int, along: float, state: int, margin: float, half: float,
    work: Array,
) -> int:  # fmt: skip
    """
    Write the normal and the points of the manifold, axes of A; return their number.

    along : [m]  s along the normal

    The point of least gap is among them. Where the patch lacks it, the nearest points are added,
    or for the overlap along a face its deepest corner, unless that hangs over the rim and the
    patch is as deep but for the gains.
    """
    is_b = side == OF_B
    reference, incident = (b, a) if is_b else (a, b)
    normal = load(work, AXIS)
    if side == NONE:
        face = facing(a, normal)
    else:
        normal = load(reference.numbers, planes_of(reference) + PLANE * face)
        if is_b:
            normal = from_b(work, normal)
    write_normal(work, scale(-1.0 if is_b else 1.0, normal))
    opposite = negate(normal)
    if not is_b:
        opposite = to_b(work, opposite)
    other = facing(incident, opposite)
    count, least = patch(
        reference, face, incident, other, is_b, normal, along, margin, work
    )  # fmt: skip
    gap = along
    if side == NONE or state == GAP:
        gap = nearest_to_axis(work) if state == GAP else along
        position = scale(0.5, add(load(work, AXIS_A), load(work, AXIS_B)))
        missing = True
    else:
        deepest = vertex(incident, support(vertices_of(incident), opposite, 0))
        if not is_b:
            deepest = point_of_b(work, deepest)
        missing = least > along + EDGE_LEAD * half + EDGE_SHARE * abs(along) or is_over(
            reference, face, is_b, normal, deepest, work
        )
        position = add_scaled(deepest, -0.5 * along, normal)
    enough = gap + (EXACT if side == NONE else DEEPER) * half
    if missing and gap <= margin and not least <= enough:
        feature = -1.0 - (float(face) * FACE_NAMES + float(other)) * (
            2.0 * MOST_CORNERS * MOST_CORNERS
        )
        write_point_at(work, CANDIDATES + POINT * count, position, gap, feature)
        count += 1
    direction = across(reference, face, is_b, work)
    return keep_extremes(work, CANDIDATES, count, direction)


@kernel
def to_world(center: Any, poses: Array, pose_a: int, found: Array, count: int) -> None:
    """Turn normal and points from the axes of A about its centre to the world."""
    write_normal(found, pose.to_world(poses, pose_a, load(found, NORMAL)))
    origin = load(poses, pose_a)
    for place in range(POINTS, POINTS + POINT * count, POINT):
        point = add(load(found, place), center)
        store(found, place, add(origin, pose.to_world(poses, pose_a, point)))
    middle = add(load(found, FACE_MIDDLE), center)
    store(found, FACE_MIDDLE, add(origin, pose.to_world(poses, pose_a, middle)))
