# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box, as a polyhedron, and a convex hull: over the middle of a side of the box as on a plane
(`geometry.polyhedra.over_face`), else see `geometry.polyhedra`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.box_record import write_box
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)
from rigid_body_sim.physics.contact.collision.pairs.hull_hull import exchange, over_face

Array = NDArray[np.float64]


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the manifold of a box and a hull."""
    box = write_box(parameters, shape_a, found)
    count = over_face(parameters, shape_b, poses, pose_b, found, box, pose_a, margin, found)
    if count != UNDECIDED:
        exchange(found)
        return count
    return collide_records(found, box, parameters, shape_b, poses, pose_a, pose_b, margin, found)
