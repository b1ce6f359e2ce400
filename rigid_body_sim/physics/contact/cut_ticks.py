# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ticks that the kernel does not do as a whole.

    something is too fast    equal pieces, each a tick of its own
                             (`collision.conservative_advancement`)
    what flies meets what    to the impact, the impact, and on after it (`events.cuts`):
    the solver moves
        until the tick is over
            go on to its end; where an impact asks for a cut, to its instant, by Newton's method
            let the impact happen

Only islands that want it are cut (`island_ticks`). A tick is also cut where a force begins or ends
inside it: that does `stepper`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.events import cuts, flight_record
from rigid_body_sim.physics.contact.island_ticks import IslandTicks, Motion, Start
from rigid_body_sim.physics.contact.islands.manners import WHOLE, pairs_of, pieces_wanted
from rigid_body_sim.physics.contact.pieces import SHORT, Call, Pieces
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_readout import WorldReadout


class Tick(NamedTuple):
    """
    A tick that is to pass.

    call   : calls the kernel of the ticks
    number : of the tick, in ticks of its length
    h      : [s]
    motion : blocks of translation and rotation
    """

    call: Call
    number: float
    h: float
    motion: Motion


class CutTicks:
    """Lets ticks of one scene pass in pieces, or cut at impacts."""

    def __init__(
        self, body_count: int, arrays: WorldArrays, readout: WorldReadout, pieces: Pieces,
        islands: IslandTicks,
    ) -> None:  # fmt: skip
        self._body_count = body_count
        self._arrays = arrays
        self._readout = readout
        self._pieces = pieces
        self._islands = islands

    def advance_fast(self, tick: Tick) -> float:
        """
        Advance over one tick, in equal pieces where something fast hits something in it; return
        the status.
        """
        arrays = self._arrays
        manifolds = arrays.manifolds_in_use
        wanted = pieces_wanted(manifolds, arrays.table, self._body_count)
        islands = self._islands.islands(wanted)
        islands.join(WHOLE, pairs_of(manifolds, arrays.table))

        def advance(pieces: int) -> float | None:
            if pieces == WHOLE and self._readout.has_events:
                return self._advance_whole(tick)
            return self._advance_in_pieces(tick, pieces)

        return self._islands.advance(islands, tick.h, tick.motion, advance)

    def advance_by_impacts(self, tick: Tick) -> float:
        """
        Advance over one tick, which is cut at impacts for the islands concerned; return the
        status.
        """
        arrays, count = self._arrays, self._body_count
        islands = self._islands.islands(cuts.manners_wanted(count, arrays.event_links))
        pairs = pairs_of(arrays.manifolds_in_use, arrays.table)
        # who is whole and flies is let go before anything is: that joins nobody yet
        for manner in sorted({*islands.wanted.tolist()} - {WHOLE}):
            islands.join(manner, pairs)

        def advance(manner: int) -> float | None:
            if manner >= cuts.FIRST:
                return self._advance_cut_at_impacts(tick)
            if manner > WHOLE:
                return self._advance_in_pieces(tick, manner)
            status = self._advance_whole(tick, fine=False)
            if status is None:  # something of what was to be whole is too fast
                found, before = arrays.manifolds_in_use, islands.wanted
                wanted = pieces_wanted(found, arrays.table, count)
                islands.want(np.where(before == WHOLE, wanted, WHOLE))
                islands.join(WHOLE, pairs_of(found, arrays.table))
                if np.array_equal(islands.wanted, before):
                    return self._advance_whole(tick)
            return status

        return self._islands.advance(islands, tick.h, tick.motion, advance)

    def _advance_in_pieces(self, tick: Tick, pieces: int) -> float:
        """Advance over one tick in equal pieces; return the status."""
        counts, length = self._arrays.counts, tick.h / pieces

        def one(piece: int) -> float:
            status = self._pieces.until_done(
                tick.call, tick.number * pieces + piece, length, tick=tick.number, h=tick.h,
                begin=piece * length,
            )  # fmt: skip
            assert status is not None  # nothing asks for a cut
            return status

        counts[tick_counts.FINE] = 1
        counts[tick_counts.CUTTING] = tick_counts.LEAVES_CUTS
        status = self._pieces.in_pieces(tick.h, [length] * pieces, one)
        counts[tick_counts.FINE] = 0
        counts[tick_counts.CUTTING] = tick_counts.ASKS_FOR_CUTS
        return status

    def _advance_whole(self, tick: Tick, *, fine: bool = True) -> float | None:
        """
        Advance over a tick that is cut at impacts, if at all, for others; the status, or None: see
        `_piece`.
        """
        status = self._piece(tick, 0.0, tick.h, tick_counts.HIDES_CUTS, fine=fine)
        if status is not None:
            self._readout.take_pieces([self._readout.read_now()], tick.h)
        return status

    def _piece(
        self, tick: Tick, begin: float, length: float, cutting: int, *, fine: bool = True
    ) -> float | None:
        """
        Advance over a piece of a tick, and return the status; None: it is to be cut at an impact,
        or into pieces.

        begin   : [s] where it begins in the tick
        length  : [s]
        cutting : what is done with impacts that ask for cuts: `tick_counts`
        fine    : whether what is fast does not ask for pieces
        """
        counts = self._arrays.counts
        counts[tick_counts.CUTTING], counts[tick_counts.FINE] = cutting, int(fine)
        try:
            return self._pieces.until_done(
                tick.call, (tick.number * tick.h + begin) / length, length, tick=tick.number,
                h=tick.h, begin=begin,
            )  # fmt: skip
        finally:
            counts[tick_counts.CUTTING] = tick_counts.ASKS_FOR_CUTS
            counts[tick_counts.FINE] = 0

    def _advance_cut_at_impacts(self, tick: Tick) -> float:
        """Advance over one tick in pieces that end at impacts; return the status."""
        pieces, readout, h = self._pieces, self._readout, tick.h
        was_piece = pieces.begin_cut()
        reads = []
        begin, number, struck = 0.0, 0, None
        while True:
            cutting = (
                tick_counts.ASKS_FOR_CUTS if number < cuts.MOST_CUTS else tick_counts.LEAVES_CUTS
            )
            cache = pieces.begin_piece()
            length = h - begin
            status = self._piece(tick, begin, length, cutting)
            is_cut = status is None
            if is_cut:
                status, length, is_cut = self._reach_impact(tick, begin, length)
            if status != 0.0:
                break
            if length > 0.0:
                reads.append(readout.read_now())
                pieces.end_piece(cache if length < SHORT * h else None)
            if is_cut:
                listed, before = len(readout.impacts), struck
                struck = self._pair_of_event()
                again = struck == before and not length > 0.0  # they do not part: the solver's
                if not again:
                    self._meet(tick, begin + length, tick_counts.STRIKES)
                if len(readout.impacts) == listed:  # or nobody approaches where the two touch
                    number = cuts.MOST_CUTS
            begin, number = begin + length, number + 1
            if not is_cut or not begin < h:
                break
        pieces.end_cut(was_piece, h, reads)
        return 0.0 if status is None else status

    def _pair_of_event(self) -> tuple[float, float]:
        """Give the colliders of event 0."""
        event = self._arrays.event_pairs
        return float(event[flight_record.COLLIDER_A]), float(event[flight_record.COLLIDER_B])

    def _reach_impact(self, tick: Tick, begin: float, most: float) -> tuple[float, float, bool]:
        """
        Advance to the impact at which a piece of a tick is to be cut; return the status, the
        length of the way [s], and whether the two have met.

        begin, most : [s] where the piece begins in the tick, and how long it is
        """
        arrays, readout, h = self._arrays, self._readout, tick.h
        length = min(float(arrays.event_pairs[flight_record.INSTANT]), most)
        if not length > 0.0:
            return 0.0, 0.0, True
        seen = 0.0, 0.0
        start = Start.of(tick.motion, arrays)
        mark = readout.mark()
        for step_number in range(cuts.NEWTON_STEPS):
            if step_number:
                start.return_to(tick.motion, arrays)
                readout.return_to(mark)
            status = self._piece(tick, begin, length, tick_counts.HIDES_CUTS)
            if status != 0.0:
                return math.nan if status is None else status, length, False
            seen = self._meet(tick, begin + length, tick_counts.LOOKS)
            better = cuts.better_instant(length, seen, most)
            if not abs(better - length) > cuts.EXACT * h or not better > 0.0:
                break
            if step_number + 1 < cuts.NEWTON_STEPS:
                length = better
        return 0.0, length, length < most or cuts.have_met(seen, h)

    def _meet(self, tick: Tick, begin: float, what: int) -> tuple[float, float]:
        """
        Look at the impact of event 0 with the bodies as they are, or let it happen; return its gap
        [m] and approach [m/s].

        begin : [s] since the start of the tick;   what : see `tick_counts`
        """
        counts = self._arrays.counts
        counts[tick_counts.INSTANT] = what
        tick.call(0, tick.number * tick.h + begin, 1.0)
        counts[tick_counts.INSTANT] = tick_counts.NOTHING
        self._readout.take_impacts(tick.h, tick.number, begin)
        event = self._arrays.event_pairs
        return float(event[flight_record.GAP]), float(event[flight_record.APPROACH])
