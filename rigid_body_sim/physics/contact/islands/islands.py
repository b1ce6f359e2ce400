# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Islands: moving bodies that contacts or force elements join, and whether one of them is at rest.

Bodies are nodes of a forest (`union_find`). Two bodies belong to one island if a contact pushes
between them, or may before the tick is over, and if a force element knows both. What cannot move
joins nobody, but an island rests only where something that cannot move pushes it: what flies, or
floats, goes on for ever.

The set of islands does not depend on the order in which they are found; the number of an island,
one more than the core index of its root, does, and nothing but its name follows from it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.collision.collider_record import STATIC
from rigid_body_sim.physics.contact.collision.conservative_advancement import motion_of
from rigid_body_sim.physics.contact.collision.geometry import manifold as points_of
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import cache_record

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def may_touch(manifold: int, h: float, swept: Array, manifolds: Array) -> bool:
    """Tell whether the bodies of a manifold may touch before a tick of free motion is over."""
    record = manifold * manifold_record.SIZE
    collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    first = record + manifold_record.POINTS + points_of.SEPARATION
    separation = manifolds[first]
    for point in range(1, int(manifolds[record + manifold_record.POINT_COUNT])):
        separation = min(separation, manifolds[first + point * points_of.POINT])
    return separation <= motion_of(swept, collider_a, collider_b, h)


@inline
def _pushes(first: int, count: int, cache: Array) -> bool:
    """Tell whether some of so many points of the cache push."""
    pushes = False
    for point in range(count):
        impulse = first + point * cache_record.POINT_SIZE + cache_record.NORMAL_IMPULSE
        pushes = pushes or cache[impulse] > 0.0
    return pushes


@kernel
def find_islands(
    manifold_count: int, body_count: int, h: float, table: Indices, swept: Array, manifolds: Array,
    cache: Array, element_groups: Indices, roots: Indices, supported: Indices,
) -> None:  # fmt: skip
    """
    Unite what was joined in a tick, after its impulses were stored in the cache.

    element_groups : some body, the same for all that force elements join
    roots          : becomes the first body of the island of each body
    supported      : becomes 1 for roots of islands that something which cannot move pushes
    """
    for body in range(body_count):
        roots[body] = body
        supported[body] = 0
    for body in range(body_count):
        unite(body, element_groups[body], roots)
    for all_are_united in (False, True):  # first all that unites, then what supports
        place = cache_record.HEAD
        for manifold in range(manifold_count):
            count = int(cache[place + cache_record.POINTS])
            pushes = _pushes(place + cache_record.MANIFOLD_HEAD, count, cache)
            place = cache_record.next_entry(place, cache)
            record = manifold * manifold_record.SIZE
            collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
            collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
            body_a = table[collider_a * collider_record.SIZE + collider_record.BODY]
            body_b = table[collider_b * collider_record.SIZE + collider_record.BODY]
            if not all_are_united:
                if (
                    body_a >= 0
                    and body_b >= 0
                    and (pushes or may_touch(manifold, h, swept, manifolds))
                ):
                    unite(body_a, body_b, roots)
            elif pushes and (body_a == STATIC or body_b == STATIC):
                supported[find(max(body_a, body_b), roots)] = 1
    for body in range(body_count):
        roots[body] = find(body, roots)
