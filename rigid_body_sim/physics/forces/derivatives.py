# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How wrenches change with the motion of bodies: the table that force elements fill for implicit
integrators.

For each pair (i, j) of bodies that a force couples, and for i = j, a block of two 6 x 6 matrices,
world axes:

    K : change of (force, torque) on i with (displacement, rotation vector) of j     [N/m, N/rad,
        N, N m/rad]
    C : change of (force, torque) on i with (velocity, angular velocity) of j        [N s/m, N s, N
        s, N m s]

The kernel `linearise` of a force element adds to them. Where it is called with `definite` = 1, the
terms are left out that would break the symmetry or the sign of the whole: what a turning arm does
to a given force, what a spring under compression does across its direction. Then -K and -C are
symmetric and positive semidefinite.

Table: number of bodies n, number of blocks, first block of each body (n + 1), body j of each
block, the blocks, and one more for pairs that no element has announced.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.vectors import add_strided, cross, dot

head = Record()
BODIES = head.number('-', 'n')
BLOCKS = head.number('-', 'blocks of pairs')
FIRST_BLOCKS = head.size  # of each body, and one past the last
SIZE_HEAD = FIRST_BLOCKS + 1  # and one for each body and each block

ROW = 6  # numbers in a row of K or C
TORQUE_ROWS = 3 * ROW  # where the rows of the torque begin
TURN_COLUMNS = 3  # where the columns of the rotation vector begin
TURN_BLOCK = TORQUE_ROWS + TURN_COLUMNS  # where the torque changes with the rotation vector

STIFFNESS_MATRIX = 0  # where K begins in a block
DAMPING_MATRIX = ROW * ROW  # where C begins
BLOCK = 2 * ROW * ROW  # numbers of K and C, row by row


@inline
def first_block(table, i):
    """Number of the first block of body i; that of body i + 1 is one past its last."""
    return int(table[FIRST_BLOCKS + i])


@inline
def partner(table, number):
    """Body j of a block."""
    return int(table[SIZE_HEAD + int(table[BODIES]) + number])


@inline
def block_place(table, number):
    """Where a block begins."""
    return SIZE_HEAD + int(table[BODIES]) + int(table[BLOCKS]) + BLOCK * number


@kernel
def clear(table):
    """Set all derivatives to zero."""
    start = block_place(table, 0)
    for m in range(BLOCK * (int(table[BLOCKS]) + 1)):
        table[start + m] = 0.0


@kernel
def place_of(table, i, j):
    """Where the block of the pair (i, j) begins."""
    end = first_block(table, i + 1)
    for number in range(first_block(table, i), end):
        if partner(table, number) == j:
            return block_place(table, number)
    return block_place(table, int(table[BLOCKS]))


@inline
def _add_column(table, place, arm, force):
    """Add the change of a force, and of its torque about the arm a, to one column."""
    add_strided(table, place, ROW, force)
    add_strided(table, place + TORQUE_ROWS, ROW, cross(arm, force))


@kernel
def _add_columns(table, place, arm, matrix):
    """Add three columns of the change of a force: matrix (3, 3), row by row."""
    first, second, third = matrix
    for column in range(3):
        _add_column(table, place + column, arm, (first[column], second[column], third[column]))


@inline
def _about(arm, matrix):
    """Rows k . (theta x b) = (b x k) . theta of a matrix of rows k."""
    return cross(arm, matrix[0]), cross(arm, matrix[1]), cross(arm, matrix[2])


@kernel
def add_between_points(table, i, j, arm, change, of, other, rate):
    """
    Add the change of a force at a point of body i with the displacement (of = STIFFNESS_MATRIX) or
    velocity (DAMPING_MATRIX) of one of j.

        arm, other : (3,) [m]      from the centres of mass to the points of i and j
        change     : (3, 3)        of the force with the displacement or velocity of the point of
                     j, row by row
        rate       : (3,) [rad/s]  angular velocity of j: a rotation of the arm changes the
                     velocity of the point; of = DAMPING_MATRIX
    """
    place = place_of(table, i, j)
    _add_columns(table, place + of, arm, change)
    _add_columns(table, place + of + TURN_COLUMNS, arm, _about(other, change))
    if of == DAMPING_MATRIX:
        # rows k . (w x (theta x b)) = (b x (k x w)) . theta
        swung = cross(change[0], rate), cross(change[1], rate), cross(change[2], rate)
        _add_columns(table, place + TURN_COLUMNS, arm, _about(other, swung))


@inline
def _add_row(table, place, v):
    add_strided(table, place, 1, v)


@kernel
def add_turning_arm(table, i, arm, force):
    """
    Add the change of the torque a x f of a given force with the rotation of the arm: (theta x a) x
    f.
    """
    place = place_of(table, i, i) + TURN_BLOCK
    s = dot(arm, force)
    ax, ay, az = arm
    fx, fy, fz = force
    _add_row(table, place, (ax * fx - s, ax * fy, ax * fz))
    _add_row(table, place + ROW, (ay * fx, ay * fy - s, ay * fz))
    _add_row(table, place + 2 * ROW, (az * fx, az * fy, az * fz - s))


@kernel
def _add_cross(table, place, v):
    """Add the change theta x v of a vector v that turns with the body."""
    x, y, z = v
    table[place + 1] += z
    table[place + 2] -= y
    table[place + ROW] -= z
    table[place + ROW + 2] += x
    table[place + 2 * ROW] += y
    table[place + 2 * ROW + 1] -= x


@kernel
def add_turning_wrench(table, i, force, torque):
    """Add the change of a force and a torque that turn with body i."""
    place = place_of(table, i, i)
    _add_cross(table, place + TURN_COLUMNS, force)
    _add_cross(table, place + TURN_BLOCK, torque)


@kernel
def _add_symmetric(table, place, s, f, v):
    """Add s 1 + f v v^T."""
    x, y, z = v
    _add_row(table, place, (s + f * x * x, f * x * y, f * x * z))
    _add_row(table, place + ROW, (f * y * x, s + f * y * y, f * y * z))
    _add_row(table, place + 2 * ROW, (f * z * x, f * z * y, s + f * z * z))


@kernel
def add_resistance(table, i, s, f, v):
    """Add s 1 + f v v^T to the change of force with velocity of body i."""
    _add_symmetric(table, place_of(table, i, i) + DAMPING_MATRIX, s, f, v)


@kernel
def add_angular_resistance(table, i, s, f, v):
    """Add s 1 + f v v^T to the change of torque with angular velocity of body i."""
    _add_symmetric(table, place_of(table, i, i) + DAMPING_MATRIX + TURN_BLOCK, s, f, v)
