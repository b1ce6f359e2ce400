# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How far a body reaches from its centre of mass.
"""

from __future__ import annotations

import math

import numpy as np

from rigid_body_sim.physics.model import rotation, shapes
from rigid_body_sim.physics.model.placed_parts import placed_parts
from rigid_body_sim.physics.model.scene import Body


def reach(body: Body | None) -> float:
    """Largest distance of a point of a body from its centre of mass [m], or a little more."""
    if body is None or body.shape is None:
        return 0.0
    return max((_reach_of_part(part) for part in placed_parts(body)), default=0.0)


def _reach_of_part(part: Body) -> float:
    center = np.subtract(part.shape_position, part.center_of_mass)
    away = math.hypot(*center.tolist())
    match part.shape:
        case shapes.Sphere(radius):
            return away + radius
        case shapes.Box(size):
            return away + 0.5 * math.hypot(*size)
        case shapes.Cylinder(radius, length):
            return away + math.hypot(radius, 0.5 * length)
        case shapes.Capsule(radius, length):
            return away + radius + 0.5 * length
        case (
            shapes.ConvexHull(vertices=points)
            | shapes.Mesh(vertices=points)
            | shapes.Surface(vertices=points)
            | shapes.Particles(positions=points)
        ):
            from_shape = rotation.rotate_back(part.shape_orientation, center)
            return max(math.hypot(*point) for point in (points + from_shape).tolist())
        case shapes.Plane():
            return 0.0
        case _:
            return away
