# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impulse caches taken apart and put together, manifold by manifold: see `cache_record`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.solver import cache_record

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

IMPULSES = (
    cache_record.NORMAL_IMPULSE,
    *range(cache_record.FRICTION_IMPULSE, cache_record.FRICTION_IMPULSE + 3),
    *range(cache_record.ANGULAR_IMPULSE, cache_record.ANGULAR_IMPULSE + 3),
)  # of a point in the cache


def entries(cache: Array) -> tuple[Indices, Indices]:
    """Tell where the numbers of each manifold begin in a cache, and how many they are."""
    starts, place = [], cache_record.HEAD
    for _ in range(int(cache[cache_record.MANIFOLDS])):
        starts.append(place)
        points = int(cache.item(place + cache_record.POINTS))
        recycled = int(cache.item(place + cache_record.RECYCLED))
        place += cache_record.MANIFOLD_HEAD + points * cache_record.POINT_SIZE + recycled
    ends = np.array([*starts, place], dtype=np.int64)
    return ends[:-1], np.diff(ends)


def cache_of(
    numbers: Array, substep: float, chosen: Indices, starts: Indices, sizes: Indices
) -> Array:
    """Make a cache of some manifolds."""
    sizes = sizes[chosen]
    places = np.arange(int(np.sum(sizes)))
    places += np.repeat(starts[chosen] - (np.cumsum(sizes) - sizes), sizes)
    head = np.zeros(cache_record.HEAD)
    head[cache_record.SUBSTEP], head[cache_record.MANIFOLDS] = substep, len(chosen)
    return np.concatenate((head, numbers[places]))


def without_pairs_of(cache: Array, colliders: Indices, count: int) -> Array:
    """
    Make a cache without the manifolds of some colliders.

    colliders : their places in the table
    count     : of all colliders: the id of a pair is a * count + b
    """
    starts, sizes = entries(cache)
    pairs = cache[starts + cache_record.PAIR_ID].astype(np.int64)
    is_own = np.zeros(count, dtype=np.bool_)
    is_own[colliders] = True
    others = ~(is_own[pairs // count] | is_own[pairs % count])
    substep = float(cache[cache_record.SUBSTEP])
    return cache_of(cache, substep, np.flatnonzero(others), starts, sizes)


def scaled(cache: Array, substep: float) -> Array:
    """Copy a cache, with the impulses that belong to another substep [s]."""
    cache = cache.copy()
    before, cache[cache_record.SUBSTEP] = float(cache[cache_record.SUBSTEP]), substep
    if before in (0.0, substep):
        return cache
    starts, _ = entries(cache)
    counts = cache[starts + cache_record.POINTS].astype(np.int64)
    points = np.repeat(starts + cache_record.MANIFOLD_HEAD, counts)
    points += cache_record.POINT_SIZE * _count_up(counts)
    cache[np.add.outer(points, IMPULSES)] *= substep / before
    return cache


def _count_up(sizes: Indices) -> Indices:
    """Count from zero in each of several runs: (2, 3) gives 0 1 0 1 2."""
    ends = np.cumsum(sizes)
    return np.arange(int(np.sum(sizes))) - np.repeat(ends - sizes, sizes)
