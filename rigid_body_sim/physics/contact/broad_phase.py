# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which colliders may touch within a tick.

A collider reaches as far as its bounding box, what it may move in a tick, and the margin. Up to
BRUTE colliders are compared each with each; more are entered, one by one, into a grid of cells
that is hashed and rebuilt every tick. There is a grid for each size of reach, in powers of two: a
collider looks at the 27 cells around it in its own grid and in those of larger ones, which were
entered before, so that each pair is met once and pebbles cost a boulder nothing. Planes are in no
grid: everything that moves is compared with them.

Two boxes that pass the test are a pair: its key is larger place * n + smaller place, in the order
of places in the table. Keys come out in rising order.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collider import BOUNDS, CORE, POSE, TABLE, bounding_box
from rigid_body_sim.physics.contact.touching_bodies import ACC, BODY, II, IM, L, P
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

BRUTE = 24  # [-] colliders, up to which no grid is worth its while
FAR = 1e15  # [-] cells from the origin, beyond which all share one
LEVELS = 60  # grids

# reaches: one row per collider
MIDDLE, HALF, SPEED, TURN, SMALL, REACH = (
    0,
    3,
    6,
    9,
    10,
    11,
)  # [m], velocity [m/s]; TURN: what turning and forces add
ROW = 12
# grid: one row per collider
CELL_X, CELL_Y, CELL_Z, LEVEL, NEXT, ORDER = range(6)
CELL = 6


@kernel
def find_reaches(
    n: int, h: float, margin: float, table: Indices, bounds: Array, poses: Array, bodies: Array,
    reaches: Array,
) -> None:  # fmt: skip
    """
    Find how far each collider reaches: bounding box, velocity, and what turning adds in a tick.
    """
    for i in range(n):
        b, o = i * BOUNDS, i * ROW
        radius = bounds[b + 7]
        if radius == math.inf:
            continue
        x, y, z, ex, ey, ez = bounding_box(bounds, b, poses, i * POSE)
        reaches[o], reaches[o + 1], reaches[o + 2] = x, y, z
        reaches[o + 3], reaches[o + 4], reaches[o + 5] = ex, ey, ez
        small = min(margin, 0.1 * radius) if radius > 0.0 else margin
        reaches[o + SMALL] = small
        core = table[i * TABLE + CORE]
        speed = 0.0
        if core >= 0:
            m = core * BODY
            u, v, w = bodies[m + P], bodies[m + P + 1], bodies[m + P + 2]
            im = bodies[m + IM]
            u, v, w = u * im, v * im, w * im
            reaches[o + SPEED], reaches[o + SPEED + 1], reaches[o + SPEED + 2] = u, v, w
            speed = math.sqrt(u * u + v * v + w * w) * h
            a, b2, c = bodies[m + L], bodies[m + L + 1], bodies[m + L + 2]
            i1, i2, i3 = bodies[m + II], bodies[m + II + 1], bodies[m + II + 2]
            i4, i5, i6 = bodies[m + II + 3], bodies[m + II + 4], bodies[m + II + 5]
            p = i1 * a + i2 * b2 + i3 * c
            q = i2 * a + i4 * b2 + i5 * c
            r = i3 * a + i5 * b2 + i6 * c
            turn = math.sqrt(p * p + q * q + r * r) * radius * h
            u, v, w = bodies[m + ACC], bodies[m + ACC + 1], bodies[m + ACC + 2]
            fall = math.sqrt(u * u + v * v + w * w) * h * h
            reaches[o + TURN] = min(turn, 2.0 * radius) + fall
        reaches[o + REACH] = max(ex, ey, ez) + small + speed + reaches[o + TURN]


@inline
def margin_of(reaches: Array, a: int, b: int, h: float) -> float:
    """Gap within which two colliders may meet in a tick [m]."""
    u = reaches[b + SPEED] - reaches[a + SPEED]
    v = reaches[b + SPEED + 1] - reaches[a + SPEED + 1]
    w = reaches[b + SPEED + 2] - reaches[a + SPEED + 2]
    return (
        min(reaches[a + SMALL], reaches[b + SMALL])
        + h * math.sqrt(u * u + v * v + w * w)
        + (reaches[a + TURN] + reaches[b + TURN])
    )


@inline
def _may_meet(reaches: Array, a: int, b: int, h: float) -> bool:
    margin = margin_of(reaches, a, b, h)
    return (
        abs(reaches[b] - reaches[a]) <= reaches[a + HALF] + reaches[b + HALF] + margin
        and abs(reaches[b + 1] - reaches[a + 1])
        <= reaches[a + HALF + 1] + reaches[b + HALF + 1] + margin
        and abs(reaches[b + 2] - reaches[a + 2])
        <= reaches[a + HALF + 2] + reaches[b + HALF + 2] + margin
    )


@kernel
def _meets_plane(
    a: int, b: int, h: float, reaches: Array, numbers: Array, table: Indices,
    bounds: Array, poses: Array,
) -> bool:  # fmt: skip
    """Tell whether collider b may reach plane a."""
    at = table[a * TABLE + 1]
    nx, ny, nz = numbers[at], numbers[at + 1], numbers[at + 2]
    o = b * ROW
    x, y, z = reaches[o], reaches[o + 1], reaches[o + 2]
    extent = min(
        abs(nx) * reaches[o + HALF]
        + abs(ny) * reaches[o + HALF + 1]
        + abs(nz) * reaches[o + HALF + 2],
        bounds[b * BOUNDS + 7],
    )
    toward = -(nx * reaches[o + SPEED] + ny * reaches[o + SPEED + 1] + nz * reaches[o + SPEED + 2])
    margin = reaches[o + SMALL] + max(toward, 0.0) * h + reaches[o + TURN]
    return nx * x + ny * y + nz * z - numbers[at + 3] - extent <= margin


@inline
def _cell(x: float) -> int:
    return int(math.floor(min(max(x, -FAR), FAR)))


@inline
def _hash(x: int, y: int, z: int, level: int, mask: int) -> int:
    return ((x * 73856093) ^ (y * 19349663) ^ (z * 83492791) ^ (level * 2654435761)) & mask


@kernel
def _sort(first: int, count: int, keys: Indices) -> None:
    """Sort keys: by insertion if few, else as a heap."""
    if count <= 24:
        for i in range(first + 1, first + count):
            key = keys[i]
            j = i
            while j > first and keys[j - 1] > key:
                keys[j] = keys[j - 1]
                j -= 1
            keys[j] = key
        return
    start, end = count // 2, count
    while end > 1:
        if start > 0:
            start -= 1
        else:
            end -= 1
            keys[first + end], keys[first] = keys[first], keys[first + end]
        root = start
        while 2 * root + 1 < end:
            child = 2 * root + 1
            if child + 1 < end and keys[first + child] < keys[first + child + 1]:
                child += 1
            if keys[first + root] >= keys[first + child]:
                break
            keys[first + root], keys[first + child] = keys[first + child], keys[first + root]
            root = child


@kernel
def find_pairs(
    n: int, planes: int, h: float, cell: float, room: int, numbers: Array,
    table: Indices, bounds: Array, poses: Array, reaches: Array, grid: Indices, heads: Indices,
    keys: Indices,
) -> int:  # fmt: skip
    """
    Write the keys of the pairs that may meet; return how many there are, also beyond the room.

    planes : so many colliders at the head of the table are planes
    cell   : [m] of the finest grid
    """
    count = 0
    if n <= BRUTE:
        for j in range(planes, n):
            moves = table[j * TABLE + CORE] >= 0
            for i in range(j):
                if not moves and (i < planes or table[i * TABLE + CORE] < 0):
                    continue
                if i < planes:
                    if not _meets_plane(i, j, h, reaches, numbers, table, bounds, poses):
                        continue
                elif not _may_meet(reaches, i * ROW, j * ROW, h):
                    continue
                if count < room:
                    keys[count] = j * n + i
                count += 1
        return count
    size = len(heads)
    mask = size - 1
    for i in range(size):
        heads[i] = -1
    finest, coarsest = LEVELS, 0
    for j in range(planes, n):
        level, edge = 0, cell
        reach = 2.0 * reaches[j * ROW + REACH]
        while edge < reach and level < LEVELS:
            level += 1
            edge *= 2.0
        grid[j * CELL + LEVEL] = level
        finest, coarsest = min(finest, level), max(coarsest, level)
    occupied = 0  # the levels that hold something, as bits
    in_order = True
    last = -1
    for falling in range(coarsest - finest + 1):
        level = coarsest - falling
        for j in range(planes, n):
            row = j * CELL
            if grid[row + LEVEL] != level:
                continue
            occupied |= 1 << level
            moves = table[j * TABLE + CORE] >= 0
            first = count
            if moves:
                for i in range(planes):
                    if _meets_plane(i, j, h, reaches, numbers, table, bounds, poses):
                        if count < room:
                            keys[count] = j * n + i
                        count += 1
            for larger in range(level, coarsest + 1):
                if not (occupied >> larger) & 1:
                    continue
                inverse = 1.0 / (cell * 2.0**larger)
                x = _cell(reaches[j * ROW] * inverse)
                y = _cell(reaches[j * ROW + 1] * inverse)
                z = _cell(reaches[j * ROW + 2] * inverse)
                if larger == level:
                    grid[row + CELL_X], grid[row + CELL_Y], grid[row + CELL_Z] = x, y, z
                for cx in range(x - 1, x + 2):
                    hash_x = (cx * 73856093) ^ (larger * 2654435761)
                    for cy in range(y - 1, y + 2):
                        hash_y = hash_x ^ (cy * 19349663)
                        for cz in range(z - 1, z + 2):
                            i = heads[(hash_y ^ (cz * 83492791)) & mask]
                            while i >= 0:
                                other = i * CELL
                                if (
                                    grid[other + CELL_X] == cx
                                    and grid[other + CELL_Y] == cy
                                    and grid[other + CELL_Z] == cz
                                    and grid[other + LEVEL] == larger
                                    and (moves or table[i * TABLE + CORE] >= 0)
                                    and _may_meet(reaches, i * ROW, j * ROW, h)
                                ):
                                    if count < room:
                                        keys[count] = j * n + i if i < j else i * n + j
                                    count += 1
                                i = grid[other + NEXT]
            place = _hash(grid[row + CELL_X], grid[row + CELL_Y], grid[row + CELL_Z], level, mask)
            grid[row + NEXT] = heads[place]
            heads[place] = j
            if count <= room and count > first:
                _sort(first, count - first, keys)
                in_order = in_order and keys[first] > last
                last = keys[count - 1]
    if not in_order and count <= room:
        _sort(0, count, keys)
    return count
