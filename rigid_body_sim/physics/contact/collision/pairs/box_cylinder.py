# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box and a cylinder: on a side of the box exactly (`cylinder_on_face`), else both as polyhedra.

Where the rim crosses an edge, or a corner of the box meets the cylinder, the cylinder is a prism
(`hulls`, `polyhedra`).
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.cylinders.on_face import UNDECIDED, on_face
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.box_record import write_box
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find the manifold of a box and a cylinder."""
    count = on_face(numbers, a, b, poses, pa, pb, margin, found)
    if count != UNDECIDED:
        return count
    box = write_box(numbers, a, found)
    return collide_records(found, box, numbers, b + PRISM, poses, pa, pb, margin, found)
