# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Overlaps deeper than a tenth of the smaller body: contact that gives way, a warning while it
happens.

    depth > DEEP min(d_A, d_B)      d : [m] least edge of the local AABB of a collider
    depth > BEGUN min(d_A, d_B)     in the first tick of a run

Something heavy on something light, or a scene that begins so: what lies in the ground comes out no
faster than `energy.gain_bound` lets it, by some 0.06 mm/s in ticks of 4 ms. The kernel of the
ticks looks at the manifolds as they are found, and at the end of a call at what presses
(`islands.left_sinking`), and lists pairs of bodies with the greatest depth; Python reads the list
and says each pair once. So are pairs whose impact has no instant that could be worked out
(`events.time_of_impact`): the solver is left them. The deepest overlap of all, and whether
anything has touched at all, are kept beside, tick for tick: between the instants at which somebody
looks impacts come and go.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
)
from rigid_body_sim.physics.contact.collision.geometry import manifold

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

DEEP = 0.1  # [-] of the smaller collider; less names what rests under a load in coarse ticks
BEGUN = 0.005  # [-] in the first tick, before anything has given way
UNTOUCHED = -1.0  # [m]
ROOM = 32  # [-] pairs that are listed between two looks; further ones are not named

head = Record()
COUNT = head.number('-', 'pairs that follow')
DEEPEST = head.number('m', 'overlap at the start of any tick; UNTOUCHED: nothing has pressed yet')
HEAD = head.size

pair = Record()
BODIES = pair.numbers(2, '-', 'indices in the scene')
DEPTH = pair.number('m', 'greatest depth of the overlap')
SPEED = pair.number('m/s', 'greatest that a tick has left it with: `islands.left_sinking`')
START_DEPTH = pair.number('m', 'of the overlap in the first tick')
UNDECIDED = pair.number('-', '1: they met at an instant that was not found')
PAIR_SIZE = pair.size


def make_overlaps() -> Array:
    """Make the list, empty."""
    overlaps = np.zeros(HEAD + ROOM * PAIR_SIZE)
    overlaps[DEEPEST] = UNTOUCHED
    return overlaps


def overlap_limits(local_bounds: Array) -> Array:
    """Depth (n,) that each collider tolerates [m]; what has no thickness, or no end: any."""
    bounds = local_bounds.reshape(-1, bounds_record.SIZE)
    half = bounds[:, bounds_record.bounds.span(bounds_record.HALF)].min(axis=1, initial=np.inf)
    edge = 2.0 * (half + bounds[:, bounds_record.ROUNDING])
    return np.where(np.isfinite(edge) & (edge > 0.0), DEEP * edge, np.inf)


@kernel
def list_pair(
    a: int, b: int, depth: float, speed: float, start_depth: float, undecided: float,
    table: Indices, overlaps: Array,
) -> None:  # fmt: skip
    """List the bodies of a pair of colliders, or what is greater of them: see `pair`."""
    index_a = float(table[a * collider_record.SIZE + collider_record.SCENE_INDEX])
    index_b = float(table[b * collider_record.SIZE + collider_record.SCENE_INDEX])
    first, second = min(index_a, index_b), max(index_a, index_b)
    count, row = int(overlaps[COUNT]), HEAD
    while row < HEAD + count * PAIR_SIZE and not (
        overlaps[row + BODIES] == first and overlaps[row + BODIES + 1] == second
    ):
        row += PAIR_SIZE
    if row == HEAD + count * PAIR_SIZE:
        if count == ROOM:
            return
        overlaps[row + BODIES], overlaps[row + BODIES + 1] = first, second
        for entry in (DEPTH, SPEED, START_DEPTH, UNDECIDED):
            overlaps[row + entry] = 0.0
        overlaps[COUNT] = count + 1.0
    overlaps[row + DEPTH] = max(overlaps[row + DEPTH], depth)
    overlaps[row + SPEED] = max(overlaps[row + SPEED], speed)
    overlaps[row + START_DEPTH] = max(overlaps[row + START_DEPTH], start_depth)
    overlaps[row + UNDECIDED] = max(overlaps[row + UNDECIDED], undecided)


@kernel
def list_deep_overlaps(
    begins: bool, manifold_count: int, table: Indices, limits: Array, manifolds: Array,
    overlaps: Array,
) -> None:  # fmt: skip
    """
    List the pairs whose surfaces overlap too deeply at the start of a tick, and keep the greatest
    overlap; begins: whether it is the first tick.
    """
    deepest = overlaps[DEEPEST]
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        least = 0.0
        for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            found = record + manifold_record.POINTS + point * manifold.POINT
            least = min(least, manifolds[found + manifold.SEPARATION])
        if least < 0.0:
            deepest = max(deepest, -least)
            a = int(manifolds[record + manifold_record.COLLIDER_A])
            b = int(manifolds[record + manifold_record.COLLIDER_B])
            limit = min(limits[a], limits[b])
            if -least > limit:
                list_pair(a, b, -least, 0.0, 0.0, 0.0, table, overlaps)
            elif begins and -least > BEGUN / DEEP * limit:
                list_pair(a, b, 0.0, 0.0, -least, 0.0, table, overlaps)
    overlaps[DEEPEST] = deepest


def take_overlaps(overlaps: Array, into: dict[tuple[int, int], Array]) -> None:
    """Move the list into the greatest of all that is listed of pairs of scene indices."""
    for row in overlaps[HEAD:].reshape(-1, PAIR_SIZE)[: int(overlaps[COUNT])]:
        first, second = (int(index) for index in row[BODIES : BODIES + 2])
        found = row[[DEPTH, SPEED, START_DEPTH, UNDECIDED]]
        into[first, second] = np.maximum(found, into.get((first, second), 0.0))
    overlaps[COUNT] = 0.0


def overlap_warning(first: str, second: str, found: Array) -> str:
    """Say that two bodies overlap, or are about to, and what helps; found: of `take_overlaps`."""
    depth, speed, start_depth, undecided = found
    if depth > 0.0:
        return (
            f'{first!r} and {second!r} overlap by {depth:.2g} m, more than a tenth of the '
            'smaller: contact gives way to what is too heavy for it, or the scene begins so; more '
            'substeps (contact.substeps) or a smaller dt carry more'
        )
    if speed > 0.0:
        return (
            f'{first!r} and {second!r} are too unlike in mass for contact to carry the load of '
            'one on the other: the solver leaves them sinking into each other at '
            f'{speed:.2g} m/s; more substeps (contact.substeps) or a smaller dt carry more'
        )
    if undecided > 0.0:
        return (
            f'{first!r} and {second!r} met at an instant that could not be worked out: the solver '
            'was left the pair, as in mode timestep; this impact is not listed, and may have lost '
            'energy'
        )
    return (
        f'{first!r} and {second!r} begin {start_depth:.2g} m in each other: under a load contact '
        'lifts them out slowly, as no energy may come of it; let the scene begin with them apart'
    )
