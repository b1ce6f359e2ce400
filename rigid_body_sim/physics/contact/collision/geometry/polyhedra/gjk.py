# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The distance of two convex sets of points: the algorithm of Gilbert, Johnson and Keerthi (GJK).

    d = min |b - a|,  a in A, b in B  =  distance of the origin from M = B - A

M is the Minkowski difference: all b - a.
A simplex of up to four points w = b - a of M approaches the point v of M nearest to the origin:
the point of M farthest along -v joins it, and the corners v does not need leave.
v . w / |v| is a lower bound of d at each step, so bodies farther apart than the margin are
dismissed after one or two steps. For polyhedra the steps end at the exact features.

The nearest point of a triangle is computed from its plane, not from its corners: the direction of
v keeps its digits while d goes to zero.

Source: Gilbert, Johnson, Keerthi, IEEE J. Robotics and Automation 4 (1988) 193.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import TINY
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import VERTEX
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    point_of_b,
    to_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    DIFFERENCE,
    NEAREST,
    NEAREST_A,
    NEAREST_B,
    OF_VERTEX_A,
    OF_VERTEX_B,
    OFFSET,
    SIMPLEX,
    SIMPLEX_CORNER,
    WEIGHT,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    Vertices,
    support,
)
from rigid_body_sim.physics.vectors import (
    add_scaled,
    cross,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

FAR, GAP, TOUCH = 0, 1, 2  # farther apart than the margin; apart; touching or overlapping
GJK_STEPS = 64  # [-] most steps; 5 to 12 are usual, and meshes of 5000 vertices need some 15
CLOSE = 1e-15  # [-] gain of |v|^2 that ends the search
TOUCHING = 1e-9  # [-] of the size of the bodies: nearer is for the separating axes to judge
COLLINEAR = 1e-26  # [-] squared sine below which a triangle is only its sides
FLAT_SIMPLEX = 1e-20  # [-] squared height / edge of a tetrahedron: each face of it is looked at
TETRAHEDRON = 4  # [-] corners of a simplex that may hold the origin
FIRST, SECOND, THIRD, FOURTH = (SIMPLEX + SIMPLEX_CORNER * index for index in range(4))


@kernel
def closest(a: Vertices, b: Vertices, margin: float, size: float, work: Array) -> tuple[int, int]:
    """
    Find the nearest points of two polyhedra.

    a, b   : vertices, each in its own axes; OFFSET and ROTATION say how B stands
    margin : [m]  farther apart is FAR
    size   : [m]  of both bodies
    Returns (FAR | GAP | TOUCH, corners of SIMPLEX); for GAP, NEAREST holds v and both points.
    """
    way = load(work, OFFSET)
    squared = dot(way, way)
    if not squared > 0.0:
        way, squared = (1.0, 0.0, 0.0), 1.0
    corners = 0
    vertex_a = vertex_b = 0
    limit = margin * margin
    touching = max((TOUCHING * size) * (TOUCHING * size), TINY)
    stalled = False
    along = squared
    for _ in range(GJK_STEPS):
        vertex_a = support(a, way, vertex_a)
        vertex_b = support(b, to_b(work, negate(way)), vertex_b)
        difference = _difference(a, b, vertex_a, vertex_b, work)
        along = dot(way, difference)
        if along > 0.0 and along * along > limit * squared:
            return FAR, corners
        if stalled or (corners > 0 and squared - along <= CLOSE * squared):
            break
        known = False
        for corner in range(corners):
            row = SIMPLEX + SIMPLEX_CORNER * corner
            known = known or (
                work[row + OF_VERTEX_A] == vertex_a and work[row + OF_VERTEX_B] == vertex_b
            )
        if known:
            break
        row = SIMPLEX + SIMPLEX_CORNER * corners
        store(work, row + DIFFERENCE, difference)
        work[row + OF_VERTEX_A], work[row + OF_VERTEX_B] = vertex_a, vertex_b
        before = squared if corners > 0 else math.inf
        corners = nearest_of_simplex(work, corners + 1)
        if corners == 0:
            return TOUCH, TETRAHEDRON
        way = load(work, NEAREST)
        squared = dot(way, way)
        if not squared > touching:
            return TOUCH, corners
        stalled = not squared < before
    if not along > 0.25 * squared:  # round-off got the better of a degenerate simplex
        return TOUCH, corners
    _write_nearest(a, b, corners, work)
    return GAP, corners


@inline
def _difference(a: Vertices, b: Vertices, vertex_a: int, vertex_b: int, work: Array) -> Any:
    """Return w = b - a of two vertices."""
    of_b = point_of_b(work, load(b.numbers, b.begin + VERTEX * vertex_b))
    return subtract(of_b, load(a.numbers, a.begin + VERTEX * vertex_a))


@kernel
def _write_nearest(a: Vertices, b: Vertices, corners: int, work: Array) -> None:
    """Write the nearest points of A and B: of the simplex, by its weights."""
    nearest_a = nearest_b = (0.0, 0.0, 0.0)
    for corner in range(corners):
        row = SIMPLEX + SIMPLEX_CORNER * corner
        weight = work[row + WEIGHT]
        of_a = load(a.numbers, a.begin + VERTEX * int(work[row + OF_VERTEX_A]))
        of_b = load(b.numbers, b.begin + VERTEX * int(work[row + OF_VERTEX_B]))
        nearest_a = add_scaled(nearest_a, weight, of_a)
        nearest_b = add_scaled(nearest_b, weight, point_of_b(work, of_b))
    store(work, NEAREST_A, nearest_a)
    store(work, NEAREST_B, nearest_b)


@kernel
def nearest_of_simplex(work: Array, corners: int) -> int:
    """
    Find v on a simplex and keep the corners it needs, each with its weight.

    Returns their number; 0 for a tetrahedron around the origin.
    """
    if corners <= 2:
        last = SIMPLEX + SIMPLEX_CORNER * (corners - 1)
        _, share, nearest = _segment(work, FIRST, last)
        work[FIRST + WEIGHT] = 1.0 - share
        if corners == 2:
            work[last + WEIGHT] = share
    else:
        least = math.inf
        best = 3
        weights = nearest = (0.0, 0.0, 0.0)
        for face in range(0 if corners == TETRAHEDRON else 3, 4):  # the corner it leaves out
            p, q, r = _corners_of_face(face)
            left_out = SIMPLEX + SIMPLEX_CORNER * face
            if corners == TETRAHEDRON and _looks_away(work, p, q, r, left_out):
                continue
            squared, shares, point = _triangle(work, p, q, r)
            if squared < least:
                least, best, weights, nearest = squared, face, shares, point
        if least == math.inf:
            return 0
        if corners == TETRAHEDRON:
            work[SIMPLEX + SIMPLEX_CORNER * best + WEIGHT] = 0.0
        p, q, r = _corners_of_face(best)
        work[p + WEIGHT], work[q + WEIGHT], work[r + WEIGHT] = weights
    store(work, NEAREST, nearest)
    to = SIMPLEX
    for corner in range(corners):
        row = SIMPLEX + SIMPLEX_CORNER * corner
        if work[row + WEIGHT] > 0.0:
            for number in range(SIMPLEX_CORNER):
                work[to + number] = work[row + number]
            to += SIMPLEX_CORNER
    return (to - SIMPLEX) // SIMPLEX_CORNER


@inline
def _corners_of_face(face: int) -> Any:
    """Return where the corners of a face of the simplex begin; face: the corner it leaves out."""
    return (
        SECOND if face == 0 else FIRST,
        THIRD if face <= 1 else SECOND,
        FOURTH if face <= 2 else THIRD,
    )


@inline
def _looks_away(work: Array, p: int, q: int, r: int, left_out: int) -> Any:
    """Tell whether the origin and a fourth corner lie on the same side of the face p q r."""
    begin = load(work, p)
    normal = cross(subtract(load(work, q), begin), subtract(load(work, r), begin))
    arm = subtract(load(work, left_out), begin)
    opposite = dot(normal, arm)
    origin = -dot(normal, begin)
    edge = dot(normal, normal) * dot(arm, arm)
    return origin * opposite > 0.0 and opposite * opposite > FLAT_SIMPLEX * edge


@kernel
def _segment(work: Array, p: int, q: int) -> Any:
    """Return |v|^2, the weight of q, and v, of the edge p q."""
    nearest, end = load(work, p), load(work, q)
    edge = subtract(end, nearest)
    length = dot(edge, edge)
    share = -dot(nearest, edge)
    if not share > 0.0:
        share = 0.0
    elif share >= length:
        share = 1.0
        nearest = end
    else:
        share /= length
        nearest = add_scaled(nearest, share, edge)
    return dot(nearest, nearest), share, nearest


@kernel
def _triangle(work: Array, p: int, q: int, r: int) -> Any:
    """Return |v|^2, the weights of p, q, r, and v, of the triangle p q r."""
    at_p, at_q, at_r = load(work, p), load(work, q), load(work, r)
    p_to_q, p_to_r, q_to_r = subtract(at_q, at_p), subtract(at_r, at_p), subtract(at_r, at_q)
    normal = cross(p_to_q, p_to_r)
    squared = dot(normal, normal)
    size = dot(p_to_q, p_to_q) * dot(p_to_r, p_to_r)
    thin = not squared > max(COLLINEAR * size, TINY)  # [m^4] below, its digits are lost
    share_p = dot(normal, cross(at_q, q_to_r))
    share_q = dot(normal, cross(p_to_r, at_p))
    share_r = dot(normal, cross(at_p, p_to_q))
    if share_p > 0.0 and share_q > 0.0 and share_r > 0.0 and not thin:
        total = share_p + share_q + share_r
        nearest = scale(dot(normal, at_p) / squared, normal)
        weights = (share_p / total, share_q / total, share_r / total)
        return dot(nearest, nearest), weights, nearest
    least = math.inf
    weights = nearest = (0.0, 0.0, 0.0)
    for side in range(3):  # its number: the corner it leaves out
        if not thin and (share_p if side == 0 else share_q if side == 1 else share_r) > 0.0:
            continue
        square, share, point = _segment(work, q if side == 0 else p, q if side == 2 else r)
        if square < least:
            least, nearest = square, point
            weights = (
                0.0 if side == 0 else 1.0 - share,
                0.0 if side == 1 else (share if side == 2 else 1.0 - share),
                0.0 if side == 2 else share,
            )
    return least, weights, nearest
