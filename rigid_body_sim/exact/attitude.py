# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Quaternions xyzw for the closed forms: product, turn about a vector, distance.

Kept apart from `physics` on purpose: an oracle shares no code with what it judges.
q and -q are the same attitude.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Array

IDENTITY = (0.0, 0.0, 0.0, 1.0)


def product(a: ArrayLike, b: ArrayLike) -> Array:
    """
    Quaternion product a b: first b turns, then a.

    (a b)_v = a_w b_v + b_w a_v + a_v x b_v
    (a b)_w = a_w b_w - a_v . b_v
        a, b : (..., 4) [-] xyzw
    """
    ax, ay, az, aw = np.moveaxis(np.asarray(a, dtype=float), -1, 0)
    bx, by, bz, bw = np.moveaxis(np.asarray(b, dtype=float), -1, 0)
    return np.stack(
        [
            aw * bx + bw * ax + ay * bz - az * by,
            aw * by + bw * ay + az * bx - ax * bz,
            aw * bz + bw * az + ax * by - ay * bx,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def inverse(q: ArrayLike) -> Array:
    """Return the inverse of unit quaternions (..., 4) xyzw: their conjugates."""
    return np.asarray(q, dtype=float) * np.array([-1.0, -1.0, -1.0, 1.0])


def turn(axis: ArrayLike, angle: ArrayLike) -> Array:
    """
    Quaternion of a turn by `angle` about a unit axis.

    q = (sin(angle/2) axis, cos(angle/2))
        axis  : (3,)  [-]   unit vector
        angle : (...) [rad]
    """
    half = 0.5 * np.asarray(angle, dtype=float)[..., np.newaxis]
    return np.concatenate([np.sin(half) * np.asarray(axis, dtype=float), np.cos(half)], axis=-1)


def rotate(q: ArrayLike, vector: ArrayLike) -> Array:
    """
    Rotate a vector by unit quaternions: body to world.

    R(q) v = v + 2 w (u x v) + 2 u x (u x v),  q = (u, w)
        q      : (..., 4) [-] xyzw
        vector : (..., 3)     any vector, body axes
    """
    q = np.asarray(q, dtype=float)
    u, w = q[..., :3], q[..., 3:]
    across = np.cross(u, np.asarray(vector, dtype=float))
    return np.asarray(vector, dtype=float) + 2.0 * (w * across + np.cross(u, across))


def angle_between(a: ArrayLike, b: ArrayLike) -> Array:
    """
    Angle of the turn that takes one attitude into another, exact to round-off also near zero.

    angle = 2 atan2(|(a* b)_v|, |(a* b)_w|)  [rad]
        a, b : (..., 4) [-] unit quaternions xyzw
    The arc cosine of w would lose half of the digits.
    """
    between = product(inverse(a), b)
    return 2.0 * np.arctan2(np.linalg.norm(between[..., :3], axis=-1), np.abs(between[..., 3]))
