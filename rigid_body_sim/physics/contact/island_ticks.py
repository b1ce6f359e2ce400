# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A tick in which each island goes in its own manner: whole, in pieces, or cut at impacts.

    for each manner that is wanted, the coarsest first, all from the start of the tick:
        let stand back who wants another one
        advance, again as long as contacts reach who stands back but is connected
    put together what each body has of its own manner

So a cut that concerns one island changes no bit of another.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.events import cuts
from rigid_body_sim.physics.contact.islands.manners import (
    WHOLE,
    Islands,
    Outcome,
    let_stand_back,
    put_together,
)
from rigid_body_sim.physics.contact.readout import together
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_readout import WorldReadout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Motion = tuple[Any, Any]  # blocks of translation and rotation
Advance = Callable[[int], float | None]  # over a tick in a manner: status, None: one is finer now

CUT = 2  # manner of a tick that a force cuts


class Start(NamedTuple):
    """
    What a tick or a piece of it starts from, copied.

    translation, rotation : blocks
    cache                 : see `cache_record`
    works                 : (n,) [J] of what is moved as told
    """

    translation: Array
    rotation: Array
    cache: Array
    works: Array

    @classmethod
    def of(cls, motion: Motion, arrays: WorldArrays) -> Start:
        """Copy what there is."""
        translation, rotation = (np.array(blocks) for blocks in motion)
        return cls(translation, rotation, arrays.cache_in_use.copy(), arrays.works.copy())

    def return_to(self, motion: Motion, arrays: WorldArrays) -> None:
        """Write it where it was."""
        for blocks, values in zip(motion, self, strict=False):
            np.asarray(blocks)[:] = values
        arrays.put_cache(self.cache)
        arrays.put_works(self.works)


class IslandTicks:
    """
    Lets ticks of one scene pass island by island.

    groups : (n,) for each body the first of those that force elements join
    sleeps : whether islands may sleep: then all go in the finest manner
    """

    def __init__(
        self, groups: Indices, arrays: WorldArrays, readout: WorldReadout, *, sleeps: bool
    ) -> None:
        self._groups = groups
        self._arrays = arrays
        self._readout = readout
        self._sleeps = sleeps

    def islands(self, wanted: Indices) -> Islands:
        """Begin with islands of which each body wants a manner (n,)."""
        return Islands(self._groups, wanted)

    def advance_cut(
        self, bodies: NDArray[np.bool_], h: float, motion: Motion, advance: Callable[[bool], float]
    ) -> float:
        """
        Advance over a tick that is cut for some bodies, and for who is connected to them.

        bodies  : whether the tick is cut for each body
        h       : [s] of the tick
        motion  : blocks of translation and rotation
        advance : advances all over the tick, cut or not, and returns the status
        """
        islands = self.islands(np.where(bodies, CUT, WHOLE))
        return self.advance(islands, h, motion, lambda manner: advance(manner == CUT))

    def advance(self, islands: Islands, h: float, motion: Motion, advance: Advance) -> float:
        """
        Advance over a tick [s], each island in its own manner: see `islands.manners`. The impacts
        of the tick are one list then.
        """
        mark = len(self._readout.impacts)
        status = self._advance_manners(islands, h, motion, advance)
        self._readout.put_in_order(mark)
        return status

    def _advance_manners(
        self, islands: Islands, h: float, motion: Motion, advance: Advance
    ) -> float:
        """Do what `advance` does, but for the list."""
        arrays, readout = self._arrays, self._readout
        wanted = islands.wanted
        if self._sleeps or wanted.min() == wanted.max():
            status = advance(int(wanted.max()))
            assert status is not None
            return status
        start = Start.of(motion, arrays)
        outcomes: dict[int, Outcome] = {}
        impacts: dict[int, list[Array]] = {}
        manner = 0
        while True:
            wanted = islands.wanted
            left = wanted[wanted > manner]
            if not left.size:
                break
            manner = int(left.min())
            mark = len(readout.impacts)
            status = self._advance_some(islands, manner, motion, start, advance)
            if status != 0.0:
                return status
            impacts[manner] = readout.impacts_since(mark)
            read = together(readout.reads())
            translation, rotation = (np.array(blocks) for blocks in motion)
            cache, works = arrays.cache_in_use.copy(), arrays.works.copy()
            outcomes[manner] = Outcome(translation, rotation, cache, works, read)
        for manner, found in impacts.items():  # who joined a finer one later has them there
            readout.add_impacts(cuts.of_manner(found, manner, wanted, arrays.table))
        cache, read = put_together(
            outcomes, wanted, arrays.table, *motion, arrays.works, arrays.substep_of(h)
        )
        arrays.put_cache(cache)
        readout.take_pieces([read], h)
        return 0.0

    def _advance_some(
        self, islands: Islands, manner: int, motion: Motion, start: Start, advance: Advance
    ) -> float:
        """
        Advance over a tick from its start in a manner, until no body is missing that is connected
        to who wants it; again, where `advance` finds that some of them want a finer one (None).
        """
        arrays, readout = self._arrays, self._readout
        mark, deepest = readout.mark(), readout.depth
        while True:
            readout.return_to(mark)
            readout.put_depth(deepest)
            start.return_to(motion, arrays)
            take_part = islands.wanted == manner
            let_stand_back(~take_part, arrays.table)
            listed = len(readout.impacts)
            readout.ask_for_pairs()
            status = advance(manner)
            # what meets at a cut is in no piece: it is hidden from the one, and flies in the other
            struck = cuts.pairs_struck(readout.impacts[listed:], arrays.table)
            pairs = np.concatenate((readout.pairs_since_asked(), struck))
            let_stand_back(np.zeros_like(take_part), arrays.table)
            islands.join(manner, pairs)
            if status is None:
                continue
            if status != 0.0 or not ((islands.wanted == manner) & ~take_part).any():
                return status
