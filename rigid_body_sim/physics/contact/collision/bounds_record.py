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
def smaller_radius(a: int, b: int, local_bounds: Array) -> float:
    """Radius of the smaller of two colliders [m]."""
    return min(local_bounds[a * SIZE + RADIUS], local_bounds[b * SIZE + RADIUS])
