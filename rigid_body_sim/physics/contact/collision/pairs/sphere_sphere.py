# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two balls: gap = |x_B - x_A| - r_A - r_B along the line of centres.

Where the centres coincide every normal is as good; it is the z axis of A.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINTS,
    TINY,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the point between two balls; two points (radius zero) never meet."""
    radius_a, radius_b = numbers[a], numbers[b]
    reach = radius_a + radius_b
    if not reach > 0.0:
        return 0
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    dx, dy, dz = poses[pb] - x, poses[pb + 1] - y, poses[pb + 2] - z
    squared = dx * dx + dy * dy + dz * dz
    distance = math.sqrt(squared)
    gap = distance - reach
    if not gap <= margin:
        return 0
    nx, ny, nz = poses[pa + 5], poses[pa + 8], poses[pa + 11]
    if squared > TINY:
        nx, ny, nz = dx / distance, dy / distance, dz / distance
    arm = radius_a + 0.5 * gap
    put_normal(found, nx, ny, nz)
    put_point(found, POINTS, x + arm * nx, y + arm * ny, z + arm * nz, gap, 0.0)
    return 1
