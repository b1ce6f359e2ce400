# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where numbers that move are kept: blocks of 64 bodies, one row per quantity.

Body i sits in block i // 64, lane i % 64. A block has rows of 64 numbers; a quantity is named by
the offset of its row inside the block, so that in a block `s` its value in lane k is `s[k + QX]`.
The constant distance between rows lets the compiler prove that they do not overlap, and so use
SIMD: 5 to 8 times faster than rows in arrays of their own. The rows of a vector follow each other:
`load_strided(s, k + MOMENTUM, LANES)` reads one, and PX, PY, PZ name its components.

translation : every moving body, rigid bodies first, then point masses; world axes
rotation    : the rigid bodies only, in the same order; a scene of point masses has none of it

A fixed body is in neither: it does not move, and its anchors are points of the world.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.vectors import add_strided, load_strided, scale

LANES = 64  # [-] bodies in a block

translation_block = Record(stride=LANES)
POSITION = translation_block.vector('m', 'of the centre of mass, world')
MOMENTUM = translation_block.vector('kg m/s', 'world axes')
POSITION_RESIDUAL = translation_block.vector('m', 'what rounding lost of the position')
MOMENTUM_RESIDUAL = translation_block.vector('kg m/s', 'what rounding lost of the momentum')
FORCE = translation_block.vector('N', 'sum of all forces at the last evaluation')
HELD_FORCE = translation_block.vector(
    'N', 'forces that stay the same over a tick: commands, uniform gravity'
)
INVERSE_MASS = translation_block.number('1/kg', 'of the whole body')
TRANSLATION = translation_block.size  # numbers in a block
TRANSLATION_STATE = FORCE  # those a run must remember

rotation_block = Record(stride=LANES)
ORIENTATION = rotation_block.quaternion('-', 'unit quaternion xyzw, principal axes to world')
ANGULAR_MOMENTUM = rotation_block.vector('kg m^2/s', 'about the centre of mass, world axes')
TORQUE = rotation_block.vector('N m', 'sum of all torques at the last evaluation, world axes')
HELD_TORQUE = rotation_block.vector('N m', 'torques that stay the same over a tick, world axes')
MOMENTS = rotation_block.vector('kg m^2', 'principal moments of inertia')
INVERSE_MOMENTS = rotation_block.vector('1/(kg m^2)', 'their inverses')
ROTATION = rotation_block.size  # numbers in a block
ROTATION_STATE = TORQUE  # those a run must remember


def _components(vector: int) -> tuple[int, int, int]:
    return vector, vector + LANES, vector + 2 * LANES


# rows of the components: translation
RX, RY, RZ = _components(POSITION)
PX, PY, PZ = _components(MOMENTUM)
EX, EY, EZ = _components(POSITION_RESIDUAL)
GX, GY, GZ = _components(MOMENTUM_RESIDUAL)
FX, FY, FZ = _components(FORCE)
HX, HY, HZ = _components(HELD_FORCE)
IM = INVERSE_MASS

# rotation
QX, QY, QZ = _components(ORIENTATION)
QW = QZ + LANES
LX, LY, LZ = _components(ANGULAR_MOMENTUM)
TX, TY, TZ = _components(TORQUE)
KX, KY, KZ = _components(HELD_TORQUE)
I1, I2, I3 = _components(MOMENTS)
J1, J2, J3 = _components(INVERSE_MOMENTS)


def blocks(bodies: int) -> int:
    """Count the blocks that hold so many bodies."""
    return (bodies + LANES - 1) // LANES


def rows(array: NDArray[np.float64], size: int, offset: int, count: int) -> NDArray[np.float64]:
    """
    View `count` successive rows of every block as (blocks, count, 64).

        size   : numbers in a block
        offset : offset of the first row
    """
    return array.reshape(-1, size // LANES, LANES)[:, offset // LANES : offset // LANES + count]


def scatter(
    array: NDArray[np.float64], size: int, offset: int, values: NDArray[np.float64]
) -> None:
    """Write values (bodies, count) into rows, body i into block i // 64, lane i % 64."""
    view = rows(array, size, offset, values.shape[1])
    full, rest = divmod(len(values), LANES)
    if full:
        whole = values[: full * LANES].reshape(full, LANES, -1)
        view[:full] = whole.transpose(0, 2, 1)
    if rest:
        view[full, :, :rest] = values[full * LANES :].T


def gather(
    array: NDArray[np.float64], size: int, offset: int, count: int, bodies: int
) -> NDArray[np.float64]:
    """Read rows as (bodies, count): the inverse of `scatter`."""
    view = rows(array, size, offset, count)
    return np.ascontiguousarray(view.transpose(0, 2, 1)).reshape(-1, count)[:bodies]


@inline
def at(index, size):
    """Place of lane `index % 64` in block `index // 64`: add the offset of a row."""
    return (index // LANES) * size + index % LANES


@inline
def block_count(bodies):
    """Count the blocks that hold so many bodies, in a kernel."""
    return (bodies + LANES - 1) // LANES


@inline
def lanes_in(block, bodies):
    """Count the lanes of a block that hold one of so many bodies."""
    return min(LANES, bodies - LANES * block)


@inline
def wide(lanes):
    """
    Lanes up to the end of a vector of eight, but for a last one alone: what a vector leaves over
    is done one by one, at the price of a vector each. Empty lanes hold a unit sphere at rest.

    Eight are four at a time, twice, or eight at once, which compilers make for most processors;
    where they make four at a time, once, two to four bodies cost twice what they could.
    """
    return lanes if lanes % 8 == 1 else (lanes + 7) // 8 * 8


@inline
def _keep_rows(bodies, size, size_kept, array, kept):
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        for row in range(0, size_kept, LANES):
            here, there = block * size + row, block * size_kept + row
            for lane in range(lanes):
                kept[there + lane] = array[here + lane]


@kernel
def keep_motion(n_moving, n_rigid, translation, rotation, sizes, kept_translation, kept_rotation):
    """Copy the first rows of each block, lanes in use; sizes: numbers kept of a block of each."""
    _keep_rows(n_moving, TRANSLATION, sizes[0], translation, kept_translation)
    _keep_rows(n_rigid, ROTATION, sizes[1], rotation, kept_rotation)


@inline
def rotate(x, y, z, w, a, b, c):
    """
    Rotate a vector from body to world axes.

    R(q) v = v + 2 w (u x v) + 2 u x (u x v)
        u, w    : vector part (x, y, z) and scalar part of the unit quaternion q [-]
        a, b, c : v, body axes

    With (-x, -y, -z, w) it rotates from world to body axes.
    """
    tx = 2.0 * (y * c - z * b)
    ty = 2.0 * (z * a - x * c)
    tz = 2.0 * (x * b - y * a)
    return (
        a + w * tx + (y * tz - z * ty),
        b + w * ty + (z * tx - x * tz),
        c + w * tz + (x * ty - y * tx),
    )


@inline
def add_compensated(total, lost, increment):
    """
    Add a small number to a large one and remember what rounding lost (Kahan, 1965).

    After 1e7 additions of 1e-7 of the total nothing is lost; a plain sum loses 1e-9 of it.
    """
    y = increment + lost
    t = total + y
    return t, y - (t - total)


@inline
def rotated(q, v):
    """Return R(q) v: `rotate` for tuples."""
    x, y, z, w = q
    a, b, c = v
    return rotate(x, y, z, w, a, b, c)


@inline
def rotated_back(q, v):
    """Return R(q)^T v, from world to body axes."""
    x, y, z, w = q
    a, b, c = v
    return rotate(-x, -y, -z, w, a, b, c)


@inline
def select(condition, q, r):
    """Return the quaternion q where the condition holds, else r: without a branch in a lane."""
    x, y, z, w = r
    a, b, c, d = q
    return (
        a if condition else x,
        b if condition else y,
        c if condition else z,
        d if condition else w,
    )


@inline
def position(translation, index):
    """Position of the centre of mass (x, y, z) [m], world."""
    return load_strided(translation, at(index, TRANSLATION) + POSITION, LANES)


@inline
def velocity(translation, index):
    """Velocity of the centre of mass (x, y, z) [m/s], world."""
    k = at(index, TRANSLATION)
    return scale(translation[k + INVERSE_MASS], load_strided(translation, k + MOMENTUM, LANES))


@inline
def orientation(rotation, index):
    """Orientation (x, y, z, w) of the principal axes of a rigid body."""
    k = at(index, ROTATION)
    return rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]


@inline
def to_world(rotation, index, v):
    """Rotate a vector from the principal axes of a rigid body to world axes."""
    return rotated(orientation(rotation, index), v)


@inline
def angular_velocity(rotation, index):
    """Angular velocity (x, y, z) of a rigid body [rad/s], world axes: R I^-1 R^T L."""
    k = at(index, ROTATION)
    q = orientation(rotation, index)
    a, b, c = rotated_back(q, load_strided(rotation, k + ANGULAR_MOMENTUM, LANES))
    return rotated(q, (a * rotation[k + J1], b * rotation[k + J2], c * rotation[k + J3]))


@inline
def add_force(translation, index, force):
    """Add a force (x, y, z) that acts at the centre of mass [N], world axes."""
    add_strided(translation, at(index, TRANSLATION) + FORCE, LANES, force)


@inline
def add_torque(rotation, index, torque):
    """Add a torque (x, y, z) about the centre of mass [N m], world axes."""
    add_strided(rotation, at(index, ROTATION) + TORQUE, LANES, torque)
