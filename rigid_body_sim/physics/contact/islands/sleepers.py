# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What islands keep while they sleep: the impulse cache of their contacts, and what can be read of
them.

It is part of what the next tick depends on. As numbers: the sleep state of each body
(`sleep_record`), then for each island, in the order of their numbers, a head (`island` below), a
cache as in `solver.cache_record`, and its contacts (`kept` below).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    pose,
)
from rigid_body_sim.physics.contact.islands import sleep_record
from rigid_body_sim.physics.contact.islands.groups import groups_of
from rigid_body_sim.physics.contact.islands.sleep import make_sleep_state
from rigid_body_sim.physics.contact.islands.sleep_record import AWAKE
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.contact.solver.cache_entries import cache_of, entries, scaled
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.contacts import Contacts
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

island = Record()  # its head
NUMBER = island.number('-', 'of the island')
CACHE_LENGTH = island.number('-', 'how many numbers its cache has')
CONTACT_COUNT = island.number('-', 'how many contacts it shows')
HEAD = island.size

kept = Record()  # a contact that can be read
BODIES = kept.numbers(2, '-', 'indices in the scene')
POINT = kept.vector('m', 'world')
NORMAL = kept.vector('-', 'from the first body to the second, world axes')
SEPARATION = kept.number('m', 'negative: overlap')
FORCE = kept.vector('N', 'upon the second body, world axes')
TORQUE = kept.vector('N m', 'beside it, of rolling and torsional friction')
KEPT = kept.size


@dataclass(frozen=True, eq=False)
class Island:
    """
    What one island keeps.

    cache    : impulses of its contacts, see `cache_record`
    contacts : (m, KEPT) what can be read of them
    """

    cache: Array
    contacts: Array


def _axes(begin: int) -> slice:
    """Columns of a vector that begins in one."""
    return slice(begin, begin + 3)


def _radii_of(body_count: int, table: Indices, local_bounds: Array, local_poses: Array) -> Array:
    """Radii (n,) of the balls about the centres of mass that hold the shapes of bodies."""
    radii = np.zeros(body_count)
    bounds = local_bounds.reshape(-1, bounds_record.SIZE)
    centres = bounds[:, _axes(bounds_record.CENTER)]
    arms = centres - local_poses.reshape(-1, pose.SIZE)[:, _axes(pose.POSITION)]
    reach = np.sqrt(np.sum(arms * arms, axis=1)) + bounds[:, bounds_record.RADIUS]
    cores = table[collider_record.BODY :: collider_record.SIZE]
    moving = cores >= 0
    np.maximum.at(radii, cores[moving], reach[moving])
    return radii


class Sleepers:
    """
    The sleepers of a scene.

    state : of the kernels, see `sleep.SleepState`
    """

    def __init__(
        self, scene: Scene, layout: Layout, table: Indices, local_bounds: Array,
        local_poses: Array,
    ) -> None:  # fmt: skip
        radii = _radii_of(layout.n_moving, table, local_bounds, local_poses)
        self.state = make_sleep_state(radii, groups_of(scene, layout))
        self._islands: dict[int, Island] = {}

    @property
    def _names(self) -> Array:
        """Island of each body, see `sleep_record.ISLAND`: a view."""
        return self.state.sleep_states[sleep_record.ISLAND :: sleep_record.SIZE]

    def fall_asleep(
        self, cache: Array, *, table: Indices, manifolds: Array, h: float,
        read: Callable[[Array], Contacts],
    ) -> tuple[Array, Array]:  # fmt: skip
        """
        Take over the contacts of who fell asleep in the last tick.

            cache, manifolds : of that tick, as far as they are in use
            read           : reads the contacts of some of the manifolds
            returns        : what is left of the two
        """
        manifolds = manifolds.reshape(-1, manifold_record.SIZE)
        names = np.append(self._names, AWAKE).astype(np.int64)
        fresh = np.append(~np.isin(names[:-1], list(self._islands)) & (names[:-1] > 0), False)
        cores = table[collider_record.BODY :: collider_record.SIZE][
            manifolds[:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]].astype(np.int64)
        ]
        cores = np.where(cores < -1, -2 - cores, cores)  # the last row is of what cannot move
        awake = (cores >= 0) & (names[cores] == 0)
        owner = np.where(fresh[cores[:, 0]], names[cores[:, 0]], names[cores[:, 1]])
        moves = fresh[cores].any(axis=1) & ~awake.any(axis=1)
        starts, sizes = entries(cache)
        substep = cache[cache_record.SUBSTEP]
        for name in np.unique(names[fresh]).tolist():
            own = np.flatnonzero(moves & (owner == name))
            self._islands[name] = Island(
                cache_of(cache, substep, own, starts, sizes),
                _kept(read(manifolds[own].ravel()), h),
            )
        left = np.flatnonzero(~moves)
        return cache_of(cache, substep, left, starts, sizes), manifolds[left].ravel()

    def wake(self, cache: Array) -> Array:
        """Wake the islands that are marked; return the cache with their contacts."""
        names = self._names
        woken = sorted({-int(name) for name in names if name < AWAKE})
        awake = np.isin(np.abs(names), woken)
        self.state.sleep_states.reshape(-1, sleep_record.SIZE)[awake] = 0.0
        caches = [cache, *(self._islands.pop(name).cache for name in woken)]
        substep = float(
            next(
                one[cache_record.SUBSTEP]
                for one in caches
                if one[cache_record.MANIFOLDS] > 0.0 or one is caches[-1]
            )
        )
        caches[1:] = [scaled(one, substep) for one in caches[1:]]
        ends = np.cumsum([0, *(len(one) for one in caches)])
        places = [entries(one) for one in caches]
        starts = np.concatenate(
            [end + begin for end, (begin, _) in zip(ends, places, strict=False)]
        )
        sizes = np.concatenate([size for _, size in places])
        numbers = np.concatenate(caches)
        # what is known of a pair since its island fell asleep comes first, and stays
        _, chosen = np.unique(numbers[starts + cache_record.PAIR_ID], return_index=True)
        return cache_of(numbers, substep, chosen, starts, sizes)

    def wake_body(self, core: int, cache: Array) -> Array:
        """
        Wake the island of a body, if it sleeps; it has not rested yet. Return the cache with the
        contacts of who wakes.
        """
        name = self._names[core]
        if name != AWAKE:
            self._names[np.abs(self._names) == abs(name)] = -abs(name)
            cache = self.wake(cache)
        self.state.sleep_states.reshape(-1, sleep_record.SIZE)[core] = 0.0
        return cache

    def contacts(self, awake: Contacts, h: float) -> Contacts:
        """Add the contacts that sleepers keep to those of a tick of length h [s]."""
        kept = [self._islands[name].contacts for name in sorted(self._islands)]
        rows = np.concatenate([np.zeros((0, KEPT)), *kept])
        return Contacts(
            np.concatenate((awake.bodies, rows[:, BODIES : BODIES + 2].astype(np.int64))),
            np.concatenate((awake.point, rows[:, _axes(POINT)])),
            np.concatenate((awake.normal, rows[:, _axes(NORMAL)])),
            np.concatenate((awake.gap, rows[:, SEPARATION])),
            np.concatenate((awake.impulse, rows[:, _axes(FORCE)] * h)),
            np.concatenate((awake.angular_impulse, rows[:, _axes(TORQUE)] * h)),
            awake.damped,
            awake.taken_back,
        )

    def snapshot(self) -> tuple[Array, dict[int, Island]]:
        """Give all of it for a return of the same run."""
        return self.state.sleep_states.copy(), dict(self._islands)

    def return_to(self, snapshot: tuple[Array, dict[int, Island]]) -> None:
        """Return to a snapshot."""
        sleep, islands = snapshot
        self.state.sleep_states[:] = sleep
        self._islands = dict(islands)

    def remembered(self) -> Array:
        """Give all of it in one row."""
        parts = [self.state.sleep_states]
        for name, one in sorted(self._islands.items()):
            head = np.zeros(HEAD)
            head[NUMBER], head[CACHE_LENGTH] = name, len(one.cache)
            head[CONTACT_COUNT] = len(one.contacts)
            parts += [head, one.cache, one.contacts.ravel()]
        return np.concatenate(parts)

    def recall(self, numbers: Array) -> None:
        """
        Restore what `remembered` gave; without numbers everybody is awake.

        Raises ValueError for other numbers.
        """
        size = len(self.state.sleep_states)
        if 0 < len(numbers) < size:
            raise ValueError(f'{len(numbers)} numbers of who sleeps; {size} are needed')
        self.state.sleep_states[:] = numbers[:size] if len(numbers) else 0.0
        self._islands.clear()
        begin = size
        while begin < len(numbers):
            head = numbers[begin : begin + HEAD]
            middle = begin + HEAD + int(head[CACHE_LENGTH])
            end = middle + int(head[CONTACT_COUNT]) * KEPT
            if not begin < middle <= end <= len(numbers):
                raise ValueError('what it holds of islands that sleep is not whole, or too long')
            self._islands[int(head[NUMBER])] = Island(
                numbers[begin + HEAD : middle].copy(),
                numbers[middle:end].reshape(-1, KEPT).copy(),
            )
            begin = end


def _kept(contacts: Contacts, h: float) -> Array:
    """Rows (m, KEPT) of what can be read of contacts over a tick of length h [s]."""
    rows = np.zeros((len(contacts.gap), KEPT))
    rows[:, BODIES : BODIES + 2] = contacts.bodies
    rows[:, _axes(POINT)] = contacts.point
    rows[:, _axes(NORMAL)] = contacts.normal
    rows[:, SEPARATION] = contacts.gap
    rows[:, _axes(FORCE)] = contacts.impulse / h
    rows[:, _axes(TORQUE)] = contacts.angular_impulse / h
    return rows
