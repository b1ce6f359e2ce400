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
    tx, ty, tz = mx - rise * ax, my - rise * ay, mz - rise * az
    sine = math.sqrt(tx * tx + ty * ty + tz * tz)
    lower = height - half * abs(rise)
    if not lower - radius * sine <= margin:
        return 0
    upper_end = rise < 0.0  # the end at +z is the lower one
    end = half if upper_end else -half
    slot = -1
    if sine < FLAT:
        along_x = tx * poses[pa + 3] + ty * poses[pa + 6] + tz * poses[pa + 9]
        along_y = tx * poses[pa + 4] + ty * poses[pa + 7] + tz * poses[pa + 10]
        slot = 0
        if abs(along_y) > abs(along_x):
            along_x, slot = along_y, 1
        blend = FLAT - sine
        if along_x < 0.0:
            blend = -blend
        axis = pa + 3 + slot
        if along_x < 0.0:
            slot += 2
        tx += blend * poses[axis]
        ty += blend * poses[axis + 3]
        tz += blend * poses[axis + 6]
        sine = math.sqrt(tx * tx + ty * ty + tz * tz)
    ux, uy, uz = tx / sine, ty / sine, tz / sine
    put_normal(found, -mx, -my, -mz)
    cx, cy, cz = end * ax, end * ay, end * az
    fall = radius * (mx * ux + my * uy + mz * uz)
    other = half * abs(rise) < fall  # the other end is lower than the point opposite
    count = 0
    for k in range(4):
        feature = 1.0 * upper_end if k == 0 else 1.0 + k + 5.0 * upper_end
        px, py, pz = ux, uy, uz
        gap = lower - fall
        if k == 1 or k == 2:  # a quarter turn to either side
            turn = 1.0 if k == 1 else -1.0
            px, py, pz = (
                turn * (ay * uz - az * uy),
                turn * (az * ux - ax * uz),
                turn * (ax * uy - ay * ux),
            )
            gap = lower - radius * (mx * px + my * py + mz * pz)
        if k == 3:
            if other:
                cx, cy, cz = -cx, -cy, -cz
                gap = lower + 2.0 * half * abs(rise) - fall
                feature = 1.0 - upper_end
            else:
                px, py, pz = -ux, -uy, -uz
                gap = lower + fall
        if not gap <= margin:
            continue
        if slot >= 0 and not (other and k == 3):
            step = k if k < 2 else 5 - k  # in quarter turns: 0, 1, 3, 2
            feature = FIXED + (slot + step) % 4 + 5.0 * upper_end
        put_point(
            found,
            POINTS + count * POINT,
            x + (cx - radius * px - 0.5 * gap * mx),
            y + (cy - radius * py - 0.5 * gap * my),
            z + (cz - radius * pz - 0.5 * gap * mz),
            gap,
            feature,
        )
        count += 1
    return count
