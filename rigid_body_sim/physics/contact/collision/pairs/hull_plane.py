# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A convex hull on a plane: gap = m . x - offset for each vertex, m the normal out of the plane.

Of more than four vertices within the margin the manifold holds those that lie farthest along four
directions fixed in the hull, and the deepest, as in `extreme_points`, but from the vertices where
they stand: a mesh may have thousands below the margin.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    LEAD,
    MOST,
    POINT,
    POINTS,
    TIE,
    put_normal,
    put_point,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    COUNT,
    RADIUS,
    VERTICES,
)

CHOSEN = POINTS + MOST * POINT  # where the chosen vertices are listed
SKEW = 0.6  # [-] of one axis to the other: along an axis two corners of a box are as far


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find up to four vertices of a hull above a plane, or in it."""
    mx, my, mz = numbers[b], numbers[b + 1], numbers[b + 2]
    cx, cy, cz = numbers[a + CENTER], numbers[a + CENTER + 1], numbers[a + CENTER + 2]
    ux, uy, uz = 0.0, 0.0, 0.0  # m in the axes of the hull
    height = -numbers[b + 3]
    for i in range(3):
        m = numbers[b + i]
        height += m * poses[pa + i]
        ux += m * poses[pa + 3 + 3 * i]
        uy += m * poses[pa + 4 + 3 * i]
        uz += m * poses[pa + 5 + 3 * i]
    height += ux * cx + uy * cy + uz * cz
    first, last = a + VERTICES, a + VERTICES + 3 * int(numbers[a + COUNT])
    if not height - numbers[a + RADIUS] <= margin:
        return 0
    count = choose(numbers, first, last, height, ux, uy, uz, margin, numbers[a + RADIUS], found)
    put_normal(found, -mx, -my, -mz)
    for c in range(count):
        k = int(found[CHOSEN + c])
        x, y, z = numbers[k], numbers[k + 1], numbers[k + 2]
        gap = height + (ux * x + uy * y + uz * z)
        x, y, z = x + cx, y + cy, z + cz
        put_point(
            found,
            POINTS + POINT * c,
            poses[pa]
            + (poses[pa + 3] * x + poses[pa + 4] * y + poses[pa + 5] * z)
            - 0.5 * gap * mx,
            poses[pa + 1]
            + (poses[pa + 6] * x + poses[pa + 7] * y + poses[pa + 8] * z)
            - 0.5 * gap * my,
            poses[pa + 2]
            + (poses[pa + 9] * x + poses[pa + 10] * y + poses[pa + 11] * z)
            - 0.5 * gap * mz,
            gap,
            float(k - first),
        )
    return count


@kernel
def choose(
    numbers,
    first: int,
    last: int,
    height: float,
    ux: float,
    uy: float,
    uz: float,
    margin: float,
    radius: float,
    found,
) -> int:
    """List up to four vertices whose height + u . x is within the margin; return their number."""
    count, least, deepest = 0, math.inf, 0
    for k in range(first, last, 3):
        gap = height + (ux * numbers[k] + uy * numbers[k + 1] + uz * numbers[k + 2])
        if gap <= margin:
            if count < MOST:
                found[CHOSEN + count] = k
            count += 1
            if gap < least:
                least, deepest = gap, k
    if count <= MOST:
        return count
    # Two axes of the hull across the normal, skewed: the one that leans most is left out.
    x, y, z = abs(ux), abs(uy), abs(uz)
    vx, vy, vz = 1.0, SKEW, 0.0
    if x > y and x > z:
        vx, vz = 0.0, 1.0
    elif y > z:
        vx, vy, vz = SKEW, 0.0, 1.0
    kept = 0
    shallow = math.inf
    for _ in range(MOST):
        best, top = -1, -math.inf
        for k in range(first, last, 3):
            x, y, z = numbers[k], numbers[k + 1], numbers[k + 2]
            if height + (ux * x + uy * y + uz * z) <= margin:
                x = vx * x + vy * y + vz * z
                if x > top + LEAD * radius:
                    best, top = k, x
        fresh = True
        for c in range(kept):
            fresh = fresh and found[CHOSEN + c] != best
        if fresh:
            found[CHOSEN + kept] = best
            kept += 1
            x, y, z = numbers[best], numbers[best + 1], numbers[best + 2]
            shallow = min(shallow, height + (ux * x + uy * y + uz * z))
        vx, vy, vz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    if least < shallow - TIE * radius:
        nearest, reach = 0, math.inf
        for c in range(kept):
            k = int(found[CHOSEN + c])
            x, y = numbers[k] - numbers[deepest], numbers[k + 1] - numbers[deepest + 1]
            z = numbers[k + 2] - numbers[deepest + 2]
            if x * x + y * y + z * z < reach:
                nearest, reach = c, x * x + y * y + z * z
        found[CHOSEN + nearest] = deepest
    return kept
