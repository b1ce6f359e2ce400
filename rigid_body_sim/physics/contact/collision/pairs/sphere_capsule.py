# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a capsule: the ball and the nearest ball on the capsule's axis.

    t = clamp((x_A - x_B) . b, -l, l),  gap = |x_A - x_B - t b| - r_A - r_B,  b: the axis
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
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
    """Find the point between a ball and a capsule."""
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    dx, dy, dz = poses[pb] - x, poses[pb + 1] - y, poses[pb + 2] - z
    bx, by, bz = poses[pb + 5], poses[pb + 8], poses[pb + 11]
    t = clamp(-(bx * dx + by * dy + bz * dz), numbers[b + 1])
    dx, dy, dz = dx + t * bx, dy + t * by, dz + t * bz
    squared = dx * dx + dy * dy + dz * dz
    distance = math.sqrt(squared)
    radius = numbers[a]
    gap = distance - radius - numbers[b]
    if not gap <= margin:
        return 0
    nx, ny, nz = poses[pb + 3], poses[pb + 6], poses[pb + 9]
    if squared > TINY:
        nx, ny, nz = dx / distance, dy / distance, dz / distance
    arm = radius + 0.5 * gap
    put_normal(found, nx, ny, nz)
    put_point(found, POINTS, x + arm * nx, y + arm * ny, z + arm * nz, gap, 0.0)
    return 1
