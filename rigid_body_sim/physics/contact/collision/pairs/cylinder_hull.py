# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder and a convex hull: over the middle of a face as on a plane
(`geometry.polyhedra.over_face`); at its mantle (`geometry.cylinders.mantle`) and where an edge or
a corner is near its rim (`geometry.cylinders.rim_on_edge`) exactly, else as a prism
(`geometry.cylinders.turned_prism`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import (
    UNDECIDED,
    hull_beyond_ends,
    onto_mantle,
)
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_edge import rim_on_edge
from rigid_body_sim.physics.contact.collision.geometry.cylinders.turned_prism import (
    collide_prisms,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import HELD_COUNT
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM, Hull
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.over_face import (
    NO_FACE,
    face_below,
    plane_of,
)
from rigid_body_sim.physics.contact.collision.pairs import cylinder_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of a cylinder and a hull."""
    radius, half_length = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    hull = Hull(parameters, shape_b)
    reach = math.sqrt(radius * radius + half_length * half_length)
    face = face_below(hull, poses, pose_b, load(poses, pose_a), reach)
    if face != NO_FACE:
        out, offset = plane_of(hull, face, poses, pose_b)
        return cylinder_plane.on_plane(
            parameters, shape_a, poses, pose_a, out, offset, margin, found
        )
    found[HELD_COUNT] = 0.0  # a turned prism has other corners in each tick
    count = collide_core(
        radius, half_length, parameters, shape_b, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    beyond = hull_beyond_ends(parameters, shape_b, half_length, poses, pose_a, pose_b)
    count = onto_mantle(found, count, pose.axis(poses, pose_a, 2), radius, True, beyond)
    if count == UNDECIDED:
        count = rim_on_edge(
            parameters, shape_a, parameters, shape_b, poses, pose_a, pose_b, margin, found
        )
    if count != UNDECIDED:
        return count
    return collide_prisms(
        parameters, shape_a + PRISM, parameters, shape_b, True, False, poses, pose_a, pose_b,
        margin, found,
    )  # fmt: skip
