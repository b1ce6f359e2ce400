# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule on a plane: the balls at its two ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the ends of a capsule that are near a plane; feature: 0 the end at -z, 1 that at +z."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    ax, ay, az = poses[pa + 5], poses[pa + 8], poses[pa + 11]
    radius = numbers[a]
    middle = mx * x + my * y + mz * z - numbers[b + 3] - radius
    rise = mx * ax + my * ay + mz * az
    count = 0
    for end in range(2):
        t = numbers[a + 1] if end else -numbers[a + 1]
        gap = middle + t * rise
        if gap <= margin:
            arm = radius + 0.5 * gap
            px, py, pz = x + (t * ax - arm * mx), y + (t * ay - arm * my), z + (t * az - arm * mz)
            put_point(found, POINTS + count * POINT, px, py, pz, gap, float(end))
            count += 1
    put_normal(found, -mx, -my, -mz)
    return count
