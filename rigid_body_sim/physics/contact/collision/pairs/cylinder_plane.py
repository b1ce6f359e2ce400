# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder on a plane, with its true round rim (`rim`).

The lowest points of both ends are the lowest line of a lying cylinder, which rolls without bumps.
The lower end also has points a quarter turn to either side and, unless the other end is nearer,
one opposite: a standing cylinder rests on four points.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import (
    lowest_direction,
    rim_feature,
)
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
    """Find up to four points of the rims of a cylinder near a plane; feature: see `rim`."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    ax, ay, az = poses[pa + 5], poses[pa + 8], poses[pa + 11]
    radius, half = numbers[a], numbers[a + 1]
    rise = mx * ax + my * ay + mz * az
    height = mx * x + my * y + mz * z - numbers[b + 3]
    # tau in the axes of the end: its component along a is exactly zero there
    tx = mx * poses[pa + 3] + my * poses[pa + 6] + mz * poses[pa + 9]
    ty = mx * poses[pa + 4] + my * poses[pa + 7] + mz * poses[pa + 10]
    sine = math.sqrt(tx * tx + ty * ty)
    lower = height - half * abs(rise)
    if not lower - radius * sine <= margin:
        return 0
    ux, uy, slot = lowest_direction(tx, ty)
    put_normal(found, -mx, -my, -mz)
    upper_end = rise < 0.0  # the end at +z is the lower one
    fall = radius * (tx * ux + ty * uy)
    other = half * abs(rise) < fall  # the other end is lower than the point opposite
    count = 0
    for k in range(4):
        end = half if upper_end else -half
        qx, qy = -ux, -uy  # towards the point
        gap = lower - fall
        feature = rim_feature(k, slot, upper_end)
        if k == 1 or k == 2:  # a quarter turn to either side
            qx, qy = (uy, -ux) if k == 1 else (-uy, ux)
            gap = lower + radius * (tx * qx + ty * qy)
        if k == 3 and other:
            end = -end
            gap = lower + 2.0 * half * abs(rise) - fall
            feature = 1.0 - upper_end  # the lowest of the other end
        elif k == 3:
            qx, qy = ux, uy
            gap = lower + fall
        if not gap <= margin:
            continue
        qx, qy = radius * qx, radius * qy
        put_point(
            found,
            POINTS + count * POINT,
            x + (end * ax + qx * poses[pa + 3] + qy * poses[pa + 4] - 0.5 * gap * mx),
            y + (end * ay + qx * poses[pa + 6] + qy * poses[pa + 7] - 0.5 * gap * my),
            z + (end * az + qx * poses[pa + 9] + qy * poses[pa + 10] - 0.5 * gap * mz),
            gap,
            feature,
        )
        count += 1
    return count
