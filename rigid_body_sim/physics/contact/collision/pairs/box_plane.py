# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box on a plane: the corners of the side that faces the plane, as far as they are near it.

    s = m . x - offset for each corner x, m the normal out of the plane, s the separation

The lowest corner is always one of them, and so is every corner it can tip over to. Corners of the
side above are left out even where a plate is thinner than the margin: they would push real ones
out of the manifold.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.aabb import extent
from rigid_body_sim.physics.contact.collision.geometry.manifold import write_normal, write_point
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES, NORMAL, OFFSET
from rigid_body_sim.physics.vectors import add, dot, load, negate, scale, subtract

Array = NDArray[np.float64]

CORNERS = 8  # bit k of the number of a corner: 1 where it lies at + along axis k


@inline
def _steepest(along: Any) -> Any:
    """Return the axis that leans most towards the plane, or away from it."""
    facing = 2
    if abs(along[0]) > abs(along[1]):
        if abs(along[0]) > abs(along[2]):
            facing = 0
    elif abs(along[1]) > abs(along[2]):
        facing = 1
    return facing


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the corners of a box below the margin; feature: number of the corner."""
    out, center = load(parameters, shape_b + NORMAL), load(poses, pose_a)
    height = dot(out, center) - parameters[shape_b + OFFSET]
    along = pose.to_shape(poses, pose_a, out)
    half = load(parameters, shape_a + HALF_EDGES)
    if not height - extent(half, along) <= margin:
        return 0
    facing = _steepest(along)
    side = 0 if along[facing] > 0.0 else 1
    count = 0
    for corner in range(CORNERS):
        if corner >> facing & 1 != side:
            continue
        local = (
            half[0] if corner & 1 else -half[0],
            half[1] if corner & 2 else -half[1],
            half[2] if corner & 4 else -half[2],
        )
        separation = height + dot(along, local)
        if not separation <= margin:
            continue
        raised = scale(0.5 * separation, out)
        position = add(center, subtract(pose.to_world(poses, pose_a, local), raised))
        write_point(found, count, position, separation, float(corner))
        count += 1
    write_normal(found, negate(out))
    return count
