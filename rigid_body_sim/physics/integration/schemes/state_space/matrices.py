# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The state space of rotations in the lecture: a matrix R and the angular momentum L.

    R' = [omega] R,   L' = torque,   omega = R I^-1 R^T L            world axes
        [omega] : the matrix of the cross product, [omega] v = omega x v

No explicit Runge–Kutta method keeps R^T R = 1: on a fixed axis explicit Euler stretches it by
1 + (h omega)^2 a step, the classical method shrinks it by 1 - (h omega)^6 / 72. That is what this
module is there to show; a quaternion is scaled to unit length and does not suffer from it.
Source: Baraff, Rigid Body Simulation (SIGGRAPH course notes, Physically Based Modeling).

R is kept from tick to tick, nine rows of `memory`, row by row; forces and reports see the
quaternion of the nearest rotation. With REORTHONORMALISE that rotation takes the place of R after
each step. Compiled but not vectorised.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    VECTOR,
    copy_rows,
    multiply,
    normalised,
    read_quaternion,
    read_vector,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.state_space.protocol import (
    ErrorControl,
    StateSpace,
)
from rigid_body_sim.physics.integration.schemes.state_space.relative_error import larger
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    INVERSE_MOMENTS,
    LANES,
    ORIENTATION,
    ROTATION,
    TORQUE,
)
from rigid_body_sim.physics.vectors import add, cross, dot, scale, subtract

work_rows = Record(stride=LANES)
Y_MATRIX = work_rows.matrix('-', 'R at the start of the step')
MATRIX_SIZE = work_rows.size  # numbers of R in a block
Y_MOMENTUM = work_rows.vector('kg m^2/s', 'L at the start of the step, world axes')
SLOPE_SIZE = work_rows.size  # numbers of y, and of a slope, in a block
STAGE_MATRIX = work_rows.matrix('-', 'R of the stage')
SLOPES_AT = work_rows.size

ITERATIONS = 40  # [-] of the polar decomposition; five are normal, more only far from a rotation
LENGTH = 1.7320508075688772  # [-] of a rotation matrix: the root of the sum of its squares

# bound for each tableau
STAGES = slot('[-] stages of a step')
A = slot('[-] the tableau, row by row, with its zeros')
B = slot('[-] weights of the stages')
ERROR = slot('[-] weights of the slopes in the error of a pair')
REORTHONORMALISE = slot('[-] whether the nearest rotation takes the place of R after a step')


@inline
def _read_matrix(block, place):
    """Read a matrix: its three rows."""
    return (
        read_vector(block, place),
        read_vector(block, place + VECTOR),
        read_vector(block, place + 2 * VECTOR),
    )


@inline
def _write_matrix(block, place, first, second, third):
    """Write a matrix by its rows."""
    write_vector(block, place, first)
    write_vector(block, place + VECTOR, second)
    write_vector(block, place + 2 * VECTOR, third)


@inline
def _mean(row, over, cofactors):
    """Mean of a row of X and of X^-T."""
    return scale(0.5, add(row, scale(over, cofactors)))


@inline
def _nearest_rotation(first, second, third):
    """
    Polar factor of a matrix given by its rows: X <- (X + X^-T) / 2 (Higham, SIAM J. Sci. Stat.
    Comput. 7, 1986).
    """
    for _iteration in range(ITERATIONS):
        cofactors = cross(second, third)
        over = 1.0 / dot(first, cofactors)
        new_first = _mean(first, over, cofactors)
        new_second = _mean(second, over, cross(third, first))
        new_third = _mean(third, over, cross(first, second))
        a, b, c = subtract(new_first, first)
        d, e, f = subtract(new_second, second)
        g, h, i = subtract(new_third, third)
        change = abs(a) + abs(b) + abs(c) + abs(d) + abs(e)
        change += abs(f) + abs(g) + abs(h) + abs(i)
        first, second, third = new_first, new_second, new_third
        if not change > 1e-9:  # the next change would be its square
            break
    return first, second, third


@inline
def _quaternion(first, second, third):
    """
    Quaternion of a rotation matrix given by its rows (Shepperd, J. Guidance and Control 1, 1978).
    """
    a, b, c = first
    d, e, f = second
    g, h, i = third
    trace = a + e + i
    if trace >= a and trace >= e and trace >= i:
        found = h - f, c - g, d - b, 1.0 + trace
    elif a >= e and a >= i:
        found = 1.0 + a - e - i, b + d, c + g, h - f
    elif e >= i:
        found = b + d, 1.0 + e - i - a, f + h, c - g
    else:
        found = c + g, f + h, 1.0 + i - a - e, d - b
    return normalised(found)


@inline
def _write_orientation(lane, state, work, place):
    """
    Write the quaternion nearest to the matrix at a place of `work`, on the side of the one before.
    """
    first, second, third = _read_matrix(work, place + lane)
    first, second, third = _nearest_rotation(first, second, third)
    x, y, z, w = _quaternion(first, second, third)
    qx, qy, qz, qw = read_quaternion(state, lane + ORIENTATION)
    if x * qx + y * qy + z * qz + w * qw < 0.0:
        x, y, z, w = -x, -y, -z, -w
    write_quaternion(state, lane + ORIENTATION, (x, y, z, w))


@inline
def matrix(x, y, z, w):
    """Matrix of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    )


@inline
def begin(lanes, state, work, memory):
    """Start a step: y = (R, L)."""
    copy_rows(lanes, Y_MATRIX, MATRIX_SIZE, memory, work)
    copy_rows(lanes, Y_MATRIX, MATRIX_SIZE, memory, work[STAGE_MATRIX:])
    for lane in range(lanes):
        write_vector(work, lane + Y_MOMENTUM, read_vector(state, lane + ANGULAR_MOMENTUM))


def move(stage, lanes, h, state, work):
    """
    Make the state of a stage from the slopes of those before it, and the quaternion for the forces
    to read.
    """
    for lane in range(lanes):
        for place in range(lane, lane + SLOPE_SIZE, LANES):
            total = work[place]
            for before in range(stage):
                slope = SLOPES_AT + SLOPE_SIZE * before
                total += h * A[stage * STAGES + before] * work[slope + place]
            if place < Y_MOMENTUM:
                work[STAGE_MATRIX + place] = total
            else:
                state[ANGULAR_MOMENTUM + place - Y_MOMENTUM] = total
        _write_orientation(lane, state, work, STAGE_MATRIX)


@inline
def _combined(a, v, b, w):
    """Return a v - b w."""
    return subtract(scale(a, v), scale(b, w))


@inline
def slope_of(lanes, state, work, slope):
    """Slope of a stage."""
    for lane in range(lanes):
        first, second, third = _read_matrix(work, lane + STAGE_MATRIX)
        momentum = read_vector(state, lane + ANGULAR_MOMENTUM)
        rate = multiply(  # body axes
            read_vector(state, lane + INVERSE_MOMENTS),
            (
                first[0] * momentum[0] + second[0] * momentum[1] + third[0] * momentum[2],
                first[1] * momentum[0] + second[1] * momentum[1] + third[1] * momentum[2],
                first[2] * momentum[0] + second[2] * momentum[1] + third[2] * momentum[2],
            ),
        )
        wx, wy, wz = dot(first, rate), dot(second, rate), dot(third, rate)
        _write_matrix(
            slope, lane + Y_MATRIX,
            _combined(wy, third, wz, second), _combined(wz, first, wx, third),
            _combined(wx, second, wy, first),
        )  # fmt: skip
        write_vector(slope, lane + Y_MOMENTUM, read_vector(state, lane + TORQUE))


def end(lanes, h, state, work, memory):
    """y + h sum b K, and the quaternion nearest to it."""
    for lane in range(lanes):
        for place in range(lane, lane + SLOPE_SIZE, LANES):
            total = 0.0
            for stage in range(STAGES):
                total += B[stage] * work[SLOPES_AT + SLOPE_SIZE * stage + place]
            work[place] += h * total
        _write_orientation(lane, state, work, Y_MATRIX)
        write_vector(state, lane + ANGULAR_MOMENTUM, read_vector(work, lane + Y_MOMENTUM))
        if REORTHONORMALISE:
            x, y, z, w = read_quaternion(state, lane + ORIENTATION)
            xx, xy, xz, yx, yy, yz, zx, zy, zz = matrix(x, y, z, w)
            _write_matrix(work, lane + Y_MATRIX, (xx, xy, xz), (yx, yy, yz), (zx, zy, zz))
    copy_rows(lanes, Y_MATRIX, MATRIX_SIZE, work, memory)


@inline
def renew(lanes, state, work):
    """Make the new matrix that of the next stage."""
    copy_rows(lanes, Y_MATRIX, MATRIX_SIZE, work, work[STAGE_MATRIX:])


@inline
def keep(lanes, state, memory, kept):
    """Keep R and L."""
    copy_rows(lanes, Y_MATRIX, MATRIX_SIZE, memory, kept)
    for lane in range(lanes):
        write_vector(kept, lane + Y_MOMENTUM, read_vector(state, lane + ANGULAR_MOMENTUM))


@inline
def restore(lanes, kept, state, work):
    """Return to the start of the substep."""
    copy_rows(lanes, Y_MATRIX, SLOPE_SIZE, kept, work)
    for lane in range(lanes):
        write_vector(state, lane + ANGULAR_MOMENTUM, read_vector(kept, lane + Y_MOMENTUM))
        _write_orientation(lane, state, work, Y_MATRIX)


def error_of(lanes, h, state, work, tolerances, first, worst, culprit):
    """
    Largest error of R and of L of the bodies of a block relative to the tolerances, and whose; y
    is the new state.
    """
    rtol, atol = tolerances
    for lane in range(lanes):
        of_matrix = of_momentum = size = 0.0  # sums of squares
        for place in range(lane, lane + SLOPE_SIZE, LANES):
            total = 0.0
            for stage in range(STAGES + 1):
                total += ERROR[stage] * work[SLOPES_AT + SLOPE_SIZE * stage + place]
            if place < Y_MOMENTUM:
                of_matrix += total * total
            else:
                of_momentum += total * total
                size += work[place] * work[place]
        error = larger(
            h * math.sqrt(of_matrix) / (atol + rtol * LENGTH),
            h * math.sqrt(of_momentum) / (atol + rtol * math.sqrt(size)),
        )
        if error > worst or error != error:
            worst, culprit = error, first + lane
    return worst, culprit


MATRICES = StateSpace(
    state_size=ROTATION,
    memory_size=MATRIX_SIZE,
    slopes_at=SLOPES_AT,
    slope_size=SLOPE_SIZE,
    begin=begin,
    move=move,
    slope_of=slope_of,
    end=end,
    control=ErrorControl(renew=renew, keep=keep, restore=restore, error_of=error_of),
)
