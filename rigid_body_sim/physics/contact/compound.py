# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies of several solids: each part of a union is a collider of its own, all of one body.

Parts of a body never meet each other. Point masses in a union have no surface and meet nobody, and
neither do unions without any solid. A mesh that is not convex can be a union of hulls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rigid_body_sim.physics import rotation as so3
from rigid_body_sim.physics.model import Body
from rigid_body_sim.physics.shapes import Particle, Union


def solids(body: Body) -> Iterator[Body]:
    """Give each solid of a body, as the same body with this shape alone."""
    if not isinstance(body.shape, Union):
        yield body
        return
    for part in body.shape.parts:
        if isinstance(part.shape, Particle):
            continue
        position = body.shape_position + so3.rotate(body.shape_orientation, part.position)
        orientation = so3.multiply(body.shape_orientation, part.orientation)
        x, y, z = position.tolist()
        a, b, c, d = orientation.tolist()
        yield from solids(
            replace(
                body, shape=part.shape, shape_position=(x, y, z), shape_orientation=(a, b, c, d)
            )
        )
