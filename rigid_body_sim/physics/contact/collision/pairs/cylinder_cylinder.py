# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two cylinders: where their mantles touch exactly (`geometry.cylinders.mantle`), else as prisms
(`geometry.cylinders.turned_prism`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import (
    UNDECIDED,
    onto_mantle,
    round_beyond_ends,
)
from rigid_body_sim.physics.contact.collision.geometry.cylinders.turned_prism import (
    collide_prisms,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.pairs import capsule_capsule
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two cylinders."""
    count = capsule_capsule.collide(
        parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    radius_a, half_a = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    radius_b, half_b = parameters[shape_b + RADIUS], parameters[shape_b + HALF_LENGTH]
    beyond = round_beyond_ends(half_a, half_b, radius_b, False, poses, pose_a, pose_b)
    count = onto_mantle(found, count, pose.axis(poses, pose_a, 2), radius_a, True, beyond)
    if count != UNDECIDED:
        beyond = round_beyond_ends(half_b, half_a, radius_a, False, poses, pose_b, pose_a)
        count = onto_mantle(found, count, pose.axis(poses, pose_b, 2), radius_b, False, beyond)
    if count != UNDECIDED:
        return count
    return collide_prisms(
        parameters, shape_a + PRISM, parameters, shape_b + PRISM, True, True, poses, pose_a,
        pose_b, margin, found,
    )  # fmt: skip
