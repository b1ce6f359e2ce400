# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The contact of one scene: its colliders in their order, its arrays, its kernel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact import solver_bodies, step
from rigid_body_sim.physics.contact.collision import collider, manifold_record, swept_aabbs
from rigid_body_sim.physics.contact.collision.axis_of_symmetry import (
    members,
    symmetry_features,
    symmetry_of,
)
from rigid_body_sim.physics.contact.collision.collider import Colliders
from rigid_body_sim.physics.contact.collision.collider_order import order
from rigid_body_sim.physics.contact.collision.convexity_defect import convexity_warnings
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.hash_grid import SIZE as CELL
from rigid_body_sim.physics.contact.collision.hash_grid import size_of_heads
from rigid_body_sim.physics.contact.collision.narrow_phase import manifold_finder
from rigid_body_sim.physics.contact.collision.neighbour_list import size_of_fat_aabbs, size_of_list
from rigid_body_sim.physics.contact.collision.pairs import collide_kernel
from rigid_body_sim.physics.contact.energy import pressing_groups
from rigid_body_sim.physics.contact.islands import sleep
from rigid_body_sim.physics.contact.readout import read, together
from rigid_body_sim.physics.contact.settings import ContactSettings
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    cache_record,
    constraint,
    contact_point,
    forces_of_state,
    lane_scratch,
    variable_mass,
)
from rigid_body_sim.physics.contact.solver.impulse_cache import size_in_use
from rigid_body_sim.physics.contact.solver.iterations import solver
from rigid_body_sim.physics.contact.suited_integrators import unsuited
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.blocks import blocks
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PIECES_AT_ONCE = 64  # [-] whose contacts are kept apart; more take memory, fewer take time


class ContactPlan:
    """
    What the contact of a scene needs beside the blocks.

    settings : of the scene
    warnings : what the scene should know before it starts, a line each
    """

    def __init__(self, scene: Scene, layout: Layout, integrator: Integrator) -> None:
        reason = unsuited(integrator)
        if reason is not None:
            raise InvalidModel(
                f'integrator {integrator.name!r} refuses the scene {scene.name!r}: {reason}',
                at=('integrator',),
            )
        self.settings = ContactSettings.of(scene.contact)
        self._layout = layout
        self._integrator = integrator
        colliders = Colliders.of(scene, layout)
        self.warnings = convexity_warnings(scene)
        self._order = order(scene, colliders)
        self._kinds = colliders.pairs()
        materials = colliders.materials.reshape(-1, collider.MATERIAL)
        self.angular = bool(np.any(materials[:, 2:] > 0.0))
        self.bounces = bool(np.any(materials[:, 0] > 0.0))
        self._width = (
            contact_point.SIZE_LONG if self.angular or self.bounces else contact_point.SIZE
        )
        self._take(colliders)
        self._flows = variable_mass.flows_of(layout, colliders.bodies.tolist())
        self._sleepers: Any = None
        if self.settings.sleeping:
            from rigid_body_sim.physics.contact.islands.sleepers import Sleepers

            self._sleepers = Sleepers(
                scene, layout, self.settings, self.table, self.bounds, self.mounts
            )
        self._make_room(len(self._order))
        self._kernels: dict[str, Callable[..., Any]] = {}
        self._is_read = False  # whether the rows are those of the last tick
        self._h = 0.0  # [s] of the last tick
        self._pieces: list[tuple[Contacts, Array]] = []  # of the last tick, if it was cut

    def _take(self, colliders: Colliders) -> None:
        """Bring the colliders into their order."""
        n = len(self._order)

        def ordered(array: NDArray[Any], size: int) -> NDArray[Any]:
            return np.ascontiguousarray(array.reshape(-1, size)[self._order]).ravel()

        self.numbers = colliders.shape_parameters
        self.table = ordered(colliders.table, collider.TABLE)
        self.bounds = ordered(colliders.local_bounds, collider.BOUNDS)
        self.mounts = ordered(colliders.local_poses, collider.POSE)
        self.materials = ordered(colliders.materials, collider.MATERIAL)
        self.poses = np.concatenate(
            (ordered(colliders.poses, collider.POSE), np.zeros(2 * collider.POSE))
        )
        self.reaches = np.zeros(max(1, n) * swept_aabbs.SIZE)
        self.found = np.zeros(manifold.FOUND)
        self.bodies = _aligned((self._layout.n_moving + 1) * solver_bodies.SIZE)
        table, mounts = (
            self.table.reshape(-1, collider.TABLE),
            self.mounts.reshape(-1, collider.POSE),
        )
        for core, places in members(table[:, collider.CORE]):
            row = self.bodies[core * solver_bodies.SIZE : (core + 1) * solver_bodies.SIZE]
            kinds = table[places, collider.TYPE].tolist()
            (
                row[solver_bodies.SYMMETRY],
                row[solver_bodies.SYMMETRY_AXIS : solver_bodies.SYMMETRY_AXIS + 3],
            ) = symmetry_of(kinds, mounts[places])

    def _make_room(self, n: int) -> None:
        """Make the lists that grow."""
        moving = self._layout.n_moving
        self.rooms = np.zeros(size_of_fat_aabbs(n))
        self.heads = np.zeros(size_of_heads(n), dtype=np.int64)
        self.grid = np.zeros(max(1, n) * CELL, dtype=np.int64)
        self._make_room_for_pairs(16 * n + 16)
        self.records = np.zeros((4 * n + 8) * manifold_record.SIZE)
        self.memory = np.zeros(
            cache_record.HEAD
            + (4 * n + 8) * (cache_record.MANIFOLD_HEAD + manifold.MOST * cache_record.POINT_SIZE)
        )
        self.rows = _aligned(
            lane_scratch.SIZE + (n // 2 + 40) * (constraint.SIZE + 4 * self._width)
        )
        self.batches = np.zeros((4 * n + 64) * batch_record.SIZE, dtype=np.int64)
        self.colours = np.zeros(moving + 1, dtype=np.int64)
        self.open_batches = np.zeros(batch_record.OPEN_BATCHES, dtype=np.int64)
        self.touching = np.zeros(moving + 1, dtype=np.int64)
        self.marks = np.zeros(moving + 1, dtype=np.int64)
        self.groups = np.zeros(moving + 1, dtype=np.int64)
        self.accounts = np.zeros((moving + 1) * pressing_groups.ACCOUNT)
        self.workspace = np.zeros(max(1, blocks(moving)) * forces_of_state.SAVED)
        self.counts = np.zeros(step.COUNTS, dtype=np.int64)
        self.counts[step.N_COLLIDERS] = n
        self.counts[step.LANES_AT_ONCE] = constraint.LANES
        self.counts[step.PLANES] = int(
            np.sum(self.table[collider.TYPE :: collider.TABLE] == collider.PLANE)
        )
        radii = self.bounds[7 :: collider.BOUNDS]
        radii = radii[np.isfinite(radii) & (radii > 0.0)]
        radius = float(np.median(radii)) if radii.size else 1.0
        s = self.settings
        self.numbers_of_settings = np.array(
            [
                s.substeps, s.damping_ratio, s.relaxations, s.restitution_threshold, s.slop,
                s.push_out_speed, s.margin, radius,
            ],
            dtype=np.float64,
        )  # fmt: skip
        self._pack()

    def _make_room_for_pairs(self, room: int) -> None:
        self.kept = np.zeros(size_of_list(room), dtype=np.int64)
        self.keys = np.zeros(room, dtype=np.int64)

    def _pack(self) -> None:
        """Measure the lists and make the arguments of the kernel."""
        counts = self.counts
        counts[step.ASSEMBLED] = 0
        counts[step.PAIR_ROOM] = len(self.keys)
        counts[step.MANIFOLD_ROOM] = len(self.records) // manifold_record.SIZE
        counts[step.ROW_ROOM] = len(self.rows)
        counts[step.BATCH_ROOM] = len(self.batches) // batch_record.SIZE
        counts[step.MEMORY_ROOM] = len(self.memory)
        self._arguments = tuple(
            argument(array)
            for array in (
                self.numbers_of_settings, counts, self.numbers, self.table, self.bounds,
                self.mounts, self.materials, self.poses, self.reaches, self.found, self.bodies,
                self.rows, self.records, self.memory, self.rooms, self.grid, self.heads, self.kept,
                self.keys,
                self.batches, self.colours, self.open_batches, self.touching,
                self.marks, self.groups,
                self.accounts,
            )
        )  # fmt: skip
        nothing = 3 * (argument(np.zeros(0)),)
        self._arguments += nothing if self._sleepers is None else self._sleepers.arguments
        self._arguments += (argument(self._flows),)

    def _grow(self) -> None:
        """Double the list that was too short; nothing else in it is needed but the memory."""
        short = self.counts[step.SHORT]
        if short == step.SHORT_OF_PAIRS:
            self._make_room_for_pairs(2 * int(self.counts[step.PAIRS]))
        elif short == step.SHORT_OF_MANIFOLDS:
            self.records = np.zeros(2 * int(self.counts[step.MANIFOLDS]) * manifold_record.SIZE)
        elif short == step.SHORT_OF_MEMORY:
            self.memory = np.concatenate((self.memory, np.zeros(len(self.memory))))
        else:
            self.rows = _aligned(2 * len(self.rows))
            self.batches = np.zeros(2 * len(self.batches), dtype=np.int64)
        self._pack()

    def _answer(self, h: float) -> None:
        """Do what the kernel returned for: make room, or put in order who sleeps."""
        short = self.counts[step.SHORT]
        if self._sleepers is None or short not in (step.WOKEN, step.FELL_ASLEEP):
            self._grow()
            return
        memory = self.memory[: size_in_use(self.memory)]
        if short == step.WOKEN:
            self._put_memory(self._sleepers.wake(memory))
        else:
            memory, records = self._sleepers.fall_asleep(
                memory,
                table=self.table,
                records=self._records,
                h=h,
                read=lambda records: self._read(records)[0],
            )
            self._put_memory(memory)
            self.records[: len(records)] = records
            self.counts[step.MANIFOLDS] = len(records) // manifold_record.SIZE
        self.counts[step.STALE] = 1

    def remembered(self) -> Array:
        """Give what the next tick starts from beside the blocks: see `cache_record`."""
        memory = self.memory[: size_in_use(self.memory)].copy()
        if self._sleepers is None:
            return memory
        return np.concatenate((memory, self._sleepers.remembered()))

    def recall(self, numbers: Array) -> None:
        """Restore what `remembered` gave; without numbers there is no memory of any contact."""
        if self._sleepers is not None:
            end = size_in_use(numbers) if len(numbers) else 0
            self._sleepers.recall(numbers[end:])
            self.counts[step.STALE] = 1
            numbers = numbers[:end]
        self._put_memory(numbers)
        self._is_read = False

    def snapshot(self) -> tuple[Any, ...]:
        """Give what `remembered` gives for a return of the same run: what sleeps is not copied."""
        memory = self.memory[: size_in_use(self.memory)].copy()
        return memory, None if self._sleepers is None else self._sleepers.snapshot()

    def return_to(self, snapshot: tuple[Any, ...]) -> None:
        """Return to a snapshot."""
        memory, sleepers = snapshot
        if self._sleepers is not None:
            self._sleepers.return_to(sleepers)
            self.counts[step.STALE] = 1
        self._put_memory(memory)
        self._is_read = False

    def _put_memory(self, numbers: Array) -> None:
        if len(numbers) > len(self.memory):
            self.memory = np.zeros(len(numbers))
            self._pack()
        self.memory[: cache_record.HEAD] = 0.0
        self.memory[: len(numbers)] = numbers
        self.counts[step.ASSEMBLED] = 0

    def contacts(self) -> Contacts:
        """Read the contacts of the last tick; none before the first."""
        if not self._is_read:
            return NO_CONTACTS
        found = together(self._pieces) if self._pieces else self._read(self._records)
        return found[0] if self._sleepers is None else self._sleepers.contacts(found[0], self._h)

    @property
    def _records(self) -> Array:
        """Records of the manifolds of the last tick or piece."""
        return self.records[: self.counts[step.MANIFOLDS] * manifold_record.SIZE]

    def _read(self, records: Array) -> tuple[Contacts, Array]:
        return read(
            len(records) // manifold_record.SIZE,
            width=self._width,
            bounces=self.bounces,
            table=self.table,
            records=records,
            rows=self.rows,
            bodies=self.bodies,
        )

    def kernel(
        self, scene: str, evaluate: Callable[..., Any] | None, velocity_dependent: bool
    ) -> Callable[..., Any]:
        """
        Make the kernel of the scene, with the usual call of a scheme.

        scene, evaluate, velocity_dependent : as of `Scheme.coupled`; evaluate None: nothing
                                              depends on the state
        """
        if scene not in self._kernels:
            assert isinstance(self._integrator.scheme, Splitting)
            flags = {'angular': self.angular, 'bounces': self.bounces}
            flags['turns'] = bool(np.ptp(self._layout.moments, axis=1).any() or self._flows.size)
            pairs = [(a, b, collide_kernel(a, b)) for a, b in self._kinds]
            passes = solver(width=self._width, **flags, **symmetry_features(self._kinds))
            if self._sleepers is not None:
                passes |= sleep.KERNELS
            if self._flows.size:
                passes |= variable_mass.KERNELS
            compiled = step.tick_kernel(
                f'{self._integrator.name}_{scene}',
                WIDTH=self._width,
                ANGULAR=self.angular,
                BOUNCES=self.bounces,
                COUPLED=evaluate is not None,
                VELOCITY_DEPENDENT=velocity_dependent,
                SLEEPING=self._sleepers is not None,
                FLOWS=self._flows.size > 0,
                drift_rotation=self._integrator.scheme.drift_rotation,
                evaluate=_nothing if evaluate is None else evaluate,
                find_manifolds=manifold_finder(pairs),
                **passes,
            )
            self._kernels[scene] = self._with_arrays(compiled)
        return self._kernels[scene]

    def _with_arrays(self, compiled: Callable[..., Any]) -> Callable[..., Any]:
        def advance(
            ticks: int, at: float, h: float, n_moving: int, n_rigid: int, translation: Any,
            rotation: Any, method: Any, workspace: Any, elements: Any, ranges: Any,
        ) -> float:  # fmt: skip
            own = argument(self.workspace)
            done, status = 0, 0.0
            while True:
                status = compiled(
                    ticks - done, at + done, h, n_moving, n_rigid, translation, rotation, method,
                    own, elements, ranges, *self._arguments,
                )  # fmt: skip
                if self.counts[step.DONE]:
                    done += int(self.counts[step.DONE])
                    self._is_read, self._pieces = True, []
                self._h = h
                if status != 0.0 or self.counts[step.SHORT] == step.NOTHING_SHORT:
                    return status
                if self.counts[step.SHORT] != step.TOO_LONG:
                    self._answer(h)
                    if done == ticks:
                        return status
                    continue
                status = self._in_pieces(
                    compiled, at + done, h, n_moving, n_rigid, translation, rotation, method, own,
                    elements, ranges,
                )  # fmt: skip
                done += 1
                self._is_read = True
                if status != 0.0 or done == ticks:
                    return status

        return advance

    def _in_pieces(
        self, compiled: Callable[..., Any], at: float, h: float, *arguments: Any
    ) -> float:
        """
        Advance over one tick in pieces, because something fast hits something in it, and read the
        contacts of each piece before the next one writes over them.
        """
        pieces = int(self.counts[step.PIECES])
        self.counts[step.CUT] = pieces
        self._pieces = []
        done, status = 0, 0.0
        while done < pieces and status == 0.0:
            status = compiled(1, at * pieces + done, h / pieces, *arguments, *self._arguments)
            if self.counts[step.DONE]:
                done += 1
                self._pieces.append(self._read(self._records))
                if len(self._pieces) == PIECES_AT_ONCE:
                    self._pieces = [together(self._pieces)]
            elif status == 0.0:
                self._answer(h / pieces)
        self.counts[step.CUT] = 0
        return status


def _aligned(size: int) -> Array:
    """
    Make zeros that begin where a cache line does: eight lanes are one line, and a vector that
    straddles two costs twice as much.
    """
    array = np.zeros(size + 8)
    skip = -array.ctypes.data // 8 % 8
    return array[skip : skip + size]


def _nothing(*_arguments: Any) -> None:
    """Stand for the forces of a scene where there are none that depend on its state."""
