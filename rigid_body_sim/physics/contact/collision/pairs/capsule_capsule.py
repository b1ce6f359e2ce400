# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two capsules: the nearest points of their axes, and the ends of the stretch side by side.

Axes a, b, half lengths l_A, l_B, w = x_B - x_A, c = a . b: |w + t b - s a| is least at
    s = (w . a - c w . b) / (1 - c^2),  t = c s - w . b
where these lie within the axes, else at an end (Ericson, Real-Time Collision Detection, 5.1.9).
Axes within BESIDE of parallel touch at both ends of the stretch, so that one capsule can rest on
the other; the gaps there are the true ones, the normal is that of the nearest points.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    SHORTEST,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

BESIDE = 0.03  # [-] sin^2 of the angle below which axes lie side by side (10 degrees)
PARALLEL = 1e-8  # [-] sin^2 below which the nearest points are no better than the ends
SAME = 1e-6  # [-] of the half lengths: points nearer than this are one
NO_DIRECTION = 1e-14  # [-] of all sizes: nearer axes cross, and their distance has no direction


@kernel
def _put(
    poses: Array,
    pa: int,
    pb: int,
    found: Array,
    count: int,
    s: float,
    t: float,
    shift: float,
    reach: float,
    margin: float,
    feature: float,
) -> int:
    """Append the point between A(s) and B(t), if it is within the margin; return the new count."""
    wx = poses[pb] - poses[pa]
    wy = poses[pb + 1] - poses[pa + 1]
    wz = poses[pb + 2] - poses[pa + 2]
    ax, ay, az = s * poses[pa + 5], s * poses[pa + 8], s * poses[pa + 11]
    bx, by, bz = wx + t * poses[pb + 5], wy + t * poses[pb + 8], wz + t * poses[pb + 11]
    dx, dy, dz = bx - ax, by - ay, bz - az
    gap = math.sqrt(dx * dx + dy * dy + dz * dz) - reach
    if not gap <= margin:
        return count
    put_point(
        found,
        POINTS + count * POINT,
        poses[pa] + (0.5 * (ax + bx) + shift * found[0]),
        poses[pa + 1] + (0.5 * (ay + by) + shift * found[1]),
        poses[pa + 2] + (0.5 * (az + bz) + shift * found[2]),
        gap,
        feature,
    )
    return count + 1


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find up to three points between two capsules; feature: 0 nearest, 1 and 2 the ends."""
    wx = poses[pb] - poses[pa]
    wy = poses[pb + 1] - poses[pa + 1]
    wz = poses[pb + 2] - poses[pa + 2]
    ax, ay, az = poses[pa + 5], poses[pa + 8], poses[pa + 11]
    bx, by, bz = poses[pb + 5], poses[pb + 8], poses[pb + 11]
    half_a, half_b = numbers[a + 1], numbers[b + 1]
    reach, shift = numbers[a] + numbers[b], 0.5 * (numbers[a] - numbers[b])
    along_a = wx * ax + wy * ay + wz * az
    along_b = wx * bx + wy * by + wz * bz
    c = ax * bx + ay * by + az * bz
    kx, ky, kz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sine = kx * kx + ky * ky + kz * kz
    s = clamp((along_a - c * along_b) / sine, half_a) if sine > 1e-16 else clamp(along_a, half_a)
    t = c * s - along_b
    if abs(t) > half_b:
        t = clamp(t, half_b)
        s = clamp(along_a + c * t, half_a)
    dx, dy, dz = wx + t * bx - s * ax, wy + t * by - s * ay, wz + t * bz - s * az
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if not distance - reach <= margin:
        return 0
    size = reach + half_a + half_b
    if distance > max(NO_DIRECTION * size, SHORTEST):
        put_normal(found, dx / distance, dy / distance, dz / distance)
    elif sine > PARALLEL:
        length = math.sqrt(sine)
        if kx * wx + ky * wy + kz * wz < 0.0:
            length = -length
        put_normal(found, kx / length, ky / length, kz / length)
    else:
        put_normal(found, poses[pa + 3], poses[pa + 6], poses[pa + 9])
    count = 0
    same = SAME * (half_a + half_b)
    beside = abs(c) * half_b
    low, high = clamp(along_a - beside, half_a), clamp(along_a + beside, half_a)
    if sine < BESIDE and high - low > same:
        if sine > PARALLEL and low + same < s < high - same:
            count = _put(poses, pa, pb, found, count, s, t, shift, reach, margin, 0.0)
        t_low, t_high = (-half_b, half_b) if c > 0.0 else (half_b, -half_b)
        if low == -half_a:  # an end of A, else one of B
            t_low = clamp(c * low - along_b, half_b)
        if high == half_a:
            t_high = clamp(c * high - along_b, half_b)
        count = _put(poses, pa, pb, found, count, low, t_low, shift, reach, margin, 1.0)
        count = _put(poses, pa, pb, found, count, high, t_high, shift, reach, margin, 2.0)
    if count == 0:
        count = _put(poses, pa, pb, found, count, s, t, shift, reach, margin, 0.0)
    return count
