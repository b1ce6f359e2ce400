# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two convex hulls, see `geometry.polyhedra`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two hulls."""
    return collide_records(
        parameters, shape_a, parameters, shape_b, poses, pose_a, pose_b, margin, found
    )
