# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a controller answers: a force and a torque on a body, and the axes in which they stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rigid_body_sim.physics.model.scene import Vector

NO_VECTOR: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Wrench:
    """
    Force at the origin of a frame and torque, along the axes of the frame.

    force, torque : (3,) [N], [N m]; of an impulse [N s], [N m s]
    frame : 'world', 'body': axes that turn with the body; both at its centre of mass; or the name
            of a frame that the scene fixes to the body, a thruster: its origin and its axes

    It is judged where it is used: three finite numbers each, a frame that the body has.
    """

    force: Sequence[float] = NO_VECTOR
    torque: Sequence[float] = NO_VECTOR
    frame: str = 'world'

    def __eq__(self, other: object) -> bool:
        """Compare the numbers, whether they stand in tuples, lists or arrays."""
        if not isinstance(other, Wrench):
            return NotImplemented
        return self.frame == other.frame and all(
            np.array_equal(a, b)
            for a, b in ((self.force, other.force), (self.torque, other.torque))
        )

    def __hash__(self) -> int:
        return hash((*self.force, *self.torque, self.frame))
