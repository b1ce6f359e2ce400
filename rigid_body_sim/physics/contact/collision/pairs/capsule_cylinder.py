# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule and a cylinder: at its mantle (`geometry.cylinders.mantle`) and at its rim
(`geometry.cylinders.rim_on_core`) exactly, else as a prism (`geometry.cylinders.turned_prism`,
`geometry.polyhedra.cores`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import (
    UNDECIDED,
    onto_mantle,
    round_beyond_ends,
)
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_core import rim_on_core
from rigid_body_sim.physics.contact.collision.geometry.cylinders.turned_prism import (
    POSE_A,
    POSE_B,
    copy_pose,
    turn_towards_normal,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import NORMAL
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.pairs import capsule_capsule
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import load, negate, store

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find where a capsule touches a cylinder."""
    count = capsule_capsule.collide(
        parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    radius, half_length = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    half_of_b = parameters[shape_b + HALF_LENGTH]
    beyond = round_beyond_ends(half_of_b, half_length, radius, True, poses, pose_b, pose_a)
    axis = pose.axis(poses, pose_b, 2)
    count = onto_mantle(found, count, axis, parameters[shape_b + RADIUS], False, beyond)
    if count == UNDECIDED:
        count = rim_on_core(
            parameters, shape_b, shape_a, True, poses, pose_b, pose_a, -math.inf, margin, found
        )
        if count > 0:
            store(found, NORMAL, negate(load(found, NORMAL)))
    if count != UNDECIDED:
        return count
    prism = shape_b + PRISM
    count = collide_core(
        radius, half_length, parameters, prism, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    copy_pose(poses, pose_a, found, POSE_A)
    copy_pose(poses, pose_b, found, POSE_B)
    if not turn_towards_normal(parameters, prism, found, POSE_B):
        return count
    return collide_core(
        radius, half_length, parameters, prism, found, POSE_A, POSE_B, margin, found
    )
