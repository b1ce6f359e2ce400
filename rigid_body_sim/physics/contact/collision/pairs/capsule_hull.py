# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A capsule and a convex hull, see `cores`."""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find where a capsule touches a convex hull."""
    return collide_core(numbers[a], numbers[a + 1], numbers, b, poses, pa, pb, margin, found)
