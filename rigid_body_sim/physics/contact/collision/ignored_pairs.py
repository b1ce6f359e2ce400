# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Pairs that the scene says do not meet: taken out of those that the broad phase has found.
"""

from __future__ import annotations

import numpy as np

from rigid_body_sim.physics.arrays import Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider_record


@inline
def is_ignored(pair_id: int, ignored: Indices) -> bool:
    """Tell whether a pair is one of those, which are in rising order."""
    low, high = 0, len(ignored)
    while low < high:
        middle = (low + high) // 2
        if ignored[middle] < pair_id:
            low = middle + 1
        else:
            high = middle
    return low < len(ignored) and ignored[low] == pair_id


@kernel
def without_ignored(pairs: int, ignored: Indices, pair_ids: Indices) -> int:
    """
    Take the ignored ones out of so many pairs, in place; return how many are left.

    ignored, pair_ids : in rising order
    """
    left = 0
    for pair in range(pairs):
        pair_id = pair_ids[pair]
        if is_ignored(pair_id, ignored):
            continue
        pair_ids[left] = pair_id
        left += 1
    return left


def ignored_colliders(ignored: Indices, table: Indices, body_count: int) -> Indices:
    """Give the ids of pairs that do not meet (n,), in rising order: see `pair_rules`."""
    return np.sort(pairs_of_colliders(ignored, table, body_count)[0])


def pairs_of_colliders(pairs: Indices, table: Indices, body_count: int) -> tuple[Indices, Indices]:
    """
    Give the pair ids of the colliders of pairs of bodies, and which pair each is of.

    table : of the colliders in their order
    """
    of_body = table[collider_record.SCENE_INDEX :: collider_record.SIZE]
    count = len(of_body)
    order = np.argsort(of_body, kind='stable')
    first = np.searchsorted(of_body[order], np.arange(body_count))
    parts = np.bincount(of_body, minlength=body_count)
    low, high = pairs // body_count, pairs % body_count
    ids, of_pair = [], []
    for i, j in np.ndindex(*(int(np.max(parts, initial=0)),) * 2):
        both = np.flatnonzero((parts[low] > i) & (parts[high] > j))
        a, b = order[first[low[both]] + i], order[first[high[both]] + j]
        ids.append(np.maximum(a, b) * count + np.minimum(a, b))
        of_pair.append(both)
    if not ids:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    return np.concatenate(ids), np.concatenate(of_pair)
