# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two cylinders, each as a prism (`hulls`): one that rolls on the other bumps at its edges."""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find the manifold of two prisms."""
    return collide_records(numbers, a + PRISM, numbers, b + PRISM, poses, pa, pb, margin, found)
