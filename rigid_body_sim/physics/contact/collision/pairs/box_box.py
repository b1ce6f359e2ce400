# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two boxes: fifteen separating axes, then a patch of two sides, or a point of two edges.

The separating axis is that of the largest separation s among the normals of the sides and the
cross products of edges (Gottschalk, Lin, Manocha, SIGGRAPH 1996). It stays the same under small
motions because a later kind must win clearly: a side of B by FACE_LEAD of the smallest half edge
over a side of A, a pair of edges by EDGE_LEAD of it and EDGE_SHARE |s| over the best side. What
was so in the last tick stays: then a side of A must beat those of B by FACE_LEAD, and edges win
that are better by HELD_LEAD of that.

Where the patch is empty, or edges pass each other beyond their ends, boxes that are apart get the
pair of their nearest points, and boxes that overlap get the deepest corner.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.boxes.edges import (
    CORNERS_A,
    EDGES,
    edge_contact,
    nearest_points,
)
from rigid_body_sim.physics.contact.collision.geometry.boxes.faces import (
    SIDES_OF_B,
    deepest_corner,
    face_contact,
)
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import between, relate
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_COMMON_NORMAL
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    FACE_LEAD,
    HELD,
    HELD_COUNT,
    SHORTEST,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]

HELD_LEAD = 0.5  # [-] of both, for edges that met in the last tick
NOTHING = -1.0  # in place of a feature of the last tick
CLEAR = 1e-9  # [-] of the smallest half edge: below, the direction between nearest points is noise
# [-] |a_i . b_j| above which every cross product is the normal of a side, within 2 mrad: else what
# lies nearly flat stands on a crossing of edges in every other tick
COVERED = 1.0 - 2e-6

NO_EDGES = -1  # in place of the number 3 i + j of a pair of edges: a side separates most


@inline
def _side(along: float, half: float, others_half: Any, cosines: Any) -> Any:
    """
    Separation along the normal of a side.

        along, half : offset of the boxes along it; half edge of its own box
        others_half : half edges of the other box;   cosines : of its axes with the normal
    """
    return abs(along) - (
        half
        + others_half[0] * abs(cosines[0])
        + others_half[1] * abs(cosines[1])
        + others_half[2] * abs(cosines[2])
    )


@inline
def _sides(along: Any, half: Any, others_half: Any, cosines: Any) -> Any:
    """Separations along the three normals of a box: see `_side`."""
    return (
        _side(along[0], half[0], others_half, cosines[0]),
        _side(along[1], half[1], others_half, cosines[1]),
        _side(along[2], half[2], others_half, cosines[2]),
    )


@inline
def _all_within(separations: Any, margin: float) -> Any:
    return separations[0] <= margin and separations[1] <= margin and separations[2] <= margin


@inline
def _largest(separations: Any) -> Any:
    """Return the largest separation, and its axis."""
    best, axis = separations[0], 0
    if separations[1] > best:
        best, axis = separations[1], 1
    if separations[2] > best:
        best, axis = separations[2], 2
    return best, axis


@inline
def _crossed(
    along: Any, cosine_1: float, cosine_2: float, half: Any, other_1: float, cosine_3: float,
    other_2: float, cosine_4: float, to_beat: float,
) -> Any:  # fmt: skip
    """
    Separation along a_i x b_j, not divided by its length where it cannot win.

        along, half        : middle of B, and half edges of A, along the two axes of A behind a_i
        cosine_1, cosine_2 : b_j along these, so that the length is sqrt(c1^2 + c2^2)
        other_1, other_2   : half edges of B behind b_j
        cosine_3, cosine_4 : a_i along the axes of the other one
    """
    separation = abs(along[1] * cosine_1 - along[0] * cosine_2) - (
        half[0] * abs(cosine_2)
        + half[1] * abs(cosine_1)
        + other_1 * abs(cosine_4)
        + other_2 * abs(cosine_3)
    )
    if separation < 0.0 and separation <= to_beat:
        return separation  # to divide by a length below one makes it smaller still
    squared = cosine_1 * cosine_1 + cosine_2 * cosine_2
    return separation / math.sqrt(squared) if squared > NO_COMMON_NORMAL else -math.inf


@inline
def _edges_of(
    first: int, along: Any, half: Any, half_b: Any, own: Any, behind_1: Any, behind_2: Any,
    largest: float, edge: int,
) -> Any:  # fmt: skip
    """
    Let the axes a_i x b_j of one edge of A and the three of B try to beat the largest separation.

        first              : number of the first of the three pairs of edges
        along, half        : see `_crossed`
        own                : cosines a_i . b_j;   behind_1, behind_2 : those of the axes behind a_i
        returns            : the largest separation, and its pair of edges
    """
    separation = _crossed(
        along, behind_1[0], behind_2[0], half, half_b[1], own[1], half_b[2], own[2], largest
    )
    if separation > largest:
        largest, edge = separation, first
    separation = _crossed(
        along, behind_1[1], behind_2[1], half, half_b[2], own[2], half_b[0], own[0], largest
    )
    if separation > largest:
        largest, edge = separation, first + 1
    separation = _crossed(
        along, behind_1[2], behind_2[2], half, half_b[0], own[0], half_b[1], own[1], largest
    )
    if separation > largest:
        largest, edge = separation, first + 2
    return largest, edge


@inline
def _largest_of_edges(along: Any, half_a: Any, half_b: Any, rows: Any, to_beat: float) -> Any:
    """
    Return the largest separation of a pair of edges, and its number 3 i + j; to_beat and NO_EDGES
    where none is larger.

        along : middle of B in the axes of A;   rows : cosines a_i . b_j, row by row
    """
    largest, edge = to_beat, NO_EDGES
    row_0, row_1, row_2 = rows
    closest = max(
        abs(row_0[0]), abs(row_0[1]), abs(row_0[2]), abs(row_1[0]), abs(row_1[1]), abs(row_1[2])
    )
    if max(closest, abs(row_2[0]), abs(row_2[1]), abs(row_2[2])) < COVERED:
        largest, edge = _edges_of(
            0, (along[1], along[2]), (half_a[1], half_a[2]), half_b, row_0, row_1, row_2,
            largest, edge,
        )  # fmt: skip
        largest, edge = _edges_of(
            3, (along[2], along[0]), (half_a[2], half_a[0]), half_b, row_1, row_2, row_0,
            largest, edge,
        )  # fmt: skip
        largest, edge = _edges_of(
            6, (along[0], along[1]), (half_a[0], half_a[1]), half_b, row_2, row_0, row_1,
            largest, edge,
        )  # fmt: skip
    return largest, edge


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two boxes."""
    offset = between(poses, pose_a, pose_b)
    half_a = load(parameters, shape_a + HALF_EDGES)
    half_b = load(parameters, shape_b + HALF_EDGES)
    column_0 = pose.to_shape(poses, pose_a, pose.axis(poses, pose_b, 0))
    column_1 = pose.to_shape(poses, pose_a, pose.axis(poses, pose_b, 1))
    column_2 = pose.to_shape(poses, pose_a, pose.axis(poses, pose_b, 2))
    rows = (
        (column_0[0], column_1[0], column_2[0]),
        (column_0[1], column_1[1], column_2[1]),
        (column_0[2], column_1[2], column_2[2]),
    )
    along_a = pose.to_shape(poses, pose_a, offset)
    separations = _sides(along_a, half_a, half_b, rows)
    if not _all_within(separations, margin):
        return 0
    best, axis = _largest(separations)
    along_b = pose.to_shape(poses, pose_b, offset)
    separations = _sides(along_b, half_b, half_a, (column_0, column_1, column_2))
    if not _all_within(separations, margin):
        return 0
    best_b, axis_b = _largest(separations)
    smallest = min(half_a[0], half_a[1], half_a[2], half_b[0], half_b[1], half_b[2])
    held = found[HELD] if found[HELD_COUNT] > 0.0 else NOTHING
    lead = -FACE_LEAD if SIDES_OF_B <= held < EDGES else FACE_LEAD
    of_b = best_b > best + lead * smallest
    if of_b:
        best, axis = best_b, axis_b
    share = HELD_LEAD if EDGES <= held < CORNERS_A else 1.0
    to_beat = best + share * (EDGE_LEAD * smallest + EDGE_SHARE * abs(best))
    largest, edge = _largest_of_edges(along_a, half_a, half_b, rows, to_beat)
    if edge != NO_EDGES and largest > margin:
        return 0
    clear = max(CLEAR * smallest, SHORTEST)
    count = 0
    if edge == NO_EDGES:
        reference, incident, pose_r, pose_i = (
            (shape_b, shape_a, pose_b, pose_a) if of_b else (shape_a, shape_b, pose_a, pose_b)
        )
        count = face_contact(
            parameters, reference, incident, poses, pose_r, pose_i, margin, found, of_b, axis
        )
        if count:
            return count
        if not best > clear:
            return deepest_corner(
                parameters, incident, poses, pose_r, pose_i, found, of_b, axis, best
            )
    relate(parameters, shape_a, shape_b, poses, pose_a, pose_b, found)
    if edge != NO_EDGES:
        i, j = edge // 3, edge % 3
        count = edge_contact(poses, pose_a, margin, found, i, j, largest > clear)
    return count if count else nearest_points(poses, pose_a, margin, found)
