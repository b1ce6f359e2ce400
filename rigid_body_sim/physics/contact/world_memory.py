# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the next tick of a scene with contact starts from beside the motion: the impulse cache, and
who sleeps.

    remembered, recall    as numbers, for another run of the same scene
    snapshot, return_to   as arrays, for a return of the same run, which also finds what could be
                          read then; `keep` is a snapshot that costs little, in place of the last
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument, prepared
from rigid_body_sim.physics.contact import tick_counts
from rigid_body_sim.physics.contact.collision import collider_record, deep_overlaps
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.contact.solver.cache_entries import without_pairs_of
from rigid_body_sim.physics.contact.solver.impulse_cache import keep_cache, size_in_use
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.contact.world_readout import NOTHING_FOUND, Mark, WorldReadout

Array = NDArray[np.float64]


# what a run returns to: impulse cache (`cache_record`), sleepers (None where nobody may sleep),
# works of what is moved as told [J], deepest overlap so far [m], and what else could be read; a
# tuple, which costs a fifth of what has names, as each tick makes one
Snapshot = tuple[Array, Any, Array, float, Mark]


class WorldMemory:
    """What the next tick of one scene starts from."""

    def __init__(self, arrays: WorldArrays, sleepers: Any, readout: WorldReadout) -> None:
        self._arrays = arrays
        self._sleepers = sleepers  # None where nobody may sleep
        self._readout = readout
        # a number seen through it is Python's own: numpy makes one of its own of each
        self._overlaps: Any = memoryview(arrays.overlaps)
        # version of the arrays, a place for the cache, what copies it, and whether nothing else is
        # to be kept but overlaps
        self._kept: tuple[int, Array, Callable[..., Any], bool]
        self._kept = -1, arrays.cache, keep_cache, False

    @property
    def is_new(self) -> bool:
        """Whether no tick was done since the scene began: nobody has found its loads."""
        return bool(self._arrays.cache[cache_record.SUBSTEP] == 0.0)

    def remembered(self) -> Array:
        """Give what the next tick starts from beside the blocks: see `cache_record`."""
        cache = self._arrays.cache_in_use.copy()
        if self._sleepers is None:
            return cache
        return np.concatenate((cache, self._sleepers.remembered()))

    def recall(self, numbers: Array) -> None:
        """
        Restore what `remembered` gave; without numbers nothing is known of any contact.

        Raises ValueError for other numbers.
        """
        end = size_in_use(np.array(numbers)) if len(numbers) else 0
        if (
            end > len(numbers)
            or (end == 0) != (len(numbers) == 0)
            or (self._sleepers is None and end != len(numbers))
        ):
            raise ValueError(
                'what it holds of contacts is not as this version keeps it: it comes from another '
                'scene or another version'
            )
        if self._sleepers is not None:
            self._sleepers.recall(numbers[end:])
            numbers = numbers[:end]
        self._readout.forget_overlaps()
        self._readout.forget_impacts()
        self._restart_from(numbers)

    def snapshot(self) -> Snapshot:
        """Give what `remembered` gives for a return of the same run: what sleeps is not copied."""
        arrays, readout = self._arrays, self._readout
        sleepers = None if self._sleepers is None else self._sleepers.snapshot()
        cache = arrays.cache_in_use.copy()
        return cache, sleepers, arrays.works.copy(), readout.depth, readout.mark()

    def keep(self) -> Snapshot:
        """Do what `snapshot` does, into an array that the next call uses again."""
        version, kept, copy, is_all = self._kept
        if version != self._arrays.version:
            kept, copy, is_all = self._make_place()
        copy()
        if is_all and not self._readout.overlaps:
            return (
                kept,
                None,
                self._arrays.works,
                self._overlaps[deep_overlaps.DEEPEST],
                NOTHING_FOUND,
            )
        sleepers = None if self._sleepers is None else self._sleepers.snapshot()
        depth = self._overlaps[deep_overlaps.DEEPEST]
        return kept, sleepers, self._arrays.works.copy(), depth, self._readout.mark()

    def _make_place(self) -> tuple[Array, Callable[..., Any], bool]:
        """Make a place for the cache, and what copies it; tell whether it is all to be kept."""
        arrays = self._arrays
        kept = np.zeros_like(arrays.cache)
        last = argument(arrays.cache), argument(kept)
        copy = prepared(keep_cache, (), last, brief=True)
        lists_impacts = self._readout.has_events
        is_all = self._sleepers is None and not (lists_impacts or arrays.drives.size)
        self._kept = arrays.version, kept, copy, is_all
        return kept, copy, is_all

    def return_to(self, snapshot: Snapshot) -> None:
        """Return to a snapshot."""
        cache, sleepers, works, depth, found = snapshot
        self._arrays.put_works(works)
        self._readout.put_depth(depth)
        self._readout.return_to(found)
        self._arrays.forget()
        self._arrays.pack()  # a list may have grown without a word of it, in what was broken off
        if self._sleepers is not None:
            self._sleepers.return_to(sleepers)
        self._restart_from(cache)

    def forget_body(self, core: int) -> None:
        """
        Forget what was known of a body that has been put elsewhere: impulses, sleep and the
        neighbours of all; who slept beside it wakes.
        """
        arrays = self._arrays
        cache = arrays.cache_in_use.copy()
        if self._sleepers is not None:
            cache = self._sleepers.wake_body(core, cache)
        cores = arrays.table[collider_record.BODY :: collider_record.SIZE]
        # the table names who sleeps otherwise: `islands.sleep`
        own = np.flatnonzero((cores == core) | (cores == -2 - core))
        arrays.forget()
        self._readout.forget_impacts()
        self._restart_from(without_pairs_of(cache, own, len(cores)))

    def _restart_from(self, cache: Array) -> None:
        """Let the next tick start from an impulse cache; no contacts were found for it yet."""
        if self._sleepers is not None:
            self._arrays.counts[tick_counts.SLEEP_CHANGED] = 1
        self._arrays.put_cache(cache)
        self._readout.forget_tick()
