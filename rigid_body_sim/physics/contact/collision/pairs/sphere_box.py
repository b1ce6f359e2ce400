# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a box: the ball's centre and the nearest point of the box.

Centre p outside, in box axes: q_k = clamp(p_k, -h_k, h_k), separation |p - q| - r. Inside: through
the nearest side, separation max_k(|p_k| - h_k) - r.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, divide, dot, load, subtract

Array = NDArray[np.float64]


@inline
def _to_nearest(local: Any, half: Any) -> Any:
    """Return q - p: the way to the nearest point of the box, box axes."""
    return (
        clamp(local[0], half[0]) - local[0],
        clamp(local[1], half[1]) - local[1],
        clamp(local[2], half[2]) - local[2],
    )


@inline
def _through_side(local: Any, half: Any) -> Any:
    """Return the distance of the nearest side, at most zero, and the direction into the box."""
    distance = abs(local[0]) - half[0]
    inward = 1.0 if local[0] < 0.0 else -1.0, 0.0, 0.0
    if abs(local[1]) - half[1] > distance:
        distance = abs(local[1]) - half[1]
        inward = 0.0, 1.0 if local[1] < 0.0 else -1.0, 0.0
    if abs(local[2]) - half[2] > distance:
        distance = abs(local[2]) - half[2]
        inward = 0.0, 0.0, 1.0 if local[2] < 0.0 else -1.0
    return distance, inward


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the point between a ball and a box."""
    center = load(poses, pose_a)
    local = pose.to_shape(poses, pose_b, subtract(center, load(poses, pose_b)))
    half = load(parameters, shape_b + HALF_EDGES)
    toward = _to_nearest(local, half)
    squared = dot(toward, toward)
    if squared > TINY:
        distance = math.sqrt(squared)
        toward = divide(toward, distance)
    else:
        distance, toward = _through_side(local, half)
    radius = parameters[shape_a + RADIUS]
    separation = distance - radius
    if not separation <= margin:
        return 0
    normal = pose.to_world(poses, pose_b, toward)
    arm = radius + 0.5 * separation
    write_normal(found, normal)
    write_point(found, 0, add_scaled(center, arm, normal), separation, 0.0)
    return 1
