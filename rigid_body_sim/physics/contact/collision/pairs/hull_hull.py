# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two convex hulls: over the middle of a face as on a plane (`geometry.polyhedra.over_face`), else as
two polyhedra (`geometry.polyhedra`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_OF_A,
    FACE_OF_B,
    NEITHER,
    NORMAL,
    NORMAL_OWNER,
    TURNED,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    RADIUS,
    Hull,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.over_face import (
    NO_FACE,
    face_below,
    plane_of,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)
from rigid_body_sim.physics.contact.collision.pairs import hull_plane
from rigid_body_sim.physics.vectors import add, load, negate, store

Array = NDArray[np.float64]


@kernel
def over_face(
    parameters: Array, shape: int, poses: Array, place: int, numbers: Array, other: int,
    place_of_other: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the manifold of a hull over the middle of a face of another polyhedron, whose record
    begins at `other` of `numbers`; return UNDECIDED where it is not. The normal is towards that,
    which counts as B.
    """
    hull = Hull(numbers, other)
    center = pose.to_world(poses, place, load(parameters, shape + CENTER))
    center = add(load(poses, place), center)
    face = face_below(hull, poses, place_of_other, center, parameters[shape + RADIUS])
    if face == NO_FACE:
        return UNDECIDED
    out, offset = plane_of(hull, face, poses, place_of_other)
    found[NORMAL_OWNER], found[TURNED] = FACE_OF_B, NEITHER
    return hull_plane.on_plane(parameters, shape, poses, place, out, offset, margin, found)


@inline
def exchange(found: Array) -> None:
    """Let the body over the face be B of the manifold."""
    store(found, NORMAL, negate(load(found, NORMAL)))
    found[NORMAL_OWNER] = FACE_OF_A


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two hulls."""
    count = over_face(
        parameters, shape_a, poses, pose_a, parameters, shape_b, pose_b, margin, found
    )
    if count != UNDECIDED:
        return count
    count = over_face(
        parameters, shape_b, poses, pose_b, parameters, shape_a, pose_a, margin, found
    )
    if count != UNDECIDED:
        exchange(found)
        return count
    return collide_records(
        parameters, shape_a, parameters, shape_b, poses, pose_a, pose_b, margin, found
    )
