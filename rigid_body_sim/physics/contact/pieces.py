# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pieces of a tick that is cut, each a tick of its own to the kernel; and what Python does where
the kernel returns early.

    a list is too short      it grows
    islands wake or fall     their impulses move into the impulse cache, or out of it
    asleep

However a tick is cut, contacts stay as soft as in the whole one, and the next tick starts from the
impulses of no short piece: a cut does not move what rests.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.islands.manners import Read
from rigid_body_sim.physics.contact.readout import together
from rigid_body_sim.physics.contact.solver.cache_entries import scaled
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_readout import WorldReadout
from rigid_body_sim.physics.state.contacts import NO_CONTACTS

Array = NDArray[np.float64]
Call = Callable[[int, float, float], float]  # ticks, number of the first, length [s] -> status

AT_ONCE = 64  # [-] pieces whose contacts are kept apart; more take memory, fewer take time
# [-] of the longest piece of a tick: what noise a shorter one leaves in its impulses would be
# scaled up with them, and throw up what rests
SHORT = 0.25
NOTHING_READ: Read = NO_CONTACTS, np.zeros((0, 2))


class Pieces:
    """Lets the pieces of a tick pass, and answers the kernel of one scene."""

    def __init__(self, arrays: WorldArrays, sleepers: Any, readout: WorldReadout) -> None:
        self._arrays = arrays
        self._sleepers = sleepers  # None where nobody may sleep
        self._readout = readout
        self._has_woken = False  # whether somebody has in the piece under way

    def in_pieces(
        self, h: float, lengths: Sequence[float], advance: Callable[[int], float]
    ) -> float:
        """
        Advance over the pieces of one tick, and read the contacts of each before the next one
        writes over them.

        h       : [s] of the tick
        lengths : [s] of the pieces
        advance : advances over the piece of a number, and returns the status
        returns : the last status
        """
        was_piece = self.begin_cut()
        least = SHORT * max(lengths)
        reads: list[Read] = []
        status = 0.0
        for number, length in enumerate(lengths):
            cache = self.begin_piece(is_short=length < least)
            status = advance(number)
            if status != 0.0:
                break
            reads += self._readout.reads()
            self.end_piece(cache)
            if len(reads) >= AT_ONCE:
                reads = [together(reads)]
        self.end_cut(was_piece, h, reads)
        return status

    def begin_cut(self) -> int:
        """Let each call of the kernel be a piece of a tick; return whether it was one before."""
        counts = self._arrays.counts
        was_piece, counts[tick_counts.PIECE] = int(counts[tick_counts.PIECE]), 1
        return was_piece

    def end_cut(self, was_piece: int, h: float, reads: list[Read]) -> None:
        """End a tick [s] in pieces: the impulses in the cache become those of a whole one."""
        arrays = self._arrays
        arrays.counts[tick_counts.PIECE] = was_piece
        arrays.put_cache(scaled(arrays.cache_in_use, arrays.substep_of(h)))
        self._readout.take_pieces([together(reads) if reads else NOTHING_READ], h)

    def begin_piece(self, *, is_short: bool = True) -> Array | None:
        """Begin a piece; return the impulse cache, which a short one leaves as it found it."""
        self._has_woken = False
        return self._arrays.cache_in_use.copy() if is_short else None

    def end_piece(self, cache: Array | None) -> None:
        """End a piece; cache: what a short one began with, to which it returns."""
        if cache is not None and not self._has_woken:
            self._arrays.put_cache(cache)

    def until_done(
        self, call: Call, number: float, length: float, *, tick: float, h: float, begin: float
    ) -> float | None:
        """
        Call the kernel until a piece is done; return the status, None: it is to be cut itself.

        number  : of the piece, as if all before were as long
        length  : [s]
        tick, h : number and length [s] of the tick that it is of
        begin   : [s] where it begins in the tick
        """
        counts, readout = self._arrays.counts, self._readout
        while True:
            status = call(1, number, length)
            readout.take_impacts(h, tick, begin)
            readout.take_overlaps()
            if status != 0.0 or counts[tick_counts.DONE]:
                readout.piece_passed()
                return status
            if counts[tick_counts.STATUS] in (tick_counts.CUT, tick_counts.TOO_LONG):
                return None
            self.answer(length)

    def answer(self, h: float) -> None:
        """
        Do what the kernel returned for, in a tick of a length [s]: let a list grow, or put in
        order who sleeps.
        """
        arrays = self._arrays
        status = arrays.counts[tick_counts.STATUS]
        if status == tick_counts.WOKEN:
            arrays.put_cache(self._sleepers.wake(arrays.cache_in_use))
            self._has_woken = True
        elif status == tick_counts.FELL_ASLEEP:
            self._let_sleep(h)
        else:
            arrays.grow()
            return
        arrays.counts[tick_counts.SLEEP_CHANGED] = 1

    def _let_sleep(self, h: float) -> None:
        """Let sleepers keep the contacts of who fell asleep in the last tick of length h [s]."""
        arrays = self._arrays
        cache, manifolds = self._sleepers.fall_asleep(
            arrays.cache_in_use,
            table=arrays.table,
            manifolds=arrays.manifolds_in_use,
            h=h,
            read=lambda manifolds: self._readout.read(manifolds)[0],
        )
        arrays.put_cache(cache)
        arrays.put_manifolds(manifolds)
