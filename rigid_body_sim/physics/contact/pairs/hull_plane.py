# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A convex hull on a plane: gap = m . x - offset for each vertex, m the normal out of the plane.

The manifold is chosen as in `manifold.keep_four`, but from the vertices where they stand, in three
passes: a mesh may have thousands below the margin.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.contact.hull_records import CENTER, COUNT, RADIUS, VERTICES
from rigid_body_sim.physics.contact.manifold import (
    LEAD,
    POINT,
    POINTS,
    SAME,
    TIE,
    put_normal,
    put_point,
)
from rigid_body_sim.physics.kernels import kernel


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find up to four vertices of a hull above a plane, or in it."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    xx, xy, xz = poses[pa + 3], poses[pa + 4], poses[pa + 5]
    yx, yy, yz = poses[pa + 6], poses[pa + 7], poses[pa + 8]
    zx, zy, zz = poses[pa + 9], poses[pa + 10], poses[pa + 11]
    ux, uy, uz = (
        mx * xx + my * yx + mz * zx,
        mx * xy + my * yy + mz * zy,
        mx * xz + my * yz + mz * zz,
    )
    cx, cy, cz = numbers[a + CENTER], numbers[a + CENTER + 1], numbers[a + CENTER + 2]
    height = mx * poses[pa] + my * poses[pa + 1] + mz * poses[pa + 2] - numbers[b + 3]
    height += ux * cx + uy * cy + uz * cz
    radius = numbers[a + RADIUS]
    if not height - radius <= margin:
        return 0
    first, last = a + VERTICES, a + VERTICES + 3 * int(numbers[a + COUNT])
    tie = TIE * radius
    least, deepest = math.inf, -1
    for k in range(first, last, 3):
        gap = height + (ux * numbers[k] + uy * numbers[k + 1] + uz * numbers[k + 2])
        if gap <= margin and gap < least - tie:
            least, deepest = gap, k
    if deepest < 0:
        return 0
    ax, ay, az = numbers[deepest], numbers[deepest + 1], numbers[deepest + 2]
    reach, farthest = SAME * radius * (SAME * radius), -1
    for k in range(first, last, 3):
        x, y, z = numbers[k], numbers[k + 1], numbers[k + 2]
        if height + (ux * x + uy * y + uz * z) <= margin:
            x, y, z = x - ax, y - ay, z - az
            distance = x * x + y * y + z * z
            if distance > reach * (1.0 + LEAD):
                reach, farthest = distance, k
    left = right = -1
    if farthest >= 0:
        x, y, z = numbers[farthest] - ax, numbers[farthest + 1] - ay, numbers[farthest + 2] - az
        tx, ty, tz = uy * z - uz * y, uz * x - ux * z, ux * y - uy * x
        most, fewest = SAME * reach, -SAME * reach
        for k in range(first, last, 3):
            x, y, z = numbers[k], numbers[k + 1], numbers[k + 2]
            if height + (ux * x + uy * y + uz * z) <= margin:
                area = tx * (x - ax) + ty * (y - ay) + tz * (z - az)
                if area > most * (1.0 + LEAD):
                    most, left = area, k
                if area < fewest * (1.0 + LEAD):
                    fewest, right = area, k
    put_normal(found, -mx, -my, -mz)
    count = 0
    for choice in range(4):
        k = deepest if choice == 0 else farthest if choice == 1 else left if choice == 2 else right
        if k < 0:
            continue
        x, y, z = numbers[k], numbers[k + 1], numbers[k + 2]
        gap = height + (ux * x + uy * y + uz * z)
        x, y, z = x + cx, y + cy, z + cz
        put_point(
            found,
            POINTS + POINT * count,
            poses[pa] + (xx * x + xy * y + xz * z) - 0.5 * gap * mx,
            poses[pa + 1] + (yx * x + yy * y + yz * z) - 0.5 * gap * my,
            poses[pa + 2] + (zx * x + zy * y + zz * z) - 0.5 * gap * mz,
            gap,
            float(k - first),
        )
        count += 1
    return count
