# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Groups of islands that the solver visits one after the other, so that what it needs of a group
stays in the cache of the processor: all passes between two motions, before the next group.

Islands of a tick are bodies that manifolds join. In the order of their first bodies they fill
groups of like size, an even number for the sake of two threads, of MANIFOLDS manifolds at most or
little more; a larger island is a group of its own. Islands share no body
that moves, so it changes no bit where a group ends.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver.group_record import FIRST_BODY, FIRST_MANIFOLD, SIZE

# [-] some 400 kB of rows and bodies: a quarter of them costs calls and empty lanes, four times as
# many leave a second-level cache of 1 MB
MANIFOLDS = 200
FEW = 2 * MANIFOLDS  # [-] so many are one group: they fit all the same


@inline
def _one_of(index: int, manifolds: Array, table: Indices) -> int:
    """A body of a manifold that moves."""
    record = index * manifold_record.SIZE
    collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    body_a = table[collider_a * collider_record.SIZE + collider_record.BODY]
    return (
        body_a if body_a >= 0 else table[collider_b * collider_record.SIZE + collider_record.BODY]
    )


@inline
def _find_islands(
    manifold_count: int, body_count: int, table: Indices, manifolds: Array, roots: Indices,
    sizes: Indices,
) -> None:  # fmt: skip
    """Unite what manifolds join, and count the manifolds of each island at its root."""
    for body in range(body_count):
        roots[body] = body
        sizes[body] = 0
    for index in range(manifold_count):
        record = index * manifold_record.SIZE
        collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
        collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
        body_a = table[collider_a * collider_record.SIZE + collider_record.BODY]
        body_b = table[collider_b * collider_record.SIZE + collider_record.BODY]
        if body_a >= 0 and body_b >= 0:
            unite(body_a, body_b, roots)
    for index in range(manifold_count):
        sizes[find(_one_of(index, manifolds, table), roots)] += 1


@inline
def _fill_groups(manifold_count: int, body_count: int, roots: Indices, group_of: Indices) -> int:
    """Put the islands into groups, in place of their sizes; return how many groups there are."""
    usual = 0.5 * manifold_count / math.ceil(0.5 * manifold_count / MANIFOLDS)
    number, filled = 0, 0
    for body in range(body_count):
        root = find(body, roots)
        if root == body:  # the first body of its island
            size = group_of[body]
            if filled > 0 and filled + 0.5 * size > usual:
                number, filled = number + 1, 0
            filled += size
            group_of[body] = number
        else:
            group_of[body] = group_of[root]
    return number + 1


@kernel
def find_groups(
    manifold_count: int, body_count: int, apart: bool, table: Indices, manifolds: Array,
    roots: Indices, group_of: Indices, groups: Indices, order: Indices,
) -> int:  # fmt: skip
    """
    Put the manifolds in the order of their groups; return how many groups there are.

    apart    : False: one group of all
    roots    : scratch, a number for each body
    group_of : the group of each body
    groups   : the table of groups; its FIRST_MANIFOLD
    order    : manifolds, those of one group after the other, in each as they come
    """
    if not apart or manifold_count <= FEW:
        groups[FIRST_MANIFOLD], groups[SIZE + FIRST_MANIFOLD] = 0, manifold_count
        for index in range(manifold_count):
            order[index] = index
        return 1
    _find_islands(manifold_count, body_count, table, manifolds, roots, group_of)
    count = _fill_groups(manifold_count, body_count, roots, group_of)
    for number in range(count + 1):
        groups[number * SIZE + FIRST_MANIFOLD] = 0
    for index in range(manifold_count):
        number = group_of[_one_of(index, manifolds, table)]
        groups[(number + 1) * SIZE + FIRST_MANIFOLD] += 1
    for number in range(count):
        groups[(number + 1) * SIZE + FIRST_MANIFOLD] += groups[number * SIZE + FIRST_MANIFOLD]
    for index in range(manifold_count):
        number = group_of[_one_of(index, manifolds, table)]
        order[groups[number * SIZE + FIRST_MANIFOLD]] = index
        groups[number * SIZE + FIRST_MANIFOLD] += 1
    for number in range(count, 0, -1):  # each has become where the next one begins
        groups[number * SIZE + FIRST_MANIFOLD] = groups[(number - 1) * SIZE + FIRST_MANIFOLD]
    groups[FIRST_MANIFOLD] = 0
    return count


@kernel
def sort_touching(
    count: int, group_count: int, group_of: Indices, groups: Indices, scratch: Indices,
    touching: Indices,
) -> None:  # fmt: skip
    """Sort the bodies that touch by their groups, and tell where each group begins."""
    groups[FIRST_BODY], groups[SIZE + FIRST_BODY] = 0, count
    if group_count == 1:
        return
    for number in range(group_count + 1):
        groups[number * SIZE + FIRST_BODY] = 0
    for index in range(count):
        scratch[index] = touching[index]
        groups[(group_of[touching[index]] + 1) * SIZE + FIRST_BODY] += 1
    for number in range(group_count):
        groups[(number + 1) * SIZE + FIRST_BODY] += groups[number * SIZE + FIRST_BODY]
    for index in range(count):
        place = group_of[scratch[index]] * SIZE + FIRST_BODY
        touching[groups[place]] = scratch[index]
        groups[place] += 1
    for number in range(group_count, 0, -1):
        groups[number * SIZE + FIRST_BODY] = groups[(number - 1) * SIZE + FIRST_BODY]
    groups[FIRST_BODY] = 0
