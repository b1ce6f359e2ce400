# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two boxes in the axes of the first, as kernels keep them in their scratch.

    TURN    (3, 3) [-]  C_ij = a_i . b_j, axes of A and B: from the axes of B to those of A
    ABSOLUTE (3, 3) [-] |C_ij|
    MIDDLE  (3,) [m]    t, middle of B from the middle of A, axes of A
    HALF_A, HALF_B (3,) [m]  half edges
Separation of the two along a unit vector n:
    s(n) = |t . n| - sum_i |n . a_i| h_i - sum_j |n . b_j| h_j
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.manifold import SCRATCH

Array = NDArray[np.float64]

TURN = SCRATCH
ABSOLUTE = TURN + 9
MIDDLE = ABSOLUTE + 9
HALF_A = MIDDLE + 3
HALF_B = HALF_A + 3
FREE = HALF_B + 3


@inline
def load(numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, found: Array) -> None:
    """Write the relative pose and the half edges of two boxes."""
    dx = poses[pb] - poses[pa]
    dy = poses[pb + 1] - poses[pa + 1]
    dz = poses[pb + 2] - poses[pa + 2]
    for i in range(3):
        ax, ay, az = poses[pa + 3 + i], poses[pa + 6 + i], poses[pa + 9 + i]
        found[MIDDLE + i] = ax * dx + ay * dy + az * dz
        found[HALF_A + i] = numbers[a + i]
        found[HALF_B + i] = numbers[b + i]
        for j in range(3):
            c = ax * poses[pb + 3 + j] + ay * poses[pb + 6 + j] + az * poses[pb + 9 + j]
            found[TURN + 3 * i + j] = c
            found[ABSOLUTE + 3 * i + j] = abs(c)


@inline
def crossed(found: Array, i: int, j: int) -> Any:
    """
    Separation along a_i x b_j, times its length [m].

    The length is sqrt(1 - C_ij^2).
    """
    i1, i2 = (i + 1) % 3, (i + 2) % 3
    j1, j2 = (j + 1) % 3, (j + 2) % 3
    at_1, at_2 = TURN + 3 * i1 + j, TURN + 3 * i2 + j
    along = found[MIDDLE + i2] * found[at_1] - found[MIDDLE + i1] * found[at_2]
    return abs(along) - (
        found[HALF_A + i1] * found[ABSOLUTE + 3 * i2 + j]
        + found[HALF_A + i2] * found[ABSOLUTE + 3 * i1 + j]
        + found[HALF_B + j1] * found[ABSOLUTE + 3 * i + j2]
        + found[HALF_B + j2] * found[ABSOLUTE + 3 * i + j1]
    )


@inline
def between(poses: Array, p: int, q: int) -> Any:
    """From the origin of the pose at p to that of the pose at q, world axes."""
    return poses[q] - poses[p], poses[q + 1] - poses[p + 1], poses[q + 2] - poses[p + 2]


@inline
def component(poses: Array, p: int, x: float, y: float, z: float) -> Any:
    """Component of a vector along the axis whose column of R begins at p."""
    return poses[p] * x + poses[p + 3] * y + poses[p + 6] * z
