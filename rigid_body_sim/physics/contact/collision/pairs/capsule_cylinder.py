# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule and a cylinder, as a prism (`hulls`): it bumps at its edges when it rolls, see `cores`.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.cores import collide_core
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM


@kernel
def collide(numbers, a: int, b: int, poses, pa: int, pb: int, margin: float, found) -> int:
    """Find where a capsule touches a cylinder."""
    return collide_core(
        numbers[a], numbers[a + 1], numbers, b + PRISM, poses, pa, pb, margin, found
    )
