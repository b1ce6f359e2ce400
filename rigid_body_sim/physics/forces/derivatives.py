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
terms are left out that
would break the symmetry or the sign of the whole: what a turning arm does to a given force, what a
spring under compression does across its direction. Then -K and -C are symmetric and positive
semidefinite.

Table: number of bodies n, number of blocks, first block of each body (n + 1), body j of each
block, the blocks, and one more for pairs that no element has announced.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel

BLOCK = 72  # numbers of K and C, row by row
DAMPING = 36  # where C begins


@inline
def first_block(table, i):
    """Number of the first block of body i; that of body i + 1 is one past its last."""
    return int(table[2 + i])


@inline
def partner(table, number):
    """Body j of a block."""
    return int(table[3 + int(table[0]) + number])


@inline
def block_place(table, number):
    """Where a block begins."""
    return 3 + int(table[0]) + int(table[1]) + BLOCK * number


@kernel
def clear(table):
    """Set all derivatives to zero."""
    start = block_place(table, 0)
    for m in range(BLOCK * (int(table[1]) + 1)):
        table[start + m] = 0.0


@kernel
def place_of(table, i, j):
    """Where the block of the pair (i, j) begins."""
    end = first_block(table, i + 1)
    for number in range(first_block(table, i), end):
        if partner(table, number) == j:
            return block_place(table, number)
    return block_place(table, int(table[1]))


@kernel
def _add_column(table, m, ax, ay, az, fx, fy, fz):
    """Add the change of a force, and of its torque about the arm a, to one column."""
    table[m] += fx
    table[m + 6] += fy
    table[m + 12] += fz
    table[m + 18] += ay * fz - az * fy
    table[m + 24] += az * fx - ax * fz
    table[m + 30] += ax * fy - ay * fx


@kernel
def add_between_points(
    table, i, j, arm, k11, k12, k13, k21, k22, k23, k31, k32, k33, m, other, rate
):
    """
    Add the change of a force at a point of body i with the displacement (m = 0) or velocity (m =
    DAMPING) of one of j.

        arm, other : (3,) [m]      from the centres of mass to the points of i and j
        k          : (3, 3)        change of the force with the displacement or velocity of the
                     point of j
        rate       : (3,) [rad/s]  angular velocity of j: a rotation of the arm changes the
                     velocity of the point; m != 0
    """
    ax, ay, az = arm
    bx, by, bz = other
    place = place_of(table, i, j)
    n = place + m
    _add_column(table, n, ax, ay, az, k11, k21, k31)
    _add_column(table, n + 1, ax, ay, az, k12, k22, k32)
    _add_column(table, n + 2, ax, ay, az, k13, k23, k33)
    # rows k . (theta x b) = (b x k) . theta
    u1, v1, w1 = by * k13 - bz * k12, bz * k11 - bx * k13, bx * k12 - by * k11
    u2, v2, w2 = by * k23 - bz * k22, bz * k21 - bx * k23, bx * k22 - by * k21
    u3, v3, w3 = by * k33 - bz * k32, bz * k31 - bx * k33, bx * k32 - by * k31
    _add_column(table, n + 3, ax, ay, az, u1, u2, u3)
    _add_column(table, n + 4, ax, ay, az, v1, v2, v3)
    _add_column(table, n + 5, ax, ay, az, w1, w2, w3)
    if m > 0:
        # rows k . (w x (theta x b)) = (b x (k x w)) . theta
        ox, oy, oz = rate
        p1, q1, r1 = k12 * oz - k13 * oy, k13 * ox - k11 * oz, k11 * oy - k12 * ox
        p2, q2, r2 = k22 * oz - k23 * oy, k23 * ox - k21 * oz, k21 * oy - k22 * ox
        p3, q3, r3 = k32 * oz - k33 * oy, k33 * ox - k31 * oz, k31 * oy - k32 * ox
        _add_column(
            table, place + 3, ax, ay, az, by * r1 - bz * q1, by * r2 - bz * q2, by * r3 - bz * q3
        )
        _add_column(
            table, place + 4, ax, ay, az, bz * p1 - bx * r1, bz * p2 - bx * r2, bz * p3 - bx * r3
        )
        _add_column(
            table, place + 5, ax, ay, az, bx * q1 - by * p1, bx * q2 - by * p2, bx * q3 - by * p3
        )


@kernel
def add_turning_arm(table, i, ax, ay, az, fx, fy, fz):
    """
    Add the change of the torque a x f of a given force with the rotation of the arm: (theta x a) x
    f.
    """
    m = place_of(table, i, i) + 21
    s = ax * fx + ay * fy + az * fz
    table[m] += ax * fx - s
    table[m + 1] += ax * fy
    table[m + 2] += ax * fz
    table[m + 6] += ay * fx
    table[m + 7] += ay * fy - s
    table[m + 8] += ay * fz
    table[m + 12] += az * fx
    table[m + 13] += az * fy
    table[m + 14] += az * fz - s


@kernel
def _add_cross(table, m, x, y, z):
    """Add the change theta x v of a vector v that turns with the body."""
    table[m + 1] += z
    table[m + 2] -= y
    table[m + 6] -= z
    table[m + 8] += x
    table[m + 12] += y
    table[m + 13] -= x


@kernel
def add_turning_wrench(table, i, fx, fy, fz, tx, ty, tz):
    """Add the change of a force and a torque that turn with body i."""
    m = place_of(table, i, i)
    _add_cross(table, m + 3, fx, fy, fz)
    _add_cross(table, m + 21, tx, ty, tz)


@kernel
def _add_symmetric(table, m, s, f, x, y, z):
    """Add s 1 + f v v^T."""
    table[m] += s + f * x * x
    table[m + 1] += f * x * y
    table[m + 2] += f * x * z
    table[m + 6] += f * y * x
    table[m + 7] += s + f * y * y
    table[m + 8] += f * y * z
    table[m + 12] += f * z * x
    table[m + 13] += f * z * y
    table[m + 14] += s + f * z * z


@kernel
def add_resistance(table, i, turning, s, f, x, y, z):
    """
    Add s 1 + f v v^T to the change of force with velocity, or (turning = 1) of torque with angular
    velocity, of body i.
    """
    _add_symmetric(table, place_of(table, i, i) + DAMPING + 21 * turning, s, f, x, y, z)
