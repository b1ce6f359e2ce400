# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two balls: s = |x_B - x_A| - r_A - r_B along the line of centres, s the separation.

Where the centres coincide every normal is as good; it is the z axis of A.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS
from rigid_body_sim.physics.vectors import add_scaled, divide, dot, load, subtract

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the point between two balls; two points (radius zero) never meet."""
    radius_a, radius_b = parameters[shape_a + RADIUS], parameters[shape_b + RADIUS]
    reach = radius_a + radius_b
    if not reach > 0.0:
        return 0
    center = load(poses, pose_a)
    offset = subtract(load(poses, pose_b), center)
    squared = dot(offset, offset)
    distance = math.sqrt(squared)
    separation = distance - reach
    if not separation <= margin:
        return 0
    normal = pose.axis(poses, pose_a, 2)
    if squared > TINY:
        normal = divide(offset, distance)
    arm = radius_a + 0.5 * separation
    write_normal(found, normal)
    write_point(found, 0, add_scaled(center, arm, normal), separation, 0.0)
    return 1
