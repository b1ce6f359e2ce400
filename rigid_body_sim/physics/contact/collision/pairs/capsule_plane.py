# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule on a plane: the balls at its two ends.

    s = m . (x +- l a) - offset - r
        m : normal out of the plane;  a, l : axis and its half length;  s : separation
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import write_normal, write_point
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_LENGTH,
    NORMAL,
    OFFSET,
    RADIUS,
)
from rigid_body_sim.physics.vectors import add, dot, load, negate, scale, subtract

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the ends of a capsule that are near a plane; feature: 0 the end at -z, 1 that at +z."""
    out, center = load(parameters, shape_b + NORMAL), load(poses, pose_a)
    axis = pose.axis(poses, pose_a, 2)
    radius, half_length = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    middle = dot(out, center) - parameters[shape_b + OFFSET] - radius
    rise = dot(out, axis)
    count = 0
    for end in range(2):
        along = half_length if end else -half_length
        separation = middle + along * rise
        if separation <= margin:
            arm = radius + 0.5 * separation
            position = add(center, subtract(scale(along, axis), scale(arm, out)))
            write_point(found, count, position, separation, float(end))
            count += 1
    write_normal(found, negate(out))
    return count
