# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Edges and corners of two boxes that are nearest to each other: one point.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import (
    COSINES,
    HALF_A,
    HALF_B,
    OFFSET,
    ROW,
    SCRATCH_BEHIND,
    crossed,
)
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_COMMON_NORMAL
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    divide,
    dot,
    load,
    load_strided,
    store,
    subtract,
)

Array = NDArray[np.float64]

EDGES, CORNERS_A, CORNERS_B = 10000.0, 20000.0, 30000.0  # features: edge pairs, corners

two_edges = Record(begin=SCRATCH_BEHIND)  # nearest points of the two edges under way
ON_A = two_edges.vector('m', 'point of A from the middle of A, axes of A')
ON_B = two_edges.vector('m', 'point of B, the same')
NORMAL = two_edges.vector('-', 'unit normal from A to B, axes of A')


@inline
def _from_b(found: Array, v: Any) -> Any:
    """Turn a direction from the axes of B into those of A."""
    return (
        dot(load(found, COSINES), v),
        dot(load(found, COSINES + ROW), v),
        dot(load(found, COSINES + 2 * ROW), v),
    )


@inline
def _axis_b(found: Array, j: int) -> Any:
    """Axis j of B in the axes of A."""
    return load_strided(found, COSINES + j, ROW)


@inline
def _report(
    poses: Array, pose_a: int, found: Array, on_a: Any, on_b: Any, normal: Any, feature: float
) -> Any:
    """Write normal and point from axes of A into the world; return the separation along n."""
    separation = dot(normal, subtract(on_b, on_a))
    write_normal(found, pose.to_world(poses, pose_a, normal))
    middle = pose.to_world(poses, pose_a, add(on_a, on_b))
    write_point(found, 0, add_scaled(load(poses, pose_a), 0.5, middle), separation, feature)
    return separation


@kernel
def _nearest_on_lines(found: Array, i: int, j: int) -> Any:
    """
    Find the nearest points of the two edges along a_i and b_j that face each other most.

    ON_A, ON_B and NORMAL are written. Returns the number of the pair of edges, and whether they
    cross, seen along the normal. If not, the nearest points of their lines lie beyond their ends,
    and the points are those of the edges.
    """
    next_a, last_a = (i + 1) % 3, (i + 2) % 3
    row_i, row_next, row_last = COSINES + ROW * i, COSINES + ROW * next_a, COSINES + ROW * last_a
    normal_next, normal_last = -found[row_last + j], found[row_next + j]  # a_i x b_j
    length = math.sqrt(normal_next * normal_next + normal_last * normal_last)
    if normal_next * found[OFFSET + next_a] + normal_last * found[OFFSET + last_a] < 0.0:
        length = -length
    normal_next /= length
    normal_last /= length
    found[NORMAL + i] = 0.0
    found[NORMAL + next_a] = normal_next
    found[NORMAL + last_a] = normal_last
    up_next, up_last = normal_next > 0.0, normal_last > 0.0
    found[ON_A + i] = 0.0
    found[ON_A + next_a] = found[HALF_A + next_a] if up_next else -found[HALF_A + next_a]
    found[ON_A + last_a] = found[HALF_A + last_a] if up_last else -found[HALF_A + last_a]
    on_b = load(found, OFFSET)
    number = 4.0 * i + 2.0 * up_next + up_last
    for behind in range(1, 3):
        axis = (j + behind) % 3
        up = normal_next * found[row_next + axis] + normal_last * found[row_last + axis] < 0.0
        half = found[HALF_B + axis] if up else -found[HALF_B + axis]
        on_b = add_scaled(on_b, half, _axis_b(found, axis))
        number = 2.0 * number + up
    store(found, ON_B, on_b)
    # nearest points x_A + alpha a_i, x_B + beta b_j
    along_a = found[ON_B + i] - found[ON_A + i]
    along_b = dot(subtract(on_b, load(found, ON_A)), _axis_b(found, j))
    cosine = found[row_i + j]
    half_a, half_b = found[HALF_A + i], found[HALF_B + j]
    alpha = (along_a - cosine * along_b) / (length * length)
    beta = alpha * cosine - along_b
    crossing = abs(alpha) <= half_a and abs(beta) <= half_b
    if not crossing:
        beta = clamp(clamp(alpha, half_a) * cosine - along_b, half_b)
        alpha = clamp(along_a + beta * cosine, half_a)
    found[ON_A + i] += alpha
    store(found, ON_B, add_scaled(on_b, beta, _axis_b(found, j)))
    return 3.0 * number + j, crossing


@kernel
def edge_contact(
    poses: Array, pose_a: int, margin: float, found: Array, i: int, j: int, across: bool
) -> int:
    """
    Find the point between the edges along a_i and b_j, which span the separating axis.

    across : report only edges that cross each other, seen along the normal
    """
    number, crossing = _nearest_on_lines(found, i, j)
    if across and not crossing:
        return 0
    on_a, on_b, normal = load(found, ON_A), load(found, ON_B), load(found, NORMAL)
    separation = _report(poses, pose_a, found, on_a, on_b, normal, EDGES + number)
    return 1 if separation <= margin else 0


@inline
def _corner(found: Array, corner: int, half: int) -> Any:
    """Corner 0 to 7 of the box whose half edges begin at `half`, its own axes."""
    return (
        found[half] if corner & 1 else -found[half],
        found[half + 1] if corner & 2 else -found[half + 1],
        found[half + 2] if corner & 4 else -found[half + 2],
    )


@inline
def _in_box(found: Array, half: int, point: Any) -> Any:
    """Point of the box whose half edges begin at `half` that is nearest to a point, its axes."""
    return (
        clamp(point[0], found[half]),
        clamp(point[1], found[half + 1]),
        clamp(point[2], found[half + 2]),
    )


@kernel
def nearest_points(poses: Array, pose_a: int, margin: float, found: Array) -> int:
    """
    Find the nearest points of two boxes that do not overlap; 0: farther apart than the margin.

    They are a corner and a box, or two edges that cross. Two edges span their own separating
    axis, so that of each pair of directions only one pair of edges can be nearest.
    """
    least, feature = math.inf, 0.0
    offset = load(found, OFFSET)
    on_a = on_b = offset
    for k in range(8):
        corner = add(offset, _from_b(found, _corner(found, k, HALF_B)))
        nearest = _in_box(found, HALF_A, corner)
        way = subtract(corner, nearest)
        squared = dot(way, way)
        if squared < least:
            least, feature = squared, CORNERS_B + k
            on_a, on_b = nearest, corner
    for k in range(8):
        corner = _corner(found, k, HALF_A)
        arm = subtract(corner, offset)
        seen = (
            dot(_axis_b(found, 0), arm), dot(_axis_b(found, 1), arm), dot(_axis_b(found, 2), arm)
        )  # fmt: skip
        way = subtract(_in_box(found, HALF_B, seen), seen)
        squared = dot(way, way)
        if squared < least:
            least, feature = squared, CORNERS_A + k
            on_a, on_b = corner, add(corner, _from_b(found, way))
    for i in range(3):
        for j in range(3):
            cosine = found[COSINES + ROW * i + j]
            squared_sine = 1.0 - cosine * cosine
            apart = crossed(found, i, j)
            if squared_sine < NO_COMMON_NORMAL or not (
                apart > 0.0 and apart * apart < least * squared_sine
            ):
                continue
            number, crossing = _nearest_on_lines(found, i, j)
            if crossing:
                least, feature = apart * apart / squared_sine, EDGES + number
                on_a, on_b = load(found, ON_A), load(found, ON_B)
    way = subtract(on_b, on_a)
    squared = dot(way, way)
    distance = math.sqrt(squared)
    if squared < TINY or not distance <= margin:
        return 0
    separation = _report(poses, pose_a, found, on_a, on_b, divide(way, distance), feature)
    return 1 if separation <= margin else 0
