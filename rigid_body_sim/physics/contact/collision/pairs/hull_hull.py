# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two convex hulls, see `polyhedra`."""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find the manifold of two hulls."""
    return collide_records(numbers, a, numbers, b, poses, pa, pb, margin, found)
