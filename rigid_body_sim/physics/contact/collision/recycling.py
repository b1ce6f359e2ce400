# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Manifolds that follow their bodies: of pairs that have hardly moved against each other since their
last full detection, what that found is taken again (contact recycling).

Kept of a pair are the places x_A, x_B of each point on the two surfaces, in the axes of their
shapes, and what spans the normal: a face of A or of B, or an edge of each. All of it moves with
the bodies:

    n   = R_A d_A                 of a face of A; likewise of B
          R_A d_A x R_B d_B / |.| of two edges
    gap = n . (x_B - x_A),        a point lies midway

So normal and separation are those of the same parts of the two shapes to round-off: a corner
stays at its distance from a face, two edges stay at theirs. What is not looked at again is which
parts they are. They are kept while, since the full detection,

    |x_B - x_A - gap_0 n|  <= TOLERANCE d      at each point
    |Q - Q_0|_F / sqrt 2   <= TOLERANCE        Q = R_A^T R_B: the angle they turned by [rad]
        d : diameter of the smaller ball about the two

which is the same whoever is A. So no material point near the contact has come nearer by more than
3 TOLERANCE d than its points say: by so much, at most, a corner that was not among them is deeper,
and another axis would be the better one. It is always the last full detection that is compared
with, so nothing adds up. Besides, the pair must be unable to reach in this tick what lay beyond
the margin then; and where its face has other corners than its points, and two of these bear all
of the load, it must not tip over these: others may be needed (`loaded_side`).

A cylinder touches with other parts as it turns about its axis, and nothing else changes by that.
So where a face of the other shape meets its rim or mantle, its frame in R, Q and x is that of its
axis and the normal; where rim and mantle of two cylinders meet, that of its axis and the other's.
Neither feels spin: what rolls slowly rolls as it would. The normal of a mantle turns by
TOLERANCE (1 + d / r); it is kept midway between both frames.

A normal along the way between two nearest points turns by TOLERANCE d / gap. It is kept midway
too, for pairs that are FAR TOLERANCE d apart and cannot meet in this tick, half of the gap being
left: their rows do not act. Nearer pairs of this kind are detected anew.

What is kept decides bits, so it is part of the state: it goes from tick to tick in the impulse
cache (`solver.cache_record`), in the order of the pairs.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose, swept_aabbs
from rigid_body_sim.physics.contact.collision.bounds_record import smaller_radius
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CYLINDER,
    HULL,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import NONE as NO_SIDE
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import loaded_side
from rigid_body_sim.physics.contact.collision.geometry.manifold import write_normal, write_point
from rigid_body_sim.physics.contact.collision.recycled_record import (
    DIRECTION_A,
    DIRECTION_B,
    FACE_AREA,
    FACE_RADIUS,
    FACE_SQUARE,
    FEATURE,
    MARGIN,
    MIDDLE_ON_A,
    MIDDLE_ON_B,
    NORMAL_OWNER,
    ON_A,
    ON_B,
    POINT,
    POINT_COUNT,
    POINTS,
    ROTATION,
    SEPARATION,
    SIZE,
    TURNED,
    size_in_use,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOLERANCE = 1e-4  # [-]; 1e-3 answers a tenth more pairs of a pile at rest, at ten times the error
# [rad] by which a pair may turn of which two points bear all: what has a corner beyond tips by
# more in two ticks, what settles over joints by less
TIPS = 2e-5
FAR = 20.0  # [-] so the normal is within 3 degrees of the way
REACH = 3.0  # [-] of TOLERANCE d: how much nearer a point may be than is known
# types of pairs whose kernels say whose the normal is
RECYCLED_KINDS = frozenset(
    {(BOX, CYLINDER), (BOX, HULL), (CYLINDER, CYLINDER), (CYLINDER, HULL), (HULL, HULL)}
)
NONE = -1  # in place of a record
ROW = 3  # numbers of a row of ROTATION

frames = Record(begin=manifold.SCRATCH)
POSE_A = frames.numbers(pose.SIZE, '-', 'pose of A, turned with the normal if it is the one')
POSE_B = frames.numbers(pose.SIZE, '-', 'the same of B')


class Recycling(NamedTuple):
    """
    What is known of pairs from the last tick, and from their last full detections.

    kept    : the impulse cache of the last tick
    places  : where the record of each pair begins in it, or NONE
    records : of the tick under way, one behind the other; empty where the scene has no such pair
    held    : which points they had, see `held_features`; empty where none depends on them
    """

    kept: Array
    places: Indices
    records: Array
    held: Array


@inline
def unit(v: Any) -> Any:
    """Return v / |v|."""
    return scale(1.0 / math.sqrt(dot(v, v)), v)


@inline
def _copy_poses(poses: Array, pose_a: int, pose_b: int, found: Array) -> None:
    """Copy the poses of a pair to POSE_A and POSE_B."""
    for entry in range(pose.SIZE):
        found[POSE_A + entry] = poses[pose_a + entry]
        found[POSE_B + entry] = poses[pose_b + entry]


@inline
def _turn(place: int, direction: Any, found: Array) -> None:
    """Turn the frame of a cylinder about its axis until its x axis looks along a direction."""
    axis = pose.axis(found, place, 2)
    across = unit(add_scaled(direction, -dot(direction, axis), axis))
    stride = pose.ROW_Y - pose.ROW_X
    store_strided(found, place + pose.ROW_X, stride, across)
    store_strided(found, place + pose.ROW_X + 1, stride, cross(axis, across))


@kernel
def _turn_both(found: Array) -> None:
    """Turn the frames of two cylinders to each other's axis."""
    axis_a, axis_b = pose.axis(found, POSE_A, 2), pose.axis(found, POSE_B, 2)
    _turn(POSE_A, axis_b, found)
    _turn(POSE_B, axis_a, found)


@inline
def _normal(record: int, kept: Array, found: Array) -> Any:
    """Return the normal of a record as the bodies stand now."""
    owner = kept[record + NORMAL_OWNER]
    if owner == manifold.FACE_OF_A:
        return pose.to_world(found, POSE_A, load(kept, record + DIRECTION_A))
    along_b = pose.to_world(found, POSE_B, load(kept, record + DIRECTION_B))
    if owner == manifold.FACE_OF_B:
        return along_b
    along_a = pose.to_world(found, POSE_A, load(kept, record + DIRECTION_A))
    if owner == manifold.OF_EDGES:
        return unit(cross(along_a, along_b))
    return unit(add(along_a, along_b))


@kernel
def recall_pair(
    index: int, a: int, b: int, margin: float, colliders: ColliderArrays, recycling: Recycling,
    found: Array,
) -> Any:  # fmt: skip
    """
    Write the manifold of the pair of an index from its record, as the bodies stand now; return
    where that begins, and the number of points; NONE, 0: there is none, they have moved too far,
    or other points may be needed. What it has held is told.
    """
    record = recycling.places[index] if len(recycling.records) > 0 else NONE
    if record == NONE:
        return NONE, 0
    kept = recycling.kept
    swept = colliders.swept_aabbs
    rest = min(
        swept[a * swept_aabbs.SIZE + swept_aabbs.MARGIN],
        swept[b * swept_aabbs.SIZE + swept_aabbs.MARGIN],
    )
    near = TOLERANCE * 2.0 * smaller_radius(colliders.local_bounds, a, b)
    motion = margin - rest
    if not motion + REACH * near <= kept[record + MARGIN]:
        return NONE, 0
    least = -math.inf
    if kept[record + NORMAL_OWNER] == manifold.OF_NEAREST:
        least = max(FAR * near, 2.0 * motion)
    pose_a, pose_b = a * pose.SIZE, b * pose.SIZE
    _copy_poses(colliders.poses, pose_a, pose_b, found)
    turned = kept[record + TURNED]
    if turned == manifold.BOTH:
        _turn_both(found)
    normal = _normal(record, kept, found)
    if turned == manifold.SHAPE_A:
        _turn(POSE_A, normal, found)
    elif turned == manifold.SHAPE_B:
        _turn(POSE_B, normal, found)
    angle = TOLERANCE
    if kept[record + FACE_AREA] > 0.0 and loaded_side(found)[0] != NO_SIDE:
        angle = TIPS
    return record, _recall(record, normal, near, angle, least, margin, kept, found)


@kernel
def _recall(
    record: int, normal: Any, near: float, angle: float, least: float, most: float, kept: Array,
    found: Array,
) -> int:  # fmt: skip
    """
    Do that from the frames of the pair.

        near        : [m] how far points may have moved
        angle       : [rad] by which the two may have turned
        least, most : [m] between which the least gap must be
    """
    squares = 0.0
    for i in range(3):
        turned = pose.to_shape(found, POSE_B, pose.axis(found, POSE_A, i))
        change = subtract(turned, load(kept, record + ROTATION + ROW * i))
        squares += dot(change, change)
    if not squares <= 2.0 * angle * angle:
        return 0
    origin = load(found, POSE_A + pose.POSITION)
    apart = subtract(load(found, POSE_B + pose.POSITION), origin)
    smallest = math.inf
    count = int(kept[record + POINT_COUNT])
    for index in range(count):
        place = record + POINTS + POINT * index
        on_a = pose.to_world(found, POSE_A, load(kept, place + ON_A))
        on_b = pose.to_world(found, POSE_B, load(kept, place + ON_B))
        way = add(apart, subtract(on_b, on_a))
        moved = add_scaled(way, -kept[place + SEPARATION], normal)
        if not dot(moved, moved) <= near * near:
            return 0
        gap = dot(normal, way)
        smallest = min(smallest, gap)
        position = add(origin, add_scaled(on_a, 0.5, way))
        write_point(found, index, position, gap, kept[place + FEATURE])
    if not least <= smallest <= most:
        return 0
    write_normal(found, normal)
    found[manifold.FACE_AREA] = kept[record + FACE_AREA]
    if found[manifold.FACE_AREA] > 0.0:
        found[manifold.FACE_RADIUS] = kept[record + FACE_RADIUS]
        found[manifold.FACE_SQUARE] = kept[record + FACE_SQUARE]
        on_a = pose.to_world(found, POSE_A, load(kept, record + MIDDLE_ON_A))
        on_b = pose.to_world(found, POSE_B, load(kept, record + MIDDLE_ON_B))
        middle = add(origin, scale(0.5, add(on_a, add(apart, on_b))))
        store(found, manifold.FACE_MIDDLE, middle)
    return count


@kernel
def keep_pair(
    number: int, known: int, a: int, b: int, count: int, margin: float,
    colliders: ColliderArrays, recycling: Recycling, found: Array,
) -> float:  # fmt: skip
    """
    Write the record of a pair whose manifold of some points has been found; return where it
    begins, or NONE.

        number : of the manifold
        known  : the record from which it was recalled, or NONE
    """
    record = number * SIZE
    if known != NONE:
        for entry in range(size_in_use(known, recycling.kept)):
            recycling.records[record + entry] = recycling.kept[known + entry]
        return float(record)
    if found[manifold.NORMAL_OWNER] == manifold.NOBODYS:
        return float(NONE)
    normal, turned = load(found, manifold.NORMAL), found[manifold.TURNED]
    _copy_poses(colliders.poses, a * pose.SIZE, b * pose.SIZE, found)
    if turned == manifold.BOTH:
        _turn_both(found)
    elif turned == manifold.SHAPE_A:
        _turn(POSE_A, normal, found)
    elif turned == manifold.SHAPE_B:
        _turn(POSE_B, normal, found)
    _keep(record, min(count, manifold.MOST), margin, found, recycling.records)
    return float(record)


@kernel
def _keep(record: int, count: int, margin: float, found: Array, records: Array) -> None:
    """Write the record of what a pair kernel has found, in the frames of the pair."""
    owner = found[manifold.NORMAL_OWNER]
    records[record + NORMAL_OWNER] = owner
    records[record + TURNED] = found[manifold.TURNED]
    records[record + POINT_COUNT] = float(count)
    records[record + MARGIN] = margin
    for i in range(3):
        turned = pose.to_shape(found, POSE_B, pose.axis(found, POSE_A, i))
        store(records, record + ROTATION + ROW * i, turned)
    for entry in range(FACE_AREA, POINTS):
        records[record + entry] = 0.0  # what is not known is the same in all runs
    normal = load(found, manifold.NORMAL)
    along_a = pose.to_shape(found, POSE_A, normal)
    along_b = pose.to_shape(found, POSE_B, normal)
    if owner == manifold.OF_EDGES:
        along_a = load(found, manifold.EDGE_A)
        edge_b = pose.to_world(found, POSE_A, load(found, manifold.EDGE_B))
        along_b = pose.to_shape(found, POSE_B, edge_b)
    store(records, record + DIRECTION_A, along_a)
    store(records, record + DIRECTION_B, along_b)
    origin_a = load(found, POSE_A + pose.POSITION)
    origin_b = load(found, POSE_B + pose.POSITION)
    for index in range(count):
        place = record + POINTS + POINT * index
        source = manifold.POINTS + manifold.POINT * index
        gap = found[source + manifold.SEPARATION]
        point = load(found, source + manifold.POSITION)
        on_a = subtract(add_scaled(point, -0.5 * gap, normal), origin_a)
        on_b = subtract(add_scaled(point, 0.5 * gap, normal), origin_b)
        store(records, place + ON_A, pose.to_shape(found, POSE_A, on_a))
        store(records, place + ON_B, pose.to_shape(found, POSE_B, on_b))
        records[place + SEPARATION] = gap
        records[place + FEATURE] = found[source + manifold.FEATURE]
    records[record + FACE_AREA] = found[manifold.FACE_AREA]
    if found[manifold.FACE_AREA] > 0.0:
        records[record + FACE_RADIUS] = found[manifold.FACE_RADIUS]
        records[record + FACE_SQUARE] = found[manifold.FACE_SQUARE]
        middle = load(found, manifold.FACE_MIDDLE)
        on_a, on_b = subtract(middle, origin_a), subtract(middle, origin_b)
        store(records, record + MIDDLE_ON_A, pose.to_shape(found, POSE_A, on_a))
        store(records, record + MIDDLE_ON_B, pose.to_shape(found, POSE_B, on_b))
