# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball on a plane: gap = m . x_A - offset - r_A, m the normal out of the plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINTS,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the lowest point of a ball above a plane, or in it."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    radius = numbers[a]
    gap = mx * x + my * y + mz * z - numbers[b + 3] - radius
    if not gap <= margin:
        return 0
    arm = radius + 0.5 * gap
    put_normal(found, -mx, -my, -mz)
    put_point(found, POINTS, x - arm * mx, y - arm * my, z - arm * mz, gap, 0.0)
    return 1
