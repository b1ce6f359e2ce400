# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The state space of points: r' = p / m, p' = F.

y and each slope hold r and p in the rows where the state has them, POSITION to PZ.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.integration.schemes.state_space.lanes import (
    add_rows,
    add_to_vector,
    copy_rows,
    read_vector,
    scale_rows,
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
    FORCE,
    INVERSE_MASS,
    LANES,
    MOMENTUM,
    MOMENTUM_RESIDUAL,
    POSITION,
    POSITION_RESIDUAL,
    TRANSLATION,
    add_compensated,
)
from rigid_body_sim.physics.vectors import add_scaled, scale

ROWS_END = POSITION_RESIDUAL  # where the rows of r and p end
# numbers of y, and of a slope, in a block: eight more than r and p so that the rows of one lane do
# not all fall into the same few sets of the cache, which costs a single body a third of its time
SLOPE_SIZE = ROWS_END + 8
SLOPES_AT = SLOPE_SIZE
FEW = 8  # [body] so few of a block are taken one by one: their sums fit the registers
NONE = (0.0, 0.0, 0.0)

# bound for each tableau
STAGES = slot('[-] stages of a step')
A = slot('[-] the tableau, row by row, with its zeros')
B = slot('[-] weights of the stages')
TOTAL = slot('[-] slope that `end` may overwrite')
BC = slot('[-] sum of b c')
ERROR = slot('[-] weights of the slopes in the error of a pair')


@inline
def begin(lanes, state, work, memory):
    """Start a step: y = (r, p)."""
    for lane in range(lanes):
        write_vector(work, lane + POSITION, read_vector(state, lane + POSITION))
        write_vector(work, lane + MOMENTUM, read_vector(state, lane + MOMENTUM))


def move(stage, lanes, h, state, work):
    """Make the state of a stage from the slopes of those before it."""
    if lanes < FEW:
        for lane in range(lanes):
            position = read_vector(work, lane + POSITION)
            momentum = read_vector(work, lane + MOMENTUM)
            for before in range(stage):
                factor = h * A[stage * STAGES + before]
                if factor != 0.0:
                    place = SLOPES_AT + SLOPE_SIZE * before + lane
                    position = add_scaled(position, factor, read_vector(work, place + POSITION))
                    momentum = add_scaled(momentum, factor, read_vector(work, place + MOMENTUM))
            write_vector(state, lane + POSITION, position)
            write_vector(state, lane + MOMENTUM, momentum)
    else:
        start = True
        for before in range(stage):
            factor = h * A[stage * STAGES + before]
            if factor != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * before :]
                if start:
                    add_rows(lanes, POSITION, ROWS_END, work, factor, slope, state)
                else:
                    add_rows(lanes, POSITION, ROWS_END, state, factor, slope, state)
                start = False


@inline
def slope_of(lanes, state, work, slope):
    """Slope of a stage."""
    for lane in range(lanes):
        write_vector(
            slope,
            lane + POSITION,
            scale(state[lane + INVERSE_MASS], read_vector(state, lane + MOMENTUM)),
        )
        write_vector(slope, lane + MOMENTUM, read_vector(state, lane + FORCE))


@inline
def _finish(lane, h, state, work, velocity, force):
    """y + h K of one body."""
    add_to_vector(
        state,
        lane + POSITION,
        lane + POSITION_RESIDUAL,
        read_vector(work, lane + POSITION),
        scale(h, velocity),
    )
    add_to_vector(
        state,
        lane + MOMENTUM,
        lane + MOMENTUM_RESIDUAL,
        read_vector(work, lane + MOMENTUM),
        scale(h, force),
    )


def end(lanes, h, state, work, memory):
    """y + h sum b K."""
    if lanes < FEW:
        for lane in range(lanes):
            velocity = force = NONE
            for stage in range(STAGES):
                weight = B[stage]
                if weight != 0.0:
                    place = SLOPES_AT + SLOPE_SIZE * stage + lane
                    velocity = add_scaled(velocity, weight, read_vector(work, place + POSITION))
                    force = add_scaled(force, weight, read_vector(work, place + MOMENTUM))
            _finish(lane, h, state, work, velocity, force)
    else:
        total = work[SLOPES_AT + SLOPE_SIZE * TOTAL :]
        scale_rows(lanes, POSITION, ROWS_END, B[0], work[SLOPES_AT:], total)
        for stage in range(1, STAGES):
            if B[stage] != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * stage :]
                add_rows(lanes, POSITION, ROWS_END, total, B[stage], slope, total)
        for lane in range(lanes):
            velocity, force = (
                read_vector(total, lane + POSITION),
                read_vector(total, lane + MOMENTUM),
            )
            _finish(lane, h, state, work, velocity, force)


@inline
def _step_component(place, h, time_per_mass, delay, state):
    """Step one component of a body under a constant force."""
    momentum, force = state[place + MOMENTUM], state[place + FORCE]
    state[place + POSITION], state[place + POSITION_RESIDUAL] = add_compensated(
        state[place + POSITION],
        state[place + POSITION_RESIDUAL],
        time_per_mass * (momentum + delay * force),
    )
    state[place + MOMENTUM], state[place + MOMENTUM_RESIDUAL] = add_compensated(
        momentum, state[place + MOMENTUM_RESIDUAL], h * force
    )


def step_under_held_force(lanes, h, state, work):
    """
    Step points under a constant force: the tableau summed by hand.

    r <- r + h p/m + h^2 (sum b_i c_i) F/m,   p <- p + h F
    """
    delay = h * BC
    for lane in range(lanes):
        time_per_mass = h * state[lane + INVERSE_MASS]
        _step_component(lane, h, time_per_mass, delay, state)
        _step_component(lane + LANES, h, time_per_mass, delay, state)
        _step_component(lane + 2 * LANES, h, time_per_mass, delay, state)


@inline
def renew(lanes, state, work):
    """Leave all as it is: a slope needs the state alone."""


@inline
def keep(lanes, state, memory, kept):
    """Keep what rounding lost; r and p are in y."""
    copy_rows(lanes, POSITION, ROWS_END, state[POSITION_RESIDUAL:], kept)


@inline
def restore(lanes, kept, state, work):
    """Return to the start of the substep."""
    copy_rows(lanes, POSITION, ROWS_END, work, state)
    copy_rows(lanes, POSITION, ROWS_END, kept, state[POSITION_RESIDUAL:])


def error_of(lanes, h, state, work, tolerances, first, worst, culprit):
    """Largest error of r and p of the bodies of a block relative to the tolerances, and whose."""
    for lane in range(lanes):
        velocity = force = NONE
        for stage in range(STAGES + 1):
            place = SLOPES_AT + SLOPE_SIZE * stage + lane
            velocity = add_scaled(velocity, ERROR[stage], read_vector(work, place + POSITION))
            force = add_scaled(force, ERROR[stage], read_vector(work, place + MOMENTUM))
        error = larger(
            relative_error(
                h,
                velocity,
                read_vector(work, lane + POSITION),
                read_vector(state, lane + POSITION),
                tolerances,
            ),
            relative_error(
                h,
                force,
                read_vector(work, lane + MOMENTUM),
                read_vector(state, lane + MOMENTUM),
                tolerances,
            ),
        )
        if error > worst or error != error:
            worst, culprit = error, first + lane
    return worst, culprit


POINTS = StateSpace(
    state_size=TRANSLATION,
    memory_size=0,
    slopes_at=SLOPES_AT,
    slope_size=SLOPE_SIZE,
    begin=begin,
    move=move,
    slope_of=slope_of,
    end=end,
    control=ErrorControl(renew=renew, keep=keep, restore=restore, error_of=error_of),
)
