# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The broad phase: the pairs that may meet within a tick, out of a neighbour list that is kept over
ticks (a Verlet list).

What a collider may reach in a tick lies in a box, its swept AABB. Its fat AABB is that box,
enlarged by a flight of AHEAD ticks and by a skin. The list holds the pairs whose fat AABBs
overlap, and is good while every swept AABB stays in its fat one, however it got there: boxes that
overlap lie in fat ones that do. So no pair is missed, and since each tick tests exactly the pairs
in the list, it finds the pairs, and the order, of a list made anew. Skin and flight change no bit
of a result, and need not be remembered: a body that was put elsewhere has left its fat AABB.

A wide fat AABB lasts long, but many pairs are tested in vain. The skin grows when a list was used
up early and shrinks when it lasted; at an age of WORTH * radius / skin ticks, making the list has
cost about as much as the pairs that the skin added to it.

Up to BRUTE colliders are compared each with each, more in a hash grid (`hash_grid`). Planes are in
no grid: the fat AABBs of everything that moves are compared with them.

    fat_aabbs  : for n colliders: fat AABBs, swept AABBs, AABBs sorted for the grid; edges of the
                 cells of the grid; skin
    neighbours : LENGTH and AGE, then from PAIRS on the later and the earlier colliders of the
                 pairs, in rising order; then as many again, while they are sorted
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import (
    aabb,
    bounds_record,
    collider_record,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.aabb import HIGH, LOW, overlap
from rigid_body_sim.physics.contact.collision.collider import BroadPhase, ColliderArrays
from rigid_body_sim.physics.contact.collision.hash_grid import LEVELS, Grid, find_overlaps
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET
from rigid_body_sim.physics.contact.collision.swept_aabbs import may_meet, may_meet_plane
from rigid_body_sim.physics.vectors import dot, load

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

BRUTE = 24  # [-] colliders, up to which no grid is worth its while
AHEAD = 8.0  # [-] ticks of flight that a fat AABB holds
WORTH = 1.5  # [-] age times skin, in radii, at which a list and its length cost the same
THINNEST, FIRST, THICKEST = 0.02, 0.1, 1.0  # [-] skin in radii
THICKER, THINNER = 1.4, 0.75  # [-] from one list to the next
LATE = 2.0  # [-] times that age, from which a list is made anew with a thinner skin
CORNER_ROUND_OFF = 1e-14  # [-] of what is added up to a corner of a box
LARGEST = 1e150  # [m] from the origin

NO_LIST = 0  # age of no list
NO_SKIN = 0.0  # [m] skin before the first list

neighbour_list = Record()
LENGTH = neighbour_list.number('-', 'pairs in the list')
AGE = neighbour_list.number('tick', 'since it was made, that included; NO_LIST')
PAIRS = neighbour_list.size


class Query(NamedTuple):
    """
    What the broad phase is asked for.

    size   : colliders
    planes : so many at the head of the table are planes
    room   : pairs for which the list has room
    h      : tick [s]
    radius : of a usual collider [m]
    """

    size: int
    planes: int
    room: int
    h: float
    radius: float


def size_of_fat_aabbs(count: int) -> int:
    """Count the numbers of `fat_aabbs` for so many colliders."""
    return 3 * aabb.SIZE * count + LEVELS + 1


def size_of_list(room: int) -> int:
    """Count the numbers of `neighbours` with room for so many pairs."""
    return PAIRS + 4 * room


@inline
def _skin_place(count: int) -> int:
    return 3 * aabb.SIZE * count + LEVELS


@kernel
def _find_boxes(query: Query, swept: Array, fat_aabbs: Array) -> bool:
    """Find the swept AABBs as corners; tell whether each is in its fat AABB."""
    inside = True
    for collider in range(query.planes, query.size):
        row = collider * swept_aabbs.SIZE
        fat, box = collider * aabb.SIZE, (query.size + collider) * aabb.SIZE
        expansion = swept[row + swept_aabbs.EXPANSION]
        for axis in range(3):
            center = swept[row + swept_aabbs.CENTER + axis]
            reach = swept[row + swept_aabbs.HALF + axis] + expansion
            reach += CORNER_ROUND_OFF * (abs(center) + reach)
            low, high = center - reach, center + reach
            fat_aabbs[box + LOW + axis], fat_aabbs[box + HIGH + axis] = low, high
            inside &= (low >= fat_aabbs[fat + LOW + axis]) & (high <= fat_aabbs[fat + HIGH + axis])
    return inside


@kernel
def _make_fat_aabbs(
    query: Query, skin: float, colliders: ColliderArrays, fat_aabbs: Array
) -> None:
    """Give each collider its fat AABB, and each plane a box that overlaps all."""
    swept = colliders.swept_aabbs
    for plane in range(query.planes):
        box = (query.size + plane) * aabb.SIZE
        for axis in range(3):
            fat_aabbs[box + LOW + axis], fat_aabbs[box + HIGH + axis] = -LARGEST, LARGEST
    for collider in range(query.planes, query.size):
        row = collider * swept_aabbs.SIZE
        fat, box = collider * aabb.SIZE, (query.size + collider) * aabb.SIZE
        around = 0.0
        if colliders.table[collider * collider_record.SIZE + collider_record.BODY] >= 0:
            bounds = collider * bounds_record.SIZE
            around = min(
                skin,
                colliders.local_bounds[bounds + bounds_record.RADIUS]
                + swept[row + swept_aabbs.MARGIN],
            )
        for axis in range(3):
            flight = swept[row + swept_aabbs.VELOCITY + axis] * (AHEAD * query.h)
            low = fat_aabbs[box + LOW + axis] - around + min(flight, 0.0)
            high = fat_aabbs[box + HIGH + axis] + around + max(flight, 0.0)
            fat_aabbs[fat + LOW + axis] = min(max(low, -LARGEST), LARGEST)
            fat_aabbs[fat + HIGH + axis] = max(min(high, LARGEST), -LARGEST)


@inline
def _reaches_plane(plane: int, collider: int, colliders: ColliderArrays, fat_aabbs: Array) -> Any:
    """Tell whether a fat AABB, with the margin of its collider, reaches a plane."""
    normal, box = load(colliders.parameters, plane + NORMAL), collider * aabb.SIZE
    lowest = (
        fat_aabbs[box + LOW] if normal[0] > 0.0 else fat_aabbs[box + HIGH],
        fat_aabbs[box + LOW + 1] if normal[1] > 0.0 else fat_aabbs[box + HIGH + 1],
        fat_aabbs[box + LOW + 2] if normal[2] > 0.0 else fat_aabbs[box + HIGH + 2],
    )
    height = dot(normal, lowest) - colliders.parameters[plane + OFFSET]
    return height <= colliders.swept_aabbs[collider * swept_aabbs.SIZE + swept_aabbs.MARGIN]


@kernel
def _add_planes(
    query: Query, length: int, colliders: ColliderArrays, broad_phase: BroadPhase
) -> int:
    """Add the pairs with planes to a list of so many; return how many there are then."""
    neighbours, table = broad_phase.neighbours, colliders.table
    for plane in range(query.planes):
        place = table[plane * collider_record.SIZE + collider_record.PARAMETERS]
        for collider in range(query.planes, query.size):
            moves = table[collider * collider_record.SIZE + collider_record.BODY] >= 0
            if moves and _reaches_plane(place, collider, colliders, broad_phase.fat_aabbs):
                if length < query.room:
                    neighbours[PAIRS + length] = collider
                    neighbours[PAIRS + query.room + length] = plane
                length += 1
    return length


@kernel
def _compare_all(query: Query, colliders: ColliderArrays, broad_phase: BroadPhase) -> int:
    """Compare each with each: the list in its order; return its length."""
    neighbours, table = broad_phase.neighbours, colliders.table
    fat_aabbs, length = broad_phase.fat_aabbs, 0
    for later in range(query.planes, query.size):
        body = table[later * collider_record.SIZE + collider_record.BODY]
        for earlier in range(later):
            other = table[earlier * collider_record.SIZE + collider_record.BODY]
            if body == other or max(body, other) < 0:  # parts of one body; neither moves
                continue
            if earlier < query.planes:
                place = table[earlier * collider_record.SIZE + collider_record.PARAMETERS]
                meets = _reaches_plane(place, later, colliders, fat_aabbs)
            else:
                meets = overlap(fat_aabbs, earlier * aabb.SIZE, later * aabb.SIZE)
            if meets:
                if length < query.room:
                    neighbours[PAIRS + length] = later
                    neighbours[PAIRS + query.room + length] = earlier
                length += 1
    return length


@kernel
def _sort(length: int, count: int, room: int, counts: Indices, neighbours: Indices) -> int:
    """
    Sort the pairs by their earlier colliders, then, keeping that order, by their later ones: each
    time count them, then put them where they belong. Drop copies; return how many are left.
    """
    for step in range(2):
        source = PAIRS + 2 * room * step
        target = PAIRS + 2 * room * (1 - step)
        sorted_by = source + room * (1 - step)
        for collider in range(count):
            counts[collider] = 0
        for pair in range(length):
            counts[neighbours[sorted_by + pair]] += 1
        total = target
        for collider in range(count):
            of_this = counts[collider]
            counts[collider] = total
            total += of_this
        for pair in range(length):
            collider = neighbours[sorted_by + pair]
            place = counts[collider]
            counts[collider] = place + 1
            neighbours[place] = neighbours[source + pair]
            neighbours[place + room] = neighbours[source + room + pair]
    left, last_later, last_earlier = 0, -1, -1
    for pair in range(length):
        later, earlier = neighbours[PAIRS + pair], neighbours[PAIRS + room + pair]
        neighbours[PAIRS + left], neighbours[PAIRS + room + left] = later, earlier
        left += (later != last_later) | (earlier != last_earlier)
        last_later, last_earlier = later, earlier
    return left


@kernel
def _make_list(query: Query, colliders: ColliderArrays, broad_phase: BroadPhase) -> int:
    """Make fat AABBs and the list of those that overlap; return its length, even beyond room."""
    count, room, radius = query.size, query.room, query.radius
    fat_aabbs, neighbours = broad_phase.fat_aabbs, broad_phase.neighbours
    place = _skin_place(count)
    skin = fat_aabbs[place]
    if skin == NO_SKIN:
        skin = FIRST * radius
    elif neighbours[AGE] > NO_LIST:
        skin *= THICKER if neighbours[AGE] * skin < WORTH * radius else THINNER
        skin = min(max(skin, THINNEST * radius), THICKEST * radius)
    fat_aabbs[place] = skin
    _make_fat_aabbs(query, skin, colliders, fat_aabbs)
    if count <= BRUTE:
        length = _compare_all(query, colliders, broad_phase)
    else:
        entered, edges = 2 * aabb.SIZE * count, 3 * aabb.SIZE * count
        grid = Grid(
            fat_aabbs, fat_aabbs[entered:edges], fat_aabbs[edges:], broad_phase.grid,
            broad_phase.hash_heads,
        )  # fmt: skip
        length = find_overlaps(
            query.planes, count, room, colliders.table, grid, neighbours[PAIRS : PAIRS + room],
            neighbours[PAIRS + room : PAIRS + 2 * room],
        )  # fmt: skip
        length = _add_planes(query, length, colliders, broad_phase)
        if length <= room:
            length = _sort(length, count, room, broad_phase.hash_heads, neighbours)
    neighbours[LENGTH] = length
    neighbours[AGE] = 1 if length <= room else NO_LIST
    return length


@kernel
def find_pairs(
    count: int, planes: int, h: float, radius: float, room: int, colliders: ColliderArrays,
    broad_phase: BroadPhase,
) -> int:  # fmt: skip
    """
    Write the ids, later collider * count + earlier one, of the pairs that may meet in this tick,
    in rising order; return how many there are, or the length of the list, if beyond its room.

        count  : of colliders
        planes : so many of them at the head of the table are planes
        h      : tick [s];   radius : of a usual collider [m]
        room   : pairs for which the list has room
    """
    query = Query(count, planes, room, h, radius)
    fat_aabbs, neighbours = broad_phase.fat_aabbs, broad_phase.neighbours
    swept, pair_ids = colliders.swept_aabbs, broad_phase.pair_ids
    inside = _find_boxes(query, swept, fat_aabbs)
    age, skin = neighbours[AGE], fat_aabbs[_skin_place(count)]
    late = skin > THINNEST * radius and age * skin > LATE * WORTH * radius
    if age > NO_LIST and inside and not late:
        neighbours[AGE] = age + 1
    else:
        length = _make_list(query, colliders, broad_phase)
        if length > room:
            return length
    near = 0
    for pair in range(neighbours[LENGTH]):
        pair_ids[near] = pair
        later = count + neighbours[PAIRS + pair]
        earlier = count + neighbours[PAIRS + room + pair]
        near += overlap(fat_aabbs, later * aabb.SIZE, earlier * aabb.SIZE)
    found = 0
    for index in range(near):
        pair = pair_ids[index]
        later, earlier = neighbours[PAIRS + pair], neighbours[PAIRS + room + pair]
        if earlier < planes:
            plane = colliders.table[earlier * collider_record.SIZE + collider_record.PARAMETERS]
            meets = may_meet_plane(plane, later, h, colliders)
        else:
            meets = may_meet(swept, earlier * swept_aabbs.SIZE, later * swept_aabbs.SIZE, h)
        if meets:
            pair_ids[found] = later * count + earlier
            found += 1
    return found
