# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The arrays of a scene with contact: made once, but for the lists, which grow.

The kernel of the ticks takes them in groups (`tick_world.World`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact import (
    crew,
    detection,
    prescribed_bodies,
    solver_bodies,
    tick_counts,
    tick_settings,
    tick_world,
)
from rigid_body_sim.physics.contact.array_groups import Constraints, Forces, Motion
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    hash_grid,
    held_features,
    manifold_record,
    neighbour_list,
    pose,
    recycled_record,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.axis_of_symmetry import members, symmetry_of
from rigid_body_sim.physics.contact.collision.collider import (
    PLANE,
    SPHERE,
    SURFACE,
    BroadPhase,
    ColliderArrays,
    Colliders,
)
from rigid_body_sim.physics.contact.collision.deep_overlaps import make_overlaps, overlap_limits
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.ignored_pairs import ignored_colliders
from rigid_body_sim.physics.contact.collision.pair_materials import materials_of_colliders
from rigid_body_sim.physics.contact.crew import Crew
from rigid_body_sim.physics.contact.energy.scratch import EnergyScratch, make_scratch
from rigid_body_sim.physics.contact.events import (
    event_lists,
    flight_record,
    impact_list,
    joint_impact_record,
)
from rigid_body_sim.physics.contact.events.flight import Flights
from rigid_body_sim.physics.contact.events.flight_record import BEHIND_BLOCKS, VIEWS
from rigid_body_sim.physics.contact.islands import unsettled_record
from rigid_body_sim.physics.contact.islands.sleep import SleepState
from rigid_body_sim.physics.contact.packed_bodies import PackedBodies, make_packed_bodies
from rigid_body_sim.physics.contact.pair_rules import PairRules
from rigid_body_sim.physics.contact.prescribed_bodies import PrescribedBodies, driven_bodies
from rigid_body_sim.physics.contact.settings import ContactSettings
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    cache_record,
    colouring,
    constraint,
    friction_patch,
    group_record,
    lane_scratch,
)
from rigid_body_sim.physics.contact.solver.forces_of_state import SAVED
from rigid_body_sim.physics.contact.solver.group_record import most_groups
from rigid_body_sim.physics.contact.solver.impulse_cache import size_in_use
from rigid_body_sim.physics.contact.tick_settings import settings_row
from rigid_body_sim.physics.model import material
from rigid_body_sim.physics.state.blocks import LANES, blocks

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# room at first, per collider and beside
PAIRS_OF_EACH, PAIRS_BESIDE = 16, 16
MANIFOLDS_OF_EACH, MANIFOLDS_BESIDE = 4, 8
BATCHES_OF_EACH, BATCHES_BESIDE = 4, 64
COLLIDERS_OF_A_BATCH, FULL_BATCHES_BESIDE = 2, 40

EVENTS_OF_EACH, EVENTS_BESIDE = 8, 64
POINTS_OF_EACH = 16  # of an impact at several points
IMPACTS_OF_EACH, IMPACTS_BESIDE = 20, 512

CACHE_LINE = 8  # numbers


class WorldArrays:
    """
    The arrays of one scene.

    version : another number after each change of which arrays there are
    """

    def __init__(
        self,
        body_count: int,
        width: int,
        flows: Array,
        pivoted: Sequence[int],
        *,
        holds: bool,
        recycles: bool,
    ) -> None:
        """
        Make what does not depend on colliders.

        width    : numbers of a contact point
        holds    : whether points of some pairs depend on those of the last tick
        recycles : whether manifolds of some pairs follow their bodies: see `collision.recycling`
        """
        self._width, self._holds, self._recycles = width, holds, recycles
        self.version = 0
        self.pivoted = np.array(pivoted, dtype=np.int64)
        self.flows = flows
        self._body_count = body_count
        self._pulled = np.zeros(body_count, dtype=np.bool_)
        self.colours = np.zeros(body_count + 1, dtype=np.int64)
        self.partners = np.zeros(body_count + 1, dtype=np.int64)
        self.group_of = np.zeros(body_count + 1, dtype=np.int64)
        self.island_groups = np.zeros(most_groups(body_count) * group_record.SIZE, dtype=np.int64)
        self.touching = np.zeros(body_count + 1, dtype=np.int64)
        self.marks = np.zeros(body_count + 1, dtype=np.int64)
        self.saved = np.zeros(max(1, blocks(body_count)) * SAVED)
        self.open_batches = np.zeros(batch_record.OPEN_BATCHES, dtype=np.int64)
        self.found = np.zeros(manifold.FOUND)
        self.scratch = aligned(lane_scratch.SIZE)
        self.board = crew.make_board()
        self.counts = np.zeros(tick_counts.SIZE, dtype=np.int64)
        self.counts[tick_counts.LANES] = constraint.LANES
        self._energy = make_scratch(body_count)
        self.unsettled_roots = np.zeros(body_count + 1, dtype=np.int64)
        self.unsettled = np.zeros((body_count + 1) * unsettled_record.SIZE)

    def take_integrator(self, method_rows: int) -> None:
        """Make room for packed bodies; method_rows: numbers that the integrator keeps of one."""
        self._method_rows = method_rows
        self._packed = make_packed_bodies(self._body_count, method_rows)

    def take_events(self, method_rows: int, *, wanted: bool) -> None:
        """
        Make what impacts at their instants need, where they are wanted, after the colliders.

        method_rows : numbers that the integrator keeps of a body
        """
        bodies = self._body_count if wanted else 0
        self.flight_records = np.zeros(bodies * flight_record.SIZE)
        self.flight_records[flight_record.MASS_SCALE :: flight_record.SIZE] = 1.0
        self.flight_scratch = np.zeros(flight_record.BEHIND_BLOCKS + 2 * LANES * method_rows)
        room = EVENTS_OF_EACH * bodies + EVENTS_BESIDE if wanted else 0
        self._make_event_lists(room)
        self.impact_list = np.zeros((IMPACTS_OF_EACH * bodies + IMPACTS_BESIDE) * impact_list.SIZE)
        rows = 2 + bodies if wanted else 0
        self.joint_bodies = np.zeros(rows * joint_impact_record.BODY_SIZE)
        self.joint_points = np.zeros(POINTS_OF_EACH * rows * joint_impact_record.POINT_SIZE)
        if not wanted:
            self.impact_list = self.impact_list[:0]

    def _make_event_lists(self, room: int) -> None:
        self.event_pairs = np.zeros(room * flight_record.EVENT)
        links = event_lists.size_of_links(self._body_count, room) if room else 0
        self.event_links = np.zeros(links, dtype=np.int64)
        if room:
            self.take_pulled(self._pulled)

    def take_pulled(self, bodies: NDArray[np.bool_]) -> None:
        """Take over on which bodies forces act that depend on the state or on time."""
        self._pulled, count = bodies, self._body_count
        begin = event_lists.PULLED * count
        self.event_links[begin : begin + count] = bodies

    def take_colliders(self, colliders: Colliders, order: Indices) -> None:
        """Take over the colliders in an order, and make the arrays that depend on them."""

        def ordered(array: NDArray[Any], size: int) -> NDArray[Any]:
            return np.ascontiguousarray(array.reshape(-1, size)[order]).ravel()

        count = len(order)
        self.shape_parameters = colliders.shape_parameters
        self.table = ordered(colliders.table, collider_record.SIZE)
        self.local_bounds = ordered(colliders.local_bounds, bounds_record.SIZE)
        self.overlap_limits = overlap_limits(self.local_bounds)
        self.overlaps = make_overlaps()
        self.local_poses = ordered(colliders.local_poses, pose.SIZE)
        self.materials = ordered(colliders.materials, material.SIZE)
        poses = ordered(colliders.poses, pose.SIZE)
        self.poses = np.concatenate(
            (poses, np.zeros(4 * pose.SIZE))
        )  # and two of a pair at two times
        self.swept = np.zeros(max(1, count) * swept_aabbs.SIZE)
        self.fat_aabbs = np.zeros(neighbour_list.size_of_fat_aabbs(count))
        self.hash_heads = np.zeros(hash_grid.size_of_heads(count), dtype=np.int64)
        self.grid = np.zeros(max(1, count) * hash_grid.SIZE, dtype=np.int64)
        driven, rows = driven_bodies([colliders.parts[i] for i in order], self._body_count)
        self.table[collider_record.FIXED_ROW :: collider_record.SIZE] = rows
        self.drives, self.paths, self.moment, self.works, self.of_bodies = driven
        count_driven = len(driven.drives) // prescribed_bodies.SIZE
        fixed = max(most_groups(self._body_count), 1 + count_driven)
        self.bodies = aligned((self._body_count + fixed) * solver_bodies.SIZE)
        planes = self.table[collider_record.TYPE :: collider_record.SIZE] == PLANE
        self.counts[tick_counts.COLLIDERS] = count
        self.counts[tick_counts.PLANES] = int(np.sum(planes))
        surfaces = self.table[collider_record.TYPE :: collider_record.SIZE] == SURFACE
        self.counts[tick_counts.SURFACES] = int(np.sum(surfaces))
        self._note_symmetry()
        self._make_lists(count)

    def _note_symmetry(self) -> None:
        """Tell the solver how each body turns."""
        table = self.table.reshape(-1, collider_record.SIZE)
        local_poses = self.local_poses.reshape(-1, pose.SIZE)
        rows = self.bodies.reshape(-1, solver_bodies.SIZE)
        axis = slice(solver_bodies.SYMMETRY_AXIS, solver_bodies.SYMMETRY_AXIS + 3)
        for body, places in members(table[:, collider_record.BODY]):
            kinds = table[places, collider_record.TYPE].tolist()
            rows[body, solver_bodies.SYMMETRY], rows[body, axis] = symmetry_of(
                kinds, local_poses[places]
            )

    def has_ball_off_center(self) -> bool:
        """Tell whether a ball is a part of a body that does not turn about its centre."""
        table = self.table.reshape(-1, collider_record.SIZE)
        bodies = table[:, collider_record.BODY]
        balls = (table[:, collider_record.TYPE] == SPHERE) & (bodies >= 0)
        rows = self.bodies.reshape(-1, solver_bodies.SIZE)[bodies[balls]]
        return bool(np.any(rows[:, solver_bodies.SYMMETRY] != solver_bodies.CENTRED_BALL))

    def has_surface_that_turns(self) -> bool:
        """Tell whether anything that moves and touches is no ball about its centre of mass."""
        bodies = self.table.reshape(-1, collider_record.SIZE)[:, collider_record.BODY]
        rows = self.bodies.reshape(-1, solver_bodies.SIZE)[bodies[bodies >= 0]]
        turns = rows[:, solver_bodies.SYMMETRY] != solver_bodies.CENTRED_BALL
        return bool(np.any(turns)) or bool(self.drives.size)

    def _usual_radius(self) -> float:
        """Median of the bounding radii [m] of what has one."""
        radii = self.local_bounds[bounds_record.RADIUS :: bounds_record.SIZE]
        types = self.table[collider_record.TYPE :: collider_record.SIZE]
        radii = radii[np.isfinite(radii) & (radii > 0.0) & (types != SURFACE)]
        ordered, count = sorted(radii.tolist()), radii.size
        return 0.5 * (ordered[(count - 1) // 2] + ordered[count // 2]) if count else 1.0

    def take_settings(self, settings: ContactSettings) -> None:
        """Take over the settings of the scene, after the colliders."""
        self.settings = settings_row(settings, self._usual_radius())

    def take_pair_rules(self, rules: PairRules, body_count: int) -> None:
        """Take over the rules of pairs, after the colliders; body_count: of the scene."""
        self.ignored = ignored_colliders(rules.ignored, self.table, body_count)
        self.pair_material_rows = materials_of_colliders(rules, self.table, body_count)

    def take_sleep_state(self, state: SleepState) -> None:
        """Take over what is known of sleep; without it, of no bodies."""
        self.sleep_state = state

    def _make_lists(self, count: int) -> None:
        """Make the lists that grow."""
        self._make_pair_lists(PAIRS_OF_EACH * count + PAIRS_BESIDE)
        manifolds = MANIFOLDS_OF_EACH * count + MANIFOLDS_BESIDE
        self._make_manifolds(manifolds)
        room = cache_record.MOST_OF_MANIFOLD + self._recycles * recycled_record.SIZE
        self.cache = np.zeros(cache_record.HEAD + manifolds * room)
        batches = count // COLLIDERS_OF_A_BATCH + FULL_BATCHES_BESIDE
        room = constraint.SIZE + manifold.MOST * self._width + friction_patch.SIZE
        self.rows = aligned(colouring.HEAD + batches * room)
        batches = BATCHES_OF_EACH * count + BATCHES_BESIDE
        self.batches = np.zeros(batches * batch_record.ROOM, dtype=np.int64)

    def _make_manifolds(self, room: int) -> None:
        self.manifolds = np.zeros(room * manifold_record.SIZE)
        self.manifold_order = np.zeros(room, dtype=np.int64)
        self.cache_places = np.zeros(room, dtype=np.int64)
        self.members = np.zeros(room, dtype=np.int64)
        self.recycled_records = np.zeros(self._recycles * room * recycled_record.SIZE)

    def _make_pair_lists(self, room: int) -> None:
        self.neighbours = np.zeros(neighbour_list.size_of_list(room), dtype=np.int64)
        self.pair_ids = np.zeros(room, dtype=np.int64)
        self.of_parts = np.zeros(room // detection.PAIRS_OF_PART + 1, dtype=np.int64)
        self.held_features = np.zeros(self._holds * room * held_features.SIZE)
        self.recycled_places = np.zeros(self._recycles * room, dtype=np.int64)

    def pack(self) -> None:
        """Measure the lists: `world` gives others from now on."""
        counts = self.counts
        counts[tick_counts.ASSEMBLED] = 0
        counts[tick_counts.PAIR_ROOM] = len(self.pair_ids)
        counts[tick_counts.MANIFOLD_ROOM] = len(self.manifolds) // manifold_record.SIZE
        counts[tick_counts.ROW_ROOM] = len(self.rows)
        counts[tick_counts.BATCH_ROOM] = len(self.batches) // batch_record.ROOM
        counts[tick_counts.CACHE_ROOM] = len(self.cache)
        counts[tick_counts.EVENT_ROOM] = len(self.event_pairs) // flight_record.EVENT
        counts[tick_counts.IMPACT_ROOM] = len(self.impact_list) // impact_list.SIZE
        self.version += 1

    def world(self, of_motion: Sequence[Any], elements: Any, ranges: Any) -> tick_world.World:
        """
        Give all of them as the kernel takes them.

        of_motion        : what a scheme knows of the bodies that move: see `array_groups.Motion`
        elements, ranges : of the forces, see `array_groups.Forces`
        """
        motion = Motion(*of_motion, pivoted=argument(self.pivoted))
        settings, bodies, found = map(argument, (self.settings, self.bodies, self.found))
        materials, pair_materials, ignored, local_poses = map(
            argument, (self.materials, self.pair_material_rows, self.ignored, self.local_poses)
        )
        colliders = _grouped(
            ColliderArrays, self.shape_parameters, self.table, self.local_bounds, self.poses,
            self.swept,
        )  # fmt: skip
        broad_phase = _grouped(
            BroadPhase, self.fat_aabbs, self.grid, self.hash_heads, self.neighbours, self.pair_ids
        )
        constraints = _grouped(
            Constraints, self.manifolds, self.rows, self.batches, self.colours, self.partners,
            self.open_batches, self.cache, self.island_groups, self.group_of, self.manifold_order,
            self.cache_places, self.unsettled_roots, self.unsettled, self.members, self.scratch,
        )  # fmt: skip
        views, turning, method = np.split(self.flight_scratch, (VIEWS, BEHIND_BLOCKS))
        driven = _grouped(
            PrescribedBodies, self.drives, self.paths, self.moment, self.works, self.of_bodies
        )
        flights = Flights(
            motion, colliders, bodies, local_poses, found, materials, pair_materials, ignored,
            settings, driven,
            *map(argument, (
                self.joint_bodies, self.joint_points, self.flight_records, views, turning, method,
                self.event_pairs, self.event_links, self.impact_list,
            )),
        )  # fmt: skip
        return tick_world.World(
            motion,
            Forces(elements, ranges, argument(self.saved)),
            settings,
            argument(self.counts),
            colliders,
            materials,
            tick_world.Detection(
                local_poses,
                broad_phase,
                found,
                ignored,
                argument(self.recycled_places),
                argument(self.recycled_records),
                argument(self.held_features),
                argument(self.of_parts),
            ),
            bodies,
            constraints,
            argument(self.touching),
            argument(self.marks),
            _grouped(EnergyScratch, *self._energy),
            _grouped(SleepState, *self.sleep_state),
            argument(self.flows),
            pair_materials,
            driven,
            argument(self.overlap_limits),
            argument(self.overlaps),
            flights,
            _grouped(PackedBodies, *self._packed),
            _grouped(Crew, self.board, np.zeros(crew.SIZE_OF_OWN, dtype=np.int64)),
        )

    def world_of_helper(self, world: tick_world.World) -> tick_world.World:
        """Give the same with scratch of its own, for another thread: see `crew`."""
        own = np.zeros(crew.SIZE_OF_OWN, dtype=np.int64)
        own[crew.HELPS] = 1
        packed = make_packed_bodies(self._body_count, self._method_rows)
        return world._replace(
            detection=world.detection._replace(found=argument(np.zeros_like(self.found))),
            constraints=world.constraints._replace(scratch=argument(aligned(lane_scratch.SIZE))),
            packed=_grouped(PackedBodies, *packed),
            crew=_grouped(Crew, self.board, own),
        )

    def forget(self) -> None:
        """Begin anew but for the cache: the last tick was broken off anywhere, or in a piece."""
        self.counts[tick_counts.PIECE] = self.counts[tick_counts.FINE] = 0
        self.counts[tick_counts.CUTTING] = tick_counts.ASKS_FOR_CUTS
        self.counts[tick_counts.INSTANT] = tick_counts.NOTHING
        self.counts[tick_counts.IMPACTS] = 0
        self.table[collider_record.STANDS_BACK :: collider_record.SIZE] = 0
        self.neighbours[neighbour_list.AGE] = neighbour_list.NO_LIST
        for scratch in (self.colours, self.touching, self.marks, self.saved, self.open_batches):
            scratch[:] = 0

    def grow(self) -> None:
        """Double the list that was too short; nothing else in it is needed but the cache."""
        status = self.counts[tick_counts.STATUS]
        if status == tick_counts.SHORT_OF_PAIRS:
            self._make_pair_lists(2 * int(self.counts[tick_counts.PAIRS]))
        elif status == tick_counts.SHORT_OF_MANIFOLDS:
            manifolds = 2 * int(self.counts[tick_counts.MANIFOLDS])
            self._make_manifolds(manifolds)
        elif status == tick_counts.SHORT_OF_CACHE:
            self.cache = np.concatenate((self.cache, np.zeros(len(self.cache))))
        elif status == tick_counts.SHORT_OF_EVENTS:
            self._make_event_lists(2 * len(self.event_pairs) // flight_record.EVENT)
        elif status == tick_counts.SHORT_OF_IMPACTS:
            self.impact_list = np.zeros(2 * len(self.impact_list))
        else:
            self.rows = aligned(2 * len(self.rows))
            self.batches = np.zeros(2 * len(self.batches), dtype=np.int64)
        self.pack()

    def substep_of(self, h: float) -> float:
        """Substep [s] of a tick [s]."""
        return h / int(self.settings[tick_settings.SUBSTEPS])

    @property
    def work_of_drives(self) -> float:
        """Work that was done so far by what is moved as told, and by belts [J]."""
        return float(self.works.sum())

    def put_works(self, works: Array) -> None:
        """
        Let the work so far on each body be another one (n,) [J]: time passes again from an earlier
        instant.
        """
        self.works[:] = works

    @property
    def taken_back(self) -> Array:
        """What the last tick took back of each body: see `energy.scratch`."""
        return self._energy.taken

    @property
    def cache_in_use(self) -> Array:
        """The impulse cache as far as it is in use: a view."""
        return self.cache[: size_in_use(self.cache)]

    def put_cache(self, numbers: Array) -> None:
        """Write the impulse cache; no numbers: nothing is known of any contact."""
        if len(numbers) > len(self.cache):
            self.cache = np.zeros(len(numbers))
            self.pack()
        self.cache[: cache_record.HEAD] = 0.0
        self.cache[: len(numbers)] = numbers
        self.counts[tick_counts.ASSEMBLED] = 0

    @property
    def manifolds_in_use(self) -> Array:
        """Manifolds of the last tick or piece: a view."""
        return self.manifolds[: self.counts[tick_counts.MANIFOLDS] * manifold_record.SIZE]

    def put_manifolds(self, manifolds: Array) -> None:
        """Write the manifolds that are left."""
        self.manifolds[: len(manifolds)] = manifolds
        self.counts[tick_counts.MANIFOLDS] = len(manifolds) // manifold_record.SIZE


def _grouped(kind: type[Any], *arrays: Array | Indices) -> Any:
    """Put arrays into a group as a kernel takes them."""
    return kind(*map(argument, arrays))


def aligned(size: int) -> Array:
    """
    Make zeros that begin where a cache line does: eight lanes are one line, and a vector that
    straddles two costs twice as much.
    """
    array = np.zeros(size + CACHE_LINE)
    skip = -array.ctypes.data // array.itemsize % CACHE_LINE
    return array[skip : skip + size]
