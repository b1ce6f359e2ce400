# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attitudes for controllers and plots: unit quaternions xyzw, body to world, of any leading shape.

    v_W = q v_B q*                       rotate(q, v_B); rotate_back(q, v_W) is the inverse
    multiply(p, q)                       first q, then p
    exp(n a) = (n sin(a/2), cos(a/2))    exp of a rotation vector [rad]; log is its inverse
    log(multiply(p, inverse(q)))         the turn from q to p, world axes: an attitude error
    log(multiply(inverse(q), p))         the same in the axes of the body at q

`(x, y, z, w)` is the order everywhere in this package, as in ROS and in scipy's Rotation. q and -q
are the same attitude. Quaternions that are no longer of length one (sums, interpolations, files)
go through `normalise` first: nothing here scales them, but for `log` and `as_scipy`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.rotation import (
    IDENTITY,
    angle_between,
    conjugate,
    from_rotation_vector,
    matrix_from_quaternion,
    multiply,
    normalise,
    quaternion_from_matrix,
    rotate,
    rotate_back,
)

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

__all__ = [
    'IDENTITY',
    'angle_between',
    'as_scipy',
    'conjugate',
    'exp',
    'from_matrix',
    'from_scipy',
    'inverse',
    'log',
    'matrix',
    'multiply',
    'normalise',
    'rotate',
    'rotate_back',
]

exp = from_rotation_vector
inverse = conjugate
matrix = matrix_from_quaternion
from_matrix = quaternion_from_matrix


def log(q: ArrayLike) -> Array:
    """
    Return the rotation vector of a turn: its axis times its angle, which is 0 to pi.

    log(q) = 2 atan2(|u|, |w|) u / |u| sign(w),  q = (u, w)
        q       : (..., 4) [-]  quaternion xyzw; -q gives the same vector, but for turns by pi
        returns : (..., 3) [rad]

    Through scipy's Rotation, which keeps all digits of small angles. Raises InvalidModel for a
    quaternion of zero length or one that is not finite.
    """
    q = np.asarray(q, dtype=np.float64)
    if q.ndim == 0 or q.shape[-1] != 4:
        raise InvalidModel(f'log: got the shape {q.shape}; quaternions (..., 4) xyzw are needed')
    if q.size == 0:
        return np.zeros((*q.shape[:-1], 3))
    return as_scipy(q.reshape(-1, 4)).as_rotvec().reshape(*q.shape[:-1], 3)


def as_scipy(q: ArrayLike) -> Rotation:
    """Return scipy's Rotation of quaternions (4,) or (n, 4): for Euler angles, means, splines."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(normalise(q))


def from_scipy(rotation: Rotation) -> Array:
    """Return the quaternions (4,) or (n, 4), xyzw, of scipy's Rotation."""
    return rotation.as_quat()
