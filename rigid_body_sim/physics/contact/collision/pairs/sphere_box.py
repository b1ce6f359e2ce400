# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a box: the ball's centre and the nearest point of the box.

Centre p outside, in box axes: q_k = clamp(p_k, -h_k, h_k), gap = |p - q| - r. Inside: through the
nearest side, gap = max_k(|p_k| - h_k) - r.
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
    """Find the point between a ball and a box."""
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    dx, dy, dz = x - poses[pb], y - poses[pb + 1], z - poses[pb + 2]
    px = dx * poses[pb + 3] + dy * poses[pb + 6] + dz * poses[pb + 9]
    py = dx * poses[pb + 4] + dy * poses[pb + 7] + dz * poses[pb + 10]
    pz = dx * poses[pb + 5] + dy * poses[pb + 8] + dz * poses[pb + 11]
    hx, hy, hz = numbers[b], numbers[b + 1], numbers[b + 2]
    ex, ey, ez = clamp(px, hx) - px, clamp(py, hy) - py, clamp(pz, hz) - pz
    squared = ex * ex + ey * ey + ez * ez
    if squared > TINY:
        distance = math.sqrt(squared)
        ex, ey, ez = ex / distance, ey / distance, ez / distance
    else:
        distance = abs(px) - hx
        ex, ey, ez = 1.0 if px < 0.0 else -1.0, 0.0, 0.0
        if abs(py) - hy > distance:
            distance = abs(py) - hy
            ex, ey, ez = 0.0, 1.0 if py < 0.0 else -1.0, 0.0
        if abs(pz) - hz > distance:
            distance = abs(pz) - hz
            ex, ey, ez = 0.0, 0.0, 1.0 if pz < 0.0 else -1.0
    radius = numbers[a]
    gap = distance - radius
    if not gap <= margin:
        return 0
    nx = poses[pb + 3] * ex + poses[pb + 4] * ey + poses[pb + 5] * ez
    ny = poses[pb + 6] * ex + poses[pb + 7] * ey + poses[pb + 8] * ez
    nz = poses[pb + 9] * ex + poses[pb + 10] * ey + poses[pb + 11] * ez
    arm = radius + 0.5 * gap
    put_normal(found, nx, ny, nz)
    put_point(found, POINTS, x + arm * nx, y + arm * ny, z + arm * nz, gap, 0.0)
    return 1
