# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The pairs that may meet within a tick, out of a list that is kept over ticks (a Verlet list).

What a collider may reach in a tick lies in a box. Its room is that box, enlarged by a flight of
AHEAD ticks and by a skin. The list holds the pairs whose rooms overlap, and is good while every
box stays in its room, however it got there: boxes that overlap lie in rooms that do. So no pair is
missed, and since each tick tests exactly the pairs kept, it finds the pairs, and the order, of a
list made anew. Skin and flight change no bit of a result, and need not be remembered: a body that
was put elsewhere has left its room.

A wide room lasts long, but many pairs are tested in vain. The skin grows when a list was used up
early and shrinks when it lasted; at an age of WORTH * radius / skin ticks, making the list has
cost about as much as the pairs that the skin added to it.

Up to BRUTE colliders are compared each with each, more in a grid (`grid`). Planes are in no grid:
the rooms of everything that moves are compared with them.

    rooms : for n colliders: room, box, box sorted for the grid, BOX each; edges for the grid; skin
    kept  : number of pairs, age in ticks (0: no list); then the larger and the smaller places of
            the pairs, in rising order; then as many again, while they are sorted
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.collider import BOUNDS, CORE, SIZES, TABLE
from rigid_body_sim.physics.contact.collision.hash_grid import BOX, LEVELS, overlap, overlaps
from rigid_body_sim.physics.contact.collision.swept_aabbs import (
    HALF,
    REACH,
    ROW,
    SMALL,
    SPEED,
    may_meet,
    meets_plane,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

BRUTE = 24  # [-] colliders, up to which no grid is worth its while
AHEAD = 8.0  # [-] ticks of flight that a room holds
WORTH = 1.5  # [-] age times skin, in radii, at which a list and its length cost the same
THINNEST, FIRST, THICKEST = 0.02, 0.1, 1.0  # [-] skin in radii
THICKER, THINNER = 1.4, 0.75  # [-] from one list to the next
LATE = 2.0  # [-] times that age, from which a list is made anew with a thinner skin
ROUND_OFF = 1e-14  # [-] of what is added up to a corner of a box
LARGEST = 1e150  # [m] from the origin

KEPT, AGE, LIST = 0, 1, 2


def size_of_rooms(n: int) -> int:
    """Count the numbers of `rooms` for n colliders."""
    return 3 * BOX * n + LEVELS + 1


def size_of_list(room: int) -> int:
    """Count the numbers of `kept` with room for so many pairs."""
    return LIST + 4 * room


@kernel
def _find_boxes(planes: int, n: int, reaches: Array, rooms: Array) -> bool:
    """Find the boxes of all that colliders may reach; tell whether they are in their rooms."""
    inside = True
    for j in range(planes, n):
        o, p, q = j * ROW, j * BOX, (n + j) * BOX
        for axis in range(3):
            x, e = reaches[o + axis], reaches[o + HALF + axis] + reaches[o + REACH]
            e += ROUND_OFF * (abs(x) + e)
            low, high = x - e, x + e
            rooms[q + axis], rooms[q + 3 + axis] = low, high
            inside &= (low >= rooms[p + axis]) & (high <= rooms[p + 3 + axis])
    return inside


@kernel
def _make_rooms(
    planes: int, n: int, h: float, skin: float, table: Indices, bounds: Array, reaches: Array,
    rooms: Array,
) -> None:  # fmt: skip
    """Give each collider its room, and each plane a box that overlaps all."""
    for i in range(planes):
        for axis in range(3):
            rooms[(n + i) * BOX + axis], rooms[(n + i) * BOX + 3 + axis] = -LARGEST, LARGEST
    for j in range(planes, n):
        o, p, q = j * ROW, j * BOX, (n + j) * BOX
        around = 0.0
        if table[j * TABLE + CORE] >= 0:
            around = min(skin, bounds[j * BOUNDS + 7] + reaches[o + SMALL])
        for axis in range(3):
            flight = reaches[o + SPEED + axis] * (AHEAD * h)
            low = rooms[q + axis] - around + min(flight, 0.0)
            high = rooms[q + 3 + axis] + around + max(flight, 0.0)
            rooms[p + axis] = min(max(low, -LARGEST), LARGEST)
            rooms[p + 3 + axis] = max(min(high, LARGEST), -LARGEST)


@inline
def _reaches_plane(at: int, p: int, small: float, numbers: Array, rooms: Array) -> bool:
    """Tell whether a room, with the margin of its collider, reaches a plane."""
    nx, ny, nz = numbers[at], numbers[at + 1], numbers[at + 2]
    x = rooms[p] if nx > 0.0 else rooms[p + 3]
    y = rooms[p + 1] if ny > 0.0 else rooms[p + 4]
    z = rooms[p + 2] if nz > 0.0 else rooms[p + 5]
    return nx * x + ny * y + nz * z - numbers[at + 3] <= small


@kernel
def _add_planes(
    planes: int, n: int, room: int, count: int, numbers: Array, table: Indices, reaches: Array,
    rooms: Array, kept: Indices,
) -> int:  # fmt: skip
    """Add the pairs with planes to a list of so many; return how many there are then."""
    for i in range(planes):
        at = table[i * TABLE + SIZES]
        for j in range(planes, n):
            small = reaches[j * ROW + SMALL]
            if table[j * TABLE + CORE] >= 0 and _reaches_plane(at, j * BOX, small, numbers, rooms):
                if count < room:
                    kept[LIST + count], kept[LIST + room + count] = j, i
                count += 1
    return count


@kernel
def _compare_all(
    planes: int, n: int, room: int, numbers: Array, table: Indices, reaches: Array, rooms: Array,
    kept: Indices,
) -> int:  # fmt: skip
    """Compare each with each: the list in its order; return its length."""
    count = 0
    for j in range(planes, n):
        small = reaches[j * ROW + SMALL]
        core = table[j * TABLE + CORE]
        for i in range(j):
            other = table[i * TABLE + CORE]
            if core == other or max(core, other) < 0:  # parts of one body; neither moves
                continue
            if i < planes:
                at = table[i * TABLE + SIZES]
                meets = _reaches_plane(at, j * BOX, small, numbers, rooms)
            else:
                meets = overlap(rooms, i * BOX, j * BOX)
            if meets:
                if count < room:
                    kept[LIST + count], kept[LIST + room + count] = j, i
                count += 1
    return count


@kernel
def _sort(count: int, n: int, room: int, heads: Indices, kept: Indices) -> int:
    """
    Sort the pairs by their smaller places, then, keeping that order, by their larger ones: each
    time count them, then put them where they belong. Drop copies; return how many are left.
    """
    for turn in range(2):
        source = LIST + 2 * room * turn
        target = LIST + 2 * room * (1 - turn)
        by = source + room * (1 - turn)
        for i in range(n):
            heads[i] = 0
        for k in range(count):
            heads[kept[by + k]] += 1
        total = target
        for i in range(n):
            here = heads[i]
            heads[i] = total
            total += here
        for k in range(count):
            i = kept[by + k]
            to = heads[i]
            heads[i] = to + 1
            kept[to] = kept[source + k]
            kept[to + room] = kept[source + room + k]
    left, last_j, last_i = 0, -1, -1
    for k in range(count):
        j, i = kept[LIST + k], kept[LIST + room + k]
        kept[LIST + left], kept[LIST + room + left] = j, i
        left += (j != last_j) | (i != last_i)
        last_j, last_i = j, i
    return left


@kernel
def _make_list(
    planes: int, n: int, h: float, radius: float, room: int, numbers: Array, table: Indices,
    bounds: Array, reaches: Array, rooms: Array, grid: Indices, heads: Indices, kept: Indices,
) -> int:  # fmt: skip
    """Make rooms and the list of those that overlap; return its length, also beyond its room."""
    at = 3 * BOX * n + LEVELS
    skin = rooms[at]
    if skin == 0.0:
        skin = FIRST * radius
    elif kept[AGE] > 0:
        skin *= THICKER if kept[AGE] * skin < WORTH * radius else THINNER
        skin = min(max(skin, THINNEST * radius), THICKEST * radius)
    rooms[at] = skin
    _make_rooms(planes, n, h, skin, table, bounds, reaches, rooms)
    if n <= BRUTE:
        count = _compare_all(planes, n, room, numbers, table, reaches, rooms, kept)
    else:
        entered, edges = rooms[2 * BOX * n : 3 * BOX * n], rooms[3 * BOX * n :]
        count = overlaps(
            planes, n, room, table, rooms, edges, entered, grid, heads, LIST, LIST + room, kept
        )
        count = _add_planes(planes, n, room, count, numbers, table, reaches, rooms, kept)
        if count <= room:
            count = _sort(count, n, room, heads, kept)
    kept[KEPT] = count
    kept[AGE] = 1 if count <= room else 0
    return count


@kernel
def find_pairs(
    n: int, planes: int, h: float, radius: float, room: int, numbers: Array, table: Indices,
    bounds: Array, reaches: Array, rooms: Array, grid: Indices, heads: Indices, kept: Indices,
    keys: Indices,
) -> int:  # fmt: skip
    """
    Write the keys larger place * n + smaller place of the pairs that may meet in this tick, in
    rising order; return how many there are, or, if the list is longer than its room, its length.

        planes : so many colliders at the head of the table are planes
        radius : of a usual collider [m]
    """
    inside = _find_boxes(planes, n, reaches, rooms)
    age, skin = kept[AGE], rooms[3 * BOX * n + LEVELS]
    late = skin > THINNEST * radius and age * skin > LATE * WORTH * radius
    if age > 0 and inside and not late:
        kept[AGE] = age + 1
    else:
        length = _make_list(
            planes, n, h, radius, room, numbers, table, bounds, reaches, rooms, grid, heads, kept
        )
        if length > room:
            return length
    near = 0
    for k in range(kept[KEPT]):
        keys[near] = k
        near += overlap(rooms, (n + kept[LIST + k]) * BOX, (n + kept[LIST + room + k]) * BOX)
    count = 0
    for k in range(near):
        j, i = kept[LIST + keys[k]], kept[LIST + room + keys[k]]
        if i < planes:
            meets = meets_plane(table[i * TABLE + SIZES], j, h, reaches, numbers, bounds)
        else:
            meets = may_meet(reaches, i * ROW, j * ROW, h)
        if meets:
            keys[count] = j * n + i
            count += 1
    return count
