# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which of many AABBs overlap: a hash grid, a hashed grid of cells on several levels.

Boxes of about one size share a level; the edge of its cells is the largest edge of its boxes.
Boxes are sorted by the cells of their middles, by counting, into one list, where the cells of a
column along z follow each other. What overlaps a box has its middle within the box enlarged by
half an edge: two or three cells along each axis. Of those of its own level a box visits only the
ones ahead of its own cell, and what follows it there, so that a pair is met once. Smaller boxes
visit the cells of larger levels, which costs little while those are few, and pebbles cost a
boulder nothing.

Two cells may share a hash: then a pair can be met more than once. All that is met is compared, so
nothing has to be known of the cell it comes from; who sorts the pairs drops the copies.

    hash_heads : for each hash, where in the sorted list the boxes with it begin; then their number
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import aabb, collider_record
from rigid_body_sim.physics.contact.collision.aabb import HIGH, LOW, overlap

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TINY = 1e-12  # [m] smallest edge
FAR = 1e12  # [-] cells from the origin, beyond which all share one
WIDER = 1.002  # [-] of an edge: rounding may put a middle so far from its place in FAR cells
LEVELS = 64
USUAL = 32  # the level of a box of usual size
FROM_CELL = -1  # place in the sorted list: that of the first cell of a column
BROAD = 1.4  # [-] of the usual edge: what that level still holds, down to a quarter of it

# where a box stands in the grid
cell = Record()
CELL_X = cell.number('-', 'of the cell of its middle, on its level')
CELL_Y = cell.number('-', '')
CELL_Z = cell.number('-', '')
LEVEL = cell.number('-', 'that its size has')
HASH = cell.number('-', 'of its cell')
ORDER = cell.number('-', 'which box stands at this place of the sorted list')
SIZE = cell.size


class Grid(NamedTuple):
    """
    The arrays of the grid; all but `aabbs` are written.

    aabbs        : boxes of all colliders, see `aabb`
    sorted_aabbs : the same in the order of the sorted list
    edges        : LEVELS: edge of the cells of each level [m], 0: no box has it
    cells        : a row of SIZE for each collider
    hash_heads   : see the module
    """

    aabbs: Array
    sorted_aabbs: Array
    edges: Array
    cells: Indices
    hash_heads: Indices


def size_of_heads(n: int) -> int:
    """Count the places of the hash for n colliders, and one more."""
    size = 64
    while size < 4 * n:
        size *= 2
    return size + 1


@inline
def _cell(x: float) -> int:
    return int(math.floor(min(max(x, -FAR), FAR)))


@inline
def _column(x: int, y: int, level: int) -> int:
    """Hash of a column of cells along z; the cell at z has this and z more."""
    return (x * 73856093) ^ (y * 19349663) ^ (level * 2654435761)


@inline
def _edge(aabbs: Array, box: int) -> float:
    return max(
        aabbs[box + HIGH] - aabbs[box + LOW],
        aabbs[box + HIGH + 1] - aabbs[box + LOW + 1],
        aabbs[box + HIGH + 2] - aabbs[box + LOW + 2],
        TINY,
    )


@kernel
def _find_levels(first: int, count: int, grid: Grid) -> None:
    """Find the level of each box, and the edge of the cells of each level."""
    aabbs, edges = grid.aabbs, grid.edges
    for level in range(LEVELS):
        edges[level] = 0.0
    inverse = 0.0
    for collider in range(first, count):
        inverse += 1.0 / _edge(aabbs, collider * aabb.SIZE)
    usual = BROAD * (count - first) / inverse  # a harmonic mean: few large ones do not matter
    for collider in range(first, count):
        edge = _edge(aabbs, collider * aabb.SIZE)
        level = min(max(math.frexp(edge / usual)[1] + USUAL, 0), LEVELS - 1)
        if level == USUAL - 1:
            level = USUAL
        grid.cells[collider * SIZE + LEVEL] = level
        edges[level] = max(edges[level], edge)


@kernel
def _sort_into_cells(first: int, count: int, grid: Grid) -> None:
    """Find the cell of each box, and sort the boxes by the hash of their cells, by counting."""
    aabbs, cells, heads = grid.aabbs, grid.cells, grid.hash_heads
    size = len(heads) - 1
    for index in range(size):
        heads[index] = 0
    for collider in range(first, count):
        box, row = collider * aabb.SIZE, collider * SIZE
        level = cells[row + LEVEL]
        half = 0.5 / grid.edges[level]
        x = _cell((aabbs[box + LOW] + aabbs[box + HIGH]) * half)
        y = _cell((aabbs[box + LOW + 1] + aabbs[box + HIGH + 1]) * half)
        z = _cell((aabbs[box + LOW + 2] + aabbs[box + HIGH + 2]) * half)
        hashed = (_column(x, y, level) + z) & (size - 1)
        cells[row + CELL_X], cells[row + CELL_Y], cells[row + CELL_Z] = x, y, z
        cells[row + HASH] = hashed
        heads[hashed] += 1
    total = 0
    for index in range(size):
        total += heads[index]
        heads[index] = total
    heads[size] = total
    for behind in range(count - first):
        collider = count - 1 - behind
        hashed = cells[collider * SIZE + HASH]
        heads[hashed] -= 1
        place = heads[hashed]
        cells[place * SIZE + ORDER] = collider
        source, target = collider * aabb.SIZE, place * aabb.SIZE
        for entry in range(aabb.SIZE):
            grid.sorted_aabbs[target + entry] = aabbs[source + entry]


@inline
def _meet_column(
    box: int, hashed: int, cells: int, begin: int, room: int, met: int, grid: Grid, met_at: Indices
) -> int:
    """
    Add the boxes that overlap a box and stand in cells of a column that follow each other.

        box    : where it begins in the sorted list
        hashed : hash of the first cell;   cells : their number
        begin  : where in the sorted list to begin; FROM_CELL: where the first cell does
        met    : how many were met before;   met_at : written, up to the room
    """
    boxes, heads = grid.sorted_aabbs, grid.hash_heads
    size = len(heads) - 1
    end = hashed + cells
    start = heads[hashed] if begin == FROM_CELL else begin
    last = heads[min(end, size)]
    around = heads[end - size] if end > size else 0  # the hash begins anew
    for other in range(start, last):
        met_at[min(met, room - 1)] = other
        met += overlap(boxes, box, other * aabb.SIZE)
    for other in range(around):
        met_at[min(met, room - 1)] = other
        met += overlap(boxes, box, other * aabb.SIZE)
    return met


@inline
def _meet_box(place: int, coarsest: int, room: int, met: int, grid: Grid, met_at: Indices) -> int:
    """Add the boxes that overlap the one at a place of the sorted list: see `_meet_column`."""
    boxes, cells, box = grid.sorted_aabbs, grid.cells, place * aabb.SIZE
    mask = len(grid.hash_heads) - 2
    row = cells[place * SIZE + ORDER] * SIZE
    own = cells[row + LEVEL]
    x, y, z = cells[row + CELL_X], cells[row + CELL_Y], cells[row + CELL_Z]
    for level in range(own, coarsest + 1):
        edge = grid.edges[level]
        if edge == 0.0:
            continue
        half, inverse = WIDER * 0.5 * edge, 1.0 / edge
        low_x = x if level == own else _cell((boxes[box + LOW] - half) * inverse)
        low_y = _cell((boxes[box + LOW + 1] - half) * inverse)
        low_z = _cell((boxes[box + LOW + 2] - half) * inverse)
        high_x = _cell((boxes[box + HIGH] + half) * inverse)
        high_y = _cell((boxes[box + HIGH + 1] + half) * inverse)
        high_z = _cell((boxes[box + HIGH + 2] + half) * inverse)
        for cell_x in range(low_x, high_x + 1):
            ahead = level > own or cell_x > x
            for cell_y in range(low_y if ahead else y, high_y + 1):
                here = not ahead and cell_y == y
                low = z if here else low_z
                hashed = (_column(cell_x, cell_y, level) + low) & mask
                begin = place + 1 if here else FROM_CELL
                met = _meet_column(box, hashed, high_z - low + 1, begin, room, met, grid, met_at)
    return met


@kernel
def find_overlaps(
    first: int, count: int, room: int, table: Indices, grid: Grid, later: Indices,
    earlier: Indices,
) -> int:  # fmt: skip
    """
    Write the pairs of boxes of two bodies that overlap, of which at least one moves, in any order,
    some of them more than once; return how many were written, or would have been beyond the room.

        first          : boxes before this one are left out;   count : of colliders
        room           : pairs for which there is room
        later, earlier : written: the later of two colliders, and the earlier
    """
    if count - first < 2:
        return 0
    _find_levels(first, count, grid)
    _sort_into_cells(first, count, grid)
    coarsest = 0
    for level in range(LEVELS):
        if grid.edges[level] > 0.0:
            coarsest = level
    pairs = 0
    for place in range(count - first):
        met = _meet_box(place, coarsest, room, pairs, grid, earlier)
        if met > room:
            pairs = met
            continue
        one = grid.cells[place * SIZE + ORDER]
        body = table[one * collider_record.SIZE + collider_record.BODY]
        for index in range(pairs, met):
            other = grid.cells[earlier[index] * SIZE + ORDER]
            of_other = table[other * collider_record.SIZE + collider_record.BODY]
            if body != of_other and max(body, of_other) >= 0:  # not two parts of one body
                later[pairs], earlier[pairs] = max(one, other), min(one, other)
                pairs += 1
    return pairs
