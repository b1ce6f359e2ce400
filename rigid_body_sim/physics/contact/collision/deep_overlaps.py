# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Overlaps deeper than a tenth of the smaller body: contact that gives way, a warning while it
happens.

    depth > DEEP min(d_A, d_B)      d : [m] least edge of the local AABB of a collider

Something heavy on something light, or a scene that begins so. The kernel of the ticks looks at the
manifolds as they are found, and lists pairs of bodies with the greatest depth; Python reads the
list and says each pair once.
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
ROOM = 32  # [-] pairs that are listed between two looks; further ones are not named

head = Record()
COUNT = head.number('-', 'pairs that follow')
HEAD = head.size

pair = Record()
BODIES = pair.numbers(2, '-', 'indices in the scene')
DEPTH = pair.number('m', 'greatest depth of the overlap')
SPEED = pair.number('m/s', 'greatest that a tick has left it with: `islands.left_sinking`')
PAIR_SIZE = pair.size


def make_overlaps() -> Array:
    """Make the list, empty."""
    return np.zeros(HEAD + ROOM * PAIR_SIZE)


def overlap_limits(local_bounds: Array) -> Array:
    """Depth (n,) that each collider tolerates [m]; what has no thickness, or no end: any."""
    bounds = local_bounds.reshape(-1, bounds_record.SIZE)
    half = bounds[:, bounds_record.HALF : bounds_record.HALF + 3].min(axis=1, initial=np.inf)
    edge = 2.0 * (half + bounds[:, bounds_record.ROUNDING])
    return np.where(np.isfinite(edge) & (edge > 0.0), DEEP * edge, np.inf)


@kernel
def list_pair(first: float, second: float, depth: float, speed: float, overlaps: Array) -> None:
    """List a pair of bodies, or its greater depth or speed."""
    count = int(overlaps[COUNT])
    for index in range(count):
        row = HEAD + index * PAIR_SIZE
        if overlaps[row + BODIES] == first and overlaps[row + BODIES + 1] == second:
            overlaps[row + DEPTH] = max(overlaps[row + DEPTH], depth)
            overlaps[row + SPEED] = max(overlaps[row + SPEED], speed)
            return
    if count < ROOM:
        row = HEAD + count * PAIR_SIZE
        overlaps[row + BODIES] = first
        overlaps[row + BODIES + 1] = second
        overlaps[row + DEPTH] = depth
        overlaps[row + SPEED] = speed
        overlaps[COUNT] = count + 1.0


@kernel
def list_deep_overlaps(
    manifold_count: int, table: Indices, limits: Array, manifolds: Array, overlaps: Array
) -> None:
    """List the pairs whose surfaces overlap too deeply at the start of a tick."""
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        least = 0.0
        for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            found = record + manifold_record.POINTS + point * manifold.POINT
            least = min(least, manifolds[found + manifold.SEPARATION])
        if least < 0.0:
            a = int(manifolds[record + manifold_record.COLLIDER_A])
            b = int(manifolds[record + manifold_record.COLLIDER_B])
            if -least > min(limits[a], limits[b]):
                first = table[a * collider_record.SIZE + collider_record.SCENE_INDEX]
                second = table[b * collider_record.SIZE + collider_record.SCENE_INDEX]
                list_pair(
                    float(min(first, second)), float(max(first, second)), -least, 0.0, overlaps
                )


def take_overlaps(overlaps: Array, into: dict[tuple[int, int], tuple[float, float]]) -> None:
    """Move the list into the greatest depth [m] and speed [m/s] of each pair of scene indices."""
    for row in overlaps[HEAD:].reshape(-1, PAIR_SIZE)[: int(overlaps[COUNT])]:
        first, second = (int(index) for index in row[BODIES : BODIES + 2])
        depth, speed = into.get((first, second), (0.0, 0.0))
        into[first, second] = max(float(row[DEPTH]), depth), max(float(row[SPEED]), speed)
    overlaps[COUNT] = 0.0


def overlap_warning(first: str, second: str, depth: float, speed: float) -> str:
    """Say that two bodies overlap, or are about to, and what helps."""
    if depth > 0.0:
        return (
            f'{first!r} and {second!r} overlap by {depth:.2g} m, more than a tenth of the '
            'smaller: contact gives way to what is too heavy for it, or the scene begins so; more '
            'substeps (contact.substeps) or a smaller dt carry more'
        )
    return (
        f'{first!r} and {second!r} are too unlike in mass for contact to carry the load of one on '
        f'the other: the solver leaves them sinking into each other at {speed:.2g} m/s; more '
        'substeps (contact.substeps) or a smaller dt carry more'
    )
