# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What islands keep while they sleep: the memory of their contacts, and what can be read of them.

It is part of what the next tick depends on. As numbers: SLEEPER of each body (`sleeping`), then
for each island, in the order of their numbers, its number, how many numbers its memory has, how
many contacts it shows, and both: a memory as in `cache_record`, KEPT numbers a contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.contact.collision import collider, manifold_record
from rigid_body_sim.physics.contact.islands import sleep
from rigid_body_sim.physics.contact.islands.sleep import ward_of
from rigid_body_sim.physics.contact.settings import ContactSettings
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.integration.schemes.implicit.coupling import components, neighbours
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.contacts import Contacts
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

KEPT = 12  # of a contact: bodies (2), point (3), normal (3), gap, force (3) [N]
HEAD = 3  # of an island
IMPULSES = (
    cache_record.NORMAL_IMPULSE,
    *range(cache_record.FRICTION_IMPULSE, cache_record.FRICTION_IMPULSE + 3),
    *range(cache_record.ANGULAR_IMPULSE, cache_record.ANGULAR_IMPULSE + 3),
)  # of a remembered point


@dataclass(frozen=True, eq=False)
class Island:
    """
    What one island keeps.

    memory   : of its contacts, see `cache_record`
    contacts : (m, KEPT) what can be read of them
    """

    memory: Array
    contacts: Array


class Sleepers:
    """
    The sleepers of a scene.

    arguments : of the kernels: SLEEPER per body, limits, ward (see `sleeping`)
    """

    def __init__(
        self, scene: Scene, layout: Layout, settings: ContactSettings, table: Indices,
        bounds: Array, mounts: Array,
    ) -> None:  # fmt: skip
        groups = np.arange(layout.n_moving)
        for members in components(neighbours(scene, layout)):
            groups[members] = min(members)
        radii = np.zeros(layout.n_moving)
        arms = (
            bounds.reshape(-1, collider.BOUNDS)[:, :3] - mounts.reshape(-1, collider.POSE)[:, :3]
        )
        reach = np.sqrt(np.sum(arms * arms, axis=1)) + bounds[7 :: collider.BOUNDS]
        moving = table[collider.CORE :: collider.TABLE] >= 0
        np.maximum.at(radii, table[collider.CORE :: collider.TABLE][moving], reach[moving])
        self._slumber = np.zeros(layout.n_moving * sleep.SLEEPER)
        self._islands: dict[int, Island] = {}
        self.arguments = (
            argument(self._slumber),
            argument(np.array([settings.sleep_speed, settings.sleep_time, *radii])),
            argument(ward_of(groups)),
        )

    @property
    def _names(self) -> Array:
        """Island of each body, see `sleeping.ISLAND`: a view."""
        return self._slumber[sleep.ISLAND :: sleep.SLEEPER]

    def fall_asleep(
        self, memory: Array, *, table: Indices, records: Array, h: float,
        read: Callable[[Array], Contacts],
    ) -> tuple[Array, Array]:  # fmt: skip
        """
        Take over the contacts of who fell asleep in the last tick.

            memory, records : of that tick, as far as they are in use
            read            : reads the contacts of some of the records
            returns         : what is left of the two
        """
        records = records.reshape(-1, manifold_record.SIZE)
        names = np.append(self._names, 0.0).astype(np.int64)
        fresh = np.append(~np.isin(names[:-1], list(self._islands)) & (names[:-1] > 0), False)
        cores = table[collider.CORE :: collider.TABLE][
            records[:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]].astype(np.int64)
        ]
        cores = np.where(cores < -1, -2 - cores, cores)  # the last row is of what cannot move
        awake = (cores >= 0) & (names[cores] == 0)
        owner = np.where(fresh[cores[:, 0]], names[cores[:, 0]], names[cores[:, 1]])
        moves = fresh[cores].any(axis=1) & ~awake.any(axis=1)
        sizes = (
            2 + records[:, manifold_record.POINT_COUNT].astype(np.int64) * cache_record.POINT_SIZE
        )
        starts = cache_record.HEAD + np.cumsum(sizes) - sizes
        for name in np.unique(names[fresh]).tolist():
            own = np.flatnonzero(moves & (owner == name))
            self._islands[name] = Island(
                _picked(memory, memory[0], own, starts, sizes),
                _kept(read(records[own].ravel()), h),
            )
        left = np.flatnonzero(~moves)
        return _picked(memory, memory[0], left, starts, sizes), records[left].ravel()

    def wake(self, memory: Array) -> Array:
        """Wake the islands that are marked; return the memory with their contacts."""
        names = self._names
        woken = sorted({-int(name) for name in names if name < 0.0})
        awake = np.isin(np.abs(names), woken)
        self._slumber.reshape(-1, sleep.SLEEPER)[awake] = 0.0
        found = [memory, *(self._islands.pop(name).memory for name in woken)]
        substep = float(next(part[0] for part in found if part[1] > 0.0 or part is found[-1]))
        for k, part in enumerate(found[1:], start=1):
            found[k] = part = part.copy()
            starts, sizes = _entries(part)
            points = np.repeat(starts + 2, (sizes - 2) // cache_record.POINT_SIZE)
            points += cache_record.POINT_SIZE * _count_up((sizes - 2) // cache_record.POINT_SIZE)
            part[np.add.outer(points, IMPULSES)] *= substep / part[0]
        ends = np.cumsum([0, *(len(part) for part in found)])
        places = [_entries(part) for part in found]
        starts = np.concatenate([end + at for end, (at, _) in zip(ends, places, strict=False)])
        sizes = np.concatenate([size for _, size in places])
        numbers = np.concatenate(found)
        # what is known of a pair since its island fell asleep comes first, and stays
        _, which = np.unique(numbers[starts], return_index=True)
        return _picked(numbers, substep, which, starts, sizes)

    def contacts(self, awake: Contacts, h: float) -> Contacts:
        """Add the contacts that sleepers keep to those of a tick of length h [s]."""
        kept = [self._islands[name].contacts for name in sorted(self._islands)]
        rows = np.concatenate([np.zeros((0, KEPT)), *kept])
        return Contacts(
            np.concatenate((awake.bodies, rows[:, :2].astype(np.int64))),
            np.concatenate((awake.point, rows[:, 2:5])),
            np.concatenate((awake.normal, rows[:, 5:8])),
            np.concatenate((awake.gap, rows[:, 8])),
            np.concatenate((awake.impulse, rows[:, 9:] * h)),
        )

    def snapshot(self) -> tuple[Array, dict[int, Island]]:
        """Give all of it for a return of the same run."""
        return self._slumber.copy(), dict(self._islands)

    def return_to(self, snapshot: tuple[Array, dict[int, Island]]) -> None:
        """Return to a snapshot."""
        slumber, islands = snapshot
        self._slumber[:] = slumber
        self._islands = dict(islands)

    def remembered(self) -> Array:
        """Give all of it in one row."""
        parts = [self._slumber]
        for name, island in sorted(self._islands.items()):
            sizes = len(island.memory), len(island.contacts)
            head = np.array([name, *sizes], dtype=np.float64)
            parts += [head, island.memory, island.contacts.ravel()]
        return np.concatenate(parts)

    def recall(self, numbers: Array) -> None:
        """Restore what `remembered` gave; without numbers everybody is awake."""
        size = len(self._slumber)
        self._slumber[:] = numbers[:size] if len(numbers) else 0.0
        self._islands.clear()
        at = size
        while at < len(numbers):
            name, remembered, count = numbers[at : at + HEAD].tolist()
            middle = at + HEAD + int(remembered)
            end = middle + int(count) * KEPT
            self._islands[int(name)] = Island(
                numbers[at + HEAD : middle].copy(),
                numbers[middle:end].reshape(-1, KEPT).copy(),
            )
            at = end


def _entries(memory: Array) -> tuple[Indices, Indices]:
    """Tell where the numbers of each manifold begin in a memory, and how many they are."""
    starts, at = [], cache_record.HEAD
    for _ in range(int(memory[1])):
        starts.append(at)
        at += 2 + int(memory.item(at + 1)) * cache_record.POINT_SIZE
    ends = np.array([*starts, at], dtype=np.int64)
    return ends[:-1], np.diff(ends)


def _count_up(sizes: Indices) -> Indices:
    """Count from zero in each of several runs: (2, 3) gives 0 1 0 1 2."""
    ends = np.cumsum(sizes)
    return np.arange(int(np.sum(sizes))) - np.repeat(ends - sizes, sizes)


def _picked(
    numbers: Array, substep: float, which: Indices, starts: Indices, sizes: Indices
) -> Array:
    """Make a memory of some manifolds."""
    sizes = sizes[which]
    at = np.arange(int(np.sum(sizes)))
    at += np.repeat(starts[which] - (np.cumsum(sizes) - sizes), sizes)
    return np.concatenate(([substep, float(len(which))], numbers[at]))


def _kept(contacts: Contacts, h: float) -> Array:
    force = contacts.impulse / h
    gap = contacts.gap[:, None]
    return np.hstack(
        (contacts.bodies.astype(np.float64), contacts.point, contacts.normal, gap, force)
    )
