# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The loads of what begins at rest, before the first tick of a scene.

Sequential impulses learn a load over many substeps, the slower the heavier what is carried, and
what carries it sinks meanwhile. What stands when a scene begins has its load already: the impulses
that would hold it still for a substep, found before anything moves,

    v + h F/m + sum of J M^-1 J^T >= 0 along the normals,  with friction

by relaxing all contacts until nothing changes. They are recalled like those of a last tick, with
the static sink that they come to, of each point its own (`static_sink`): the scene begins in
balance, wherever faces are loaded.

An island in which something that presses moves along its normal is in an impact, and begins
without loads.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    solve,
    static_sink,
    surface_chain,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.softness import spring_mass
from rigid_body_sim.physics.contact.touching import bodies_of, lane_of, moving_body_of
from rigid_body_sim.physics.vectors import dot

REST = 1e-14  # [m/s] what a pass may still change
VISITS = 1_000_000  # [-] of the constraints of an island, at most: the rest is learnt in motion
MOVES = 0.01  # [m/s] along a normal: faster is an impact


@kernel
def find_islands(
    batch_count: int, static: int, touching: Indices, batches: Indices, rows: Array,
    roots: Indices, sizes: Indices,
) -> None:  # fmt: skip
    """
    Join the bodies that contacts join; count the constraints of each island at its first, and one
    more. A lone body has none: it finds its load in a substep.
    """
    for index in range(len(touching)):
        roots[touching[index]] = touching[index]
        sizes[touching[index]] = 0
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if body_a != static and body_b != static:
                unite(body_a, body_b, roots)
    for index in range(len(touching)):
        if roots[touching[index]] != touching[index]:
            sizes[find(touching[index], roots)] = 1
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            root = find(moving_body_of(lane, static, rows), roots)
            sizes[root] += 1 if sizes[root] > 0 else 0


@kernel
def wake_islands(
    passes: int, batch_count: int, static: int, touching: Indices, batches: Indices, rows: Array,
    roots: Indices, sizes: Indices,
) -> bool:  # fmt: skip
    """
    Let all constraints of an island be visited again where the last pass has changed one, until it
    has had its visits; tell whether there are any. Size of an island that is settled: negative.
    """
    for index in range(len(touching)):
        sizes[touching[index]] = -abs(sizes[touching[index]])
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if rows[lane + constraint.UNSETTLED] > 0.0:
                root = find(moving_body_of(lane, static, rows), roots)
                sizes[root] = abs(sizes[root])
    found = False
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            size = sizes[find(moving_body_of(lane, static, rows), roots)]
            goes_on = size > 0 and size * passes <= VISITS
            rows[lane + constraint.UNSETTLED] = 1.0 if goes_on else 0.0
            if goes_on:
                found = True
    return found


@kernel
def _mark_impacts(
    width: int, static: int, constraints: Constraints, roots: Indices, sizes: Indices,
    bodies: Array,
) -> None:  # fmt: skip
    """Give islands in which something that presses moves along its normal the size 0."""
    batches, rows, scratch = constraints.batches, constraints.rows, constraints.scratch
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        used = batches[batch + batch_record.LANE_COUNT]
        own = rows[begin : begin + constraint.SIZE]
        solve.gather_momenta(used, own, scratch, bodies)
        for point in range(batches[batch + batch_record.POINT_COUNT]):
            first = begin + constraint.SIZE + point * width
            points = rows[first : first + width]
            for lane in range(used):
                arm_a, arm_b = wide_lanes.arms(points, lane)
                velocity = wide_lanes.relative_velocity(own, scratch, lane, arm_a, arm_b, True)
                normal = wide_lanes.vector(own, lane + constraint.NORMAL)
                presses = points[lane + contact_point.NORMAL_IMPULSE] > 0.0
                if presses and abs(dot(normal, velocity)) > MOVES:
                    sizes[find(moving_body_of(begin + lane, static, rows), roots)] = 0


@inline
def _take_loads(lane: int, points: int, width: int, rows: Array) -> None:
    """Let a constraint begin without loads."""
    rows[lane + constraint.OTHERS_IMPULSE] = 0.0
    for row in range(lane + constraint.SIZE, lane + constraint.SIZE + points * width, width):
        rows[row + contact_point.NORMAL_IMPULSE] = 0.0
        rows[row + contact_point.TANGENT_IMPULSE_1] = 0.0
        rows[row + contact_point.TANGENT_IMPULSE_2] = 0.0


@inline
def _share_load(lane: int, points: int, width: int, h: float, rows: Array) -> float:
    """
    Return the load of a constraint [m/s^2], as `impulse_cache` does of a tick, and give each of
    its points that has a spring of its own its share of the sink.
    """
    first, end = lane + constraint.SIZE, lane + constraint.SIZE + points * width
    pressed, largest = rows[lane + constraint.OTHERS_IMPULSE], 0.0
    for row in range(first, end, width):
        pressed += rows[row + contact_point.NORMAL_IMPULSE]
        largest = max(largest, _load_of_point(lane, row, h, rows))
    spring = rows[lane + constraint.SPRING_MASS]
    if spring > 0.0 and rows[lane + constraint.ALONE] > 0.0:
        return pressed / (h * spring)
    total, bearing = 0.0, 0.0
    for row in range(first, end, width):
        of_point = _load_of_point(lane, row, h, rows)
        total += of_point
        bearing += static_sink.share_that_bears(of_point, largest)
    load = total / bearing if bearing > 0.0 else 0.0
    if load > 0.0 and rows[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE:
        for row in range(first, end, width):
            rows[row + contact_point.SINK_SHARE] = _load_of_point(lane, row, h, rows) / load
    return load


@inline
def _load_of_point(lane: int, row: int, h: float, rows: Array) -> Any:
    """Return what a point carries, over its mass [m/s^2]; h: substep [s]."""
    mass = spring_mass(lane, row, rows, rows)
    return rows[row + contact_point.NORMAL_IMPULSE] / (h * mass) if mass > 0.0 else 0.0


@kernel
def recall_loads(
    width: int, static: int, h: float, constraints: Constraints, roots: Indices, sizes: Indices,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Let the constraints of islands at rest recall the impulses that were found, and their sink, and
    the others none; bodies are as they begin.

    h : [s] substep
    """
    manifolds, rows = constraints.manifolds, constraints.rows
    _mark_impacts(width, static, constraints, roots, sizes, bodies)
    surface_chain.note_impulses(width, rows, constraints.scratch)
    for index in range(len(constraints.order)):
        manifold = constraints.order[index]
        lane = lane_of(manifold, manifolds)
        rests = sizes[find(moving_body_of(lane, static, rows), roots)] != 0
        points = int(manifolds[manifold * manifold_record.SIZE + manifold_record.POINT_COUNT])
        rows[lane + constraint.TOUCHED] = 0.0
        if not rests:
            _take_loads(lane, points, width, rows)
        static_sink.begin(lane, h, _share_load(lane, points, width, h, rows), rows)
