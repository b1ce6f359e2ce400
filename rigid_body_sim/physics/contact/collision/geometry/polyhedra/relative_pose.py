# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where body B stands as seen from body A.

    x_A = t + Q x_B,   t = R_A^T (c_B - c_A),   Q = R_A^T R_B
        c : centre of a polyhedron, world; differences are taken first, so that a far origin costs
            no more digits than the poses have lost
        R : shape axes to world

Everything between two polyhedra is computed in the axes of A about its centre. t and Q are kept as
OFFSET and ROTATION of `scratch`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import OFFSET, ROTATION
from rigid_body_sim.physics.vectors import add, dot, load, load_strided, store, subtract

Array = NDArray[np.float64]

ROW = 3  # numbers of a row of ROTATION


@kernel
def relate(
    center_a: Any, center_b: Any, poses: Array, pose_a: int, pose_b: int, work: Array
) -> None:
    """Write OFFSET and ROTATION; center_a, center_b [m]: the centres, axes of their shapes."""
    apart = subtract(load(poses, pose_b), load(poses, pose_a))
    apart = add(apart, pose.to_world(poses, pose_b, center_b))
    apart = subtract(apart, pose.to_world(poses, pose_a, center_a))
    for i in range(3):
        axis = pose.axis(poses, pose_a, i)
        work[OFFSET + i] = dot(axis, apart)
        store(work, ROTATION + ROW * i, pose.to_shape(poses, pose_b, axis))


@inline
def axis_of_b(work: Array, index: int) -> Any:
    """Return an axis of B, 0 to 2, in the axes of A."""
    return load_strided(work, ROTATION + index, ROW)


@inline
def to_b(work: Array, v: Any) -> Any:
    """Turn a direction from the axes of A into those of B."""
    return (
        dot(axis_of_b(work, 0), v),
        dot(axis_of_b(work, 1), v),
        dot(axis_of_b(work, 2), v),
    )


@inline
def from_b(work: Array, v: Any) -> Any:
    """Turn a direction from the axes of B into those of A."""
    return (
        dot(load(work, ROTATION), v),
        dot(load(work, ROTATION + ROW), v),
        dot(load(work, ROTATION + 2 * ROW), v),
    )


@inline
def point_of_b(work: Array, point: Any) -> Any:
    """Return a point of B, from its centre in its axes, as seen from A."""
    return add(load(work, OFFSET), from_b(work, point))
