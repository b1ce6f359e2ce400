# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball on a plane: s = m . x_A - offset - r_A, m the normal out of the plane, s the separation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import write_normal, write_point
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, dot, load, negate

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the lowest point of a ball above a plane, or in it."""
    out, center = load(parameters, shape_b + NORMAL), load(poses, pose_a)
    radius = parameters[shape_a + RADIUS]
    separation = dot(out, center) - parameters[shape_b + OFFSET] - radius
    if not separation <= margin:
        return 0
    arm = radius + 0.5 * separation
    write_normal(found, negate(out))
    write_point(found, 0, add_scaled(center, -arm, out), separation, 0.0)
    return 1
