# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule and a cylinder, as a prism (`geometry.polyhedra.hulls`): it bumps at its edges when it
rolls, see `geometry.polyhedra.cores`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find where a capsule touches a cylinder."""
    radius, half_length = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    return collide_core(
        radius, half_length, parameters, shape_b + PRISM, poses, pose_a, pose_b, margin, found
    )
