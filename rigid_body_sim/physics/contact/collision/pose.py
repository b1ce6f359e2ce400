# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pose of a collider: a place and a rotation matrix R, row by row.

    poses       : origin of the shape in the world, and R from shape axes to world axes
    local_poses : how a pose follows from the body: its centre of mass c (of one on a pivot, the
                  pivot) seen from the origin of the shape, shape axes, and the rotation M from
                  shape axes to principal axes: R = R(q) M,  x = r - R c
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.vectors import dot, load, load_strided

Array = NDArray[np.float64]

pose = Record()
POSITION = pose.vector('m', 'origin of the shape; in a local pose, the centre of mass')
ROW_X = pose.vector('-', 'first row of R: what the shape axes have of the outer x axis')
ROW_Y = pose.vector('-', 'second row of R')
ROW_Z = pose.vector('-', 'third row of R')
SIZE = pose.size


@inline
def axis(poses: Array, place: int, index: int) -> Any:
    """Return an axis of the shape, 0 to 2, in world axes: a column of R."""
    return load_strided(poses, place + ROW_X + index, ROW_Y - ROW_X)


@inline
def to_world(poses: Array, place: int, v: Any) -> Any:
    """Return R v: a direction in shape axes, turned into world axes."""
    return (
        dot(load(poses, place + ROW_X), v),
        dot(load(poses, place + ROW_Y), v),
        dot(load(poses, place + ROW_Z), v),
    )


@inline
def to_shape(poses: Array, place: int, v: Any) -> Any:
    """Return R^T v: a direction in world axes, turned into shape axes."""
    return (
        dot(axis(poses, place, 0), v),
        dot(axis(poses, place, 1), v),
        dot(axis(poses, place, 2), v),
    )
