# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule and a box: the capsule's axis against the box.

In box axes the axis is p + t d, |t| <= l. Apart, the distance to the box is a convex function of t
whose square has a derivative that is linear between the points where the axis crosses the planes
of the sides: its zero is exact. Where the axis enters the box, the separating axis of largest
separation counts: three sides and three edges (cross products with d), an edge only where it wins
by EDGE_LEAD of the smallest half edge + EDGE_SHARE |s|.

Besides the nearest point, the ends of the stretch that lies over the same side or edge are points,
with their own true gaps, so that a capsule can lie on a box.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    SCRATCH,
    SHORTEST,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

ENTERED = 1e-9  # [-] of all sizes: nearer than this the axis counts as in the box
EDGE_LEAD = 1e-3  # [-] of the smallest half edge; 0: a capsule in a side gets one point for two
EDGE_SHARE = 0.05  # [-] of |s|
OVERHANG = 0.1  # [-] of the radius: how far beyond an edge the stretch reaches that lies on it
SAME = 1e-6  # [-] of the radius: gaps nearer than this are equal

MIDDLE, ALONG, HALF, NORMAL = SCRATCH, SCRATCH + 3, SCRATCH + 6, SCRATCH + 9  # p, d, h, n


@inline
def _slope(found: Array, t: float) -> Any:
    """Half the derivative of the squared distance to the box at p + t d."""
    total = 0.0
    for k in range(3):
        x = found[MIDDLE + k] + t * found[ALONG + k]
        total += found[ALONG + k] * (x - clamp(x, found[HALF + k]))
    return total


@inline
def _distance(found: Array, t: float) -> Any:
    """Distance of p + t d from the box."""
    total = 0.0
    for k in range(3):
        x = found[MIDDLE + k] + t * found[ALONG + k]
        x -= clamp(x, found[HALF + k])
        total += x * x
    return math.sqrt(total)


@kernel
def _nearest(found: Array, half: float) -> Any:
    """Return t of the point of the axis that is nearest to the box."""
    low, high = -half, half
    at_low, at_high = _slope(found, low), _slope(found, high)
    if at_low >= 0.0:
        return low
    if at_high <= 0.0:
        return high
    for k in range(3):
        d = found[ALONG + k]
        if d == 0.0:
            continue
        for side in range(2):
            h = found[HALF + k] if side else -found[HALF + k]
            t = (h - found[MIDDLE + k]) / d
            if low < t < high:
                slope = _slope(found, t)
                if slope > 0.0:
                    high, at_high = t, slope
                elif slope < 0.0:
                    low, at_low = t, slope
                else:
                    return t
    return low - at_low / (at_high - at_low) * (high - low)  # a product of lengths might overflow


@kernel
def _entered(found: Array, half: float) -> Any:
    """
    Write the normal out of the box of the axis of largest separation.

    Returns the separation and t of the nearest point of an edge; for a side, t = infinity.
    """
    best, side = -math.inf, 0
    smallest = found[HALF]
    for k in range(3):
        smallest = min(smallest, found[HALF + k])
        s = abs(found[MIDDLE + k]) - found[HALF + k] - half * abs(found[ALONG + k])
        if s > best:
            best, side = s, k
    largest, edge = best + EDGE_LEAD * smallest + EDGE_SHARE * abs(best), -1
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        ni, nj = -found[ALONG + j], found[ALONG + i]
        length = math.sqrt(ni * ni + nj * nj)
        if length < 1e-3:
            continue
        s = abs(found[MIDDLE + i] * ni + found[MIDDLE + j] * nj)
        s = (s - found[HALF + i] * abs(ni) - found[HALF + j] * abs(nj)) / length
        if s > largest:
            largest, edge = s, k
    for k in range(3):
        found[NORMAL + k] = 0.0
    if edge < 0:
        found[NORMAL + side] = -1.0 if found[MIDDLE + side] < 0.0 else 1.0
        return best, math.inf
    i, j = (edge + 1) % 3, (edge + 2) % 3
    ni, nj = -found[ALONG + j], found[ALONG + i]
    squared = ni * ni + nj * nj
    length = math.sqrt(squared)
    if found[MIDDLE + i] * ni + found[MIDDLE + j] * nj < 0.0:
        length = -length
    found[NORMAL + i] = ni / length
    found[NORMAL + j] = nj / length
    # along the edge the two are as near as they look when seen along it
    ei = found[HALF + i] if ni / length > 0.0 else -found[HALF + i]
    ej = found[HALF + j] if nj / length > 0.0 else -found[HALF + j]
    t = found[ALONG + i] * (ei - found[MIDDLE + i]) + found[ALONG + j] * (ej - found[MIDDLE + j])
    return largest, clamp(t / squared, half)


@kernel
def _put(
    poses: Array,
    pb: int,
    found: Array,
    count: int,
    t: float,
    gap: float,
    radius: float,
    margin: float,
    feature: float,
) -> int:
    """Append the point between the axis at t and the box; return the new count."""
    if not gap <= margin:
        return count
    arm = radius + 0.5 * gap
    x = found[MIDDLE] + t * found[ALONG] - arm * found[NORMAL]
    y = found[MIDDLE + 1] + t * found[ALONG + 1] - arm * found[NORMAL + 1]
    z = found[MIDDLE + 2] + t * found[ALONG + 2] - arm * found[NORMAL + 2]
    put_point(
        found,
        POINTS + count * POINT,
        poses[pb] + (poses[pb + 3] * x + poses[pb + 4] * y + poses[pb + 5] * z),
        poses[pb + 1] + (poses[pb + 6] * x + poses[pb + 7] * y + poses[pb + 8] * z),
        poses[pb + 2] + (poses[pb + 9] * x + poses[pb + 10] * y + poses[pb + 11] * z),
        gap,
        feature,
    )
    return count + 1


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find up to three points between capsule and box; feature: 0 nearest, 1 and 2 the ends."""
    wx = poses[pa] - poses[pb]
    wy = poses[pa + 1] - poses[pb + 1]
    wz = poses[pa + 2] - poses[pb + 2]
    ax, ay, az = poses[pa + 5], poses[pa + 8], poses[pa + 11]
    radius, half = numbers[a], numbers[a + 1]
    size = half
    for k in range(3):
        x, y, z = poses[pb + 3 + k], poses[pb + 6 + k], poses[pb + 9 + k]
        found[MIDDLE + k] = wx * x + wy * y + wz * z
        found[ALONG + k] = ax * x + ay * y + az * z
        found[HALF + k] = numbers[b + k]
        size += numbers[b + k]
    t = _nearest(found, half)
    distance = _distance(found, t)
    if not distance - radius <= margin:
        return 0
    apart, at_edge = distance > max(ENTERED * size, SHORTEST), math.inf
    if apart:
        for k in range(3):
            x = found[MIDDLE + k] + t * found[ALONG + k]
            found[NORMAL + k] = (x - clamp(x, found[HALF + k])) / distance
    else:
        distance, at_edge = _entered(found, half)
        if at_edge < math.inf:
            t = at_edge
    main = 0
    for k in range(1, 3):
        if abs(found[NORMAL + k]) > abs(found[NORMAL + main]):
            main = k
    low, high = -half, half
    beyond = OVERHANG * radius + (distance if apart else 0.0)
    for k in range(3):
        d = found[ALONG + k]
        if k == main or d == 0.0:
            continue
        limit = found[HALF + k] + abs(found[NORMAL + k]) * beyond
        one, two = (-limit - found[MIDDLE + k]) / d, (limit - found[MIDDLE + k]) / d
        low = max(low, min(one, two))
        high = min(high, max(one, two))
    nx, ny, nz = found[NORMAL], found[NORMAL + 1], found[NORMAL + 2]
    put_normal(
        found,
        -(poses[pb + 3] * nx + poses[pb + 4] * ny + poses[pb + 5] * nz),
        -(poses[pb + 6] * nx + poses[pb + 7] * ny + poses[pb + 8] * nz),
        -(poses[pb + 9] * nx + poses[pb + 10] * ny + poses[pb + 11] * nz),
    )
    gap = distance - radius
    if at_edge < math.inf or not high - low > SAME * size:
        return _put(poses, pb, found, 0, t, gap, radius, margin, 0.0)
    if apart:
        gap_low, gap_high = _distance(found, low) - radius, _distance(found, high) - radius
    else:
        out = found[NORMAL + main]
        level = out * found[MIDDLE + main] - found[HALF + main] - radius
        gap_low = level + low * out * found[ALONG + main]
        gap_high = level + high * out * found[ALONG + main]
    count = 0
    if apart and gap < min(gap_low, gap_high) - SAME * radius:
        count = _put(poses, pb, found, count, t, gap, radius, margin, 0.0)
    count = _put(poses, pb, found, count, low, gap_low, radius, margin, 1.0)
    return _put(poses, pb, found, count, high, gap_high, radius, margin, 2.0)
