# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What can be read of ticks that have passed.

    contacts    of the last tick; of one that was cut, those of its pieces together
    impacts     since they were last forgotten
    overlaps    that are too deep, and the deepest, since the start or what was restored last
    pairs       of bodies that contacts joined, where somebody asks

Whoever calls the kernel of the ticks (`ticks`, `pieces`) says what has passed; whoever lets time
pass again from an earlier instant (`cut_ticks`, `island_ticks`, `world_memory`) returns to a mark.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact import tick_counts, tick_settings
from rigid_body_sim.physics.contact.collision import (
    collider_record,
    deep_overlaps,
    manifold_record,
)
from rigid_body_sim.physics.contact.collision.deep_overlaps import overlap_warning, take_overlaps
from rigid_body_sim.physics.contact.events import cuts, impact_list
from rigid_body_sim.physics.contact.events.read_impacts import of_last_tick, read_impacts
from rigid_body_sim.physics.contact.islands.manners import Read, pairs_of
from rigid_body_sim.physics.contact.readout import joined, read, together, with_taken_back
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Written(NamedTuple):
    """
    What the kernel of a scene writes, and how.

    width    : numbers of a contact point
    angular  : whether its rows hold angular impulses
    bounces  : whether they hold restitution impulses
    events   : whether impacts come at their instants
    substeps : of the integrator, ticks of the kernel in one of the scene
    """

    width: int
    angular: bool
    bounces: bool
    events: bool
    substeps: int


# what had been found at an instant: overlaps, and how many calls of the kernel had listed impacts
Mark = tuple[dict[tuple[int, int], Array], int]
NOTHING_FOUND: Mark = {}, 0


class WorldReadout:
    """
    What the ticks of one scene have left to be read.

    whole    : [s] of a whole tick: instants are counted in it
    overlaps : of pairs of scene indices that are, or were, too deep
    impacts  : rows of `impact_list`, of each call of the kernel
    """

    def __init__(
        self, scene: Scene, layout: Layout, arrays: WorldArrays, sleepers: Any, written: Written
    ) -> None:
        self._layout = layout
        self._arrays = arrays
        self._sleepers = sleepers  # None where nobody may sleep
        self._written = written
        self._names = [body.name for body in scene.bodies]
        cores = arrays.table[collider_record.BODY :: collider_record.SIZE]
        indices = arrays.table[collider_record.SCENE_INDEX :: collider_record.SIZE]
        self._scene_indices = np.zeros(layout.n_moving, dtype=np.int64)  # of bodies that touch
        self._scene_indices[cores[cores >= 0]] = indices[cores >= 0]
        # seen through these, a number is Python's own: numpy makes one of its own of each
        self._counts = memoryview(arrays.counts)
        self._numbers: Any = memoryview(arrays.overlaps)
        self.whole = 0.0
        self.overlaps: dict[tuple[int, int], Array] = {}
        self.impacts: list[Array] = []
        self._is_read = False  # whether the rows are those of the last tick
        self._h = 0.0  # [s] of the last tick
        self._tick = 0.0  # its number in the kernel
        self._pieces: list[Read] = []  # of the last tick, if it was cut
        self._asked: list[list[Indices]] = []  # where somebody asks who was connected

    @property
    def has_events(self) -> bool:
        """Whether impacts come at their instants."""
        return self._written.events

    def take_tick(self, h: float) -> None:
        """Take over the length of a whole tick [s]."""
        self.whole = h

    def ticks_passed(self, last: float, h: float) -> None:
        """Note that ticks of a length [s] have passed; last: number of the last one."""
        self._tick = last if h == self.whole else self._number_of(last, h)
        self._is_read, self._pieces, self._h = True, [], h
        if self._asked:
            self._note_pairs()

    def piece_passed(self) -> None:
        """Note that a piece of a tick has passed."""
        self._is_read, self._pieces = True, []
        self._note_pairs()

    def take_pieces(self, pieces: list[Read], h: float) -> None:
        """Note that a tick of a length [s] has passed, and what was read of its pieces."""
        self._is_read, self._pieces, self._h = True, pieces, h

    def number_tick(self, tick: float, h: float) -> None:
        """Note the number of the tick that has passed in pieces, counted in ticks of h [s]."""
        self._tick = self._number_of(tick, h)

    def _number_of(self, tick: float, h: float) -> float:
        """Give the number of the whole tick that a tick of a length [s] is of."""
        whole = self.whole
        return tick if h == whole else float(cuts.number_of(tick, h, whole))

    def take_impacts(self, h: float, tick: float | None = None, begin: float = 0.0) -> None:
        """
        Take the impacts of a call of the kernel out of its list.

        h           : [s] of the ticks that are counted
        tick, begin : of a piece: the tick that it is of, and where it begins in it [s]
        """
        count = self._counts[tick_counts.IMPACTS]
        if not count:
            return
        found = self._arrays.impact_list[: count * impact_list.SIZE].copy()
        if tick is not None:
            found[impact_list.TICK :: impact_list.SIZE] = tick
            found[impact_list.PART :: impact_list.SIZE] += begin
        if h != self.whole:
            cuts.count_in(found, h, self.whole)
        self.impacts.append(found)
        if self.depth < 0.0:
            self.put_depth(0.0)
        self._counts[tick_counts.IMPACTS] = 0

    def take_overlaps(self) -> None:
        """Take the overlaps of calls of the kernel out of its list."""
        take_overlaps(self._arrays.overlaps, self.overlaps)

    def ask_for_pairs(self) -> None:
        """Note from now on which bodies are joined by contacts."""
        self._asked.append([])

    def pairs_since_asked(self) -> Indices:
        """Give the pairs (m, 2) of bodies that were joined since `ask_for_pairs` was called."""
        return np.concatenate([np.zeros((0, 2), dtype=np.int64), *self._asked.pop()])

    def _note_pairs(self) -> None:
        """Note which bodies contacts joined, where somebody asks."""
        if self._asked:
            pairs = pairs_of(self._arrays.manifolds_in_use, self._arrays.table)
            for asked in self._asked:
                asked.append(pairs)
            if self._written.events:
                met = cuts.pairs_met(self._layout.n_moving, self._arrays.event_links)
                for asked in self._asked:
                    asked.append(met)

    @property
    def depth(self) -> float:
        """The deepest overlap so far [m]; UNTOUCHED where nothing has pressed yet."""
        return self._numbers[deep_overlaps.DEEPEST]

    def put_depth(self, depth: float) -> None:
        """Let the deepest overlap so far be another one [m]."""
        self._numbers[deep_overlaps.DEEPEST] = depth

    def mark(self) -> Mark:
        """Note what was found so far, for `return_to`."""
        return self.overlaps.copy(), len(self.impacts)

    def return_to(self, mark: Mark) -> None:
        """Return to what was found at a mark, but for the deepest overlap."""
        overlaps, impacts = mark
        self.overlaps = overlaps.copy()
        del self.impacts[impacts:]

    def forget_tick(self) -> None:
        """Forget the contacts of the last tick, and who asks."""
        self._is_read = False
        self._asked = []

    def forget_impacts(self) -> None:
        """Begin a new list of impacts."""
        if self.impacts:
            self.impacts = []

    def forget_overlaps(self) -> None:
        """Begin anew with what overlaps."""
        self.overlaps = {}
        self.put_depth(deep_overlaps.UNTOUCHED)

    def impacts_since(self, mark: int) -> list[Array]:
        """Take out those behind the first so many."""
        found = self.impacts[mark:]
        del self.impacts[mark:]
        return found

    def put_in_order(self, mark: int) -> None:
        """Let impacts of one tick, those behind the first so many, be one list."""
        self.impacts[mark:] = cuts.in_order(self.impacts[mark:])

    def add_impacts(self, impacts: list[Array]) -> None:
        """Add what was taken out."""
        self.impacts += impacts

    def contacts(self) -> Contacts:
        """Read the contacts of the last tick; none before the first."""
        if not self._is_read:
            return NO_CONTACTS
        found, _ = together(self._pieces) if self._pieces else self.read_now()
        if self._written.events:
            struck = of_last_tick(self.impacts, self._tick, np.asarray(self._arrays.table))
            found = joined((found, struck))
        return found if self._sleepers is None else self._sleepers.contacts(found, self._h)

    def reads(self) -> list[Read]:
        """Read the contacts of the last tick, of each piece where it was cut."""
        return self._pieces or [self.read_now()]

    def read_now(self) -> Read:
        """Read the contacts of the last call of the kernel, and which they are."""
        return self.read(self._arrays.manifolds_in_use)

    def read(self, manifolds: Array) -> Read:
        """Read the contacts of some manifolds of the last call, and which they are."""
        arrays, written = self._arrays, self._written
        contacts, which = read(
            len(manifolds) // manifold_record.SIZE,
            width=written.width,
            bounces=written.bounces,
            angular=int(arrays.settings[tick_settings.SUBSTEPS]) if written.angular else 0,
            moving=self._layout.n_moving,
            table=arrays.table,
            manifolds=manifolds,
            rows=arrays.rows,
            bodies=arrays.bodies,
        )
        if len(manifolds):
            taken, pivoted = arrays.taken_back, self._layout.pivoted
            contacts = with_taken_back(contacts, taken, self._scene_indices, pivoted)
        return contacts, which

    def read_impacts(self, *, dt_ns: int, start_ns: int) -> Impacts:
        """
        Read the impacts since they were last forgotten.

        start_ns : where tick 0 of the scene began [ns]
        """
        table = np.asarray(self._arrays.table)
        return read_impacts(
            self.impacts, dt_ns=dt_ns, start_ns=start_ns, table=table,
            substeps=self._written.substeps,
        )  # fmt: skip

    def overlap_warnings(self) -> dict[tuple[int, int], str]:
        """
        Warn of the pairs of bodies (scene indices) that have overlapped too deeply since the start
        or what was restored last, with the greatest depth: see `collision.deep_overlaps`.
        """
        names = self._names
        return {
            (first, second): overlap_warning(names[first], names[second], found)
            for (first, second), found in self.overlaps.items()
        }

    def deepest_gap(self) -> float | None:
        """
        Give the smallest gap of two bodies that touched, at the start of any tick since the start
        or what was restored last [m]; negative: an overlap. None where nothing touched.
        """
        deepest = self._numbers[deep_overlaps.DEEPEST]
        return None if deepest < 0.0 else 0.0 - deepest
