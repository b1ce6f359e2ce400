# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Graph colouring: contact constraints that share no moving body are put side by side.

Each manifold takes the first colour that neither of its bodies has yet. Those of a colour take
lanes of batches, those with most near points first, so that a batch visits few that are far
(`far_points`): constraints of one batch are independent, so eight of them are solved at once (wide
constraints, see `constraint`). A body keeps its colours as the bits of one integer; what
cannot move has none. Beyond COLOURS a manifold gets a batch of its own.

Groups of islands (`islands.solver_groups`) have batches of their own, one group after the other.
Within a group batches are visited in the order of their colours: manifolds of one colour share no
body, so that a body sees its own constraints in the order of their colours, which follows from the
order of the pairs of its own island alone. With whom a manifold shares a batch, and when that was
full, changes no bit: what is not connected does not feel each other.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
)
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    core_pair,
    face_spring,
    far_points,
    friction_patch,
    group_record,
    lane_scratch,
)
from rigid_body_sim.physics.contact.solver.manifold_constraints import are_curved, roundness

COUNTS = manifold.MOST + 1  # [-] of near points: none to all
HALF = 4  # [-] lanes of the narrower vectors
HEAD = constraint.LANES  # [-] of the rows: no lane begins at 0, which is none (`surface_friction`)
NO_ROOM = -1  # in place of the number of batches: rows or batches are too few


@inline
def _first_free(used: int) -> int:
    """Find the first colour whose bit is not set."""
    colour = 0
    while colour < batch_record.COLOURS and (used >> colour) & 1:
        colour += 1
    return colour


@inline
def _note_partner(body: int, other: int, n_moving: int, partners: Indices) -> None:
    """Count what a body touches, twice: each manifold with what moves, and 1 for all else."""
    if body < n_moving:
        partners[body] = partners[body] + 2 if other < n_moving else partners[body] | 1


@inline
def _partners_of(body_a: int, body_b: int, n_moving: int, partners: Indices) -> int:
    """Return how many others the bodies of a manifold touch, the one that touches more."""
    of_a = partners[body_a] if body_a < n_moving else 0
    of_b = partners[body_b] if body_b < n_moving else 0
    return max(of_a // 2 + of_a % 2, of_b // 2 + of_b % 2)


@inline
def _colour_group(
    group: int, n_moving: int, table: Indices, bounds: Array, constraints: Constraints
) -> None:
    """
    Choose the colour of each manifold of a group, in their order; note it, and how many near
    points it has, among the members; group: where its record begins.
    """
    manifolds, colours = constraints.manifolds, constraints.colours
    for index in range(
        constraints.groups[group + group_record.FIRST_MANIFOLD],
        constraints.groups[group + group_record.SIZE + group_record.FIRST_MANIFOLD],
    ):
        record = constraints.order[index] * manifold_record.SIZE
        collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
        collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
        body_a = collider_record.solver_body(collider_a, table)
        body_b = collider_record.solver_body(collider_b, table)
        used_a = colours[body_a] if body_a < n_moving else 0
        used_b = colours[body_b] if body_b < n_moving else 0
        colour = _first_free(used_a | used_b)
        if colour < batch_record.COLOURS:
            colours[min(body_a, n_moving)] |= 1 << colour
            colours[min(body_b, n_moving)] |= 1 << colour
        _note_partner(body_a, body_b, n_moving, constraints.partners)
        _note_partner(body_b, body_a, n_moving, constraints.partners)
        radius = bounds_record.smaller_radius(bounds, collider_a, collider_b)
        near = far_points.count_near(record, radius, manifolds)
        constraints.members[index] = colour * COUNTS + near


@inline
def _manifolds_of(body_a: int, body_b: int, n_moving: int, constraints: Constraints) -> int:
    """
    Return how many manifolds the bodies of one have, the one that has more: as many as colours.
    """
    most = 0
    for body in (body_a, body_b):
        used = constraints.colours[body] if body < n_moving else 0
        count = 0
        while used != 0:
            used &= used - 1
            count += 1
        most = max(most, count)
    return most


@inline
def _fill_batches(
    number: int, near: int, end: int, count: int, n_moving: int, width: int, room: Any,
    curved: bool, table: Indices, constraints: Constraints, bodies: Array,
) -> Any:  # fmt: skip
    """
    Give the manifolds of a group with so many near points their lanes; return where the rows in
    use end, and the number of batches, or NO_ROOM.

    end, count : both so far
    room       : of rows and of batches
    """
    manifolds, rows, batches = constraints.manifolds, constraints.rows, constraints.batches
    open_batches, group = constraints.open_batches, number * group_record.SIZE
    for index in range(
        constraints.groups[group + group_record.FIRST_MANIFOLD],
        constraints.groups[group + group_record.SIZE + group_record.FIRST_MANIFOLD],
    ):
        colour = constraints.members[index] // COUNTS
        if constraints.members[index] != colour * COUNTS + near:
            continue
        record = constraints.order[index] * manifold_record.SIZE
        collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
        collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
        body_a = collider_record.solver_body(collider_a, table)
        body_b = collider_record.solver_body(collider_b, table)
        partners = _partners_of(body_a, body_b, n_moving, constraints.partners)
        manifolds_of_bodies = float(_manifolds_of(body_a, body_b, n_moving, constraints))
        points = int(manifolds[record + manifold_record.POINT_COUNT])
        kind = batch_record.MIXED
        if roundness(collider_a, collider_b, table, bodies) > constraint.NOT_ROUND:
            kind = batch_record.BALLS
        if curved and points == 1 and are_curved(collider_a, collider_b, table, bodies):
            kind = batch_record.CURVED
        if points > 1:
            kind = batch_record.SEVERAL_POINTS
            if partners <= face_spring.FEW:
                kind = batch_record.WHOLE
        sort = batch_record.KINDS * colour + kind
        batch = open_batches[sort]
        if (
            batch == batch_record.NONE_OPEN
            or colour == batch_record.COLOURS
            or batches[batch * batch_record.SIZE + batch_record.LANE_COUNT] == constraint.LANES
        ):
            batch = count
            size = constraint.SIZE + (1 if points == 1 else manifold.MOST) * width
            size += friction_patch.SIZE if points > 1 else 0
            size += core_pair.SIZE if kind == batch_record.CURVED else 0
            if end + size > room[0] or batch >= room[1]:
                return end, NO_ROOM
            _open(batch * batch_record.SIZE, end, kind, colour, batches)
            end += size
            open_batches[sort] = batch
            count += 1
        lane = _take_lane(batch * batch_record.SIZE, points, batches)
        manifolds[record + manifold_record.LANE] = float(lane)
        body_a += number if body_a == n_moving else 0
        body_b += number if body_b == n_moving else 0
        rows[lane + constraint.BODY_A] = float(body_a * solver_bodies.SIZE)
        rows[lane + constraint.BODY_B] = float(body_b * solver_bodies.SIZE)
        rows[lane + constraint.MANIFOLDS] = manifolds_of_bodies
    return end, count


@kernel
def colour_constraints(
    manifold_count: int, group_count: int, n_moving: int, width: int, row_room: int,
    batch_room: int, curved: bool, table: Indices, bounds: Array, constraints: Constraints,
    bodies: Array,
) -> int:  # fmt: skip
    """
    Give each manifold a lane, group after group; return the number of batches, or NO_ROOM. What
    cannot move is a body of its own in each group: lanes write what nobody reads there.

        width  : numbers of a point
        curved : whether layers about cores may meet: see `curved_cores`
    """
    manifolds, rows, batches = constraints.manifolds, constraints.rows, constraints.batches
    for body in range(n_moving + 1):
        constraints.colours[body] = constraints.partners[body] = 0
    count = 0
    end = HEAD
    for number in range(group_count):
        group = number * group_record.SIZE
        first = count
        constraints.groups[group + group_record.FIRST_BATCH] = first
        for sort in range(batch_record.OPEN_BATCHES):
            constraints.open_batches[sort] = batch_record.NONE_OPEN
        _colour_group(group, n_moving, table, bounds, constraints)
        for far in range(COUNTS):
            end, count = _fill_batches(
                number, manifold.MOST - far, end, count, n_moving, width, (row_room, batch_room),
                curved, table, constraints, bodies,
            )  # fmt: skip
            if count == NO_ROOM:
                return NO_ROOM
        _sort_by_colour(first, count, batch_room, constraints.open_batches, batches)
        _empty_unused_lanes(first, count, n_moving + number, width, rows, batches)
    last = group_count * group_record.SIZE
    constraints.groups[last + group_record.FIRST_BATCH] = count
    _empty_missing_points(manifold_count, width, manifolds, rows)
    return count


@inline
def _open(batch: int, begin: int, kind: int, colour: int, batches: Indices) -> None:
    """Open a batch without lanes."""
    batches[batch + batch_record.BEGIN] = begin
    batches[batch + batch_record.POINT_COUNT] = 0
    batches[batch + batch_record.NEAR_COUNT] = 0
    batches[batch + batch_record.LANE_COUNT] = 0
    batches[batch + batch_record.KIND] = kind
    batches[batch + batch_record.COLOUR] = colour


@inline
def _sort_by_colour(
    first: int, count: int, batch_room: int, starts: Indices, batches: Indices
) -> None:
    """
    Sort batches by their colours, those of one colour as they were opened (counting sort).

    first, count : the first of them, and how many there are up to the last of them
    starts  : scratch, a number for each colour and one
    batches : behind the room for batches lies as much scratch
    """
    for colour in range(batch_record.COLOURS + 2):
        starts[colour] = 0
    starts[0] = first
    for number in range(first, count):
        batch = number * batch_record.SIZE
        starts[batches[batch + batch_record.COLOUR] + 1] += 1
        for entry in range(batch_record.SIZE):
            batches[batch_room * batch_record.SIZE + batch + entry] = batches[batch + entry]
    for colour in range(batch_record.COLOURS):
        starts[colour + 1] += starts[colour]
    for number in range(first, count):
        batch = (batch_room + number) * batch_record.SIZE
        colour = batches[batch + batch_record.COLOUR]
        to = starts[colour] * batch_record.SIZE
        starts[colour] += 1
        for entry in range(batch_record.SIZE):
            batches[to + entry] = batches[batch + entry]


@inline
def _take_lane(batch: int, points: int, batches: Indices) -> int:
    """Take the next lane of a batch for a manifold of so many points; return where it begins."""
    lane = batches[batch + batch_record.LANE_COUNT]
    batches[batch + batch_record.LANE_COUNT] = lane + 1
    batches[batch + batch_record.POINT_COUNT] = max(
        batches[batch + batch_record.POINT_COUNT], points
    )
    return batches[batch + batch_record.BEGIN] + lane


@kernel
def lanes_in_use(count: int, batches: Indices) -> int:
    """
    Tell how many lanes of each batch have to be gone over: as many as the widest one fills, or
    what a vector holds of them. A lone body waits for no lanes that are empty.
    """
    most = 0
    for b in range(count):
        most = max(most, batches[b * batch_record.SIZE + batch_record.LANE_COUNT])
    return most if most <= 1 else (HALF if most <= HALF else constraint.LANES)


@kernel
def empty_lanes_behind(lanes: int, scratch: Array) -> None:
    """Write zeros into the scratch of lanes that are not gone over: they do not look visited."""
    for lane in range(lanes, constraint.LANES):
        for entry in range(lane, lane_scratch.SIZE, constraint.LANES):
            scratch[entry] = 0.0


@kernel
def _empty_unused_lanes(
    first: int, count: int, static: int, width: int, rows: Array, batches: Indices
) -> None:
    """
    Write zeros where a batch of a group has no manifold, and the body that cannot move.

    first, count : as in `_sort_by_colour`
    """
    for b in range(first, count):
        batch = b * batch_record.SIZE
        begin = batches[batch + batch_record.BEGIN]
        end = begin + constraint.SIZE + width
        if batches[batch + batch_record.POINT_COUNT] > 1:
            end += (manifold.MOST - 1) * width + friction_patch.SIZE
        elif batches[batch + batch_record.KIND] == batch_record.CURVED:
            end += core_pair.SIZE
        for lane in range(
            begin + batches[batch + batch_record.LANE_COUNT], begin + constraint.LANES
        ):
            for row in range(lane, end, constraint.LANES):
                rows[row] = 0.0
            rows[lane + constraint.BODY_A] = float(static * solver_bodies.SIZE)
            rows[lane + constraint.BODY_B] = float(static * solver_bodies.SIZE)


@kernel
def _empty_missing_points(manifold_count: int, width: int, manifolds: Array, rows: Array) -> None:
    """Put points out of reach where a manifold has fewer than its batch: they never press."""
    for m in range(manifold_count):
        points = int(manifolds[m * manifold_record.SIZE + manifold_record.POINT_COUNT])
        if points > 1:
            lane = int(manifolds[m * manifold_record.SIZE + manifold_record.LANE])
            for point in range(points, manifold.MOST):
                begin = lane + constraint.SIZE + point * width
                for row in range(begin, begin + width, constraint.LANES):
                    rows[row] = 0.0
                rows[begin + contact_point.INITIAL_SEPARATION] = far_points.NOWHERE
