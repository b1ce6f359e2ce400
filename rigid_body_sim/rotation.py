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
are the same attitude. Nothing here scales quaternions but `normalise`, `log` and `as_scipy`: what
is no longer of length one (sums, interpolations, files) goes through `normalise` first. What is no
rotation is refused by InvalidModel: lengths off one by more than UNIT, matrices that are off
orthogonal by more than ORTHOGONAL or mirror, whatever is not finite. `multiply` takes quaternions
of any length, as in q' = q (w, 0) / 2.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import rotation as plain
from rigid_body_sim.physics.model.numbers import array_of_numbers, shown
from rigid_body_sim.physics.model.rotation import IDENTITY

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

# Single precision is off by 1e-7, as are seven digits of a text. Wider, an attitude that was not
# normalised passes, and stretches what it turns; narrower, what another program wrote is refused.
UNIT = 1e-6  # [-] how near to one the length of a quaternion must be
ORTHOGONAL = 1e-6  # [-] how near to the identity each number of R^T R must be


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """
    Compose two attitudes: first q, then p.

    p q = (p_w q_v + q_w p_v + p_v x q_v,  p_w q_w - p_v . q_v)
        p, q : (..., 4) [-]  finite quaternions xyzw, of any length
    """
    pair = _finite('multiply', 'p', p, (4,)), _finite('multiply', 'q', q, (4,))
    return _together('multiply', plain.multiply, *pair)


def inverse(q: ArrayLike) -> Array:
    """Return the inverse attitude of unit quaternions q : (..., 4) [-]: world to body."""
    return plain.conjugate(_attitudes('inverse', 'q', q))


conjugate = inverse


def rotate(q: ArrayLike, v_body: ArrayLike) -> Array:
    """
    Rotate vectors from body to world axes.

    v_W = v + w t + u x t,  t = 2 u x v,  q = (u, w)
        q      : (..., 4) [-]  unit quaternion xyzw, body to world
        v_body : (..., 3)      any vector, body axes
    """
    pair = _attitudes('rotate', 'q', q), _array('rotate', 'v_body', v_body, (3,))
    return _together('rotate', plain.rotate, *pair)


def rotate_back(q: ArrayLike, v: ArrayLike) -> Array:
    """Rotate vectors v : (..., 3) from world to body axes: v_B = q* v_W q."""
    pair = _attitudes('rotate_back', 'q', q), _array('rotate_back', 'v', v, (3,))
    return _together('rotate_back', plain.rotate_back, *pair)


def normalise(q: ArrayLike) -> Array:
    """
    Return q / |q|; a quaternion whose length is one to the last bits is returned bit for bit.

    q : (..., 4) [-]  finite, of any length but zero
    """
    return _normalised('normalise', q)


def matrix(q: ArrayLike) -> Array:
    """
    Return R_WB : (..., 3, 3), whose columns are the body axes seen from the world.

    R = 1 + 2 w [u]x + 2 [u]x [u]x
        q : (..., 4) [-]  unit quaternion xyzw, body to world
    """
    return plain.matrix_from_quaternion(_attitudes('matrix', 'q', q))


def from_matrix(matrix: ArrayLike) -> Array:
    """
    Return the unit quaternion of a rotation matrix, with w >= 0.

    matrix : (..., 3, 3) [-]  R_WB, orthogonal to within ORTHOGONAL, with determinant +1
    """
    R = _finite('from_matrix', 'matrix', matrix, (3, 3))
    with np.errstate(over='ignore', invalid='ignore'):
        apart = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3))
        worst = np.max(apart, axis=(-1, -2))
        mirrors = np.linalg.det(R) < 0.0
    _refuse(
        'from_matrix',
        'matrix',
        R,
        ~(worst <= ORTHOGONAL),
        lambda at: (
            f'R^T R is off the identity by {worst[at]:.3g}, allowed: {ORTHOGONAL:g}; a '
            'rotation matrix is needed: take scale and skew out of it, such as by U V^T of its '
            'singular value decomposition U S V^T'
        ),
    )
    _refuse(
        'from_matrix',
        'matrix',
        R,
        mirrors,
        lambda _: (
            'its determinant is -1, allowed: +1; it mirrors, which no turn does: swap two '
            'axes back, or turn one round'
        ),
    )
    return plain.quaternion_from_matrix(R)


def exp(vector: ArrayLike) -> Array:
    """
    Return the quaternion of a turn about an axis.

    q = (n sin(a/2), cos(a/2)),  vector = a n
        vector : (..., 3) [rad]
    """
    v = _finite('exp', 'vector', vector, (3,))
    with np.errstate(over='ignore', invalid='ignore'):
        q = plain.from_rotation_vector(v)
    bad = ~np.all(np.isfinite(q), axis=-1)
    _refuse('exp', 'vector', v, bad, lambda _: 'its length is beyond all numbers')
    return q


def angle_between(p: ArrayLike, q: ArrayLike) -> Array:
    """
    Return the angle [rad], 0 to pi, of the turn that takes one attitude into the other.

    a = 4 atan2(|p - q|, |p + q|), with the sign of q that makes it smaller: exact to round-off at
    every angle.
        p, q : (..., 4) [-]  unit quaternions xyzw
    """
    pair = _attitudes('angle_between', 'p', p), _attitudes('angle_between', 'q', q)
    return _together('angle_between', plain.angle_between, *pair)


def log(q: ArrayLike) -> Array:
    """
    Return the rotation vector of a turn: its axis times its angle, which is 0 to pi.

    log(q) = 2 atan2(|u|, |w|) u / |u| sign(w),  q = (u, w)
        q       : (..., 4) [-]  quaternion xyzw; -q gives the same vector, but for turns by pi
        returns : (..., 3) [rad]

    Through scipy's Rotation, which keeps all digits of small angles. Raises InvalidModel for a
    quaternion of zero length or one that is not finite.
    """
    unit = _normalised('log', q)
    if unit.size == 0:
        return np.zeros((*unit.shape[:-1], 3))
    return _scipy(unit.reshape(-1, 4)).as_rotvec().reshape(*unit.shape[:-1], 3)


def as_scipy(q: ArrayLike) -> Rotation:
    """Return scipy's Rotation of quaternions (4,) or (n, 4): for Euler angles, means, splines."""
    return _scipy(_normalised('as_scipy', q))


def from_scipy(rotation: Rotation) -> Array:
    """Return the quaternions (4,) or (n, 4), xyzw, of scipy's Rotation."""
    if not hasattr(rotation, 'as_quat'):
        raise InvalidModel(
            f'from_scipy: got {shown(rotation)}; a scipy.spatial.transform.Rotation is needed'
        )
    return rotation.as_quat()


def _scipy(unit: Array) -> Rotation:
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(unit)


def _array(said: str, name: str, given: Any, shape: tuple[int, ...]) -> Array:
    """Return an array (..., *shape) of numbers, finite or not."""
    array = array_of_numbers(given)
    if array is None or array.shape[-len(shape) :] != shape:
        got = shown(given) if array is None else f'the shape {array.shape}'
        needed = f'(..., {", ".join(map(str, shape))})'
        order = ' xyzw' if shape == (4,) else ''
        raise InvalidModel(f'{said}: {name}: got {got}; numbers {needed}{order} are needed')
    return array


def _finite(said: str, name: str, given: Any, shape: tuple[int, ...]) -> Array:
    array = _array(said, name, given, shape)
    if not np.all(np.isfinite(array)):
        axes = tuple(range(-len(shape), 0))
        bad = ~np.all(np.isfinite(array), axis=axes)
        _refuse(said, name, array, bad, lambda _: 'it is not finite; finite numbers are needed')
    return array


def _attitudes(said: str, name: str, given: Any) -> Array:
    """Return unit quaternions (..., 4), as they were given."""
    q = _array(said, name, given, (4,))
    if q.ndim == 1:
        x, y, z, w = q.tolist()
        if abs(math.hypot(x, y, z, w) - 1.0) <= UNIT:
            return q
    with np.errstate(over='ignore'):
        length = np.linalg.norm(q, axis=-1)
    _refuse(
        said,
        name,
        q,
        ~(np.abs(length - 1.0) <= UNIT),
        lambda at: (
            f'its length is {length[at]:.9g}, allowed: 1 to within {UNIT:g}; a unit '
            'quaternion xyzw is needed: rotation.normalise makes one of any finite length but zero'
        ),
    )
    return q


def _normalised(said: str, given: Any) -> Array:
    q = _finite(said, 'q', given, (4,))
    _refuse(
        said,
        'q',
        q,
        ~np.any(q, axis=-1),
        lambda _: 'a quaternion of zero length is no attitude; the identity is (0, 0, 0, 1)',
    )
    return plain.normalise(q)


def _refuse(said: str, name: str, given: Array, bad: Any, why: Any) -> None:
    """Refuse the first that is bad: its place among the others, what it is, and why not."""
    if not np.any(bad):
        return
    at = tuple(int(place[0]) for place in np.nonzero(np.atleast_1d(bad)))[: np.ndim(bad)]
    place = f'[{", ".join(map(str, at))}]' if at else ''
    raise InvalidModel(f'{said}: {name}{place}: got {shown(given[at].tolist())}; {why(at)}')


def _together(said: str, of: Any, a: Array, b: Array) -> Array:
    """Call a function of two arrays, whose leading shapes must go together."""
    try:
        return of(a, b)
    except ValueError:
        raise InvalidModel(
            f'{said}: got the shapes {a.shape} and {b.shape}; leading shapes that numpy can '
            'broadcast are needed'
        ) from None
