# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attitudes as unit quaternions, for arrays of any leading shape (..., 4).

A quaternion q = (x, y, z, w) maps body to world: v_W = q v_B q*. q and -q are the same attitude.
Source: Shuster, A survey of attitude representations, J. Astronaut. Sci. 41 (1993), in Hamilton's
order of factors. Not the kernels of the integrators: this is the plain form for setting up,
reporting and testing.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.numbers import numbers
from rigid_body_sim.physics.model.plain_products import cross

Array = NDArray[np.float64]

IDENTITY = (0.0, 0.0, 0.0, 1.0)
_INVERSE = np.array((-1.0, -1.0, -1.0, 1.0))
UNIT_ULPS = 4  # [ulp] a length this near to one is kept: dividing would only move the last bits
EPS = float(np.finfo(np.float64).eps)
NEARLY_UNIT = UNIT_ULPS * EPS  # of a squared length: half as wide


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """
    Compose two attitudes: first q, then p.

    p q = (p_w q_v + q_w p_v + p_v x q_v,  p_w q_w - p_v . q_v)
        p, q : (..., 4) [-]  quaternions xyzw
    """
    p = np.asarray(p, dtype=np.float64)
    q = np.asarray(q, dtype=np.float64)
    px, py, pz, pw = p[..., 0], p[..., 1], p[..., 2], p[..., 3]
    qx, qy, qz, qw = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    x = pw * qx + px * qw + py * qz - pz * qy
    out = np.empty((*np.shape(x), 4))
    out[..., 0] = x
    out[..., 1] = pw * qy - px * qz + py * qw + pz * qx
    out[..., 2] = pw * qz + px * qy - py * qx + pz * qw
    out[..., 3] = pw * qw - px * qx - py * qy - pz * qz
    return out


def conjugate(q: ArrayLike) -> Array:
    """Return the inverse attitude of unit quaternions q : (..., 4) [-]: world to body."""
    return np.asarray(q, dtype=np.float64) * _INVERSE


def rotate(q: ArrayLike, v_body: ArrayLike) -> Array:
    """
    Rotate vectors from body to world axes.

    v_W = v + w t + u x t,  t = 2 u x v,  q = (u, w)
        q      : (..., 4) [-]  unit quaternion xyzw, body to world
        v_body : (..., 3)      any vector, body axes
    """
    q = np.asarray(q, dtype=np.float64)
    v_body = np.asarray(v_body, dtype=np.float64)
    u, w = q[..., :3], q[..., 3:]
    t = 2.0 * cross(u, v_body)
    return v_body + w * t + cross(u, t)


def rotate_back(q: ArrayLike, v: ArrayLike) -> Array:
    """Rotate vectors v : (..., 3) from world to body axes: v_B = q* v_W q."""
    return rotate(conjugate(q), v)


def normalise(q: ArrayLike) -> Array:
    """
    Return q / |q|; a quaternion whose length is one within UNIT_ULPS is returned bit for bit.

        q : (..., 4) [-]  finite, of any length but zero
    """
    q = np.asarray(q, dtype=np.float64)
    largest = np.max(np.abs(q), axis=-1, keepdims=True)  # scaling first: no square overflows
    if not np.all(np.isfinite(largest)):
        raise InvalidModel('a quaternion needs four finite components')
    if not np.all(largest > 0.0):
        raise InvalidModel(
            'a quaternion of zero length is no attitude; the identity is [0, 0, 0, 1]'
        )
    scaled = q / largest
    scaled_length = np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    with np.errstate(over='ignore'):
        length = largest * scaled_length
    is_unit = np.abs(length - 1.0) <= UNIT_ULPS * EPS
    return np.where(is_unit, q, scaled / scaled_length)


def normalised(values: Any) -> tuple[float, float, float, float]:
    """Return `normalise` of one quaternion, four finite numbers, bit for bit, as numbers."""
    x, y, z, w = values
    largest = max(abs(x), abs(y), abs(z), abs(w))
    if not 0.0 < largest < math.inf:
        x, y, z, w = normalise(values).tolist()  # refuses it
        return x, y, z, w
    a, b, c, d = x / largest, y / largest, z / largest, w / largest
    scaled_length = math.sqrt(a * a + b * b + c * c + d * d)
    if abs(largest * scaled_length - 1.0) <= UNIT_ULPS * EPS:
        return x, y, z, w
    return a / scaled_length, b / scaled_length, c / scaled_length, d / scaled_length


def unit_quaternion(values: Any) -> tuple[float, float, float, float]:
    """Return the unit quaternion of four numbers of any length but zero; InvalidModel if none."""
    x, y, z, w = numbers(values, 4, unit='-')
    if not abs(x * x + y * y + z * z + w * w - 1.0) <= NEARLY_UNIT:
        return normalised((x, y, z, w))
    return x, y, z, w


def matrix_from_quaternion(q: ArrayLike) -> Array:
    """
    Return R_WB : (..., 3, 3), whose columns are the body axes seen from the world.

    R = 1 + 2 w [u]x + 2 [u]x [u]x
        q : (..., 4) [-]  unit quaternion xyzw, body to world
    """
    x, y, z, w = np.moveaxis(np.asarray(q, dtype=np.float64), -1, 0)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """
    Return the unit quaternion of a rotation matrix, with w >= 0.

    4 q q^T is linear in R; its row with the largest diagonal element is q up to scale, so that no
    small number is divided by (Shepperd, J. Guid. Control 1 (1978) 223).
        matrix : (..., 3, 3) [-]  R_WB, orthogonal with determinant +1
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(
        np.asarray(matrix, dtype=np.float64), (-2, -1), (0, 1)
    )
    outer = np.stack(
        [
            np.stack(row, axis=-1)
            for row in (
                (1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz),
                (xy + yx, 1.0 - xx + yy - zz, yz + zy, xz - zx),
                (xz + zx, yz + zy, 1.0 - xx - yy + zz, yx - xy),
                (zy - yz, xz - zx, yx - xy, 1.0 + xx + yy + zz),
            )
        ],
        axis=-2,
    )
    best = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    return normalise(np.where(q[..., 3:] < 0.0, -q, q))


def from_rotation_vector(vector: ArrayLike) -> Array:
    """
    Return the quaternion of a turn about an axis.

    q = (n sin(a/2), cos(a/2)),  vector = a n
        vector : (..., 3) [rad]
    """
    vector = np.asarray(vector, dtype=np.float64)
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    is_zero = angle == 0.0
    scale = np.where(is_zero, 0.5, np.sin(0.5 * angle) / np.where(is_zero, 1.0, angle))
    return np.concatenate((scale * vector, np.cos(0.5 * angle)), axis=-1)


def angle_between(p: ArrayLike, q: ArrayLike) -> Array:
    """
    Return the angle [rad], 0 to pi, of the turn that takes one attitude into the other.

    a = 4 atan2(|p - q|, |p + q|), with the sign of q that makes it smaller: exact to round-off at
    every angle, where 2 acos(|p . q|) loses half of the digits near zero.
        p, q : (..., 4) [-]  unit quaternions xyzw
    """
    p = np.asarray(p, dtype=np.float64)
    q = np.asarray(q, dtype=np.float64)
    difference = np.linalg.norm(p - q, axis=-1)
    total = np.linalg.norm(p + q, axis=-1)
    return 4.0 * np.arctan2(np.minimum(difference, total), np.maximum(difference, total))
