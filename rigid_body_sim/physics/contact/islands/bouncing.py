# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which constraints take part in a bounce: those of bodies that press, by way of whoever does, on one
that bounces in this tick. What lies elsewhere keeps its bits, though something bounces.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import batch_record, constraint, contact_point
from rigid_body_sim.physics.contact.touching import bodies_of, moving_body_of

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def bounces(lane: int, points: int, width: int, rows: Array) -> bool:
    """Tell whether some point of a constraint bounces."""
    if not (rows[lane + constraint.RESTITUTION] > 0.0 and rows[lane + constraint.TOUCHED] > 0.0):
        return False
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        pressure = (
            rows[point + contact_point.LARGEST_NORMAL_IMPULSE]
            + rows[point + contact_point.NORMAL_IMPULSE]
        )
        if pressure > 0.0 and rows[point + contact_point.APPROACH_VELOCITY] < 0.0:
            return True
    return False


@inline
def _any_bounces(batch_count: int, width: int, batches: Indices, rows: Array) -> bool:
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if bounces(lane, points, width, rows):
                return True
    return False


@kernel
def mark_bouncing(
    batch_count: int, static: int, width: int, touching: Indices, batches: Indices, rows: Array,
    roots: Indices, marks: Indices,
) -> bool:  # fmt: skip
    """
    Mark the constraints that take part in a bounce; tell whether there is any.

    static       : index of what cannot move; it joins nobody
    width        : numbers of a point
    roots, marks : scratch, a number for each body and one for what cannot move
    """
    if not _any_bounces(batch_count, width, batches, rows):
        return False
    for index in range(len(touching)):
        roots[touching[index]] = touching[index]
        marks[touching[index]] = 0
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if body_a != static and body_b != static and rows[lane + constraint.TOUCHED] > 0.0:
                unite(body_a, body_b, roots)
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if bounces(lane, points, width, rows):
                marks[find(moving_body_of(lane, static, rows), roots)] = 1
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            mark = marks[find(moving_body_of(lane, static, rows), roots)]
            rows[lane + constraint.BOUNCES] = 1.0 if mark == 1 else 0.0
    return True
