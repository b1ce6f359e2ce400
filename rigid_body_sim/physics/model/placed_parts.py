# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where each shape of a body lies in the body: the one place where unions are taken apart.

x_part = x + R(q) x_k,   q_part = q q_k
    x, q     : shape_position (3,) [m] and shape_orientation (4,) [-] of the body, body coordinates
    x_k, q_k : position and orientation of a part in the axes of its union

A union of unions gives the parts of all of them, in their order.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.model.shapes import Mesh, Union


def placed_parts(body: Body) -> Iterator[Body]:
    """Give each part of a body, as the same body with this shape alone; one that is no union."""
    if isinstance(body.shape, Mesh) and body.shape.parts:
        for hull in body.shape.parts:
            yield replace(body, shape=hull)
        return
    if not isinstance(body.shape, Union):
        yield body
        return
    for part in body.shape.parts:
        position = body.shape_position + so3.rotate(body.shape_orientation, part.position)
        orientation = so3.multiply(body.shape_orientation, part.orientation)
        x, y, z = position.tolist()
        a, b, c, d = orientation.tolist()
        yield from placed_parts(
            replace(
                body, shape=part.shape, shape_position=(x, y, z), shape_orientation=(a, b, c, d)
            )
        )
