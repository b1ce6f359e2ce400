# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ticks of a scene with contact: the kernel is called, and what it returns for is done, until all
have passed.

    as long as ticks are left
        call the kernel
        take what it has listed: impacts, deep overlaps
        where it has returned early: a tick that is cut (`cut_ticks`), or an answer (`pieces`)

The usual tick is one call and a few looks at numbers: all of it costs a third of a tick with one
box on the ground.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rigid_body_sim.physics.compile.kernel import WITHOUT
from rigid_body_sim.physics.compile.kernels import COMPILED, prepared
from rigid_body_sim.physics.compile.side_by_side import threads
from rigid_body_sim.physics.contact import tick_counts, tick_world
from rigid_body_sim.physics.contact.collision import deep_overlaps
from rigid_body_sim.physics.contact.cut_ticks import CutTicks, Tick
from rigid_body_sim.physics.contact.helpers import Helpers
from rigid_body_sim.physics.contact.island_ticks import Motion
from rigid_body_sim.physics.contact.pieces import Call, Pieces
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_readout import WorldReadout

# bodies from which on other threads may help; fewer are one group of islands (`solver_groups`),
# and to begin a thread costs 30 us
WORTH_HELP = 400


class Ticks:
    """Lets ticks of one scene pass."""

    def __init__(
        self, body_count: int, arrays: WorldArrays, readout: WorldReadout, pieces: Pieces,
        cut_ticks: CutTicks,
    ) -> None:  # fmt: skip
        self._body_count = body_count
        self._arrays = arrays
        self._readout = readout
        self._pieces = pieces
        self._cut_ticks = cut_ticks
        self._has_events = readout.has_events
        self._helpers = Helpers(arrays.board)
        # seen through these, a number is Python's own: numpy makes one of its own of each
        self._counts = memoryview(arrays.counts)
        self._overlaps: Any = memoryview(arrays.overlaps)

    def rest(self) -> None:
        """Wait until no thread works: see `helpers`."""
        self._helpers.rest()

    def of_kernel(self, compiled: Callable[..., Any], *, apart: bool) -> Callable[..., Any]:
        """
        Give a kernel of the ticks the call of a scheme; its workspace is not needed.

        apart : whether several threads have something to do
        """

        def prepare(_first: Sequence[Any], last: Sequence[Any]) -> Callable[..., float]:
            *of_motion, _workspace, elements, ranges = last
            call = self._call_of(compiled, of_motion, elements, ranges, apart=apart)
            return partial(self._advance, call, (of_motion[2], of_motion[3]))

        def advance(ticks: int, tick: float, h: float, *last: Any) -> float:
            return prepare((), last)(ticks, tick, h)

        setattr(advance, 'prepared', prepare)  # noqa: B010  # see `kernels.prepared`
        return advance

    def _call_of(
        self, compiled: Callable[..., Any], of_motion: Sequence[Any], elements: Any, ranges: Any,
        *, apart: bool,
    ) -> Call:  # fmt: skip
        """Give a kernel of the ticks its arrays, and others where these become others."""
        arrays = self._arrays
        is_worth_help = apart and self._body_count >= WORTH_HELP
        # version, its arrays, the kernel with them, and with those of who helps
        made: list[Any] = [-1, None, compiled, []]

        def call(ticks: int, tick: float, h: float) -> float:
            if made[0] != arrays.version:
                world, first = arrays.world(of_motion, elements, ranges), (ticks, tick, h)
                helpers = self._helpers_of(compiled, first, world) if is_worth_help else []
                made[1:] = world, prepared(compiled, first, (world,)), helpers
                made[0] = arrays.version
            if made[3] and ticks > 0:
                status = self._helpers.go(made[2], made[3], (ticks, tick, h))
            else:
                status = made[2](ticks, tick, h)
            if status is NotImplemented:  # a tick of another kind
                status = compiled(ticks, tick, h, made[1])
            return status

        return call

    def _helpers_of(
        self, compiled: Callable[..., Any], first: Sequence[Any], world: tick_world.World
    ) -> list[Callable[..., Any]]:
        """Give a kernel to each thread that may help, with arrays of its own; first: arguments."""
        if not COMPILED or WITHOUT:
            return []
        return [
            prepared(compiled, first, (self._arrays.world_of_helper(world),))
            for _ in range(threads() - 1)
        ]

    def _advance(self, call: Call, motion: Motion, ticks: int, tick: float, h: float) -> float:
        """
        Call the kernel, and do what it returns for, until all ticks are done; its status.

        motion  : blocks of translation and rotation
        tick, h : number of the first, in ticks of a length [s]
        """
        counts, readout = self._counts, self._readout
        if self._has_events:  # its pieces begin anywhere
            tick = float(tick)
        done = 0
        while True:
            status = call(ticks - done, tick + done, h)
            if counts[tick_counts.IMPACTS]:
                readout.take_impacts(h)
            if self._overlaps[deep_overlaps.COUNT]:
                readout.take_overlaps()
            if counts[tick_counts.DONE]:
                done += counts[tick_counts.DONE]
                readout.ticks_passed(tick + done - 1, h)
            why = counts[tick_counts.STATUS]
            if why == tick_counts.COMPLETE or status != 0.0:
                return status
            if why == tick_counts.TOO_LONG:
                status = self._cut_ticks.advance_fast(Tick(call, tick + done, h, motion))
                readout.number_tick(tick + done, h)
                done += 1
            elif why == tick_counts.CUT:
                status = self._cut_ticks.advance_by_impacts(Tick(call, tick + done, h, motion))
                readout.number_tick(tick + done, h)
                done += 1
            else:
                self._pieces.answer(h)
            if status != 0.0 or done == ticks:
                return status
