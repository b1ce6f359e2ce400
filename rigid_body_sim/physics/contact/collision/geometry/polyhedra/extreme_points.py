# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifold reduction of a patch: up to four points that stay the same from tick to tick while the
bodies rest.

The farthest points along four directions u, n x u, -u, n x (-u) that are fixed in one of the
bodies; and the deepest point, if it is deeper than these by more than a tremble. A choice that
begins with the deepest point (`manifold_reduction.keep_four`) does well for the few corners of
boxes; among the many corners of a round face it picks other ones with every tremble, and the
solver loses the impulses it remembers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FEATURE,
    LEAD,
    MOST,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    copy_point,
)
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]

DEEPER = 1e-4  # [-] of the extent: so much deeper a point must be to take the place of another


@kernel
def keep_extremes(found: Array, first: int, count: int, direction: Any) -> int:
    """
    Choose up to four of the points of a patch.

    first     : where the points begin in `found`, not before the fourth point of the manifold
    count     : how many there are; no two with the same feature
    direction : u, fixed in a body, of any length
    Returns how many are kept; they are written from POINTS on.
    """
    if count <= MOST:
        for index in range(count):
            copy_point(found, POINTS + index * POINT, first + index * POINT)
        return count
    begin, second, end = load(found, first), first + POINT, first + POINT * count
    extent = 0.0
    deepest = first
    for place in range(second, end, POINT):
        arm = subtract(load(found, place), begin)
        extent = max(extent, abs(arm[0]), abs(arm[1]), abs(arm[2]))
        if found[place + SEPARATION] < found[deepest + SEPARATION]:
            deepest = place
    lead = LEAD * extent * (abs(direction[0]) + abs(direction[1]) + abs(direction[2]))
    normal = load(found, NORMAL)
    kept = 0
    for _ in range(MOST):
        best = first
        top = dot(direction, begin)
        for place in range(second, end, POINT):
            height = dot(direction, load(found, place))
            if height > top + lead:
                best, top = place, height
        fresh = True
        for index in range(kept):
            fresh = fresh and found[POINTS + index * POINT + FEATURE] != found[best + FEATURE]
        if fresh:
            copy_point(found, POINTS + kept * POINT, best)
            kept += 1
        direction = cross(normal, direction)
    least = found[POINTS + SEPARATION]
    for index in range(1, kept):
        least = min(least, found[POINTS + index * POINT + SEPARATION])
    if found[deepest + SEPARATION] < least - DEEPER * extent:
        nearest, reach = POINTS, -1.0
        origin = load(found, deepest)
        for index in range(kept):
            arm = subtract(load(found, POINTS + index * POINT), origin)
            distance = dot(arm, arm)
            if reach < 0.0 or distance < reach:
                nearest, reach = POINTS + index * POINT, distance
        copy_point(found, nearest, deepest)
    return kept
