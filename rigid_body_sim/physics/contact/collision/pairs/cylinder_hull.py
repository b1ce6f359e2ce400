# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cylinder, as a prism (`hulls`), and a convex hull: it bumps at its edges when it rolls."""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find the manifold of a prism and a hull."""
    return collide_records(numbers, a + PRISM, numbers, b, poses, pa, pb, margin, found)
