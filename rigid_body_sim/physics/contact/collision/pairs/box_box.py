# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two boxes: fifteen separating axes, then a patch of two sides, or a point of two edges.

The separating axis is that of the largest separation s among the normals of the sides and the
cross products of edges (Gottschalk, Lin, Manocha, SIGGRAPH 1996). It stays the same under small
motions because a later kind must win clearly: a side of B by FACE_LEAD of the smallest half edge
over a side of A, a pair of edges by EDGE_LEAD of it and EDGE_SHARE |s| over the best side.

Where the patch is empty, or edges pass each other beyond their ends, boxes that are apart get the
pair of their nearest points, and boxes that overlap get the deepest corner.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.boxes.edges import (
    edge_contact,
    nearest_points,
)
from rigid_body_sim.physics.contact.collision.geometry.boxes.faces import (
    deepest_corner,
    face_contact,
)
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import (
    between,
    component,
    relate,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import SHORTEST

Array = NDArray[np.float64]

FACE_LEAD = 1e-4  # [-] of the smallest half edge; 0: stacked boxes change their reference side
EDGE_LEAD = 1e-3  # [-] of the smallest half edge; 0: sides that touch get one point for four
EDGE_SHARE = 0.05  # [-] of |s|
CLEAR = 1e-9  # [-] of the smallest half edge: below, the direction between nearest points is noise
PARALLEL = 1e-6  # [-] sin^2 of the angle between edges below which they have no common normal
COVERED = 1.0 - 5e-8  # [-] |a_i . b_j| above which every cross product is the normal of a side


@inline
def _crossed(
    t1: float,
    t2: float,
    c1: float,
    c2: float,
    h1: float,
    h2: float,
    g1: float,
    d1: float,
    g2: float,
    d2: float,
    to_beat: float,
) -> Any:
    """
    Separation along a_i x b_j, not divided by its length where it cannot win.

        t1, t2 : middle of B along the two axes of A behind a_i;   h1, h2 : half edges of A there
        c1, c2 : b_j along them, so that the length is sqrt(c1^2 + c2^2)
        g1, g2 : half edges of B behind b_j;   d1, d2 : a_i along the axes of the other one
    """
    s = abs(t2 * c1 - t1 * c2) - (h1 * abs(c2) + h2 * abs(c1) + g1 * abs(d2) + g2 * abs(d1))
    if s < 0.0 and s <= to_beat:
        return s  # to divide by a length below one makes it smaller still
    squared = c1 * c1 + c2 * c2
    return s / math.sqrt(squared) if squared > PARALLEL else -math.inf


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the manifold of two boxes."""
    dx, dy, dz = between(poses, pa, pb)
    h0, h1, h2 = numbers[a], numbers[a + 1], numbers[a + 2]
    g0, g1, g2 = numbers[b], numbers[b + 1], numbers[b + 2]
    bx, by, bz = poses[pb + 3], poses[pb + 6], poses[pb + 9]
    c00 = component(poses, pa + 3, bx, by, bz)
    c10 = component(poses, pa + 4, bx, by, bz)
    c20 = component(poses, pa + 5, bx, by, bz)
    u0 = abs(bx * dx + by * dy + bz * dz)
    bx, by, bz = poses[pb + 4], poses[pb + 7], poses[pb + 10]
    c01 = component(poses, pa + 3, bx, by, bz)
    c11 = component(poses, pa + 4, bx, by, bz)
    c21 = component(poses, pa + 5, bx, by, bz)
    u1 = abs(bx * dx + by * dy + bz * dz)
    bx, by, bz = poses[pb + 5], poses[pb + 8], poses[pb + 11]
    c02 = component(poses, pa + 3, bx, by, bz)
    c12 = component(poses, pa + 4, bx, by, bz)
    c22 = component(poses, pa + 5, bx, by, bz)
    u2 = abs(bx * dx + by * dy + bz * dz)
    # sides of A
    t0 = component(poses, pa + 3, dx, dy, dz)
    t1 = component(poses, pa + 4, dx, dy, dz)
    t2 = component(poses, pa + 5, dx, dy, dz)
    s0 = abs(t0) - (h0 + g0 * abs(c00) + g1 * abs(c01) + g2 * abs(c02))
    s1 = abs(t1) - (h1 + g0 * abs(c10) + g1 * abs(c11) + g2 * abs(c12))
    s2 = abs(t2) - (h2 + g0 * abs(c20) + g1 * abs(c21) + g2 * abs(c22))
    if not (s0 <= margin and s1 <= margin and s2 <= margin):
        return 0
    best, axis = s0, 0
    if s1 > best:
        best, axis = s1, 1
    if s2 > best:
        best, axis = s2, 2
    # sides of B
    s0 = u0 - (g0 + h0 * abs(c00) + h1 * abs(c10) + h2 * abs(c20))
    s1 = u1 - (g1 + h0 * abs(c01) + h1 * abs(c11) + h2 * abs(c21))
    s2 = u2 - (g2 + h0 * abs(c02) + h1 * abs(c12) + h2 * abs(c22))
    if not (s0 <= margin and s1 <= margin and s2 <= margin):
        return 0
    smallest = min(h0, h1, h2, g0, g1, g2)
    best_b, axis_b = s0, 0
    if s1 > best_b:
        best_b, axis_b = s1, 1
    if s2 > best_b:
        best_b, axis_b = s2, 2
    of_b = best_b > best + FACE_LEAD * smallest
    if of_b:
        best, axis = best_b, axis_b
    # edges
    edge, largest = -1, best + EDGE_LEAD * smallest + EDGE_SHARE * abs(best)
    closest = max(abs(c00), abs(c01), abs(c02), abs(c10), abs(c11), abs(c12))
    if max(closest, abs(c20), abs(c21), abs(c22)) < COVERED:
        s = _crossed(t1, t2, c10, c20, h1, h2, g1, c01, g2, c02, largest)
        if s > largest:
            largest, edge = s, 0
        s = _crossed(t1, t2, c11, c21, h1, h2, g2, c02, g0, c00, largest)
        if s > largest:
            largest, edge = s, 1
        s = _crossed(t1, t2, c12, c22, h1, h2, g0, c00, g1, c01, largest)
        if s > largest:
            largest, edge = s, 2
        s = _crossed(t2, t0, c20, c00, h2, h0, g1, c11, g2, c12, largest)
        if s > largest:
            largest, edge = s, 3
        s = _crossed(t2, t0, c21, c01, h2, h0, g2, c12, g0, c10, largest)
        if s > largest:
            largest, edge = s, 4
        s = _crossed(t2, t0, c22, c02, h2, h0, g0, c10, g1, c11, largest)
        if s > largest:
            largest, edge = s, 5
        s = _crossed(t0, t1, c00, c10, h0, h1, g1, c21, g2, c22, largest)
        if s > largest:
            largest, edge = s, 6
        s = _crossed(t0, t1, c01, c11, h0, h1, g2, c22, g0, c20, largest)
        if s > largest:
            largest, edge = s, 7
        s = _crossed(t0, t1, c02, c12, h0, h1, g0, c20, g1, c21, largest)
        if s > largest:
            largest, edge = s, 8
        if edge >= 0 and largest > margin:
            return 0
    reference, incident, pr, pi = (b, a, pb, pa) if of_b else (a, b, pa, pb)
    count = 0
    if edge < 0:
        count = face_contact(
            numbers, reference, incident, poses, pr, pi, margin, found, of_b, axis
        )
        if count:
            return count
        if not best > max(CLEAR * smallest, SHORTEST):
            return deepest_corner(numbers, incident, poses, pr, pi, found, of_b, axis, best)
    relate(numbers, a, b, poses, pa, pb, found)
    if edge >= 0:
        apart = largest > max(CLEAR * smallest, SHORTEST)
        count = edge_contact(poses, pa, margin, found, edge // 3, edge % 3, apart)
    return count if count else nearest_points(poses, pa, margin, found)
