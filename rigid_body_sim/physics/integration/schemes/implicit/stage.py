# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One stage of an implicit step, body by body: its state, what is missing in its equations, and their
Jacobian.

Unknown are d = v - v0 [m/s], world axes, and the angular velocity w [rad/s], body axes. The stage
lies a = gamma h after
its base (r0, p0, q0, m0):

    r = r0 + a (v0 + d),   q = q0 cayley(a w)
    0 = m d - a F(r, q, v, w)
    0 = I w + a w x I w - m0 - a T_B(r, q, v, w)        m0 = R0^T L0 or I w0

For the Runge–Kutta methods on (q, omega) cayley(x) = (x/2, 1) / |(x/2, 1)| and T_B = R^T T. For
the midpoint rule, which
keeps L in world axes, the attitude is half-way to q0 (a w, 1) / |(a w, 1)|, and T_B = R0^T T, so
that L1 = L0 + h T.
The argument `midpoint` tells which.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import block_place, first_block, partner
from rigid_body_sim.physics.integration.schemes.implicit.banded import entry
from rigid_body_sim.physics.integration.schemes.implicit.coupling import BODY, UNKNOWN
from rigid_body_sim.physics.state.blocks import (
    FX,
    HX,
    I1,
    I2,
    I3,
    IM,
    KX,
    KY,
    KZ,
    LX,
    LY,
    LZ,
    PX,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    TY,
    TZ,
    at,
    rotate,
)

# row of a body, beyond what `physics.coupling` keeps there
BASE_R, BASE_P, BASE_Q, BASE_M = 3, 6, 9, 13  # base of the stage
D, W = 16, 19  # unknowns
TORQUE = 22  # a T_B that belongs to the solution
MOVED, PUSHED = 25, 28  # sums over the stages: change of r, change of p
START_R, START_P, START_L = 31, 34, 37  # start of the step
KEPT = 40  # state at the start of the tick: r, p, e, g, q, L
ROTATION_KEPT = 52
C = 59  # half-angle vector of the stage's rotation
HELD = 62  # 1 where only held forces, only held torques act
HELD_TORQUE = 63


@kernel
def set_stage(midpoint, i, n_rigid, a, b, translation, rotation):
    """Write the state of a stage for the forces to read; b is the row of the body."""
    k = at(i, TRANSLATION)
    mass = 1.0 / translation[k + IM]
    for axis in range(3):
        d = b[D + axis]
        v = b[BASE_P + axis] * translation[k + IM] + d
        translation[k + RX + 64 * axis] = b[BASE_R + axis] + a * v
        translation[k + PX + 64 * axis] = b[BASE_P + axis] + mass * d
    if i < n_rigid:
        k = at(i, ROTATION)
        w1, w2, w3 = b[W], b[W + 1], b[W + 2]
        if midpoint:
            f = a / (1.0 + math.sqrt(1.0 + a * a * (w1 * w1 + w2 * w2 + w3 * w3)))
        else:
            f = 0.5 * a
        c1, c2, c3 = f * w1, f * w2, f * w3
        b[C], b[C + 1], b[C + 2] = c1, c2, c3
        x, y, z, w = turned(b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3], c1, c2, c3)
        rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW] = x, y, z, w
        rotation[k + LX], rotation[k + LY], rotation[k + LZ] = rotate(
            x, y, z, w, rotation[k + I1] * w1, rotation[k + I2] * w2, rotation[k + I3] * w3
        )


@kernel
def turned(x, y, z, w, c1, c2, c3):
    """Attitude q (c, 1), normalised."""
    n = 1.0 / math.sqrt(1.0 + (c1 * c1 + c2 * c2 + c3 * c3))
    p = (x + (w * c1 + (y * c3 - z * c2))) * n
    q = (y + (w * c2 + (z * c1 - x * c3))) * n
    r = (z + (w * c3 + (x * c2 - y * c1))) * n
    s = (w - (x * c1 + y * c2 + z * c3)) * n
    f = 1.5 - 0.5 * (p * p + q * q + r * r + s * s)
    return p * f, q * f, r * f, s * f


@kernel
def torque_attitude(midpoint, b, rotation, k):
    """Attitude that brings torques into the body axes of the equations."""
    if midpoint:
        return b[BASE_Q], b[BASE_Q + 1], b[BASE_Q + 2], b[BASE_Q + 3]
    return rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]


@kernel
def attitude_change(midpoint, b, a, axis):
    """Rotation of the stage, body axes, per unit of one component of w."""
    c1, c2, c3 = b[C], b[C + 1], b[C + 2]
    cc = c1 * c1 + c2 * c2 + c3 * c3
    if midpoint:  # c = u / (1 + n), n^2 = 1 + u^2 and so c^2 = (n - 1) / (n + 1)
        n = (1.0 + cc) / (1.0 - cc)
        f = a / (1.0 + n)
        g = -a * b[C + axis] * (1.0 / n)
        e1, e2, e3 = g * c1, g * c2, g * c3
    else:
        f = 0.5 * a
        e1 = e2 = e3 = 0.0
    e1 += f if axis == 0 else 0.0
    e2 += f if axis == 1 else 0.0
    e3 += f if axis == 2 else 0.0
    n = 2.0 / (1.0 + cc)
    return (
        n * (e1 - (c2 * e3 - c3 * e2)),
        n * (e2 - (c3 * e1 - c1 * e3)),
        n * (e3 - (c1 * e2 - c2 * e1)),
    )


@kernel
def start_equations(midpoint, i, n_rigid, a, first, band, b, translation, rotation, matrix, rhs):
    """
    Write what is missing in the equations of a body, and the inertial part of their Jacobian.
    """
    k = at(i, TRANSLATION)
    mass = 1.0 / translation[k + IM]
    u = int(b[UNKNOWN]) - first
    held = True
    for axis in range(3):
        force = translation[k + FX + 64 * axis]
        held = held and force == translation[k + HX + 64 * axis]
        rhs[u + axis] = mass * b[D + axis] - a * force
        matrix[entry(band, u + axis, u + axis)] += mass
    b[HELD] = 1.0 if held else 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        x, y, z, w = torque_attitude(midpoint, b, rotation, k)
        t1, t2, t3 = rotate(-x, -y, -z, w, rotation[k + TX], rotation[k + TY], rotation[k + TZ])
        t1, t2, t3 = a * t1, a * t2, a * t3
        b[TORQUE], b[TORQUE + 1], b[TORQUE + 2] = t1, t2, t3
        w1, w2, w3 = b[W], b[W + 1], b[W + 2]
        i1, i2, i3 = rotation[k + I1], rotation[k + I2], rotation[k + I3]
        g1, g2, g3 = a * (i3 - i2), a * (i1 - i3), a * (i2 - i1)
        rhs[u + 3] = i1 * w1 + g1 * w2 * w3 - b[BASE_M] - t1
        rhs[u + 4] = i2 * w2 + g2 * w3 * w1 - b[BASE_M + 1] - t2
        rhs[u + 5] = i3 * w3 + g3 * w1 * w2 - b[BASE_M + 2] - t3
        for axis in range(3):
            b[TORQUE + axis] += rhs[
                u + 3 + axis
            ]  # with what `correct_torque` adds: a T_B after the Newton step
        matrix[entry(band, u + 3, u + 3)] += i1
        matrix[entry(band, u + 3, u + 4)] += g1 * w3
        matrix[entry(band, u + 3, u + 5)] += g1 * w2
        matrix[entry(band, u + 4, u + 3)] += g2 * w3
        matrix[entry(band, u + 4, u + 4)] += i2
        matrix[entry(band, u + 4, u + 5)] += g2 * w1
        matrix[entry(band, u + 5, u + 3)] += g3 * w2
        matrix[entry(band, u + 5, u + 4)] += g3 * w1
        matrix[entry(band, u + 5, u + 5)] += i3
        if not midpoint:  # the rotation of R^T T: (R^T T) x theta
            for axis in range(3):
                p, q, r = attitude_change(midpoint, b, a, axis)
                matrix[entry(band, u + 3, u + 3 + axis)] -= t2 * r - t3 * q
                matrix[entry(band, u + 4, u + 3 + axis)] -= t3 * p - t1 * r
                matrix[entry(band, u + 5, u + 3 + axis)] -= t1 * q - t2 * p
        held = rotation[k + TX] == rotation[k + KX] and rotation[k + TY] == rotation[k + KY]
        b[HELD_TORQUE] = 1.0 if held and rotation[k + TZ] == rotation[k + KZ] else 0.0


@kernel
def subtract_column(
    midpoint, i, n_rigid, a, row, column, band, b, rotation, matrix, fx, fy, fz, tx, ty, tz
):
    """
    Subtract a times the change of force and torque on body i, world axes, from one column of the
    Jacobian.
    """
    matrix[entry(band, row, column)] -= a * fx
    matrix[entry(band, row + 1, column)] -= a * fy
    matrix[entry(band, row + 2, column)] -= a * fz
    if i < n_rigid:
        x, y, z, w = torque_attitude(midpoint, b, rotation, at(i, ROTATION))
        tx, ty, tz = rotate(-x, -y, -z, w, tx, ty, tz)
        matrix[entry(band, row + 3, column)] -= a * tx
        matrix[entry(band, row + 4, column)] -= a * ty
        matrix[entry(band, row + 5, column)] -= a * tz


@kernel
def subtract_blocks(midpoint, i, n_rigid, a, first, band, bodies, rotation, table, matrix):
    """Subtract what the elements know of the derivatives of the wrench on body i."""
    b = bodies[BODY * i : BODY * (i + 1)]
    row = int(b[UNKNOWN]) - first
    for number in range(first_block(table, i), first_block(table, i + 1)):
        j = partner(table, number)
        m = block_place(table, number)
        other = bodies[BODY * j : BODY * (j + 1)]
        column = int(other[UNKNOWN]) - first
        for axis in range(3):
            n = m + axis
            subtract_column(
                midpoint, i, n_rigid, a, row, column + axis, band, b, rotation, matrix,
                a * table[n] + table[n + 36],
                a * table[n + 6] + table[n + 42],
                a * table[n + 12] + table[n + 48],
                a * table[n + 18] + table[n + 54],
                a * table[n + 24] + table[n + 60],
                a * table[n + 30] + table[n + 66],
            )  # fmt: skip
        if j >= n_rigid:
            continue
        k = at(j, ROTATION)
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        o1, o2, o3 = rotate(x, y, z, w, other[W], other[W + 1], other[W + 2])
        for axis in range(3):
            # theta: rotation of the stage, world axes; u: change of the angular velocity, world
            # axes
            p, q, r = attitude_change(midpoint, other, a, axis)
            p, q, r = rotate(x, y, z, w, p, q, r)
            u1, u2, u3 = rotate(
                x,
                y,
                z,
                w,
                1.0 if axis == 0 else 0.0,
                1.0 if axis == 1 else 0.0,
                1.0 if axis == 2 else 0.0,
            )
            u1, u2, u3 = u1 + (q * o3 - r * o2), u2 + (r * o1 - p * o3), u3 + (p * o2 - q * o1)
            subtract_column(
                midpoint, i, n_rigid, a, row, column + 3 + axis, band, b, rotation, matrix,
                _product(table, m + 3, p, q, r, u1, u2, u3),
                _product(table, m + 9, p, q, r, u1, u2, u3),
                _product(table, m + 15, p, q, r, u1, u2, u3),
                _product(table, m + 21, p, q, r, u1, u2, u3),
                _product(table, m + 27, p, q, r, u1, u2, u3),
                _product(table, m + 33, p, q, r, u1, u2, u3),
            )  # fmt: skip


@inline
def _product(table, m, p, q, r, u, v, w):
    """Row of K times theta plus row of C times the change of the angular velocity."""
    return (
        table[m] * p
        + table[m + 1] * q
        + table[m + 2] * r
        + table[m + 36] * u
        + table[m + 37] * v
        + table[m + 38] * w
    )
