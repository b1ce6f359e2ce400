# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box and a cylinder: on a side of the box (`geometry.cylinders.on_face`) at its mantle
(`geometry.cylinders.mantle`) and where an edge or a corner is near its rim
(`geometry.cylinders.rim_on_edge`) exactly, else as a prism (`geometry.cylinders.turned_prism`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import (
    UNDECIDED,
    hull_beyond_ends,
    onto_mantle,
)
from rigid_body_sim.physics.contact.collision.geometry.cylinders.on_face import on_face
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_edge import rim_on_edge
from rigid_body_sim.physics.contact.collision.geometry.cylinders.turned_prism import (
    collide_prisms,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import NORMAL
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.box_record import write_box
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import load, negate, store

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of a box and a cylinder."""
    count = on_face(parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found)
    if count != UNDECIDED:
        return count
    box = write_box(parameters, shape_a, found)
    radius, half_length = parameters[shape_b + RADIUS], parameters[shape_b + HALF_LENGTH]
    count = collide_core(radius, half_length, found, box, poses, pose_b, pose_a, margin, found)
    if count == 0:
        return 0
    beyond = hull_beyond_ends(found, box, half_length, poses, pose_b, pose_a)
    count = onto_mantle(found, count, pose.axis(poses, pose_b, 2), radius, True, beyond)
    if count == UNDECIDED:
        count = rim_on_edge(parameters, shape_b, found, box, poses, pose_b, pose_a, margin, found)
    if count != UNDECIDED:
        store(found, NORMAL, negate(load(found, NORMAL)))
        return count
    return collide_prisms(
        found, box, parameters, shape_b + PRISM, False, True, poses, pose_a, pose_b, margin, found
    )
