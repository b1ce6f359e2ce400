# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The contact of one scene: its arrays, its kernel, and what Python answers when the kernel returns
before all ticks are done.

    a list is too short       it grows
    islands wake or fall      their impulses move into the impulse cache, or out of it
    asleep
    something is too fast     the tick is cut into pieces, each a tick of its own
                              (`collision.conservative_advancement`)
    what flies meets what     the tick is cut at the impact, and goes on after it (`events.cuts`)
    the solver moves

A tick is also cut where a force begins or ends inside it (`stepper`). However it is cut, contacts
stay as soft as in the whole tick, and the next one starts from the impulses of no short piece
(`in_pieces`): a cut does not move what rests.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernel import WITHOUT
from rigid_body_sim.physics.compile.kernels import COMPILED, argument, prepared
from rigid_body_sim.physics.compile.side_by_side import threads
from rigid_body_sim.physics.contact import step, tick_counts, tick_settings
from rigid_body_sim.physics.contact.collision import (
    collider_record,
    deep_overlaps,
    manifold_record,
)
from rigid_body_sim.physics.contact.collision.axis_of_symmetry import symmetry_features
from rigid_body_sim.physics.contact.collision.collider import SPHERE, Colliders
from rigid_body_sim.physics.contact.collision.collider_order import order
from rigid_body_sim.physics.contact.collision.convexity_defect import convexity_warnings
from rigid_body_sim.physics.contact.collision.deep_overlaps import overlap_warning, take_overlaps
from rigid_body_sim.physics.contact.collision.held_features import KINDS as HELD_KINDS
from rigid_body_sim.physics.contact.collision.narrow_phase import manifold_finder
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.contact.collision.recycling import RECYCLED_KINDS
from rigid_body_sim.physics.contact.collision.small_bodies import small_body_warnings
from rigid_body_sim.physics.contact.events import cuts, flight_record, impact_list
from rigid_body_sim.physics.contact.events.read_impacts import of_last_tick, read_impacts
from rigid_body_sim.physics.contact.helpers import Helpers
from rigid_body_sim.physics.contact.islands.groups import groups_of
from rigid_body_sim.physics.contact.islands.manners import (
    WHOLE,
    Islands,
    Outcome,
    Read,
    let_stand_back,
    pairs_of,
    pieces_wanted,
    put_together,
)
from rigid_body_sim.physics.contact.islands.sleep import make_sleep_state
from rigid_body_sim.physics.contact.pair_rules import pair_rules
from rigid_body_sim.physics.contact.readout import joined, read, together, with_taken_back
from rigid_body_sim.physics.contact.settings import EVENT, ContactSettings
from rigid_body_sim.physics.contact.solver import cache_record, contact_point, variable_mass
from rigid_body_sim.physics.contact.solver.cache_entries import scaled, without_pairs_of
from rigid_body_sim.physics.contact.solver.impulse_cache import keep_cache, size_in_use
from rigid_body_sim.physics.contact.solver.iterations import solver
from rigid_body_sim.physics.contact.suited_integrators import unsuited
from rigid_body_sim.physics.contact.world_arrays import WorldArrays
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model import material
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts
from rigid_body_sim.physics.state.impacts import Impacts
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Call = Callable[[int, float, float], float]  # ticks, number of the first, length [s] -> status

PIECES_AT_ONCE = 64  # [-] whose contacts are kept apart; more take memory, fewer take time
# [-] of the longest piece of a tick: what noise a shorter one leaves in its impulses would be
# scaled up with them, and throw up what rests
SHORT = 0.25
CUT = 2  # manner of a tick that a force cuts
# bodies from which on other threads may help; fewer are one group of islands (`solver_groups`),
# and to begin a thread costs 30 us
WORTH_HELP = 400


class ContactWorld:
    """
    What the contact of a scene needs beside the blocks.

    arrays   : of the kernel
    warnings : what the scene should know before it starts, a line each
    """

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator) -> None:
        reason = unsuited(integrator)
        if reason is not None:
            raise InvalidModel(
                f'integrator {integrator.name!r} refuses the scene {scene.name!r}: {reason}',
                at=('integrator',),
            )
        settings = ContactSettings.of(scene.contact)
        self._events = settings.mode == EVENT
        self._layout = layout
        self._integrator = integrator
        colliders = Colliders.of(scene, layout)
        self.warnings = convexity_warnings(scene) + small_body_warnings(scene, colliders)
        self._kinds = colliders.pairs()
        materials = colliders.materials.reshape(-1, material.SIZE)
        rules = pair_rules(scene.contact, layout.names)
        materials = np.concatenate((materials, rules.materials))  # in the same columns
        resistances = materials[:, [material.ROLLING_FRICTION, material.TORSIONAL_FRICTION]]
        self._angular = bool(np.any(resistances > 0.0))
        self._bounces = bool(np.any(materials[:, material.RESTITUTION] > 0.0))
        self._width = (
            contact_point.SIZE_LONG if self._angular or self._bounces else contact_point.SIZE
        )
        flows = variable_mass.flows_of(layout, colliders.bodies.tolist())
        self.arrays = WorldArrays(
            layout.n_moving,
            self._width,
            flows,
            layout.pivoted,
            holds=self._holds,
            recycles=self._recycles,
        )
        self.arrays.take_colliders(colliders, order(scene, colliders))
        self.arrays.take_settings(settings)
        rows = integrator.coefficients(layout.moments).shape[1]
        self.arrays.take_integrator(rows)
        self.arrays.take_events(rows, wanted=self._events)
        self.impacts: list[Array] = []  # rows of `impact_list`, of each call of the kernel
        self.arrays.take_pair_rules(rules, len(scene.bodies))
        self._sleepers = self._make_sleepers(scene, settings.sleeping)
        self.arrays.pack()
        self._kernels: dict[str, Callable[..., Any]] = {}
        self._helpers = Helpers(self.arrays.board)
        # seen through these, a number is Python's own: numpy makes one of its own of each
        self._counts = memoryview(self.arrays.counts)
        self._overlap_counts: Any = memoryview(self.arrays.overlaps)
        self._whole = 0.0  # [s] of a whole tick, as the settings have it
        # version of the arrays, a place for the cache, what copies it, and whether nothing else is
        # to be kept but overlaps
        self._kept: tuple[int, Array, Callable[..., Any], bool]
        self._kept = -1, self.arrays.cache, keep_cache, False
        self._is_read = False  # whether the rows are those of the last tick
        self._h = 0.0  # [s] of the last tick
        self._tick = 0.0  # its number in the kernel
        self._has_woken = False  # whether somebody has in the piece under way
        self._groups = groups_of(scene, layout)
        self._pairs: list[list[Indices]] = []  # where somebody asks who was connected
        self._pieces: list[Read] = []  # of the last tick, if it was cut
        self._names = [body.name for body in scene.bodies]
        cores = self.arrays.table[collider_record.BODY :: collider_record.SIZE]
        indices = self.arrays.table[collider_record.SCENE_INDEX :: collider_record.SIZE]
        self._scene_indices = np.zeros(layout.n_moving, dtype=np.int64)  # of bodies that touch
        self._scene_indices[cores[cores >= 0]] = indices[cores >= 0]
        self._overlaps: dict[tuple[int, int], NDArray[np.float64]] = {}  # of scene indices

    @property
    def has_events(self) -> bool:
        """Whether impacts come at their instants."""
        return self._events

    @property
    def _holds(self) -> bool:
        """Whether points of some pairs depend on those of the last tick: see `held_features`."""
        return not HELD_KINDS.isdisjoint(self._kinds)

    @property
    def _recycles(self) -> bool:
        """Whether manifolds of some pairs follow their bodies: see `collision.recycling`."""
        return not (self._events or RECYCLED_KINDS.isdisjoint(self._kinds))

    def _make_sleepers(self, scene: Scene, sleeping: bool) -> Any:
        """Make what keeps the contacts of sleepers; None where nobody may sleep."""
        if not sleeping:
            nobody = make_sleep_state(np.zeros(0), np.zeros(0, dtype=np.int64))
            self.arrays.take_sleep_state(nobody)
            return None
        from rigid_body_sim.physics.contact.islands.sleepers import Sleepers

        arrays = self.arrays
        sleepers = Sleepers(
            scene, self._layout, arrays.table, arrays.local_bounds, arrays.local_poses
        )
        arrays.take_sleep_state(sleepers.state)
        return sleepers

    @property
    def is_new(self) -> bool:
        """Whether no tick was done since the scene began: nobody has found its loads."""
        return bool(self.arrays.cache[cache_record.SUBSTEP] == 0.0)

    def remembered(self) -> Array:
        """Give what the next tick starts from beside the blocks: see `cache_record`."""
        cache = self.arrays.cache_in_use.copy()
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
        self._overlaps = {}
        self._overlap_counts[deep_overlaps.DEEPEST] = deep_overlaps.UNTOUCHED
        self._restart_from(numbers)

    def snapshot(self) -> tuple[Any, ...]:
        """Give what `remembered` gives for a return of the same run: what sleeps is not copied."""
        sleepers = None if self._sleepers is None else self._sleepers.snapshot()
        return (
            self.arrays.cache_in_use.copy(), sleepers, self.work_of_drives, dict(self._overlaps),
            self._overlap_counts[deep_overlaps.DEEPEST], len(self.impacts),
        )  # fmt: skip

    def keep(self) -> tuple[Any, ...]:
        """Do what `snapshot` does, into an array that the next call uses again."""
        arrays = self.arrays
        version, kept, copy, is_all = self._kept
        if version != arrays.version:
            kept = np.zeros_like(arrays.cache)
            last = argument(arrays.cache), argument(kept)
            copy = prepared(keep_cache, (), last, brief=True)
            is_all = self._sleepers is None and not (self._events or arrays.drives.size)
            self._kept = arrays.version, kept, copy, is_all
        copy()
        if is_all and not self._overlaps:
            return kept, None, 0.0, {}, self._overlap_counts[deep_overlaps.DEEPEST], 0
        sleepers = None if self._sleepers is None else self._sleepers.snapshot()
        return (
            kept, sleepers, self.work_of_drives, self._overlaps.copy(),
            self._overlap_counts[deep_overlaps.DEEPEST], len(self.impacts),
        )  # fmt: skip

    def return_to(self, snapshot: tuple[Any, ...]) -> None:
        """Return to a snapshot."""
        cache, sleepers, self.arrays.works[0], overlaps, deepest, impacts = snapshot
        self._overlap_counts[deep_overlaps.DEEPEST] = deepest
        kept = self.impacts[:impacts]
        self._overlaps = dict(overlaps)
        self.arrays.forget()
        if self._sleepers is not None:
            self._sleepers.return_to(sleepers)
        self._restart_from(cache)
        self.impacts = kept

    def read_impacts(self, *, dt_ns: int, start_ns: int) -> Impacts:
        """
        Read the impacts since they were last forgotten.

        start_ns : where tick 0 of the scene began [ns]
        """
        table = np.asarray(self.arrays.table)
        return read_impacts(
            self.impacts, dt_ns=dt_ns, start_ns=start_ns, table=table,
            substeps=self._integrator.substeps,
        )  # fmt: skip

    def forget_impacts(self) -> None:
        """Begin a new list of impacts."""
        self.impacts = []

    def take_tick(self, h: float) -> None:
        """Take over the length of a whole tick [s]."""
        if h != self._whole:
            self.arrays.settings[tick_settings.WHOLE_TICK] = self._whole = h

    def take_pulled(self, bodies: Callable[[], NDArray[np.bool_]]) -> None:
        """Take over on which bodies forces act that depend on the state or on time."""
        if self._events:
            self.arrays.take_pulled(bodies())

    @property
    def work_of_drives(self) -> float:
        """Work that was done so far by what is moved as told, and by belts [J]."""
        return self.arrays.works.item(0)

    def forget_body(self, core: int) -> None:
        """
        Forget what was known of a body that has been put elsewhere: impulses, sleep and the
        neighbours of all; who slept beside it wakes.
        """
        arrays = self.arrays
        cache = arrays.cache_in_use.copy()
        if self._sleepers is not None:
            cache = self._sleepers.wake_body(core, cache)
        cores = arrays.table[collider_record.BODY :: collider_record.SIZE]
        # the table names who sleeps otherwise: `islands.sleep`
        own = np.flatnonzero((cores == core) | (cores == -2 - core))
        arrays.forget()
        self._restart_from(without_pairs_of(cache, own, len(cores)))

    def _restart_from(self, cache: Array) -> None:
        """Let the next tick start from an impulse cache; what was read of the last one is gone."""
        if self._sleepers is not None:
            self.arrays.counts[tick_counts.SLEEP_CHANGED] = 1
        self.arrays.put_cache(cache)
        self.forget_impacts()
        self._is_read = False
        self._pairs = []

    def overlap_warnings(self) -> dict[tuple[int, int], str]:
        """
        Warn of the pairs of bodies (scene indices) that have overlapped too deeply since the start
        or what was restored last, with the greatest depth: see `collision.deep_overlaps`.
        """
        names = self._names
        return {
            (first, second): overlap_warning(names[first], names[second], found)
            for (first, second), found in self._overlaps.items()
        }

    def deepest_gap(self) -> float | None:
        """
        Give the smallest gap of two bodies that touched, at the start of any tick since the start
        or what was restored last [m]; negative: an overlap. None where nothing touched.
        """
        deepest = self._overlap_counts[deep_overlaps.DEEPEST]
        return None if deepest < 0.0 else 0.0 - deepest

    def contacts(self) -> Contacts:
        """Read the contacts of the last tick; none before the first."""
        if not self._is_read:
            return NO_CONTACTS
        found, _ = (
            together(self._pieces) if self._pieces else self._read(self.arrays.manifolds_in_use)
        )
        if self._events:
            struck = of_last_tick(self.impacts, self._tick, np.asarray(self.arrays.table))
            found = joined((found, struck))
        return found if self._sleepers is None else self._sleepers.contacts(found, self._h)

    def _read(self, manifolds: Array) -> tuple[Contacts, Array]:
        """Read the contacts of some manifolds of the last tick or piece, and which they are."""
        contacts, which = read(
            len(manifolds) // manifold_record.SIZE,
            width=self._width,
            bounces=self._bounces,
            angular=int(self.arrays.settings[tick_settings.SUBSTEPS]) if self._angular else 0,
            moving=self._layout.n_moving,
            table=self.arrays.table,
            manifolds=manifolds,
            rows=self.arrays.rows,
            bodies=self.arrays.bodies,
        )
        if len(manifolds):
            taken = self.arrays.taken_back
            pivoted = self._layout.pivoted
            contacts = with_taken_back(contacts, taken, self._scene_indices, pivoted)
        return contacts, which

    def kernel(
        self, scene: str, evaluate: Callable[..., Any] | None, velocity_dependent: bool
    ) -> Callable[..., Any]:
        """
        Make the kernel of the scene, with the usual call of a scheme.

        scene, evaluate, velocity_dependent : as of `Scheme.coupled`; evaluate None: nothing
                                              depends on the state
        """
        if scene not in self._kernels:
            compiled = self._compile(scene, evaluate, velocity_dependent)
            self._kernels[scene] = self._with_arrays(compiled, apart=self._apart(evaluate))
        return self._kernels[scene]

    def _apart(self, evaluate: Callable[..., Any] | None) -> bool:
        """Whether islands may pass their substeps one after the other, or at once."""
        arrays = self.arrays
        together = arrays.flows.size or arrays.drives.size or arrays.pivoted.size
        return evaluate is None and not together

    def rest(self) -> None:
        """Wait until no thread works: see `helpers`."""
        self._helpers.rest()

    def _compile(
        self, scene: str, evaluate: Callable[..., Any] | None, velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel of the ticks: only what the scene needs."""
        assert isinstance(self._integrator.scheme, Splitting)
        flows = bool(self.arrays.flows.size)
        pairs = [(a, b, collide_kernel(a, b)) for a, b in self._kinds]
        features = symmetry_features(self._kinds, off_center=self.arrays.has_ball_off_center())
        driven = bool(self.arrays.drives.size)
        iterations = solver(
            width=self._width,
            angular=self._angular,
            bounces=self._bounces,
            turns=bool(np.ptp(self._layout.moments, axis=1).any()) or flows,
            arcs=self.arrays.has_surface_that_turns(),
            **features,
        )
        return step.tick_kernel(
            f'{self._integrator.name}_{scene}',
            WIDTH=self._width,
            ANGULAR=self._angular,
            BOUNCES=self._bounces,
            CURVED=features['curved'],
            BALLS_MEET=(SPHERE, SPHERE) in self._kinds,
            COUPLED=evaluate is not None,
            APART=self._apart(evaluate),
            EVENTS=self._events,
            VELOCITY_DEPENDENT=velocity_dependent,
            SLEEPING=self._sleepers is not None,
            FLOWS=flows,
            DRIVES=driven,
            IGNORES=bool(self.arrays.ignored.size),
            HOLDS=self._holds,
            RECYCLES=self._recycles,
            drift_rotation=self._integrator.scheme.drift_rotation,
            evaluate=_nothing if evaluate is None else evaluate,
            **manifold_finder(pairs, holds=self._holds, recycles=self._recycles),
            **{'apply_restitution': _nothing, **iterations},
            **self._impacts_of(pairs),
        )

    def _impacts_of(self, pairs: Any) -> dict[str, Any]:
        """Make the kernels of impacts at their instants, where the scene wants them."""
        if not self._events:
            return dict.fromkeys(('find_impacts', 'meet_now', 'land'), _nothing)
        from rigid_body_sim.physics.contact.events.impact_kernels import impact_kernels

        scheme = self._integrator.scheme
        assert isinstance(scheme, Splitting)
        made = impact_kernels(self._integrator.name, pairs, drift_rotation=scheme.drift_rotation)
        return made._asdict()

    def _helpers_of(
        self, compiled: Callable[..., Any], first: Sequence[Any], world: step.World
    ) -> list[Callable[..., Any]]:
        """Give a kernel to each thread that may help, with arrays of its own; first: arguments."""
        if not COMPILED or WITHOUT:
            return []
        return [
            prepared(compiled, first, (self.arrays.world_of_helper(world),))
            for _ in range(threads() - 1)
        ]

    def _with_arrays(self, compiled: Callable[..., Any], *, apart: bool) -> Callable[..., Any]:
        """
        Give a kernel of the ticks the call of a scheme; its workspace is not needed.

        apart : whether several threads have something to do
        """
        arrays = self.arrays
        is_worth_help = apart and self._layout.n_moving >= WORTH_HELP

        def prepare(_first: Sequence[Any], last: Sequence[Any]) -> Call:
            *motion, _workspace, elements, ranges = last
            blocks_of_both = motion[2], motion[3]
            # version, its arrays, the kernel with them, and with those of who helps
            made: list[Any] = [-1, None, compiled, []]

            def call(ticks: int, tick: float, h: float) -> float:
                if made[0] != arrays.version:
                    world, first = arrays.world(motion, elements, ranges), (ticks, tick, h)
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

            def advance(ticks: int, tick: float, h: float) -> float:
                if self._events:  # its pieces begin anywhere
                    tick = float(tick)
                return self._advance(call, ticks, tick, h, blocks_of_both)

            return advance

        def advance(ticks: int, tick: float, h: float, *last: Any) -> float:
            return prepare((), last)(ticks, tick, h)

        setattr(advance, 'prepared', prepare)  # noqa: B010  # see `kernels.prepared`
        return advance

    def _advance(
        self, call: Call, ticks: int, tick: float, h: float, motion: tuple[Any, Any]
    ) -> float:
        """
        Call the kernel, and do what it returns for, until all ticks are done; its status.

        motion : blocks of translation and rotation
        """
        counts = self._counts
        done = 0
        while True:
            status = call(ticks - done, tick + done, h)
            if counts[tick_counts.IMPACTS]:
                self._take_impacts(h)
            if self._overlap_counts[deep_overlaps.COUNT]:
                take_overlaps(self.arrays.overlaps, self._overlaps)
            if counts[tick_counts.DONE]:
                done += counts[tick_counts.DONE]
                last = tick + done - 1
                self._tick = last if h == self._whole else self._number_of(last, h)
                self._is_read, self._pieces, self._h = True, [], h
                if self._pairs:
                    self._note_pairs()
            why = counts[tick_counts.STATUS]
            if why == tick_counts.COMPLETE or status != 0.0:
                return status
            if why == tick_counts.TOO_LONG:
                status = self._advance_fast(call, tick + done, h, motion)
                done += 1
            elif why == tick_counts.CUT:
                status = self._advance_by_impacts(call, tick + done, h, motion)
                self._tick = self._number_of(tick + done, h)
                done += 1
            else:
                self._answer(h)
            if status != 0.0 or done == ticks:
                return status

    def _number_of(self, tick: float, h: float) -> float:
        """Give the number of the whole tick that a tick of a length [s] is of."""
        whole = self._whole
        return tick if h == whole else float(cuts.number_of(tick, h, whole))

    def _take_impacts(self, h: float, tick: float | None = None, begin: float = 0.0) -> None:
        """
        Take the impacts of a call of the kernel out of its list.

        h           : [s] of the ticks that are counted
        tick, begin : of a piece: the tick that it is of, and where it begins in it [s]
        """
        count = self._counts[tick_counts.IMPACTS]
        if not count:
            return
        found = self.arrays.impact_list[: count * impact_list.SIZE].copy()
        if tick is not None:
            found[impact_list.TICK :: impact_list.SIZE] = tick
            found[impact_list.PART :: impact_list.SIZE] += begin
        if h != self._whole:
            cuts.count_in(found, h, self._whole)
        self.impacts.append(found)
        if self._overlap_counts[deep_overlaps.DEEPEST] < 0.0:
            self._overlap_counts[deep_overlaps.DEEPEST] = 0.0
        self.arrays.counts[tick_counts.IMPACTS] = 0

    def _advance_by_impacts(
        self, call: Call, tick: float, h: float, motion: tuple[Any, Any]
    ) -> float:
        """Advance over one tick, which is cut at impacts for the islands concerned."""
        arrays, count = self.arrays, self._layout.n_moving
        islands = Islands(self._groups, cuts.manners_wanted(count, arrays.event_links))
        pairs = pairs_of(arrays.manifolds_in_use, arrays.table)
        # who is whole and flies is let go before anything is: that joins nobody yet
        for manner in sorted({*islands.wanted.tolist()} - {WHOLE}):
            islands.join(manner, pairs)

        def advance(manner: int) -> float | None:
            if manner >= cuts.FIRST:
                return self._advance_cut_at_impacts(call, tick, h, motion)
            if manner > WHOLE:
                return self._advance_in_pieces(call, tick, h, manner)
            status = self._advance_whole(call, tick, h, fine=False)
            if status is None:  # something of what was to be whole is too fast
                found, before = arrays.manifolds_in_use, islands.wanted
                wanted = pieces_wanted(found, arrays.table, count)
                islands.want(np.where(before == WHOLE, wanted, WHOLE))
                islands.join(WHOLE, pairs_of(found, arrays.table))
                if np.array_equal(islands.wanted, before):
                    return self._advance_whole(call, tick, h)
            return status

        return self._advance_islands(islands, h, motion, advance)

    def _advance_whole(
        self, call: Call, tick: float, h: float, *, fine: bool = True
    ) -> float | None:
        """
        Advance over a tick that is cut at impacts, if at all, for others; the status, or None: see
        `_piece`.
        """
        status = self._piece(call, tick, h, (0.0, h), tick_counts.HIDES_CUTS, fine=fine)
        if status is not None:
            self._pieces = [self._read(self.arrays.manifolds_in_use)]
        return status

    def _piece(
        self, call: Call, tick: float, h: float, piece: tuple[float, float], cutting: int, *,
        fine: bool = True,
    ) -> float | None:  # fmt: skip
        """
        Advance over a piece of a tick, and return the status; None: it is to be cut at an impact,
        or into pieces.

        piece   : [s] where it begins in the tick, and how long it is
        cutting : what is done with impacts that ask for cuts: `tick_counts`
        fine    : whether what is fast does not ask for pieces
        """
        counts, (begin, length) = self.arrays.counts, piece
        counts[tick_counts.CUTTING], counts[tick_counts.FINE] = cutting, int(fine)
        try:
            while True:
                status = call(1, (tick * h + begin) / length, length)
                self._take_impacts(h, tick, begin)
                take_overlaps(self.arrays.overlaps, self._overlaps)
                if status != 0.0 or counts[tick_counts.DONE]:
                    self._is_read, self._pieces = True, []
                    self._note_pairs()
                    return status
                if counts[tick_counts.STATUS] in (tick_counts.CUT, tick_counts.TOO_LONG):
                    return None
                self._answer(length)
        finally:
            counts[tick_counts.CUTTING] = tick_counts.ASKS_FOR_CUTS
            counts[tick_counts.FINE] = 0

    def _advance_cut_at_impacts(
        self, call: Call, tick: float, h: float, motion: tuple[Any, Any]
    ) -> float:
        """Advance over one tick in pieces that end at impacts."""
        arrays, counts = self.arrays, self.arrays.counts
        was_piece, counts[tick_counts.PIECE] = int(counts[tick_counts.PIECE]), 1
        pieces: list[Read] = []
        begin, number = 0.0, 0
        while True:
            cutting = (
                tick_counts.ASKS_FOR_CUTS if number < cuts.MOST_CUTS else tick_counts.LEAVES_CUTS
            )
            cache, self._has_woken = arrays.cache_in_use.copy(), False
            length = h - begin
            status = self._piece(call, tick, h, (begin, length), cutting)
            is_cut = status is None
            if is_cut:
                status, length, is_cut = self._reach_impact(call, tick, h, (begin, length), motion)
            if status != 0.0:
                break
            if length > 0.0:
                pieces.append(self._read(arrays.manifolds_in_use))
                if length < SHORT * h and not self._has_woken:
                    arrays.put_cache(cache)
            if is_cut:
                listed = len(self.impacts)
                self._meet(call, tick, h, begin + length, tick_counts.STRIKES)
                if len(self.impacts) == listed:  # nobody approaches where the two touch
                    number = cuts.MOST_CUTS
            begin, number = begin + length, number + 1
            if not is_cut or not begin < h:
                break
        counts[tick_counts.PIECE] = was_piece
        arrays.put_cache(scaled(arrays.cache_in_use, arrays.substep_of(h)))
        self._pieces = [together(pieces)] if pieces else [(NO_CONTACTS, np.zeros((0, 2)))]
        self._is_read, self._h = True, h
        return 0.0 if status is None else status

    def _reach_impact(
        self, call: Call, tick: float, h: float, piece: tuple[float, float],
        motion: tuple[Any, Any],
    ) -> tuple[float, float, bool]:  # fmt: skip
        """
        Advance to the impact at which a piece of a tick, [s] from where and how long, is to be
        cut; return the status, the length of the way [s], and whether the two have met.
        """
        arrays, (begin, most) = self.arrays, piece
        length = min(float(arrays.event_pairs[flight_record.INSTANT]), most)
        if not length > 0.0:
            return 0.0, 0.0, True
        seen = 0.0, 0.0
        start = (*(np.array(blocks) for blocks in motion), arrays.cache_in_use.copy())
        works, overlaps, mark = self.work_of_drives, dict(self._overlaps), len(self.impacts)
        for step_number in range(cuts.NEWTON_STEPS):
            if step_number:
                for blocks, values in zip(motion, start, strict=False):
                    np.asarray(blocks)[:] = values
                arrays.put_cache(start[-1])
                arrays.works[0], self._overlaps = works, dict(overlaps)
                del self.impacts[mark:]
            status = self._piece(call, tick, h, (begin, length), tick_counts.HIDES_CUTS)
            if status != 0.0:
                return math.nan if status is None else status, length, False
            seen = self._meet(call, tick, h, begin + length, tick_counts.LOOKS)
            better = cuts.better_instant(length, seen, most)
            if not abs(better - length) > cuts.EXACT * h or not better > 0.0:
                break
            if step_number + 1 < cuts.NEWTON_STEPS:
                length = better
        return 0.0, length, length < most or cuts.have_met(seen, h)

    def _meet(
        self, call: Call, tick: float, h: float, begin: float, what: int
    ) -> tuple[float, float]:
        """
        Look at the impact of event 0 with the bodies as they are, or let it happen; return its gap
        [m] and approach [m/s].

        begin : [s] since the start of the tick;   what : see `tick_counts`
        """
        counts, arrays = self.arrays.counts, self.arrays
        counts[tick_counts.INSTANT] = what
        call(0, tick * h + begin, 1.0)
        counts[tick_counts.INSTANT] = tick_counts.NOTHING
        self._take_impacts(h, tick, begin)
        event = arrays.event_pairs
        return float(event[flight_record.GAP]), float(event[flight_record.APPROACH])

    def _advance_fast(self, call: Call, tick: float, h: float, motion: tuple[Any, Any]) -> float:
        """
        Advance over one tick, in equal pieces where something fast hits something in it.
        """
        arrays, count = self.arrays, self._layout.n_moving
        manifolds = arrays.manifolds_in_use
        islands = Islands(self._groups, pieces_wanted(manifolds, arrays.table, count))
        islands.join(WHOLE, pairs_of(manifolds, arrays.table))

        def advance(pieces: int) -> float | None:
            if pieces == WHOLE and self._events:
                return self._advance_whole(call, tick, h)
            return self._advance_in_pieces(call, tick, h, pieces)

        return self._advance_islands(islands, h, motion, advance)

    def _advance_in_pieces(self, call: Call, tick: float, h: float, pieces: int) -> float:
        """Advance over one tick in equal pieces; return the status."""
        counts, arrays = self.arrays.counts, self.arrays

        def one(piece: int) -> float:
            while True:
                status = call(1, tick * pieces + piece, h / pieces)
                self._take_impacts(h, tick, piece * (h / pieces))
                take_overlaps(arrays.overlaps, self._overlaps)
                if status != 0.0 or counts[tick_counts.DONE]:
                    self._is_read, self._pieces = True, []
                    self._note_pairs()
                    return status
                self._answer(h / pieces)

        counts[tick_counts.FINE] = 1
        counts[tick_counts.CUTTING] = tick_counts.LEAVES_CUTS
        status = self.in_pieces(h, [h / pieces] * pieces, one)
        counts[tick_counts.FINE] = 0
        counts[tick_counts.CUTTING] = tick_counts.ASKS_FOR_CUTS
        return status

    def advance_cut(
        self, bodies: NDArray[np.bool_], h: float, motion: tuple[Any, Any],
        advance: Callable[[bool], float],
    ) -> float:  # fmt: skip
        """
        Advance over a tick that is cut for some bodies, and for who is connected to them.

        bodies  : whether the tick is cut for each body
        h       : [s] of the tick
        motion  : blocks of translation and rotation
        advance : advances all over the tick, cut or not, and returns the status
        """
        islands = Islands(self._groups, np.where(bodies, CUT, WHOLE))
        return self._advance_islands(islands, h, motion, lambda manner: advance(manner == CUT))

    def _advance_islands(
        self, islands: Islands, h: float, motion: tuple[Any, Any],
        advance: Callable[[int], float | None],
    ) -> float:  # fmt: skip
        """
        Advance over a tick, each island in its own manner: see `islands.manners`. Where islands
        may sleep, all go in the finest one. The impacts of the tick are one list then.
        """
        mark = len(self.impacts)
        status = self._advance_manners(islands, h, motion, advance)
        self.impacts[mark:] = cuts.in_order(self.impacts[mark:])
        return status

    def _advance_manners(
        self, islands: Islands, h: float, motion: tuple[Any, Any],
        advance: Callable[[int], float | None],
    ) -> float:  # fmt: skip
        """Do what `_advance_islands` does, but for the list."""
        arrays = self.arrays
        wanted = islands.wanted
        if self._sleepers is not None or wanted.min() == wanted.max():
            status = advance(int(wanted.max()))
            assert status is not None
            return status
        start = (*(np.array(blocks) for blocks in motion), arrays.cache_in_use.copy())
        outcomes: dict[int, Outcome] = {}
        impacts: dict[int, list[Array]] = {}
        manner = 0
        while True:
            wanted = islands.wanted
            left = wanted[wanted > manner]
            if not left.size:
                break
            manner = int(left.min())
            mark = len(self.impacts)
            status = self._advance_some(islands, manner, motion, start, advance)
            if status != 0.0:
                return status
            impacts[manner] = self.impacts[mark:]
            del self.impacts[mark:]
            read = together(self._pieces)
            translation, rotation = (np.array(blocks) for blocks in motion)
            outcomes[manner] = Outcome(translation, rotation, arrays.cache_in_use.copy(), read)
        for manner, found in impacts.items():  # who joined a finer one later has them there
            self.impacts += cuts.of_manner(found, manner, wanted, arrays.table)
        cache, read = put_together(outcomes, wanted, arrays.table, *motion, arrays.substep_of(h))
        arrays.put_cache(cache)
        self._is_read, self._pieces, self._h = True, [read], h
        return 0.0

    def _advance_some(
        self, islands: Islands, manner: int, motion: tuple[Any, Any], start: Any,
        advance: Callable[[int], float | None],
    ) -> float:  # fmt: skip
        """
        Advance over a tick from its start in a manner, until no body is missing that is connected
        to who wants it; again, where `advance` finds that some of them want a finer one (None).
        """
        table, works, overlaps = self.arrays.table, self.work_of_drives, self._overlaps
        mark, deepest = len(self.impacts), self._overlap_counts[deep_overlaps.DEEPEST]
        while True:
            del self.impacts[mark:]
            self.arrays.works[0], self._overlaps = works, dict(overlaps)
            self._overlap_counts[deep_overlaps.DEEPEST] = deepest
            for blocks, values in zip(motion, start, strict=False):
                np.asarray(blocks)[:] = values
            self.arrays.put_cache(start[-1])
            take_part = islands.wanted == manner
            let_stand_back(~take_part, table)
            self._pairs.append([])
            status = advance(manner)
            pairs = np.concatenate([np.zeros((0, 2), dtype=np.int64), *self._pairs.pop()])
            let_stand_back(np.zeros_like(take_part), table)
            islands.join(manner, pairs)
            if status is None:
                continue
            if status != 0.0 or not ((islands.wanted == manner) & ~take_part).any():
                return status

    def _note_pairs(self) -> None:
        """Note which bodies contacts joined, where somebody asks."""
        if self._pairs:
            pairs = pairs_of(self.arrays.manifolds_in_use, self.arrays.table)
            for asked in self._pairs:
                asked.append(pairs)
            if self._events:
                met = cuts.pairs_met(self._layout.n_moving, self.arrays.event_links)
                for asked in self._pairs:
                    asked.append(met)

    def in_pieces(
        self, h: float, lengths: Sequence[float], advance: Callable[[int], float]
    ) -> float:
        """
        Advance over the pieces of one tick, and read the contacts of each before the next one
        writes over them. A short piece leaves the impulse cache as it found it.

        h       : [s] of the tick
        lengths : [s] of the pieces
        advance : advances over the piece of a number, and returns the status
        returns : the last status
        """
        counts = self.arrays.counts
        was_piece, counts[tick_counts.PIECE] = int(counts[tick_counts.PIECE]), 1
        least = SHORT * max(lengths)
        pieces: list[Read] = []
        status = 0.0
        for number, length in enumerate(lengths):
            cache = self.arrays.cache_in_use.copy() if length < least else None
            self._has_woken = False
            status = advance(number)
            if status != 0.0:
                break
            pieces += self._pieces or [self._read(self.arrays.manifolds_in_use)]
            if cache is not None and not self._has_woken:
                self.arrays.put_cache(cache)
            if len(pieces) >= PIECES_AT_ONCE:
                pieces = [together(pieces)]
        counts[tick_counts.PIECE] = was_piece
        self.arrays.put_cache(scaled(self.arrays.cache_in_use, self.arrays.substep_of(h)))
        self._pieces = [together(pieces)] if pieces else []
        self._h = h
        return status

    def _answer(self, h: float) -> None:
        """Do what the kernel returned for: let a list grow, or put in order who sleeps."""
        status = self.arrays.counts[tick_counts.STATUS]
        if status == tick_counts.WOKEN:
            self.arrays.put_cache(self._sleepers.wake(self.arrays.cache_in_use))
            self._has_woken = True
        elif status == tick_counts.FELL_ASLEEP:
            self._let_sleep(h)
        else:
            self.arrays.grow()
            return
        self.arrays.counts[tick_counts.SLEEP_CHANGED] = 1

    def _let_sleep(self, h: float) -> None:
        """Let sleepers keep the contacts of who fell asleep in the last tick of length h [s]."""
        arrays = self.arrays
        cache, manifolds = self._sleepers.fall_asleep(
            arrays.cache_in_use,
            table=arrays.table,
            manifolds=arrays.manifolds_in_use,
            h=h,
            read=lambda manifolds: self._read(manifolds)[0],
        )
        arrays.put_cache(cache)
        arrays.put_manifolds(manifolds)


def _nothing(*_arguments: Any) -> None:
    """Stand for forces, or bounces, in a scene without."""
