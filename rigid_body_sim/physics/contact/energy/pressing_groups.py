# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Groups: bodies that press on each other in a tick, and how what cannot move holds them.

In a group, contacts only pass energy on, or take it. It is named by its first body, and has a row
of numbers (`pressing_record`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.energy import pressing_record
from rigid_body_sim.physics.contact.energy.limits import PARALLEL
from rigid_body_sim.physics.contact.energy.pressing_record import CALM, FAST, FREE, SLIDING
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import batch_record, constraint, contact_point
from rigid_body_sim.physics.contact.touching import bodies_of
from rigid_body_sim.physics.vectors import dot, load, load_strided, store

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def group_of(body_a: int, body_b: int, static: int, roots: Indices) -> int:
    """Name the group of a constraint, of whose bodies one moves."""
    return roots[body_b if body_a == static else body_a]


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


@inline
def _note_plane(lane: int, group: int, rows: Array, groups: Array) -> None:
    """Note one constraint of a group with something that cannot move."""
    normal = load_strided(rows, lane + constraint.NORMAL, constraint.LANES)
    slides = (
        rows[lane + constraint.FRICTION]
        + rows[lane + constraint.ROLLING_FRICTION]
        + rows[lane + constraint.TORSIONAL_FRICTION]
        == 0.0
    )
    if slides and groups[group + pressing_record.HELD] == SLIDING:
        cosine = dot(normal, load(groups, group + pressing_record.NORMAL))
        slides = 1.0 - abs(cosine) < PARALLEL
    groups[group + pressing_record.HELD] = max(
        groups[group + pressing_record.HELD], SLIDING if slides else FAST
    )
    store(groups, group + pressing_record.NORMAL, normal)


@inline
def _add_press(
    lane: int, points: int, width: int, sign: float, group: int, rows: Array, groups: Array
) -> None:
    """Add up what the points of a constraint gave to its group."""
    press = 0.0
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        press += (
            rows[point + contact_point.TOTAL_IMPULSE] + rows[point + contact_point.NORMAL_IMPULSE]
        )
    for axis in range(3):
        groups[group + pressing_record.PRESS + axis] += (
            sign * press * rows[lane + constraint.NORMAL + constraint.LANES * axis]
        )


@kernel
def find_held(
    batch_count: int, static: int, width: int, batches: Indices, rows: Array, roots: Indices,
    groups: Array,
) -> None:  # fmt: skip
    """
    Find how each group that is not calm is held by what cannot move, and how hard that presses.

        static : index of what cannot move
        width  : numbers of a point
    """
    for batch in range(batch_count):
        record = batch * batch_record.SIZE
        begin = batches[record + batch_record.BEGIN]
        points = batches[record + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[record + batch_record.LANE_COUNT]):
            if not rows[lane + constraint.TOUCHED] > 0.0:
                continue
            body_a, body_b = bodies_of(lane, static, rows)
            group = group_of(body_a, body_b, static, roots) * pressing_record.SIZE
            if groups[group + pressing_record.HELD] == CALM:
                continue
            if body_a != static and body_b != static:
                groups[group + pressing_record.HELD] = max(
                    groups[group + pressing_record.HELD], FREE
                )
                continue
            _note_plane(lane, group, rows, groups)
            sign = 1.0 if body_a == static else -1.0
            _add_press(lane, points, width, sign, group, rows, groups)
