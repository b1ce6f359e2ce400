# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The state space of points: r' = p / m, p' = F.

y and each slope hold r and p in the rows where the state has them, RX to PZ.
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
from rigid_body_sim.physics.state.blocks import EX, FX, GX, IM, PX, RX, TRANSLATION
from rigid_body_sim.physics.vectors import add_scaled, scale

ROWS_END = EX  # where the rows of r and p end
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
        write_vector(work, lane + RX, read_vector(state, lane + RX))
        write_vector(work, lane + PX, read_vector(state, lane + PX))


def move(stage, lanes, h, state, work):
    """Make the state of a stage from the slopes of those before it."""
    if lanes < FEW:
        for lane in range(lanes):
            position, momentum = read_vector(work, lane + RX), read_vector(work, lane + PX)
            for before in range(stage):
                factor = h * A[stage * STAGES + before]
                if factor != 0.0:
                    place = SLOPES_AT + SLOPE_SIZE * before + lane
                    position = add_scaled(position, factor, read_vector(work, place + RX))
                    momentum = add_scaled(momentum, factor, read_vector(work, place + PX))
            write_vector(state, lane + RX, position)
            write_vector(state, lane + PX, momentum)
    else:
        start = True
        for before in range(stage):
            factor = h * A[stage * STAGES + before]
            if factor != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * before :]
                if start:
                    add_rows(lanes, RX, ROWS_END, work, factor, slope, state)
                else:
                    add_rows(lanes, RX, ROWS_END, state, factor, slope, state)
                start = False


@inline
def slope_of(lanes, state, work, slope):
    """Slope of a stage."""
    for lane in range(lanes):
        write_vector(slope, lane + RX, scale(state[lane + IM], read_vector(state, lane + PX)))
        write_vector(slope, lane + PX, read_vector(state, lane + FX))


@inline
def _finish(lane, h, state, work, velocity, force):
    """y + h K of one body."""
    add_to_vector(state, lane + RX, lane + EX, read_vector(work, lane + RX), scale(h, velocity))
    add_to_vector(state, lane + PX, lane + GX, read_vector(work, lane + PX), scale(h, force))


def end(lanes, h, state, work, memory):
    """y + h sum b K."""
    if lanes < FEW:
        for lane in range(lanes):
            velocity = force = NONE
            for stage in range(STAGES):
                weight = B[stage]
                if weight != 0.0:
                    place = SLOPES_AT + SLOPE_SIZE * stage + lane
                    velocity = add_scaled(velocity, weight, read_vector(work, place + RX))
                    force = add_scaled(force, weight, read_vector(work, place + PX))
            _finish(lane, h, state, work, velocity, force)
    else:
        total = work[SLOPES_AT + SLOPE_SIZE * TOTAL :]
        scale_rows(lanes, RX, ROWS_END, B[0], work[SLOPES_AT:], total)
        for stage in range(1, STAGES):
            if B[stage] != 0.0:
                slope = work[SLOPES_AT + SLOPE_SIZE * stage :]
                add_rows(lanes, RX, ROWS_END, total, B[stage], slope, total)
        for lane in range(lanes):
            velocity, force = read_vector(total, lane + RX), read_vector(total, lane + PX)
            _finish(lane, h, state, work, velocity, force)


def step_under_held_force(lanes, h, state, work):
    """
    Step points under a constant force: the tableau summed by hand.

    r <- r + h p/m + h^2 (sum b_i c_i) F/m,   p <- p + h F
    """
    for lane in range(lanes):
        over_mass = h * state[lane + IM]
        position, momentum = read_vector(state, lane + RX), read_vector(state, lane + PX)
        force = read_vector(state, lane + FX)
        moved = scale(over_mass, add_scaled(momentum, h * BC, force))
        add_to_vector(state, lane + RX, lane + EX, position, moved)
        add_to_vector(state, lane + PX, lane + GX, momentum, scale(h, force))


@inline
def renew(lanes, state, work):
    """Leave all as it is: a slope needs the state alone."""


@inline
def keep(lanes, state, memory, kept):
    """Keep what rounding lost; r and p are in y."""
    copy_rows(lanes, RX, ROWS_END, state[EX:], kept)


@inline
def restore(lanes, kept, state, work):
    """Return to the start of the substep."""
    copy_rows(lanes, RX, ROWS_END, work, state)
    copy_rows(lanes, RX, ROWS_END, kept, state[EX:])


def error_of(lanes, h, state, work, tolerances, first, worst, culprit):
    """Largest error of r and p of the bodies of a block relative to the tolerances, and whose."""
    for lane in range(lanes):
        velocity = force = NONE
        for stage in range(STAGES + 1):
            place = SLOPES_AT + SLOPE_SIZE * stage + lane
            velocity = add_scaled(velocity, ERROR[stage], read_vector(work, place + RX))
            force = add_scaled(force, ERROR[stage], read_vector(work, place + PX))
        error = larger(
            relative_error(
                h,
                velocity,
                read_vector(work, lane + RX),
                read_vector(state, lane + RX),
                tolerances,
            ),
            relative_error(
                h, force, read_vector(work, lane + PX), read_vector(state, lane + PX), tolerances
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
