# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder on a plane, with its true round rim.

The lowest point of either end is at its middle - r u, u the direction in which the end rises; both
together are the lowest line of a lying cylinder, which rolls without bumps. The lower end also has
points a quarter turn to either side and, unless the other end is nearer, one opposite: a
standing cylinder rests on four points.

    m normal out of the plane, a axis, tau = m - (m . a) a, |tau| sine of the tilt, u = tau / |tau|

Where the end is parallel to the plane u has no meaning. For |tau| < FLAT it is blended with the
nearest of the four axes d fixed in the end: u ~ tau + (FLAT - |tau|) d. So a cylinder at rest
keeps its points, and above FLAT the lowest point is exact.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.manifold import POINT, POINTS, put_normal, put_point
from rigid_body_sim.physics.kernels import kernel

Array = NDArray[np.float64]

FLAT = 1e-4  # [-] sine of the tilt below which an end keeps points fixed in it
FIXED = 10.0  # features of such points begin here


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """
    Find up to four points of the rims of a cylinder near a plane.

    feature: 0 and 1 the lowest of either end, 2 and 3 beside it, 4 opposite, FIXED + 0 … 3 fixed
    in the end; + 5 for those beside and opposite on the upper end (+z).
    """
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
    ux, uy, slot = tx, ty, -1
    if sine < FLAT:
        blend = FLAT - sine
        if abs(ty) > abs(tx):
            slot = 3 if ty < 0.0 else 1
            uy += -blend if ty < 0.0 else blend
        else:
            slot = 2 if tx < 0.0 else 0
            ux += -blend if tx < 0.0 else blend
    length = math.sqrt(ux * ux + uy * uy)
    ux, uy = ux / length, uy / length
    put_normal(found, -mx, -my, -mz)
    upper_end = rise < 0.0  # the end at +z is the lower one
    fall = radius * (tx * ux + ty * uy)
    other = half * abs(rise) < fall  # the other end is lower than the point opposite
    count = 0
    for k in range(4):
        end = half if upper_end else -half
        qx, qy = -ux, -uy  # towards the point
        gap = lower - fall
        feature = 1.0 * upper_end if k == 0 else 1.0 + k + 5.0 * upper_end
        if k == 1 or k == 2:  # a quarter turn to either side
            qx, qy = (uy, -ux) if k == 1 else (-uy, ux)
            gap = lower + radius * (tx * qx + ty * qy)
        if k == 3 and other:
            end = -end
            gap = lower + 2.0 * half * abs(rise) - fall
            feature = 1.0 - upper_end
        elif k == 3:
            qx, qy = ux, uy
            gap = lower + fall
        if not gap <= margin:
            continue
        if slot >= 0 and not (other and k == 3):
            step = k if k < 2 else 5 - k  # in quarter turns: 0, 1, 3, 2
            feature = FIXED + (slot + step) % 4 + 5.0 * upper_end
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
