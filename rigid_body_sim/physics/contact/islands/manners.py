# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A tick in several manners: whole for most islands, in pieces for those that need it.

Something fast hits something, or a force begins that acts on one body: only the islands concerned
are cut. The tick is made once in each manner that some island wants, from the same start, and each
island keeps what its own manner gave. For detection the others stand back then: manifolds among
themselves are not looked for.

Bodies are of one island if a manifold of their own manner, or a force element, joins them; an
island wants the finest manner that one of its bodies wants. So what an island does follows from
its own bodies alone, and what is not connected does not change a bit of each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument, kernel
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import cache_record
from rigid_body_sim.physics.contact.solver.cache_entries import cache_of, entries, scaled
from rigid_body_sim.physics.state.blocks import LANES, ROTATION, TRANSLATION
from rigid_body_sim.physics.state.contacts import OF_POINTS, Contacts

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Read = tuple[Contacts, Array]  # contacts of a tick, and which they are: see `readout.read`

WHOLE = 1  # the coarsest manner: a tick that is not cut
DIGITS = 3  # [bit] that a number of pieces keeps: few manners for many bodies, each a bit finer


def manner_of(pieces: int) -> int:
    """Give the manner of a number of pieces: as many, rounded up to a few digits."""
    more = max(0, pieces.bit_length() - DIGITS)
    return -(-pieces >> more) << more


@kernel
def _join(count: int, manner: int, pairs: Indices, wanted: Indices, roots: Indices) -> bool:
    """
    Unite bodies that pairs join, where one of the two wants a manner; the island wants the finest.
    Tell whether any were united.

    pairs : of bodies, one after the other
    """
    united = False
    for pair in range(count):
        first, second = find(pairs[2 * pair], roots), find(pairs[2 * pair + 1], roots)
        if first != second and (wanted[first] == manner or wanted[second] == manner):
            finest = max(wanted[first], wanted[second])
            unite(first, second, roots)
            wanted[min(first, second)] = finest
            united = True
    return united


def followed(roots: Indices) -> Indices:
    """Follow what may itself have a root: the last one of each."""
    while not np.array_equal(roots, roots[roots]):
        roots = roots[roots]
    return roots


class Islands:
    """
    Bodies by islands, with the manner that each wants, as far as is known.

    wanted : (n,) of each body
    """

    def __init__(self, groups: Indices, wanted: Indices) -> None:
        self._roots = groups.copy()  # for each body the first of those that force elements join
        self._wanted = wanted.copy()
        np.maximum.at(self._wanted, groups, wanted)

    @property
    def wanted(self) -> Indices:
        """Manner that each body wants."""
        return self._wanted[followed(self._roots)]

    def want(self, wanted: Indices) -> None:
        """Let islands want the manners (n,) of their bodies, where those are finer."""
        np.maximum.at(self._wanted, followed(self._roots), wanted)

    def join(self, manner: int, pairs: Indices) -> None:
        """Join what pairs (m, 2) of bodies join, that were found in a manner."""
        arrays = [argument(a) for a in (pairs.reshape(-1), self._wanted, self._roots)]
        while _join(len(pairs), manner, *arrays):
            pass


class Outcome(NamedTuple):
    """
    What a manner gave.

    translation, rotation : blocks
    cache                 : see `cache_record`
    works                 : (n,) [J] of what is moved as told, so far
    read                  : contacts
    """

    translation: Array
    rotation: Array
    cache: Array
    works: Array
    read: Read


def bodies_of_colliders(table: Indices) -> Indices:
    """Body of each collider, asleep or not; STATIC of what cannot move."""
    bodies = table[collider_record.BODY :: collider_record.SIZE]
    return np.where(bodies < collider_record.STATIC, -2 - bodies, bodies)


def pairs_of(manifolds: Array, table: Indices) -> Indices:
    """Pairs (m, 2) of moving bodies that manifolds join."""
    columns = [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]
    found = manifolds.reshape(-1, manifold_record.SIZE)[:, columns].astype(np.int64)
    pairs = bodies_of_colliders(table)[found]
    return np.ascontiguousarray(pairs[(pairs >= 0).all(axis=1)])


def pieces_wanted(manifolds: Array, table: Indices, count: int) -> Indices:
    """Manner (count,) that each body wants because of the manifolds that it has."""
    found = manifolds.reshape(-1, manifold_record.SIZE)
    fast = found[found[:, manifold_record.PIECES] > WHOLE]
    colliders = fast[:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]].astype(np.int64)
    pairs = bodies_of_colliders(table)[colliders]
    wanted = np.full(count + 1, WHOLE, dtype=np.int64)  # and one for what cannot move
    for pair, pieces in zip(pairs, fast[:, manifold_record.PIECES], strict=True):
        wanted[pair] = np.maximum(wanted[pair], manner_of(int(pieces)))
    return wanted[:-1]


def let_stand_back(bodies: NDArray[np.bool_], table: Indices) -> None:
    """Let detection leave out pairs of some bodies, and of what cannot move, among themselves."""
    back = np.append(bodies, bodies.any())
    table[collider_record.STANDS_BACK :: collider_record.SIZE] = back[bodies_of_colliders(table)]


def put_together(
    outcomes: dict[int, Outcome], wanted: Indices, table: Indices, translation: Array,
    rotation: Array, works: Array, substep: float,
) -> tuple[Array, Read]:  # fmt: skip
    """
    Write into the blocks, and the works (n,) [J], what each body has of its own manner; give cache
    and contacts of all.

    substep : [s] of a whole tick: the impulses in the cache become those of it
    """
    for blocks, size, name in (
        (translation, TRANSLATION, 'translation'),
        (rotation, ROTATION, 'rotation'),
    ):
        rows = np.asarray(blocks).reshape(-1, size // LANES, LANES)
        for manner, outcome in outcomes.items():
            block, lane = np.divmod(np.flatnonzero(wanted == manner), LANES)
            inside = block < len(rows)  # points do not turn
            block, lane = block[inside], lane[inside]
            of_manner = getattr(outcome, name).reshape(-1, size // LANES, LANES)
            rows[block, :, lane] = of_manner[block, :, lane]
    for manner, outcome in outcomes.items():
        mine = wanted == manner
        works[mine] = outcome.works[mine]
    own = _OwnPairs(wanted, table)
    caches = [(m, scaled(one.cache, substep)) for m, one in outcomes.items()]
    return _joined_caches(caches, own, substep), _joined_reads(outcomes, own)


class _OwnPairs:
    """Tells of which manner bodies are, and pairs of colliders, by their ids."""

    def __init__(self, wanted: Indices, table: Indices) -> None:
        self._bodies = bodies_of_colliders(table)
        self._wanted = np.append(wanted, WHOLE)
        scene_indices = table[collider_record.SCENE_INDEX :: collider_record.SIZE]
        self._cores = np.full(int(scene_indices.max(initial=-1)) + 1, -1)
        self._cores[scene_indices] = self._bodies

    def manners_of_bodies(self, scene_indices: Indices) -> Indices:
        return self._wanted[self._cores[scene_indices]]

    def manners(self, pair_ids: Array) -> Indices:
        later, earlier = np.divmod(pair_ids.astype(np.int64), len(self._bodies))
        bodies = np.maximum(self._bodies[later], self._bodies[earlier])
        return self._wanted[bodies]


def _joined_caches(caches: Sequence[tuple[int, Array]], own: _OwnPairs, substep: float) -> Array:
    ends = np.cumsum([0, *(len(cache) for _, cache in caches)])
    starts, sizes = [], []
    for (manner, cache), end in zip(caches, ends, strict=False):
        begins, lengths = entries(cache)
        mine = own.manners(cache[begins + cache_record.PAIR_ID]) == manner
        starts.append(end + begins[mine])
        sizes.append(lengths[mine])
    numbers = np.concatenate([cache for _, cache in caches])
    places, lengths = np.concatenate(starts), np.concatenate(sizes)
    order = np.argsort(numbers[places + cache_record.PAIR_ID], kind='stable')
    return cache_of(numbers, substep, order, places, lengths)


def _joined_reads(outcomes: dict[int, Outcome], own: _OwnPairs) -> Read:
    chosen = [own.manners(one.read[1][:, 0]) == manner for manner, one in outcomes.items()]
    reads = [one.read for one in outcomes.values()]
    which = np.concatenate([keys[mine] for (_, keys), mine in zip(reads, chosen, strict=True)])
    order = np.argsort(which[:, 0], kind='stable')

    def of_all(name: str) -> Any:
        parts = [getattr(found, name)[m] for (found, _), m in zip(reads, chosen, strict=True)]
        return np.concatenate(parts)[order]

    found = [one.read[0] for one in outcomes.values()]
    mine = [
        own.manners_of_bodies(one.damped) == manner
        for manner, one in zip(outcomes, found, strict=True)
    ]
    damped, taken_back = (
        np.concatenate([getattr(one, name)[m] for one, m in zip(found, mine, strict=True)])
        for name in ('damped', 'taken_back')
    )
    of_points = {name: of_all(name) for name in OF_POINTS}
    return Contacts(**of_points, damped=damped, taken_back=taken_back), which[order]
