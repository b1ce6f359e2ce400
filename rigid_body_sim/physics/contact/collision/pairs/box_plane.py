# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box on a plane: the corners of the side that faces the plane, as far as they are near it.

The lowest corner is always one of them, and so is every corner it can tip over to. Corners of the
side above are left out even where a plate is thinner than the margin: they would push real ones
out of the manifold.
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
    """Find the corners of a box below the margin; feature: number of the corner."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    height = mx * x + my * y + mz * z - numbers[b + 3]
    along_0 = mx * poses[pa + 3] + my * poses[pa + 6] + mz * poses[pa + 9]
    along_1 = mx * poses[pa + 4] + my * poses[pa + 7] + mz * poses[pa + 10]
    along_2 = mx * poses[pa + 5] + my * poses[pa + 8] + mz * poses[pa + 11]
    reach_0 = abs(along_0) * numbers[a]
    reach_1 = abs(along_1) * numbers[a + 1]
    reach_2 = abs(along_2) * numbers[a + 2]
    if not height - (reach_0 + reach_1 + reach_2) <= margin:
        return 0
    facing = 2
    if abs(along_0) > abs(along_1):
        if abs(along_0) > abs(along_2):
            facing = 0
    elif abs(along_1) > abs(along_2):
        facing = 1
    up = 0 if facing == 0 and along_0 > 0.0 else 1
    if facing == 1:
        up = 0 if along_1 > 0.0 else 1
    if facing == 2:
        up = 0 if along_2 > 0.0 else 1
    count = 0
    for corner in range(8):
        if corner >> facing & 1 != up:
            continue
        h0 = numbers[a] if corner & 1 else -numbers[a]
        h1 = numbers[a + 1] if corner & 2 else -numbers[a + 1]
        h2 = numbers[a + 2] if corner & 4 else -numbers[a + 2]
        gap = height + (along_0 * h0 + along_1 * h1 + along_2 * h2)
        if not gap <= margin:
            continue
        half = 0.5 * gap
        px = x + (poses[pa + 3] * h0 + poses[pa + 4] * h1 + poses[pa + 5] * h2 - half * mx)
        py = y + (poses[pa + 6] * h0 + poses[pa + 7] * h1 + poses[pa + 8] * h2 - half * my)
        pz = z + (poses[pa + 9] * h0 + poses[pa + 10] * h1 + poses[pa + 11] * h2 - half * mz)
        put_point(found, POINTS + count * POINT, px, py, pz, gap, float(corner))
        count += 1
    put_normal(found, -mx, -my, -mz)
    return count
