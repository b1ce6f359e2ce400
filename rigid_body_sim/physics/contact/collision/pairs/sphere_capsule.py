# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a capsule: the ball and the nearest ball on the capsule's axis.

    t = clamp((x_A - x_B) . b, -l, l),  s = |x_A - x_B - t b| - r_A - r_B
        b : the axis;  l : its half length;  s : separation
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, divide, dot, load, subtract

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the point between a ball and a capsule."""
    center = load(poses, pose_a)
    offset = subtract(load(poses, pose_b), center)
    axis = pose.axis(poses, pose_b, 2)
    along = clamp(-dot(axis, offset), parameters[shape_b + HALF_LENGTH])
    offset = add_scaled(offset, along, axis)
    squared = dot(offset, offset)
    distance = math.sqrt(squared)
    radius = parameters[shape_a + RADIUS]
    separation = distance - radius - parameters[shape_b + RADIUS]
    if not separation <= margin:
        return 0
    normal = pose.axis(poses, pose_b, 0)
    if squared > TINY:
        normal = divide(offset, distance)
    arm = radius + 0.5 * separation
    write_normal(found, normal)
    write_point(found, 0, add_scaled(center, arm, normal), separation, 0.0)
    return 1
