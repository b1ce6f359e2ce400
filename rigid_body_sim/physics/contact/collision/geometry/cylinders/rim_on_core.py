# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rim of a cylinder near the side of a capsule or of another cylinder: a segment with a layer.

The distance of a point from a cylinder is convex along the segment (`rim_on_edge`), so its least
value is where its slope changes sign. Where that point is beyond the mantle and beyond an end, a
point of the rim is nearest, and the normal lies in the plane of axis and point: what has no
friction there does not change the spin about the axis. Of two turned prisms two chords meet, along
a normal that is 11 degrees off and brakes what spins, or throws it.

An end that leans over a log by a little touches along a line: rim and side must beat the end, by
EDGE_LEAD of the smaller size, as an edge must beat a face.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim_on_edge import (
    ON_RIM,
    SHALLOW,
    least_way_from_rim,
    way_from_rim,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    NEITHER,
    NORMAL_OWNER,
    OF_NEAREST,
    TINY,
    TURNED,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, scale, subtract

Array = NDArray[np.float64]

DEEP = 0.01  # [-] of the smaller radius: what overlaps by more may part sooner along another axis
AT_AN_END = 1e-9  # [-] of the length: nearer to its end a cylinder is met there, not at its side


@kernel
def rim_on_core(
    parameters: Array, shape: int, other: int, is_capsule: bool, poses: Array, place: int,
    of_other: int, beyond: float, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the point between the rim of a cylinder and the side of another shape, a capsule or not,
    or return UNDECIDED; normal from the cylinder, else see `manifold`.

        beyond : separation of the cylinder from the ends of the other shape, along its axis [m]
    """
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    layer, length = parameters[other + RADIUS], parameters[other + HALF_LENGTH]
    middle = pose.to_shape(poses, place, subtract(load(poses, of_other), load(poses, place)))
    axis = pose.to_shape(poses, place, pose.axis(poses, of_other, 2))
    start, edge = add_scaled(middle, -length, axis), scale(2.0 * length, axis)
    share = least_way_from_rim(start, edge, radius, half)
    is_at_an_end = not AT_AN_END < share < 1.0 - AT_AN_END
    if is_at_an_end and not is_capsule:
        return UNDECIDED
    nearest = add_scaled(start, share, edge)
    beside, above, way = way_from_rim(nearest, radius, half)
    square = dot(way, way)
    if not (beside > SHALLOW * radius and above > SHALLOW * radius and square > TINY):
        return UNDECIDED
    distance = math.sqrt(square)
    gap = distance - layer
    if gap < min(beyond, 0.0) or gap < -DEEP * min(radius, layer):
        return UNDECIDED
    across = 1.0 if is_capsule else math.sqrt(max(1.0 - axis[2] * axis[2], 0.0))
    along_end = abs(middle[2]) - length * abs(axis[2]) - layer * across - half
    if along_end > gap - EDGE_LEAD * min(radius, half, layer):
        return UNDECIDED
    if not gap <= margin:
        return 0
    normal = scale(1.0 / distance, way)
    write_normal(found, pose.to_world(poses, place, normal))
    found[NORMAL_OWNER], found[TURNED] = OF_NEAREST, NEITHER
    point = add_scaled(nearest, 0.5 * gap - distance, normal)
    position = add(load(poses, place), pose.to_world(poses, place, point))
    write_point(found, 0, position, gap, ON_RIM + (1.0 if way[2] > 0.0 else 0.0))
    return 1
