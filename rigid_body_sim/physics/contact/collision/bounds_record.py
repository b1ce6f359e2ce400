# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The local bounds of a collider: an AABB along the axes of its shape, with a rounding around it, and
the radius of the bounding ball about the middle of that box.
"""

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline

bounds = Record()
CENTER = bounds.vector('m', 'middle of the box, from the origin of the shape, shape axes')
HALF = bounds.vector('m', 'half edges of the box')
ROUNDING = bounds.number('m', 'thickness of the layer around the box')
RADIUS = bounds.number('m', 'of the bounding ball about the middle; plane: infinite')
SIZE = bounds.size


@inline
def smaller_radius(local_bounds: Array, a: int, b: int) -> float:
    """Radius of the smaller of two colliders that has one [m]."""
    radius_a = local_bounds[a * SIZE + RADIUS]
    radius_b = local_bounds[b * SIZE + RADIUS]
    if radius_a <= 0.0:
        return radius_b
    if radius_b <= 0.0:
        return radius_a
    return min(radius_a, radius_b)
