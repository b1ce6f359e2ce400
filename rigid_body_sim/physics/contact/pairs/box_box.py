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

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.box_edges import PARALLEL, edge_contact, nearest_points
from rigid_body_sim.physics.contact.box_faces import deepest_corner, face_contact
from rigid_body_sim.physics.contact.two_boxes import (
    HALF_A,
    HALF_B,
    TURN,
    crossed,
    face_separation_a,
    face_separation_b,
    load,
)
from rigid_body_sim.physics.kernels import kernel

Array = NDArray[np.float64]

FACE_LEAD = 1e-4  # [-] of the smallest half edge; 0: stacked boxes change their reference side
EDGE_LEAD = 1e-3  # [-] of the smallest half edge; 0: sides that touch get one point for four
EDGE_SHARE = 0.05  # [-] of |s|
CLEAR = 1e-9  # [-] of the smallest half edge: below, the direction between nearest points is noise


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the manifold of two boxes."""
    load(numbers, a, b, poses, pa, pb, found)
    best, axis = -math.inf, 0
    for i in range(3):
        s = face_separation_a(found, i)
        if not s <= margin:
            return 0
        if s > best:
            best, axis = s, i
    best_b, axis_b = -math.inf, 0
    for j in range(3):
        s = face_separation_b(found, j)
        if not s <= margin:
            return 0
        if s > best_b:
            best_b, axis_b = s, j
    smallest = found[HALF_A]
    for k in range(3):
        smallest = min(smallest, found[HALF_A + k], found[HALF_B + k])
    of_b = best_b > best + FACE_LEAD * smallest
    if of_b:
        best, axis = best_b, axis_b
    to_beat = best + EDGE_LEAD * smallest + EDGE_SHARE * abs(best)
    edge = -1
    largest = to_beat
    for i in range(3):
        for j in range(3):
            s = crossed(found, i, j)
            if s < 0.0 and s <= largest:
                continue  # to divide by a length below one makes it smaller still
            c = found[TURN + 3 * i + j]
            sine = 1.0 - c * c
            if sine < PARALLEL:
                continue
            s /= math.sqrt(sine)
            if s > margin:
                return 0
            if s > largest:
                largest, edge = s, 3 * i + j
    apart = CLEAR * smallest
    if edge >= 0:
        count = edge_contact(poses, pa, found, edge // 3, edge % 3, largest > apart)
        return count if count else nearest_points(poses, pa, margin, found)
    count = face_contact(poses, pa, pb, margin, found, of_b, axis)
    if count:
        return count
    if best > apart:
        return nearest_points(poses, pa, margin, found)
    return deepest_corner(poses, pa, pb, found, of_b, axis, best)
