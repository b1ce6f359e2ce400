# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two boxes in the axes of the first, as the kernels of boxes keep them in their scratch.

    COSINES  (3, 3) [-]  C_ij = a_i . b_j, axes of A and B: from the axes of B to those of A
    ABSOLUTE (3, 3) [-]  |C_ij|
    OFFSET   (3,) [m]    t, middle of B from the middle of A, axes of A
    HALF_A, HALF_B (3,) [m]  half edges
Separation of the two along a unit vector n:
    s(n) = |t . n| - sum_i |n . a_i| h_i - sum_j |n . b_j| h_j
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import SCRATCH
from rigid_body_sim.physics.vectors import dot, load, subtract

Array = NDArray[np.float64]

two_boxes = Record(begin=SCRATCH)
COSINES = two_boxes.matrix('-', 'C_ij = a_i . b_j, row by row: a direction of B in axes of A')
ABSOLUTE = two_boxes.matrix('-', '|C_ij|')
OFFSET = two_boxes.vector('m', 'middle of B from the middle of A, axes of A')
HALF_A = two_boxes.vector('m', 'half edges of A')
HALF_B = two_boxes.vector('m', 'half edges of B')
SCRATCH_BEHIND = two_boxes.size
ROW = 3  # numbers of a row of COSINES and ABSOLUTE


@inline
def relate(
    parameters: Array, box_a: int, box_b: int, poses: Array, pose_a: int, pose_b: int,
    found: Array,
) -> None:  # fmt: skip
    """Write the relative pose and the half edges of two boxes."""
    offset = between(poses, pose_a, pose_b)
    for i in range(3):
        axis_a = pose.axis(poses, pose_a, i)
        found[OFFSET + i] = dot(axis_a, offset)
        found[HALF_A + i] = parameters[box_a + i]
        found[HALF_B + i] = parameters[box_b + i]
        for j in range(3):
            cosine = dot(axis_a, pose.axis(poses, pose_b, j))
            entry = ROW * i + j
            found[COSINES + entry] = cosine
            found[ABSOLUTE + entry] = abs(cosine)


@inline
def crossed(found: Array, i: int, j: int) -> Any:
    """
    Separation along a_i x b_j, times its length [m].

    The length is sqrt(1 - C_ij^2).
    """
    next_a, last_a = (i + 1) % 3, (i + 2) % 3
    next_b, last_b = (j + 1) % 3, (j + 2) % 3
    on_i, on_next, on_last = ROW * i, ROW * next_a, ROW * last_a
    along = (
        found[OFFSET + last_a] * found[COSINES + on_next + j]
        - found[OFFSET + next_a] * found[COSINES + on_last + j]
    )
    return abs(along) - (
        found[HALF_A + next_a] * found[ABSOLUTE + on_last + j]
        + found[HALF_A + last_a] * found[ABSOLUTE + on_next + j]
        + found[HALF_B + next_b] * found[ABSOLUTE + on_i + last_b]
        + found[HALF_B + last_b] * found[ABSOLUTE + on_i + next_b]
    )


@inline
def between(poses: Array, start: int, end: int) -> Any:
    """From the origin of one pose to that of another, world axes."""
    return subtract(load(poses, end), load(poses, start))
