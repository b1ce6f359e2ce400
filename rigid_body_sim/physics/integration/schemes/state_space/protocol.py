# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a Runge–Kutta scheme asks of a state space: the kernels that begin a step, move to a stage,
take its slope and end the step, for one block of bodies.

    y     : state at the start of the step
    K_j   : slopes of the stages
    Y_i   = y + h sum_{j < i} a_ij K_j        state of stage i
    y     <- y + h sum_i b_i K_i              end of the step

Arguments:
    lanes  : bodies in the block
    state  : the block, see `state.blocks`; forces read it and write their sums into it
    work   : workspace of the block: y, then the slopes from `slopes_at` on, `slope_size` numbers
             each
    memory : the part of the state that the block does not hold, `memory_size` numbers
    kept   : room of a slope for what `ErrorControl.keep` keeps

A kernel may be a plain function that names slots (the tableau, the number of stages): `bound`
binds them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rigid_body_sim.physics.compile.kernels import plain, slots_of, specialise

Kernel = Callable[..., Any]


@dataclass(frozen=True)
class ErrorControl:
    """
    What step size control needs of a state space.

    renew    : kernel (lanes, state, work): makes the state after `end` that of a stage, for its
               slope
    keep     : kernel (lanes, state, memory, kept): keeps what `work` does not hold of the state
               at the start of a substep, right after `begin`
    restore  : kernel (lanes, kept, state, work): returns to the start of a refused substep
    error_of : kernel (lanes, h, state, work, tolerances, first, worst, culprit) -> (worst,
               culprit): the largest error of a body of the block relative to the tolerances (rtol,
               atol), and whose it is; or what was before where that is larger. `first` is the
               index of the body in the first lane
    """

    renew: Kernel
    keep: Kernel
    restore: Kernel
    error_of: Kernel


@dataclass(frozen=True)
class StateSpace:
    """
    One state space.

    state_size  : numbers of a block of the state
    memory_size : numbers of a block of `memory`
    slopes_at   : where the slopes begin in the workspace of a block
    slope_size  : numbers of a slope in a block
    begin       : kernel (lanes, state, work, memory): y is the state
    move        : kernel (stage, lanes, h, state, work): the state is that of a stage
    slope_of    : kernel (lanes, state, work, slope): slope of the state of a stage
    end         : kernel (lanes, h, state, work, memory): the state is that after the step; may
                  overwrite the slope TOTAL
    control     : what an embedded pair needs; None where there is none
    """

    state_size: int
    memory_size: int
    slopes_at: int
    slope_size: int
    begin: Kernel
    move: Kernel
    slope_of: Kernel
    end: Kernel
    control: ErrorControl | None = None

    def work_size(self, slopes: int) -> int:
        """Count the numbers of the workspace of a block."""
        return self.slopes_at + self.slope_size * slopes


def bound(function: Kernel, *, name: str, offered: Mapping[str, Any]) -> Kernel:
    """
    Bind the slots of a kernel of a state space, to be compiled into its caller.

        offered : constants of a tableau; a kernel without slots needs none and is returned as it
                  is
    """
    source = plain(function)
    if not slots_of(source):
        return function
    return specialise(source, name=name, inlined=True, offered=offered)
