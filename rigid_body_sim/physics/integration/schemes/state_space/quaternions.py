# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The state space of rotations as unit quaternions and angular velocity:

    q' = q (omega, 0) / 2,   omega' = I^-1 (R^T torque - omega x I omega)        body axes

q is scaled by 1.5 - |q|^2 / 2 in every stage and normalised after the step: a smooth map that is
one on the unit sphere, so the order stays. L of the state is rebuilt from omega where forces are
to read it, and after the step.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    add_rows,
    multiply,
    nearly_normalised,
    normalised,
    read_quaternion,
    read_vector,
    scale_rows,
    write_quaternion,
    write_vector,
)
from rigid_body_sim.physics.integration.schemes.state_space.protocol import (
    ErrorControl,
    StateSpace,
)
from rigid_body_sim.physics.integration.schemes.state_space.relative_error import (
    larger,
    relative_error,
)
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    INVERSE_MOMENTS,
    LANES,
    MOMENTS,
    ORIENTATION,
    ROTATION,
    TORQUE,
    rotated,
    rotated_back,
)
from rigid_body_sim.physics.vectors import add, add_scaled, cross, dot, scale, subtract

work_rows = Record(stride=LANES)
Y_ORIENTATION = work_rows.quaternion('-', 'q at the start of the step')
Y_RATE = work_rows.vector('rad/s', 'omega at the start of the step, body axes')
ROWS_END = work_rows.size  # where y, and a slope, end
STAGE_RATE = work_rows.vector('rad/s', 'omega of the stage, body axes')
SLOPES_AT = work_rows.size
# numbers of a slope in a block: eight more than its rows so that those of one lane do not all fall
# into the same few sets of the cache, which costs a single body a third of its time
SLOPE_SIZE = ROWS_END + 8
FEW = 8  # [body] so few of a block are taken one by one: their sums fit the registers
FOURTH = 3  # number of the last stage of `step_on_a_ladder`
LADDER_STAGES = FOURTH + 1

# bound for each tableau
STAGES = slot('[-] stages of a step')
A = slot('[-] the tableau, row by row, with its zeros')
B = slot('[-] weights of the stages')
FOR_FORCES = slot('[-] whether forces will read the state of a stage')
TOTAL = slot('[-] slope that `end` may overwrite')
LADDER = slot('[-] the entries beside the diagonal, before each of LADDER_STAGES stages')
WEIGHTS = slot('[-] weights of LADDER_STAGES stages')
ERROR = slot('[-] weights of the slopes in the error of a pair')
move_stage = slot('kernel (stage, lanes, h, state, work): makes the state of a stage')
end_step = slot('kernel (lanes, h, state, work, memory): makes the state after the step')


@inline
def _added(q, factor, change):
    """Return q + factor times its change."""
    x, y, z, w = q
    dx, dy, dz, dw = change
    return x + factor * dx, y + factor * dy, z + factor * dz, w + factor * dw


@inline
def _scaled(factor, q):
    """Return factor q."""
    x, y, z, w = q
    return factor * x, factor * y, factor * z, factor * w


@inline
def _rate(lane, state):
    """Omega of a state, body axes: I^-1 R^T L."""
    orientation = read_quaternion(state, lane + ORIENTATION)
    momentum = rotated_back(orientation, read_vector(state, lane + ANGULAR_MOMENTUM))
    return multiply(momentum, read_vector(state, lane + INVERSE_MOMENTS))


@inline
def _unit(q):
    """Normalise to the last bit or two."""
    return nearly_normalised(normalised(q))


@inline
def _gyroscopic(moments, rate):
    """Omega x I omega in principal axes."""
    return (
        (moments[2] - moments[1]) * rate[1] * rate[2],
        (moments[0] - moments[2]) * rate[2] * rate[0],
        (moments[1] - moments[0]) * rate[0] * rate[1],
    )


@inline
def _slope(q, rate, torque, moments, inverses):
    """q' = q (omega, 0) / 2 and omega' = I^-1 (R^T torque - omega x I omega), q of unit length."""
    x, y, z, w = q
    axis = (x, y, z)
    change = scale(0.5, add(scale(w, rate), cross(axis, rate)))
    applied, gyroscopic = rotated_back(q, torque), _gyroscopic(moments, rate)
    return (
        (change[0], change[1], change[2], -0.5 * dot(axis, rate)),
        multiply(subtract(applied, gyroscopic), inverses),
    )


@inline
def begin(lanes, state, work, memory):
    """Start a step: y = (q, omega)."""
    for lane in range(lanes):
        rate = _rate(lane, state)
        write_quaternion(work, lane + Y_ORIENTATION, read_quaternion(state, lane + ORIENTATION))
        write_vector(work, lane + Y_RATE, rate)
        write_vector(work, lane + STAGE_RATE, rate)


@inline
def renew(lanes, state, work):
    """Write omega of the state, for the slope there: the same bits that `begin` would write."""
    for lane in range(lanes):
        write_vector(work, lane + STAGE_RATE, _rate(lane, state))


@inline
def _set_state(lane, state, orientation, rate):
    """Write q, and L = R I omega for the forces to read."""
    write_quaternion(state, lane + ORIENTATION, orientation)
    momentum = multiply(read_vector(state, lane + MOMENTS), rate)
    write_vector(state, lane + ANGULAR_MOMENTUM, rotated(orientation, momentum))


@inline
def _move_lane(lane, stage, h, state, work, tableau, stages, for_forces):
    """Make the state of a stage of one body, the sums in registers."""
    orientation = read_quaternion(work, lane + Y_ORIENTATION)
    rate = read_vector(work, lane + Y_RATE)
    for before in range(stage):
        factor = h * tableau[stage * stages + before]
        if factor != 0.0:
            place = SLOPES_AT + SLOPE_SIZE * before + lane
            orientation = _added(orientation, factor, read_quaternion(work, place + Y_ORIENTATION))
            rate = add_scaled(rate, factor, read_vector(work, place + Y_RATE))
    write_vector(work, lane + STAGE_RATE, rate)
    if for_forces:
        _set_state(lane, state, nearly_normalised(orientation), rate)
    else:
        write_quaternion(state, lane + ORIENTATION, orientation)


@inline
def _move_by(lanes, factor, work, start, slope, state):
    """Add factor K to y, or to what was made of it before."""
    stage_rate = work[STAGE_RATE - Y_RATE :]
    if start:
        add_rows(lanes, Y_ORIENTATION, Y_RATE, work, factor, slope, state)
        add_rows(lanes, Y_RATE, ROWS_END, work, factor, slope, stage_rate)
    else:
        add_rows(lanes, Y_ORIENTATION, Y_RATE, state, factor, slope, state)
        add_rows(lanes, Y_RATE, ROWS_END, stage_rate, factor, slope, stage_rate)


def move(stage, lanes, h, state, work):
    """Make the state of a stage from the slopes of those before it."""
    if lanes < FEW:
        for lane in range(lanes):
            _move_lane(lane, stage, h, state, work, A, STAGES, FOR_FORCES)
    else:
        start = True
        for before in range(stage):
            factor = h * A[stage * STAGES + before]
            if factor != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * before :]
                _move_by(lanes, factor, work, start, slope, state)
                start = False
        if FOR_FORCES:
            for lane in range(lanes):
                orientation = nearly_normalised(read_quaternion(state, lane + ORIENTATION))
                _set_state(lane, state, orientation, read_vector(work, lane + STAGE_RATE))


@inline
def _write_slope(lane, orientation, state, work, slope):
    """Write the slope of the state of a stage of one body."""
    change, acceleration = _slope(
        orientation,
        read_vector(work, lane + STAGE_RATE),
        read_vector(state, lane + TORQUE),
        read_vector(state, lane + MOMENTS),
        read_vector(state, lane + INVERSE_MOMENTS),
    )
    write_quaternion(slope, lane + Y_ORIENTATION, change)
    write_vector(slope, lane + Y_RATE, acceleration)


@inline
def slope_of(lanes, state, work, slope):
    """Slope of a stage whose q has unit length."""
    for lane in range(lanes):
        _write_slope(lane, read_quaternion(state, lane + ORIENTATION), state, work, slope)


@inline
def _slope_of_scaled(lanes, state, work, slope):
    """Slope of a stage whose q is about of unit length."""
    for lane in range(lanes):
        orientation = nearly_normalised(read_quaternion(state, lane + ORIENTATION))
        _write_slope(lane, orientation, state, work, slope)


@inline
def _finish(lane, h, state, work, change, acceleration):
    """y + h K of one body, q normalised, L rebuilt."""
    orientation = _added(read_quaternion(work, lane + Y_ORIENTATION), h, change)
    rate = add_scaled(read_vector(work, lane + Y_RATE), h, acceleration)
    _set_state(lane, state, _unit(orientation), rate)


def end(lanes, h, state, work, memory):
    """y + h sum b K, q normalised, L rebuilt."""
    if lanes < FEW:
        for lane in range(lanes):
            change, acceleration = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for stage in range(STAGES):
                weight = B[stage]
                if weight != 0.0:
                    place = SLOPES_AT + SLOPE_SIZE * stage + lane
                    change = _added(change, weight, read_quaternion(work, place + Y_ORIENTATION))
                    acceleration = add_scaled(
                        acceleration, weight, read_vector(work, place + Y_RATE)
                    )
            _finish(lane, h, state, work, change, acceleration)
    else:
        total = work[SLOPES_AT + SLOPE_SIZE * TOTAL :]
        scale_rows(lanes, Y_ORIENTATION, ROWS_END, B[0], work[SLOPES_AT:], total)
        for stage in range(1, STAGES):
            if B[stage] != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * stage :]
                add_rows(lanes, Y_ORIENTATION, ROWS_END, total, B[stage], slope, total)
        for lane in range(lanes):
            change = read_quaternion(total, lane + Y_ORIENTATION)
            _finish(lane, h, state, work, change, read_vector(total, lane + Y_RATE))


@inline
def _slope_on(start, rate, factor, change, acceleration, torque, moments, inverses):
    """Slope at the start of the step + factor times a slope."""
    orientation = nearly_normalised(_added(start, factor, change))
    rate = add_scaled(rate, factor, acceleration)
    return _slope(orientation, rate, torque, moments, inverses)


def step_on_a_ladder(lanes, h, state, work):
    """
    Step free or steadily torqued rotations by a tableau in which each stage builds on the one
    before it alone.

    Up to four stages (Euler, midpoint, the classical method) in registers: three times as fast as
    through `work`.
    """
    for lane in range(lanes):
        torque, moments = read_vector(state, lane + TORQUE), read_vector(state, lane + MOMENTS)
        inverses = read_vector(state, lane + INVERSE_MOMENTS)
        start, rate = read_quaternion(state, lane + ORIENTATION), _rate(lane, state)
        change, acceleration = _slope(nearly_normalised(start), rate, torque, moments, inverses)
        changes, accelerations = _scaled(B[0], change), scale(B[0], acceleration)
        if STAGES > 1:
            change, acceleration = _slope_on(
                start, rate, h * LADDER[1], change, acceleration, torque, moments, inverses
            )
            changes = _added(changes, WEIGHTS[1], change)
            accelerations = add_scaled(accelerations, WEIGHTS[1], acceleration)
        if STAGES > 2:
            change, acceleration = _slope_on(
                start, rate, h * LADDER[2], change, acceleration, torque, moments, inverses
            )
            changes = _added(changes, WEIGHTS[2], change)
            accelerations = add_scaled(accelerations, WEIGHTS[2], acceleration)
        if STAGES > FOURTH:
            change, acceleration = _slope_on(
                start, rate, h * LADDER[FOURTH], change, acceleration, torque, moments, inverses
            )
            changes = _added(changes, WEIGHTS[FOURTH], change)
            accelerations = add_scaled(accelerations, WEIGHTS[FOURTH], acceleration)
        rate = add_scaled(rate, h, accelerations)
        _set_state(lane, state, _unit(_added(start, h, changes)), rate)


def step(lanes, h, state, work):
    """Step free or steadily torqued rotations by any tableau."""
    begin(lanes, state, work, work[:0])
    for stage in range(STAGES):
        if stage > 0:
            move_stage(stage, lanes, h, state, work)
        _slope_of_scaled(lanes, state, work, work[SLOPES_AT + SLOPE_SIZE * stage :])
    end_step(lanes, h, state, work, work[:0])


@inline
def keep(lanes, state, memory, kept):
    """Keep q and L."""
    for lane in range(lanes):
        write_quaternion(kept, lane + ORIENTATION, read_quaternion(state, lane + ORIENTATION))
        momentum = read_vector(state, lane + ANGULAR_MOMENTUM)
        write_vector(kept, lane + ANGULAR_MOMENTUM, momentum)


@inline
def restore(lanes, kept, state, work):
    """Return to the start of the substep."""
    for lane in range(lanes):
        write_quaternion(state, lane + ORIENTATION, read_quaternion(kept, lane + ORIENTATION))
        momentum = read_vector(kept, lane + ANGULAR_MOMENTUM)
        write_vector(state, lane + ANGULAR_MOMENTUM, momentum)


def error_of(lanes, h, state, work, tolerances, first, worst, culprit):
    """
    Largest error of q, whose length is one, and of omega in body axes of the bodies of a block
    relative to the tolerances, and whose.
    """
    rtol, atol = tolerances
    for lane in range(lanes):
        change, acceleration = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for stage in range(STAGES + 1):
            place = SLOPES_AT + SLOPE_SIZE * stage + lane
            change = _added(change, ERROR[stage], read_quaternion(work, place + Y_ORIENTATION))
            acceleration = add_scaled(
                acceleration, ERROR[stage], read_vector(work, place + Y_RATE)
            )
        x, y, z, w = change
        error = larger(
            h * math.sqrt(x * x + y * y + z * z + w * w) / (atol + rtol),
            relative_error(
                h, acceleration, read_vector(work, lane + Y_RATE),
                read_vector(work, lane + STAGE_RATE), tolerances,
            ),
        )  # fmt: skip
        if error > worst or error != error:
            worst, culprit = error, first + lane
    return worst, culprit


QUATERNIONS = StateSpace(
    state_size=ROTATION,
    memory_size=0,
    slopes_at=SLOPES_AT,
    slope_size=SLOPE_SIZE,
    begin=begin,
    move=move,
    slope_of=slope_of,
    end=end,
    control=ErrorControl(renew=renew, keep=keep, restore=restore, error_of=error_of),
)
