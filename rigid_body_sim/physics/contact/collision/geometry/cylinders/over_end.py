# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder over an end of another one: there that is a half space, as the middle of a face of a
polyhedron is (`polyhedra.over_face`), and the cylinder stands, rolls and spins as on a plane.

It is where the middle of the cylinder is outside, and both of its ends, seen along the axis of the
other, lie within the disc.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, dot, load, scale, subtract

Array = NDArray[np.float64]


@inline
def end_below(
    parameters: Array, shape: int, other: int, poses: Array, place: int, of_other: int
) -> Any:
    """
    Tell whether a cylinder is over an end of another one; return also the plane of that end, unit
    normal and offset, in world axes.

        shape, other    : where their parameters begin
        place, of_other : where their poses begin
    """
    out, center = pose.axis(poses, of_other, 2), load(poses, of_other)
    way = subtract(load(poses, place), center)
    if dot(out, way) < 0.0:
        out = scale(-1.0, out)
    height, half = dot(out, way), parameters[other + HALF_LENGTH]
    along = scale(parameters[shape + HALF_LENGTH], pose.axis(poses, place, 2))
    across = add_scaled(along, -dot(out, along), out)
    way = add_scaled(way, -height, out)
    # of the two ends that which is farther from the axis
    reach = dot(way, way) + 2.0 * abs(dot(way, across)) + dot(across, across)
    room = parameters[other + RADIUS] - parameters[shape + RADIUS]
    is_over = height > half and room > 0.0 and math.sqrt(reach) <= room
    return is_over, out, dot(out, center) + half
