# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A ball and a convex hull, see `geometry.polyhedra.cores`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find where a ball touches a convex hull."""
    return collide_core(
        parameters[shape_a + RADIUS],
        0.0,
        parameters,
        shape_b,
        poses,
        pose_a,
        pose_b,
        margin,
        found,
    )
