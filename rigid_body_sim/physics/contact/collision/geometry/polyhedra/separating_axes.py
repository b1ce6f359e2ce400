# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The separating axis test (SAT): the axis along which two convex polyhedra overlap least.

    s(n) = min_B n . x - max_A n . x        separation along n; negative: overlap
    s    = max over n of s(n)               among the normals of the faces of A and B, and the
                                            cross products of those edges of A and B whose arcs
                                            on the Gauss sphere cross

No search and no limit on the number of faces: what cannot win is dismissed by a few known points w
of M = B - A: the corners of the last simplex of `gjk`, which enclose the origin, then corners of M
around the best face. For each of them

    s(n) <= n . w

so a face whose n . w is below the best s found so far costs a few products, and so does an edge
when that holds at both ends of its arc for the same w (every normal between is a sum of both with
weights whose sum is at least one; valid for s <= 0). The axis of a pair of edges counts only after
its separation has been computed from all vertices, so a degenerate edge cannot invent one.

Source of the arc test: Gregorius, The separating axis test between convex polyhedra, GDC 2013.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_CROSS_PRODUCT
from rigid_body_sim.physics.contact.collision.geometry.manifold import EDGE_A, EDGE_B, TINY
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    EDGE,
    EDGES,
    END,
    FACES,
    LEFT,
    PLANE,
    RIGHT,
    START,
    Hull,
    edges_of,
    loop_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    from_b,
    point_of_b,
    to_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    AXIS,
    AXIS_A,
    AXIS_B,
    CHUNK,
    DIFFERENCE,
    EDGES_LEFT,
    KNOWN,
    KNOWN_IN_B,
    SIMPLEX,
    SIMPLEX_CORNER,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    support,
    vertices_of,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
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

NONE, OF_A, OF_B = 0, 1, 2  # whose face has the normal
NO_FACE = NO_EDGE = -1
VECTOR = 3  # numbers of a known point
AROUND = 4  # [-] corners around the best face that become known


@inline
def _may_beat(work: Array, points: int, known: int, normal: Any, most: float) -> Any:
    """Tell whether n . w > most for all known points w."""
    for place in range(points, points + VECTOR * known, VECTOR):
        if not dot(normal, load(work, place)) > most:
            return False
    return True


@inline
def _know(work: Array, index: int, point: Any) -> None:
    """Make a point of M a known one."""
    store(work, KNOWN + VECTOR * index, point)
    store(work, KNOWN_IN_B + VECTOR * index, to_b(work, point))


@kernel
def know_simplex(work: Array, corners: int) -> None:
    """Make the corners of the simplex the known points."""
    for corner in range(corners):
        _know(work, corner, load(work, SIMPLEX + SIMPLEX_CORNER * corner + DIFFERENCE))


@kernel
def separation(
    a: Hull, b: Hull, work: Array, normal: Any, guess_a: int, guess_b: int
) -> tuple[float, int, int]:
    """
    Return s(n) and the vertices of A and B that it lies between; axes of A.

    guess_a, guess_b : vertices where to begin to look
    """
    vertex_a = support(vertices_of(a), normal, guess_a)
    vertex_b = support(vertices_of(b), to_b(work, negate(normal)), guess_b)
    way = subtract(point_of_b(work, vertex(b, vertex_b)), vertex(a, vertex_a))
    return dot(normal, way), vertex_a, vertex_b


@kernel
def best_face_of(
    side: int, a: Hull, b: Hull, work: Array, known: int, floor: float
) -> tuple[int, float, int, int]:
    """
    Find the face of A (or B) along whose normal the bodies are separated most.

    floor : [m]  only what is larger counts
    Returns its number, or NO_FACE, and s, and the vertices of A and B along its normal.
    """
    best, most, best_a, best_b = NO_FACE, floor, 0, 0
    hull = a if side == OF_A else b
    numbers, planes = hull.numbers, planes_of(hull)
    faces = int(numbers[hull.begin + FACES])
    points, sign = (KNOWN, 1.0) if side == OF_A else (KNOWN_IN_B, -1.0)
    first, top = 0, -math.inf
    for face in range(faces):  # the likeliest first: it dismisses most of the others
        normal = scale(sign, load(numbers, planes + PLANE * face))
        least = math.inf
        for place in range(points, points + VECTOR * known, VECTOR):
            least = min(least, dot(normal, load(work, place)))
        if least > top:
            first, top = face, least
    vertex_a = vertex_b = 0
    for turn in range(faces + 1):
        face = first if turn == 0 else turn - 1
        normal = scale(sign, load(numbers, planes + PLANE * face))
        if not _may_beat(work, points, known, normal, most):
            continue
        if side == OF_B:
            normal = from_b(work, normal)
        along, vertex_a, vertex_b = separation(a, b, work, normal, vertex_a, vertex_b)
        if along > most:
            best, most, best_a, best_b = face, along, vertex_a, vertex_b
    return best, most, best_a, best_b


@kernel
def best_face(
    a: Hull, b: Hull, work: Array, corners: int, handicap: float
) -> tuple[int, int, float, int]:
    """
    Find the face of either body along whose normal they are separated most.

    corners  : of SIMPLEX
    handicap : [m]  by so much a face of B must beat the best of A; less than 0: A those of B
    Returns OF_A or OF_B, the number of the face, s, and the number of known points: around the
    best face four corners of M have joined them, so that little else can win.
    """
    know_simplex(work, corners)
    floor = -math.inf
    winner, face, most = NONE, NO_FACE, floor
    best_a = best_b = 0
    for side in range(OF_A, OF_B + 1):
        found, along, vertex_a, vertex_b = best_face_of(side, a, b, work, corners, floor)
        if found != NO_FACE:
            winner, face, most = side, found, along
            floor = along + handicap
            best_a, best_b = vertex_a, vertex_b
    if winner == NONE:
        return winner, face, most, corners
    hull = a if winner == OF_A else b
    loop = loop_of(hull, face)
    for turn in range(AROUND):
        corner = int(hull.numbers[loop + 1 + turn * int(hull.numbers[loop]) // AROUND])
        if winner == OF_A:
            best_a = corner
        else:
            best_b = corner
        point = subtract(point_of_b(work, vertex(b, best_b)), vertex(a, best_a))
        _know(work, corners + turn, point)
    return winner, face, most, corners + AROUND


@inline
def _dismissed(
    work: Array, points: int, known: int, left: Any, right: Any, sign: float, floor: float
) -> Any:
    """Tell whether no normal on the arc between two faces can be better than the floor."""
    for index in range(known - 1, -1, -1):  # the corners around the best face dismiss most
        point = load(work, points + VECTOR * index)
        if sign * dot(point, left) <= floor and sign * dot(point, right) <= floor:
            return True
    return False


@kernel
def _edges_left(b: Hull, work: Array, known: int, floor: float, first: int) -> tuple[int, int]:
    """List up to CHUNK edges of B that may win; return their number and where the list ends."""
    numbers, planes, edges = b.numbers, planes_of(b), edges_of(b)
    listed, done = 0, first
    while done < int(numbers[b.begin + EDGES]) and listed < CHUNK:
        edge = edges + EDGE * done
        left = load(numbers, planes + PLANE * int(numbers[edge + LEFT]))
        right = load(numbers, planes + PLANE * int(numbers[edge + RIGHT]))
        if not _dismissed(work, KNOWN_IN_B, known, left, right, -1.0, floor):
            work[EDGES_LEFT + listed] = done
            listed += 1
        done += 1
    return listed, done


@kernel
def best_edges(a: Hull, b: Hull, work: Array, known: int, floor: float) -> tuple[int, int, float]:
    """
    Find the edges of A and B along whose cross product the bodies are separated most.

    floor : [m]  only what is larger counts
    Returns their numbers, or NO_EDGE, and s; AXIS holds the normal, axes of A. After `best_face`.
    """
    edge_a, edge_b, most = NO_EDGE, NO_EDGE, floor
    numbers_a, numbers_b = a.numbers, b.numbers
    planes_a, planes_b, edges_a, edges_b = planes_of(a), planes_of(b), edges_of(a), edges_of(b)
    done = 0
    vertex_a = vertex_b = 0
    while done < int(numbers_b[b.begin + EDGES]):
        listed, done = _edges_left(b, work, known, min(most, 0.0), done)
        for of_a in range(int(numbers_a[a.begin + EDGES]) if listed > 0 else 0):
            edge = edges_a + EDGE * of_a
            left_a = load(numbers_a, planes_a + PLANE * int(numbers_a[edge + LEFT]))
            right_a = load(numbers_a, planes_a + PLANE * int(numbers_a[edge + RIGHT]))
            if _dismissed(work, KNOWN, known, left_a, right_a, 1.0, min(most, 0.0)):
                continue
            start_a = vertex(a, int(numbers_a[edge + START]))
            along_a = to_b(work, subtract(vertex(a, int(numbers_a[edge + END])), start_a))
            left_a, right_a = to_b(work, left_a), to_b(work, right_a)
            for entry in range(listed):
                of_b = int(work[EDGES_LEFT + entry])
                edge = edges_b + EDGE * of_b
                left_b = load(numbers_b, planes_b + PLANE * int(numbers_b[edge + LEFT]))
                right_b = load(numbers_b, planes_b + PLANE * int(numbers_b[edge + RIGHT]))
                left, right = dot(along_a, left_b), dot(along_a, right_b)
                if not left * right < 0.0:
                    continue
                start_b = vertex(b, int(numbers_b[edge + START]))
                along_b = subtract(vertex(b, int(numbers_b[edge + END])), start_b)
                over = dot(right_a, along_b)
                if not (dot(left_a, along_b) * over < 0.0 and left * over < 0.0):
                    continue
                normal = cross(along_a, along_b)
                squared = dot(normal, normal)
                lengths = NO_CROSS_PRODUCT * dot(along_a, along_a) * dot(along_b, along_b)
                if not squared > max(lengths, TINY):
                    continue
                length = math.sqrt(squared)
                if dot(normal, add(left_a, right_a)) < 0.0:
                    length = -length
                normal = from_b(work, divide(normal, length))
                if not dot(normal, subtract(point_of_b(work, start_b), start_a)) > most:
                    continue
                along, vertex_a, vertex_b = separation(a, b, work, normal, vertex_a, vertex_b)
                if along > most:
                    edge_a, edge_b, most = of_a, of_b, along
                    store(work, AXIS, normal)
    return edge_a, edge_b, most


@kernel
def nearest_on_edges(a: Hull, b: Hull, work: Array, edge_a: int, edge_b: int) -> None:
    """
    Write behind AXIS the points of two crossing edges that lie nearest to each other's line, and
    the edges as those that span it.
    """
    edge = edges_of(a) + EDGE * edge_a
    start_a = vertex(a, int(a.numbers[edge + START]))
    along_a = subtract(vertex(a, int(a.numbers[edge + END])), start_a)
    edge = edges_of(b) + EDGE * edge_b
    start_b = point_of_b(work, vertex(b, int(b.numbers[edge + START])))
    along_b = subtract(point_of_b(work, vertex(b, int(b.numbers[edge + END]))), start_b)
    way = subtract(start_b, start_a)
    squared_a, squared_b = dot(along_a, along_a), dot(along_b, along_b)
    both = dot(along_a, along_b)
    way_a, way_b = dot(along_a, way), dot(along_b, way)
    det = squared_a * squared_b - both * both
    share_a = share_b = 0.5
    if det > NO_CROSS_PRODUCT * squared_a * squared_b:
        share_a = min(max((way_a * squared_b - way_b * both) / det, 0.0), 1.0)
        share_b = min(max((way_a * both - way_b * squared_a) / det, 0.0), 1.0)
    store(work, EDGE_A, along_a)
    opposes = dot(cross(along_a, along_b), load(work, AXIS)) < 0.0
    store(work, EDGE_B, negate(along_b) if opposes else along_b)
    store(work, AXIS_A, add_scaled(start_a, share_a, along_a))
    store(work, AXIS_B, add_scaled(start_b, share_b, along_b))
