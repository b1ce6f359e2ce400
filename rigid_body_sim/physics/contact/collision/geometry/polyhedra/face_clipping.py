# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where two faces of polyhedra touch: the points of one that lie over the other.

The reference face spans a prism along the contact normal n; the incident face of the other body is
clipped by its sides (Sutherland and Hodgman). Each corner x that is left lies over a point of the
reference face, at the gap

    g = (m . x - c) / (m . n)        m, c: plane of the reference face

For bodies that are separated by s along n no g is smaller than s.
A corner is named by the edges it lies between, edges of the incident face or sides of the prism:
while the same edges meet, the name stays.

Source: Sutherland, Hodgman, Reentrant polygon clipping, Comm. ACM 17 (1974) 32.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    HELD,
    HELD_COUNT,
    POINT,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CLIP,
    FACES,
    HALF,
    PLANE,
    PLANE_OFFSET,
    Hull,
    loop_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    from_b,
    point_of_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    CANDIDATES,
    CLIPPED,
    CORNER,
    EDGE_NAME,
    MOST_CORNERS,
    OFFSET,
    POLYGON,
)
from rigid_body_sim.physics.contact.collision.geometry.touching_face import measure_face
from rigid_body_sim.physics.vectors import (
    add_scaled,
    cross,
    dot,
    load,
    store,
    subtract,
)

Array = NDArray[np.float64]

STEEP = 0.05  # [-] cosine between a face and the normal below which it carries no patch
SLACK = 1e-6  # [-] of the half width: sides stand off, so that flush faces keep their corners
FACE_NAMES = 65536.0  # [-] most faces that have names of their own


@kernel
def facing(hull: Hull, direction: Any) -> int:
    """Return the face whose normal comes nearest to a direction, axes of the polyhedron."""
    numbers, planes = hull.numbers, planes_of(hull)
    best, most = 0, -math.inf
    for face in range(int(numbers[hull.begin + FACES])):
        height = dot(direction, load(numbers, planes + PLANE * face))
        if height > most:
            best, most = face, height
    return best


@inline
def _loop_corner(hull: Hull, loop: int, index: int, is_b: bool, work: Array) -> Any:
    corner = vertex(hull, int(hull.numbers[loop + 1 + index]))
    if is_b:
        return point_of_b(work, corner)
    return corner


@inline
def side_of(
    hull: Hull, loop: int, sides: int, index: int, is_b: bool, normal: Any, work: Array
) -> Any:
    """Return s and c of the side of the prism over the edge that ends at a corner: s . x <= c."""
    before = _loop_corner(hull, loop, index - 1 if index > 0 else sides - 1, is_b, work)
    here = _loop_corner(hull, loop, index, is_b, work)
    side = cross(subtract(here, before), normal)
    slack = SLACK * hull.numbers[hull.begin + HALF] * math.sqrt(dot(side, side))
    return side, dot(side, here) + slack


@kernel
def is_over(hull: Hull, face: int, is_b: bool, normal: Any, point: Any, work: Array) -> bool:
    """Tell whether a point lies within the prism over a face along the normal; axes of A."""
    loop = loop_of(hull, face)
    sides = int(hull.numbers[loop])
    for index in range(sides):
        side, limit = side_of(hull, loop, sides, index, is_b, normal, work)
        if dot(side, point) > limit:
            return False
    return True


@inline
def across(hull: Hull, face: int, is_b: bool, work: Array) -> Any:
    """Return the way from a corner of a face to the opposite one, axes of A."""
    loop = loop_of(hull, face)
    opposite = _loop_corner(hull, loop, int(hull.numbers[loop]) // 2, is_b, work)
    return subtract(_loop_corner(hull, loop, 0, is_b, work), opposite)


@inline
def _write_corner(work: Array, at: int, position: Any, edge: float) -> None:
    store(work, at, position)
    work[at + EDGE_NAME] = edge


@kernel
def clip_by_side(
    work: Array, source: int, to: int, count: int, side: Any, limit: float, name: float
) -> int:
    """Keep of a polygon what has s . x <= c; return the number of corners."""
    kept = 0
    if count == 0:
        return 0
    last = source + CORNER * (count - 1)
    end, edge = load(work, last), work[last + EDGE_NAME]
    height = dot(side, end) - limit
    for here in range(source, source + CORNER * count, CORNER):
        begin, edge_before, height_before = end, edge, height
        end, edge = load(work, here), work[here + EDGE_NAME]
        height = dot(side, end) - limit
        if (height > 0.0) != (height_before > 0.0) and kept < MOST_CORNERS:
            share = height_before / (height_before - height)
            cut = add_scaled(begin, share, subtract(end, begin))
            cut_edge = name if height > 0.0 else edge_before
            _write_corner(work, to + CORNER * kept, cut, cut_edge)
            kept += 1
        if not height > 0.0 and kept < MOST_CORNERS:
            _write_corner(work, to + CORNER * kept, end, edge)
            kept += 1
    return kept


@inline
def holds_face_of_b(found: Array) -> bool:
    """
    Tell whether the normal was that of a face of B in the last tick: by the names of the corners
    of its patch (`patch`); other points have negative ones.
    """
    held = False
    for place in range(HELD, HELD + int(found[HELD_COUNT])):
        name = math.floor(found[place] / (MOST_CORNERS * MOST_CORNERS))
        held = held | ((name >= 0) & (name - 2 * math.floor(0.5 * name) == 1))
    return held


@kernel
def patch(
    reference: Hull, face: int, incident: Hull, incident_face: int, of_b: bool, normal: Any,
    separation: float, margin: float, work: Array,
) -> tuple[int, float]:  # fmt: skip
    """
    Write the points of the incident face over the reference face at CANDIDATES.

    of_b       : whether the reference body is B, the other one A; else reversed
    normal     : n, out of the reference body; axes of A
    separation : [m]  s along n
    Returns the number of points with g <= margin, and the least g; their face is measured.
    """
    plane = planes_of(reference) + PLANE * face
    reference_normal, offset = (
        load(reference.numbers, plane),
        reference.numbers[plane + PLANE_OFFSET],
    )
    incident_normal = load(incident.numbers, planes_of(incident) + PLANE * incident_face)
    if of_b:
        reference_normal = from_b(work, reference_normal)
        offset += dot(reference_normal, load(work, OFFSET))
    else:
        incident_normal = from_b(work, incident_normal)
    steep = dot(reference_normal, normal)
    if not (steep > STEEP and dot(incident_normal, normal) < -STEEP):
        return 0, math.inf
    loop, incident_loop = loop_of(reference, face), loop_of(incident, incident_face)
    sides = int(reference.numbers[loop])
    count = int(incident.numbers[incident_loop])
    here, there = POLYGON, CLIPPED
    for index in range(count):
        corner = _loop_corner(incident, incident_loop, index, not of_b, work)
        _write_corner(work, here + CORNER * index, corner, float(index))
    for index in range(sides):
        side, limit = side_of(reference, loop, sides, index, of_b, normal, work)
        count = clip_by_side(work, here, there, count, side, limit, float(CLIP + index))
        here, there = there, here
    name = (float(face) * FACE_NAMES + float(incident_face)) * 2.0 + (1.0 if of_b else 0.0)
    kept, least = 0, math.inf
    edge = work[here + CORNER * (count - 1) + EDGE_NAME] if count > 0 else 0.0
    for at in range(here, here + CORNER * count, CORNER):
        corner, before = load(work, at), edge
        edge = work[at + EDGE_NAME]
        # SLACK reaches over the rim
        gap = max((dot(reference_normal, corner) - offset) / steep, separation)
        if gap <= margin:
            position = add_scaled(corner, -0.5 * gap, normal)
            feature = (name * MOST_CORNERS + before) * MOST_CORNERS + edge
            write_point_at(work, CANDIDATES + POINT * kept, position, gap, feature)
            kept += 1
            least = min(least, gap)
    measure_face(work, CANDIDATES, POINT, kept)
    return kept, least
