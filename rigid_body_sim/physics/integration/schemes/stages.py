# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The stages of a Runge–Kutta step of all bodies of one state space: the kernels of
`state_space.protocol`, block by block.

The workspace holds `WORK_SIZE` numbers for each block: y, the slopes, and for an embedded pair the
slope at the new state and room for what a refused substep goes back to.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rigid_body_sim.physics.compile.kernels import slot, specialise
from rigid_body_sim.physics.integration.schemes.state_space.lanes import copy_rows
from rigid_body_sim.physics.integration.schemes.state_space.protocol import StateSpace, bound
from rigid_body_sim.physics.state.blocks import LANES, block_count, lanes_in

# bound for each tableau
STAGES = slot('[-] stages of a step, without the slope at the new state')
# bound for each state space
STATE_SIZE = slot('[-] numbers of a block of the state')
MEMORY_SIZE = slot('[-] numbers of a block of what the state does not hold')
SLOPES_AT = slot('[-] where the slopes begin in the workspace of a block')
SLOPE_SIZE = slot('[-] numbers of a slope in a block')
WORK_SIZE = slot('[-] numbers of the workspace of a block')
begin = slot('kernel (lanes, state, work, memory): begins a step')
move = slot('kernel (stage, lanes, h, state, work): makes the state of a stage')
slope_of = slot('kernel (lanes, state, work, slope): takes the slope of a stage')
end = slot('kernel (lanes, h, state, work, memory): ends a step')
renew = slot('kernel (lanes, state, work): makes the new state that of a stage')
keep = slot('kernel (lanes, state, memory, kept): keeps the start of a substep')
restore = slot('kernel (lanes, kept, state, work): returns to the start of a substep')
begin_substep = slot('kernel (bodies, states, workspace, memories): `_begin_substep`')
error_of = slot('kernel (lanes, h, state, work, tolerances, first, worst, culprit): largest error')


def _prepare(stage, h, bodies, states, workspace, memories):
    """Make the state of a stage of all bodies."""
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        if stage == 0:
            begin(lanes, state, work, memories[block * MEMORY_SIZE : (block + 1) * MEMORY_SIZE])
        else:
            move(stage, lanes, h, state, work)


def _take_slopes(stage, bodies, states, workspace):
    """Take the slopes of a stage of all bodies from the forces that were evaluated."""
    for block in range(block_count(bodies)):
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        slope = work[SLOPES_AT + SLOPE_SIZE * stage : SLOPES_AT + SLOPE_SIZE * (stage + 1)]
        slope_of(lanes_in(block, bodies), state, work, slope)


def _finish(h, bodies, states, workspace, memories):
    """End the step of all bodies."""
    for block in range(block_count(bodies)):
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        memory = memories[block * MEMORY_SIZE : (block + 1) * MEMORY_SIZE]
        end(lanes_in(block, bodies), h, state, work, memory)


def _begin_substep(bodies, states, workspace, memories):
    """Begin a substep of all bodies."""
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        memory = memories[block * MEMORY_SIZE : (block + 1) * MEMORY_SIZE]
        begin(lanes, state, work, memory)
        keep(lanes, state, memory, work[SLOPES_AT + SLOPE_SIZE * (STAGES + 1) :])


def _prepare_substep(stage, h, bodies, states, workspace, memories):
    """
    Make the state of a stage of a substep of all bodies: stage 0 is that which it began with,
    stage STAGES that after it.
    """
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        if stage == STAGES:
            end(lanes, h, state, work, memories[block * MEMORY_SIZE : (block + 1) * MEMORY_SIZE])
            renew(lanes, state, work)
        elif stage > 0:
            move(stage, lanes, h, state, work)


def _largest_error(h, bodies, states, workspace, tolerances, worst, culprit):
    """Find the largest relative error of a substep of all bodies, and whose it is."""
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        worst, culprit = error_of(lanes, h, state, work, tolerances, LANES * block, worst, culprit)
    return worst, culprit


def _end_substep(accepted, bodies, states, workspace, memories):
    """
    Begin the next substep of all bodies with the slope at the new state as its first; or return
    all to the start of a refused one.
    """
    if accepted:
        begin_substep(bodies, states, workspace, memories)
    for block in range(block_count(bodies)):
        lanes = lanes_in(block, bodies)
        work = workspace[block * WORK_SIZE : (block + 1) * WORK_SIZE]
        if accepted:
            new = work[SLOPES_AT + SLOPE_SIZE * STAGES :]
            copy_rows(lanes, 0, SLOPE_SIZE // LANES * LANES, new, work[SLOPES_AT:])
        else:
            state = states[block * STATE_SIZE : (block + 1) * STATE_SIZE]
            kept = work[SLOPES_AT + SLOPE_SIZE * (STAGES + 1) :]
            restore(lanes, kept, state, work)


class Stages(NamedTuple):
    """
    Kernels of a Runge–Kutta step of all bodies of a state space.

    prepare     : (stage, h, bodies, states, workspace, memories)
    take_slopes : (stage, bodies, states, workspace)
    finish      : (h, bodies, states, workspace, memories)
    """

    prepare: Callable[..., Any]
    take_slopes: Callable[..., Any]
    finish: Callable[..., Any]


class Substeps(NamedTuple):
    """
    Kernels of a substep of an embedded pair of all bodies of a state space.

    begin       : (bodies, states, workspace, memories)
    prepare     : (stage, h, bodies, states, workspace, memories)
    take_slopes : (stage, bodies, states, workspace)
    error       : (h, bodies, states, workspace, tolerances, worst, culprit) -> (worst, culprit)
    end         : (accepted, bodies, states, workspace, memories)
    """

    begin: Callable[..., Any]
    prepare: Callable[..., Any]
    take_slopes: Callable[..., Any]
    error: Callable[..., Any]
    end: Callable[..., Any]


def _offered(space: StateSpace, slopes: int, name: str, tableau: Mapping[str, Any]) -> Any:
    """Give what the kernels of a space are bound to."""
    functions = {
        'begin': space.begin,
        'move': space.move,
        'slope_of': space.slope_of,
        'end': space.end,
    }
    if space.control is not None and 'ERROR' in tableau:
        functions |= {
            'renew': space.control.renew,
            'keep': space.control.keep,
            'restore': space.control.restore,
            'error_of': space.control.error_of,
        }
    return {
        'STAGES': tableau['STAGES'],
        'STATE_SIZE': space.state_size,
        'MEMORY_SIZE': space.memory_size,
        'SLOPES_AT': space.slopes_at,
        'SLOPE_SIZE': space.slope_size,
        'WORK_SIZE': space.work_size(slopes),
        **{
            key: bound(function, name=name, offered=tableau) for key, function in functions.items()
        },
    }


def stages_of(space: StateSpace, *, name: str, tableau: Mapping[str, Any]) -> Stages:
    """
    Make the kernels of a step.

        name    : of the method
        tableau : its constants by the names of slots
    """
    offered = _offered(space, tableau['STAGES'], name, tableau)

    def made(function: Any) -> Callable[..., Any]:
        return specialise(function, name=name, inlined=True, offered=offered)

    return Stages(made(_prepare), made(_take_slopes), made(_finish))


SUBSTEP_SLOPES = 2  # slopes of a pair beside those of its stages: at the new state; what is kept


def substeps_of(space: StateSpace, *, name: str, tableau: Mapping[str, Any]) -> Substeps:
    """Make the kernels of a substep of an embedded pair; as `stages_of`."""
    offered = _offered(space, tableau['STAGES'] + SUBSTEP_SLOPES, name, tableau)

    begin = specialise(_begin_substep, name=name, inlined=True, offered=offered)
    offered['begin_substep'] = begin

    def made(function: Any, *, inlined: bool) -> Callable[..., Any]:
        return specialise(function, name=name, inlined=inlined, offered=offered)

    return Substeps(
        begin,
        made(_prepare_substep, inlined=True),  # a call for each stage costs a lone body half again
        made(_take_slopes, inlined=True),
        made(_largest_error, inlined=True),
        made(_end_substep, inlined=True),
    )
