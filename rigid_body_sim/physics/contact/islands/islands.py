# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Islands: moving bodies that contacts or force elements join, and whether one of them is at rest.

Bodies are nodes of a `forest`. Two bodies hang together if a contact pushes between them, or may
before the tick is over, and if a force element knows both. What cannot move joins nobody, but an
island rests only where something that cannot move pushes it: what flies, or floats, goes on for
ever.

The set of islands does not depend on the order in which they are found; the number of an island,
one more than the core index of its root, does, and nothing but its name follows from it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider, manifold_record
from rigid_body_sim.physics.contact.collision.conservative_advancement import motion_of
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.islands.union_find import join, root_of
from rigid_body_sim.physics.contact.solver import cache_record

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def may_touch(m: int, h: float, reaches: Array, records: Array) -> bool:
    """Tell whether the bodies of a manifold may touch before a tick of free motion is over."""
    o = m * manifold_record.SIZE
    a, b = (
        int(records[o + manifold_record.COLLIDER_A]),
        int(records[o + manifold_record.COLLIDER_B]),
    )
    gap = records[o + manifold_record.POINTS + manifold.SEPARATION]
    for point in range(1, int(records[o + manifold_record.POINT_COUNT])):
        gap = min(
            gap, records[o + manifold_record.POINTS + point * manifold.POINT + manifold.SEPARATION]
        )
    return gap <= motion_of(reaches, a, b, h)


@kernel
def find_islands(
    manifolds: int, n_moving: int, h: float, table: Indices, reaches: Array, records: Array,
    memory: Array, groups: Indices, parents: Indices, held: Indices,
) -> None:  # fmt: skip
    """
    Hang together what was joined in a tick, after the memory of the tick was written.

    groups  : some body, the same for all that force elements join
    parents : (n_moving) becomes the root of each body
    held    : (n_moving) becomes 1 for roots of islands that something which cannot move pushes
    """
    for i in range(n_moving):
        parents[i] = i
        held[i] = 0
    for i in range(n_moving):
        join(i, groups[i], parents)
    for turn in range(2):  # first all that joins, then what holds
        at = cache_record.HEAD
        for m in range(manifolds):
            count = int(memory[at + 1])
            pushes = False
            for point in range(count):
                pushes = (
                    pushes
                    or memory[
                        at + 2 + point * cache_record.POINT_SIZE + cache_record.NORMAL_IMPULSE
                    ]
                    > 0.0
                )
            at += 2 + count * cache_record.POINT_SIZE
            a = table[
                int(records[m * manifold_record.SIZE + manifold_record.COLLIDER_A])
                * collider.TABLE
                + collider.CORE
            ]
            b = table[
                int(records[m * manifold_record.SIZE + manifold_record.COLLIDER_B])
                * collider.TABLE
                + collider.CORE
            ]
            if turn == 0:
                if a >= 0 and b >= 0 and (pushes or may_touch(m, h, reaches, records)):
                    join(a, b, parents)
            elif pushes and (a == -1 or b == -1):
                held[root_of(max(a, b), parents)] = 1
    for i in range(n_moving):
        parents[i] = root_of(i, parents)
