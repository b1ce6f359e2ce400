# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Up to four points of a patch that stay the same from tick to tick while the bodies rest.

The farthest points along four directions u, n x u, -u, n x (-u) that are fixed in one of the
bodies; and the deepest point, if it is deeper than these by more than a tremble. A choice that
begins with the deepest point (`manifold.keep_four`) does well for the few corners of boxes; among
the many corners of a round face it picks other ones with every tremble, and the solver loses the
impulses it remembers.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    LEAD,
    MOST,
    POINT,
    POINTS,
    SEPARATION,
)

DEEPER = 1e-4  # [-] of the extent: so much deeper a point must be to take the place of another


@inline
def _move(found, to: int, source: int) -> None:
    for i in range(POINT):
        found[to + i] = found[source + i]


@kernel
def keep_extremes(found, first: int, count: int, ux: float, uy: float, uz: float) -> int:
    """
    Choose up to four of the points of a patch.

    first      : where the points begin in `found`, not before the fourth point of the manifold
    count      : how many there are; no two with the same feature
    ux, uy, uz : u, fixed in a body, of any length
    Returns how many are kept; they are written from POINTS on.
    """
    if count <= MOST:
        for k in range(count):
            _move(found, POINTS + k * POINT, first + k * POINT)
        return count
    extent = 0.0
    deepest = first
    for k in range(1, count):
        at = first + k * POINT
        extent = max(
            extent,
            abs(found[at] - found[first]),
            abs(found[at + 1] - found[first + 1]),
            abs(found[at + 2] - found[first + 2]),
        )
        if found[at + SEPARATION] < found[deepest + SEPARATION]:
            deepest = at
    lead = LEAD * extent * (abs(ux) + abs(uy) + abs(uz))
    nx, ny, nz = found[0], found[1], found[2]
    kept = 0
    for _ in range(MOST):
        best = first
        top = ux * found[first] + uy * found[first + 1] + uz * found[first + 2]
        for k in range(1, count):
            at = first + k * POINT
            height = ux * found[at] + uy * found[at + 1] + uz * found[at + 2]
            if height > top + lead:
                best, top = at, height
        fresh = True
        for k in range(kept):
            fresh = fresh and found[POINTS + k * POINT + 4] != found[best + 4]
        if fresh:
            _move(found, POINTS + kept * POINT, best)
            kept += 1
        ux, uy, uz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    least = found[POINTS + SEPARATION]
    for k in range(1, kept):
        least = min(least, found[POINTS + k * POINT + SEPARATION])
    if found[deepest + SEPARATION] < least - DEEPER * extent:
        nearest, reach = POINTS, -1.0
        for k in range(kept):
            at = POINTS + k * POINT
            dx, dy = found[at] - found[deepest], found[at + 1] - found[deepest + 1]
            dz = found[at + 2] - found[deepest + 2]
            distance = dx * dx + dy * dy + dz * dz
            if reach < 0.0 or distance < reach:
                nearest, reach = at, distance
        _move(found, nearest, deepest)
    return kept
