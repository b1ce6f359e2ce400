# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two capsules: the nearest points of their axes, and the ends of the stretch side by side.

Axes a, b, half lengths l_A, l_B, w = x_B - x_A, c = a . b: |w + t b - s a| is least at
    s = (w . a - c w . b) / (1 - c^2),  t = c s - w . b
where these lie within the axes, else at an end (Ericson, Real-Time Collision Detection, 5.1.9).
Axes within BESIDE of parallel touch at both ends of the stretch, so that one capsule can rest on
the other; the separations there are the true ones, the normal is that of the nearest points.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_NEAREST_POINT
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    NORMAL,
    SHORTEST,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    divide,
    dot,
    load,
    scale,
    subtract,
)

Array = NDArray[np.float64]

BESIDE = 0.03  # [-] sin^2 of the angle below which axes lie side by side (10 degrees)
ENDS_AS_NEAR = 1e-8  # [-] sin^2 below which the nearest points are no better than the ends
ONE_PLACE = 1e-6  # [-] of the half lengths: points nearer than this are one
NO_DIRECTION = 1e-14  # [-] of all sizes: nearer axes cross, and their distance has no direction

NEAREST, LOW_END, HIGH_END = 0.0, 1.0, 2.0  # features


@inline
def _nearest(along_a: float, along_b: float, cosine: float, sine: float, half_a: float,
             half_b: float) -> Any:  # fmt: skip
    """Return s and t of the nearest points of the axes; sine: squared, see the module."""
    on_a = (along_a - cosine * along_b) / sine if sine > NO_NEAREST_POINT else along_a
    on_a = clamp(on_a, half_a)
    on_b = cosine * on_a - along_b
    if abs(on_b) > half_b:
        on_b = clamp(on_b, half_b)
        on_a = clamp(along_a + cosine * on_b, half_a)
    return on_a, on_b


@kernel
def _append(
    poses: Array, pose_a: int, pose_b: int, found: Array, count: int, on_a: float, on_b: float,
    shift: float, reach: float, margin: float, feature: float,
) -> int:  # fmt: skip
    """
    Append the point between A(s) and B(t), if it is within the margin; return the new count.

        on_a, on_b : s, t
        shift      : [m] from the middle between the axes to that between the surfaces
        reach      : sum of the radii
    """
    center = load(poses, pose_a)
    from_a = scale(on_a, pose.axis(poses, pose_a, 2))
    to_b = add_scaled(subtract(load(poses, pose_b), center), on_b, pose.axis(poses, pose_b, 2))
    between = subtract(to_b, from_a)
    separation = math.sqrt(dot(between, between)) - reach
    if not separation <= margin:
        return count
    middle = scale(0.5, add(from_a, to_b))
    position = add(center, add_scaled(middle, shift, load(found, NORMAL)))
    write_point(found, count, position, separation, feature)
    return count + 1


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find up to three points between two capsules; feature: the nearest, or one of the ends."""
    offset = subtract(load(poses, pose_b), load(poses, pose_a))
    axis_a, axis_b = pose.axis(poses, pose_a, 2), pose.axis(poses, pose_b, 2)
    half_a, half_b = parameters[shape_a + HALF_LENGTH], parameters[shape_b + HALF_LENGTH]
    radius_a, radius_b = parameters[shape_a + RADIUS], parameters[shape_b + RADIUS]
    reach, shift = radius_a + radius_b, 0.5 * (radius_a - radius_b)
    along_a, along_b = dot(offset, axis_a), dot(offset, axis_b)
    cosine = dot(axis_a, axis_b)
    across = cross(axis_a, axis_b)
    sine = dot(across, across)
    on_a, on_b = _nearest(along_a, along_b, cosine, sine, half_a, half_b)
    between = subtract(add_scaled(offset, on_b, axis_b), scale(on_a, axis_a))
    distance = math.sqrt(dot(between, between))
    if not distance - reach <= margin:
        return 0
    normal = pose.axis(poses, pose_a, 0)
    if distance > max(NO_DIRECTION * (reach + half_a + half_b), SHORTEST):
        normal = divide(between, distance)
    elif sine > ENDS_AS_NEAR:
        length = math.sqrt(sine)
        normal = divide(across, -length if dot(across, offset) < 0.0 else length)
    write_normal(found, normal)
    count = 0
    same = ONE_PLACE * (half_a + half_b)
    beside = abs(cosine) * half_b
    low, high = clamp(along_a - beside, half_a), clamp(along_a + beside, half_a)
    if sine < BESIDE and high - low > same:
        if sine > ENDS_AS_NEAR and low + same < on_a < high - same:
            count = _append(
                poses, pose_a, pose_b, found, count, on_a, on_b, shift, reach, margin, NEAREST
            )
        low_b, high_b = (-half_b, half_b) if cosine > 0.0 else (half_b, -half_b)
        if low == -half_a:  # an end of A, else one of B
            low_b = clamp(cosine * low - along_b, half_b)
        if high == half_a:
            high_b = clamp(cosine * high - along_b, half_b)
        count = _append(
            poses, pose_a, pose_b, found, count, low, low_b, shift, reach, margin, LOW_END
        )
        count = _append(
            poses, pose_a, pose_b, found, count, high, high_b, shift, reach, margin, HIGH_END
        )
    if count == 0:
        count = _append(
            poses, pose_a, pose_b, found, count, on_a, on_b, shift, reach, margin, NEAREST
        )
    return count
