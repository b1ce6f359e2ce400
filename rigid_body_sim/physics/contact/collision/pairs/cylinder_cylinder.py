# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two cylinders: one over an end of the other as on a plane (`geometry.cylinders.over_end`), where
their mantles touch (`geometry.cylinders.mantle`) and the rim of one meets mantle or rim of the
other (`geometry.cylinders.rim_on_core`, `rim_on_rim`) exactly, else as prisms
(`geometry.cylinders.turned_prism`). The face of an end on an end is round all the same: the
smaller disc, where it lies on the other, else that of the prisms, widened to their discs.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import (
    UNDECIDED,
    onto_mantle,
    round_beyond_ends,
)
from rigid_body_sim.physics.contact.collision.geometry.cylinders.over_end import end_below
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_core import rim_on_core
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_rim import rim_on_rim
from rigid_body_sim.physics.contact.collision.geometry.cylinders.turned_prism import (
    collide_prisms,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    FACE_RADIUS,
    FACE_SQUARE,
    NORMAL,
    NORMAL_OWNER,
    OF_NEAREST,
    RIM,
    SHAPE_B,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.touching_face import write_disc
from rigid_body_sim.physics.contact.collision.pairs import capsule_capsule, cylinder_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, negate, store, subtract

Array = NDArray[np.float64]

ON_ENDS = 0.999  # [-] cosine of the angle between normal and axis: an end touches
WITHIN = 1e-3  # [-] of the smaller radius, by which it may hang over
WIDER = 1.0130015562559769  # [-] of a prism of 16 sides with the area of the disc about it


@inline
def _round_off(
    radius_a: float, radius_b: float, poses: Array, pose_a: int, pose_b: int, found: Array
) -> None:
    """Measure the face of an end on an end as that of discs, not of prisms."""
    normal = load(found, NORMAL)
    along_a = abs(dot(normal, pose.axis(poses, pose_a, 2)))
    if not min(along_a, abs(dot(normal, pose.axis(poses, pose_b, 2)))) > ON_ENDS:
        return
    center = load(poses, pose_a if radius_a < radius_b else pose_b)
    apart = subtract(load(poses, pose_b), load(poses, pose_a))
    apart = add_scaled(apart, -dot(apart, normal), normal)
    least = min(radius_a, radius_b)
    if math.sqrt(dot(apart, apart)) <= abs(radius_a - radius_b) + WITHIN * least:
        middle = load(found, FACE_MIDDLE)
        way = subtract(center, middle)
        way = add_scaled(way, -dot(way, normal), normal)
        write_disc(found, least, add(middle, way))
        return
    found[FACE_AREA] *= WIDER * WIDER
    found[FACE_RADIUS] *= WIDER
    found[FACE_SQUARE] *= WIDER * WIDER


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of two cylinders."""
    is_over, out, offset = end_below(parameters, shape_a, shape_b, poses, pose_a, pose_b)
    if is_over:
        return cylinder_plane.on_plane(
            parameters, shape_a, poses, pose_a, out, offset, margin, found
        )
    is_over, out, offset = end_below(parameters, shape_b, shape_a, poses, pose_b, pose_a)
    if is_over:
        count = cylinder_plane.on_plane(
            parameters, shape_b, poses, pose_b, out, offset, margin, found
        )
        store(found, NORMAL, negate(load(found, NORMAL)))
        found[RIM] = SHAPE_B
        return count
    count = capsule_capsule.collide(
        parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    radius_a, half_a = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    radius_b, half_b = parameters[shape_b + RADIUS], parameters[shape_b + HALF_LENGTH]
    from_a = round_beyond_ends(half_a, half_b, radius_b, False, poses, pose_a, pose_b)
    from_b = round_beyond_ends(half_b, half_a, radius_a, False, poses, pose_b, pose_a)
    count = onto_mantle(found, count, pose.axis(poses, pose_a, 2), radius_a, True, from_a)
    if count != UNDECIDED:
        count = onto_mantle(found, count, pose.axis(poses, pose_b, 2), radius_b, False, from_b)
    if count == UNDECIDED:
        count = rim_on_core(
            parameters, shape_a, shape_b, False, poses, pose_a, pose_b, from_b, margin, found
        )
    if count == UNDECIDED:
        count = rim_on_core(
            parameters, shape_b, shape_a, False, poses, pose_b, pose_a, from_a, margin, found
        )
        if count > 0:
            store(found, NORMAL, negate(load(found, NORMAL)))
    if count != UNDECIDED:
        return count
    count = collide_prisms(
        parameters, shape_a + PRISM, parameters, shape_b + PRISM, True, True, poses, pose_a,
        pose_b, margin, found,
    )  # fmt: skip
    if count > 0 and found[NORMAL_OWNER] == OF_NEAREST:
        on_rims = rim_on_rim(
            parameters, shape_a, shape_b, poses, pose_a, pose_b, count, margin, found
        )
        return count if on_rims == UNDECIDED else on_rims
    if count > 0 and found[FACE_AREA] > 0.0:
        _round_off(radius_a, radius_b, poses, pose_a, pose_b, found)
    return count
