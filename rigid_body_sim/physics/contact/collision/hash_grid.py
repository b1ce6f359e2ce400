# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which of many boxes along the world axes overlap: a hashed grid of cells.

Boxes of about one size share a level; the edge of its cells is the largest edge of its boxes.
Boxes are sorted by the cells of their middles, by counting, into one list, where the cells of a
column along z follow each other. What overlaps a box has its middle within the box enlarged by
half an edge: two or three cells along each axis. Of those of its own level a box visits only the
ones ahead of its own cell, and what follows it there, so that a pair is met once. Smaller boxes
visit the cells of larger levels, which costs little while those are few, and pebbles cost a
boulder nothing.

Two cells may share a place of the hash: then a pair can be met more than once. All that is met is
compared, so nothing has to be known of the cell it comes from; who sorts the pairs drops the
copies.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.collider import CORE, TABLE

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TINY = 1e-12  # [m] smallest edge
FAR = 1e12  # [-] cells from the origin, beyond which all share one
WIDER = 1.002  # [-] of an edge: rounding may put a middle so far from its place in FAR cells
LEVELS = 64
USUAL = 32  # the level of a box of usual size
BROAD = 1.4  # [-] of the usual edge: what that level still holds, down to a quarter of it

LOW, HIGH = 0, 3
BOX = 6
CELL_X, CELL_Y, CELL_Z, LEVEL, PLACE, ORDER = range(6)
CELL = 6


def size_of_heads(n: int) -> int:
    """Count the places of the hash for n colliders, and one more."""
    size = 64
    while size < 4 * n:
        size *= 2
    return size + 1


@inline
def overlap(boxes: Array, a: int, b: int) -> bool:
    """Tell, without a branch, whether two boxes overlap; a, b: where they begin."""
    return (
        (boxes[a] <= boxes[b + 3])
        & (boxes[b] <= boxes[a + 3])
        & (boxes[a + 1] <= boxes[b + 4])
        & (boxes[b + 1] <= boxes[a + 4])
        & (boxes[a + 2] <= boxes[b + 5])
        & (boxes[b + 2] <= boxes[a + 5])
    )


@inline
def _cell(x: float) -> int:
    return int(math.floor(min(max(x, -FAR), FAR)))


@inline
def _column(x: int, y: int, level: int) -> int:
    return (x * 73856093) ^ (y * 19349663) ^ (level * 2654435761)


@inline
def _edge(boxes: Array, o: int) -> float:
    return max(
        boxes[o + 3] - boxes[o], boxes[o + 4] - boxes[o + 1], boxes[o + 5] - boxes[o + 2], TINY
    )


@kernel
def _enter(
    first: int, n: int, boxes: Array, edges: Array, entered: Array, grid: Indices, heads: Indices
) -> None:
    """Find the level and the cell of each box, and sort the boxes by cell."""
    for level in range(LEVELS):
        edges[level] = 0.0
    inverse = 0.0
    for j in range(first, n):
        inverse += 1.0 / _edge(boxes, j * BOX)
    usual = BROAD * (n - first) / inverse  # a harmonic mean: few large ones do not matter
    for j in range(first, n):
        edge = _edge(boxes, j * BOX)
        level = min(max(math.frexp(edge / usual)[1] + USUAL, 0), LEVELS - 1)
        if level == USUAL - 1:
            level = USUAL
        grid[j * CELL + LEVEL] = level
        edges[level] = max(edges[level], edge)
    size = len(heads) - 1
    for i in range(size):
        heads[i] = 0
    for j in range(first, n):
        o, row = j * BOX, j * CELL
        level = grid[row + LEVEL]
        half = 0.5 / edges[level]
        x = _cell((boxes[o] + boxes[o + 3]) * half)
        y = _cell((boxes[o + 1] + boxes[o + 4]) * half)
        z = _cell((boxes[o + 2] + boxes[o + 5]) * half)
        place = (_column(x, y, level) + z) & (size - 1)
        grid[row + CELL_X], grid[row + CELL_Y], grid[row + CELL_Z] = x, y, z
        grid[row + PLACE] = place
        heads[place] += 1
    total = 0
    for i in range(size):
        total += heads[i]
        heads[i] = total
    heads[size] = total
    for behind in range(n - first):
        j = n - 1 - behind
        place = grid[j * CELL + PLACE]
        heads[place] -= 1
        at = heads[place]
        grid[at * CELL + ORDER] = j
        o, p = j * BOX, at * BOX
        for entry in range(BOX):
            entered[p + entry] = boxes[o + entry]


@kernel
def overlaps(
    first: int, n: int, room: int, table: Indices, boxes: Array, edges: Array, entered: Array,
    grid: Indices, heads: Indices, larger: int, smaller: int, pairs: Indices,
) -> int:  # fmt: skip
    """
    Write the pairs of boxes of two bodies that overlap, of which at least one moves, in any order,
    some of them more than once; return how many were written, or would have been beyond the room.

        first           : boxes before this one are left out
        boxes           : BOX per collider: low corner, high corner [m]
        edges, entered  : LEVELS, and BOX per collider, for the grid: edges of cells, sorted boxes
        grid            : CELL per collider, for the grid
        heads           : for the grid: where in its order each place of the hash begins
        larger, smaller : where in `pairs` the later of two colliders goes, and the earlier
    """
    if n - first < 2:
        return 0
    _enter(first, n, boxes, edges, entered, grid, heads)
    mask = len(heads) - 2
    coarsest = 0
    for level in range(LEVELS):
        if edges[level] > 0.0:
            coarsest = level
    count = 0
    for at in range(n - first):
        j, o = grid[at * CELL + ORDER], at * BOX
        own = grid[j * CELL + LEVEL]
        x, y, z = grid[j * CELL + CELL_X], grid[j * CELL + CELL_Y], grid[j * CELL + CELL_Z]
        met = count
        for level in range(own, coarsest + 1):
            if edges[level] == 0.0:
                continue
            half, inverse = WIDER * 0.5 * edges[level], 1.0 / edges[level]
            x0 = x if level == own else _cell((entered[o] - half) * inverse)
            y0 = _cell((entered[o + 1] - half) * inverse)
            z0 = _cell((entered[o + 2] - half) * inverse)
            x1 = _cell((entered[o + 3] + half) * inverse)
            y1 = _cell((entered[o + 4] + half) * inverse)
            z1 = _cell((entered[o + 5] + half) * inverse)
            for cx in range(x0, x1 + 1):
                ahead = level > own or cx > x
                for cy in range(y0 if ahead else y, y1 + 1):
                    here = not ahead and cy == y
                    low = z if here else z0
                    begin = (_column(cx, cy, level) + low) & mask
                    end = begin + (z1 - low) + 1
                    k = at + 1 if here else heads[begin]
                    last = heads[min(end, mask + 1)]
                    rest = heads[end - mask - 1] if end > mask + 1 else 0
                    for other in range(k, last):
                        pairs[smaller + min(met, room - 1)] = other
                        met += overlap(entered, o, other * BOX)
                    for other in range(rest):
                        pairs[smaller + min(met, room - 1)] = other
                        met += overlap(entered, o, other * BOX)
        if met > room:
            count = met
            continue
        core = table[j * TABLE + CORE]
        for k in range(count, met):
            i = grid[pairs[smaller + k] * CELL + ORDER]
            other = table[i * TABLE + CORE]
            if core != other and max(core, other) >= 0:  # not two parts of one body
                pairs[larger + count], pairs[smaller + count] = max(i, j), min(i, j)
                count += 1
    return count
