# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Attribution: by which contact impulses bodies got a change of momentum that was found for their
group as a whole.

Impulses act between two bodies, so those that give each body of a group its own change can be
found on any spanning tree of contacts that presses the group together: from its leaves to what
cannot move, each body takes its change, and that of all that hangs on it, by the one manifold on
which it hangs. In a manifold they go to the points as what these press already.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.energy import pressing_record
from rigid_body_sim.physics.contact.energy.pressing_record import FREE
from rigid_body_sim.physics.contact.energy.scratch import CHANGE, EnergyScratch
from rigid_body_sim.physics.contact.solver import constraint, contact_point
from rigid_body_sim.physics.contact.touching import bodies_of, lane_of
from rigid_body_sim.physics.vectors import add, dot, load, load_strided, store

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# the parent of a body in the tree is a manifold, or:
LOOSE, ROOT = -1, -2


@inline
def _plant(static: int, touching: Indices, scratch: EnergyScratch) -> None:
    """Let stand as roots what cannot move, bodies that are calm, and the first of a free group."""
    scratch.parents[static] = ROOT
    for index in range(len(touching)):
        body = touching[index]
        first = scratch.roots[body]
        held = scratch.groups[first * pressing_record.SIZE + pressing_record.HELD]
        on_none = held == FREE and first == body
        scratch.parents[body] = ROOT if on_none or held < FREE else LOOSE


@inline
def _span_tree(
    manifold_count: int, static: int, touching: Indices, constraints: Constraints,
    scratch: EnergyScratch,
) -> int:  # fmt: skip
    """
    Hang each body by one manifold that presses onto what cannot move, or onto what hangs already;
    a group that hangs on nothing hangs on its first body. List the bodies in this order, and
    return how many they are.
    """
    manifolds, rows, parents = constraints.manifolds, constraints.rows, scratch.parents
    _plant(static, touching, scratch)
    count, before = 0, -1
    while count > before:
        before = count
        for manifold in range(manifold_count):
            lane = lane_of(manifold, manifolds)
            body_a, body_b = bodies_of(lane, static, rows)
            a_hangs, b_hangs = parents[body_a] != LOOSE, parents[body_b] != LOOSE
            if a_hangs != b_hangs and rows[lane + constraint.TOUCHED] > 0.0:
                body = body_b if a_hangs else body_a
                parents[body] = manifold
                scratch.sequence[count] = body
                count += 1
    return count


@inline
def _pressing(point: int, rows: Array) -> Any:
    """What a point has pressed over the tick [N s]."""
    return rows[point + contact_point.TOTAL_IMPULSE] + rows[point + contact_point.NORMAL_IMPULSE]


@inline
def _add_impulse(
    lane: int, points: int, width: int, sign: float, change: Any, rows: Array
) -> None:
    """Add an impulse to the points of a manifold, to each as it has pressed; sign 1: upon B."""
    along = sign * dot(change, load_strided(rows, lane + constraint.NORMAL, constraint.LANES))
    across = sign * dot(change, load_strided(rows, lane + constraint.TANGENT_1, constraint.LANES))
    other_way = sign * dot(
        change, load_strided(rows, lane + constraint.TANGENT_2, constraint.LANES)
    )
    first = lane + constraint.SIZE
    total = 0.0
    for point in range(first, first + points * width, width):
        total += _pressing(point, rows)
    for point in range(first, first + points * width, width):
        share = _pressing(point, rows) / total if total > 0.0 else 1.0 / points
        impulse = point + contact_point.TOTAL_IMPULSE
        rows[impulse] += share * along
        rows[impulse + constraint.LANES] += share * across
        rows[impulse + 2 * constraint.LANES] += share * other_way


@kernel
def attribute_changes(
    manifold_count: int, static: int, width: int, touching: Indices, constraints: Constraints,
    scratch: EnergyScratch,
) -> None:  # fmt: skip
    """
    Add what bodies were given to the impulses of the manifolds by which they hang, the last first:
    contacts are read with the whole change of momentum.
    """
    manifolds, rows, changes = constraints.manifolds, constraints.rows, scratch.changes
    count = _span_tree(manifold_count, static, touching, constraints, scratch)
    for index in range(count):
        body = scratch.sequence[count - 1 - index]
        manifold = scratch.parents[body]
        lane = lane_of(manifold, manifolds)
        body_a, body_b = bodies_of(lane, static, rows)
        other = body_a if body == body_b else body_b
        change = load(changes, body * CHANGE)
        if other != static:
            store(changes, other * CHANGE, add(load(changes, other * CHANGE), change))
        sign = 1.0 if body == body_b else -1.0
        points = int(manifolds[manifold * manifold_record.SIZE + manifold_record.POINT_COUNT])
        _add_impulse(lane, points, width, sign, change, rows)
