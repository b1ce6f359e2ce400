# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Groups: bodies that press on each other in a tick. In a group, contacts only pass energy on, or
take it. It is named by its first body.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import batch_record, constraint
from rigid_body_sim.physics.contact.touching import bodies_of, lane_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def group_of(body_a: int, body_b: int, static: int, roots: Indices) -> int:
    """Name the group of a constraint, of whose bodies one moves."""
    return roots[body_b if body_a == static else body_a]


@kernel
def order_of_sums(
    manifold_count: int, static: int, touching: Indices, manifolds: Array, rows: Array,
    marks: Indices, order: Indices,
) -> int:  # fmt: skip
    """
    List the bodies that touch in the order in which manifolds name them; return how many.

    What is summed over bodies is summed in this order, so that no bit of it depends on where a
    scene lists them.

        static : index of what cannot move
        marks  : scratch, a number for each body
    """
    for index in range(len(touching)):
        marks[touching[index]] = 0
    marks[static] = 1
    count = 0
    for manifold in range(manifold_count):
        for body in bodies_of(lane_of(manifold, manifolds), static, rows):
            if marks[body] == 0:
                marks[body] = 1
                order[count] = body
                count += 1
    return count


@kernel
def unite_pressing(
    batch_count: int, static: int, touching: Indices, batches: Indices, rows: Array, roots: Indices
) -> None:
    """
    Give each body the first of its group: of those that press on each other, by way of whoever
    does; what cannot move joins nobody.

        static : index of what cannot move
    """
    for index in range(len(touching)):
        roots[touching[index]] = touching[index]
    for batch in range(batch_count):
        record = batch * batch_record.SIZE
        begin = batches[record + batch_record.BEGIN]
        for lane in range(begin, begin + batches[record + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if body_a != static and body_b != static and rows[lane + constraint.TOUCHED] > 0.0:
                unite(body_a, body_b, roots)
    for index in range(len(touching)):
        roots[touching[index]] = find(touching[index], roots)
