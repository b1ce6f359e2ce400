# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies of several solids: each part of a union is a collider of its own, all of one body.

Parts of a body never meet each other. Point masses in a union have no surface and meet nobody, and
neither do unions without any solid. A mesh that is not convex can be a union of hulls.
"""

from __future__ import annotations

from collections.abc import Iterator

from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Particle


def solids(body: Body) -> Iterator[Body]:
    """Give each solid of a body, as the same body with this shape alone."""
    for part in placed_parts(body):
        if part is body or not isinstance(part.shape, Particle):
            yield part
