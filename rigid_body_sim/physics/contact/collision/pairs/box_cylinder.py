# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box and a cylinder: on a side of the box exactly (`geometry.cylinders.on_face`), else both
as polyhedra.

Where the rim crosses an edge, or a corner of the box meets the cylinder, the cylinder is a prism
(`geometry.polyhedra.hulls`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.cylinders.on_face import UNDECIDED, on_face
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.box_record import write_box
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)

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
    return collide_records(
        found, box, parameters, shape_b + PRISM, poses, pose_a, pose_b, margin, found
    )
