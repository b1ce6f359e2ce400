# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A point of a body, or of the world, as the kernels of forces know it."""

from __future__ import annotations

from dataclasses import dataclass

from rigid_body_sim.physics.model.scene import Vector

WORLD = 'world'


@dataclass(frozen=True)
class Place:
    """
    A point of a moving body, or of the world.

    index  : place of the body among the moving ones, -1 for the world
    turns  : the same among the rigid ones, -1 for a point mass or the world
    offset : (3,) [m] from the centre of mass in principal axes; for the world the point itself
    """

    index: int
    turns: int
    offset: Vector

    def numbers(self) -> tuple[float, ...]:
        """Give the five columns of a table that describe this place."""
        return (float(self.index), float(self.turns), *self.offset)
