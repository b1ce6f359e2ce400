# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulse cache: accumulated impulses from tick to tick, for the warm start of the next one.

Old and new manifolds are both in the order of their pairs, so that they are matched in one walk.
A point is the same as before if its feature is, else if its anchor lies within a fifth of the
radius.
Impulses are kept as vectors of the world (`cache_record`) and recalled along the new tangents; if
the substep changed they change with it.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    held_features,
    manifold_record,
    pose,
    recycled_record,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.geometry.surfaces import surface_scratch
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    lost_points,
    static_sink,
    surface_chain,
    warm_start,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import add, dot, load, scale, store, subtract

SAME_PLACE = 0.2  # [-] of the radius: an anchor that moved less is the same point
NEW = -1  # in place of a point or an entry of the cache: there is none for this one


@kernel
def holds_same_manifolds(
    manifold_count: int, manifolds: Array, cache: Array, places: Indices
) -> bool:
    """
    Tell whether the manifolds are those of the cache, with as many points; then places become
    what `find_places` would find.
    """
    if cache[cache_record.MANIFOLDS] != float(manifold_count):
        return False
    old = cache_record.HEAD
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        if (
            cache[old + cache_record.PAIR_ID] != manifolds[record + manifold_record.PAIR_ID]
            or cache[old + cache_record.POINTS] != manifolds[record + manifold_record.POINT_COUNT]
        ):
            return False
        places[m] = old
        old = cache_record.next_entry(old, cache)
    return True


@inline
def share_recalled(h: float, cache: Array) -> float:
    """Return the share of an impulse of the cache that acts in a substep h [s]."""
    before = cache[cache_record.SUBSTEP]
    return h / before if before > 0.0 and before != h else 1.0


@inline
def _anchor(point: Any, place: int, poses: Array) -> Any:
    """Return a point in the axes of a shape, R^T (r - x)."""
    return pose.to_shape(poses, place, subtract(point, load(poses, place + pose.POSITION)))


@inline
def _same_feature(feature: float, old_points: int, count: int, taken: int, cache: Array) -> int:
    """Find a feature among the points of the cache that are not taken, or NEW."""
    best = NEW
    for i in range(count):
        place = old_points + i * cache_record.POINT_SIZE
        same = (cache[place + cache_record.FEATURE] == feature) & (not (taken >> i) & 1)
        best = i if same else best
    return best


@kernel
def _nearest(
    point: int, old_points: int, count: int, taken: int, near: float, shape: int, poses: Array,
    manifolds: Array, cache: Array,
) -> int:  # fmt: skip
    """
    Find the nearest point of a manifold of the cache that is not taken, or NEW.

    near : [m^2] of a distance squared: what is farther is another point
    """
    anchor = _anchor(load(manifolds, point), shape, poses)
    best, least = NEW, near
    for i in range(count):
        old_anchor = load(cache, old_points + i * cache_record.POINT_SIZE + cache_record.ANCHOR)
        way = subtract(anchor, old_anchor)
        distance = dot(way, way)
        if not (taken >> i) & 1 and distance < least:
            best, least = i, distance
    return best


@inline
def _walk_to(pair: float, old: int, left: int, cache: Array) -> Any:
    """
    Walk on through the cache as far as a pair, or behind where it would be; return where that
    entry begins, and how many are left from there on.
    """
    while left > 0 and cache[old + cache_record.PAIR_ID] < pair:
        old = cache_record.next_entry(old, cache)
        left -= 1
    return old, left


@kernel
def find_places(manifold_count: int, manifolds: Array, cache: Array, places: Indices) -> None:
    """Find where the pair of each manifold begins in the cache, or NEW."""
    left = int(cache[cache_record.MANIFOLDS])
    old = cache_record.HEAD
    for m in range(manifold_count):
        pair = manifolds[m * manifold_record.SIZE + manifold_record.PAIR_ID]
        old, left = _walk_to(pair, old, left, cache)
        is_known = left > 0 and cache[old + cache_record.PAIR_ID] == pair
        places[m] = old if is_known else NEW


@inline
def moving_shape(collider_a: int, collider_b: int, table: Indices) -> int:
    """Return the collider of a pair that moves; of two the first."""
    moves = table[collider_a * collider_record.SIZE + collider_record.BODY] >= 0
    return collider_a if moves else collider_b


@kernel
def link_lost(
    manifold_count: int, table: Indices, manifolds: Array, cache: Array, bodies: Array
) -> bool:
    """
    Make the list of what each body has lost of the lines on which it rolled: manifolds of two
    points in the cache that are no more. Tell whether there are some.
    """
    colliders = len(table) // collider_record.SIZE
    for m in range(manifold_count):
        record = m * manifold_record.SIZE
        if manifolds[record + manifold_record.POINT_COUNT] == 2.0:
            collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
            collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
            shape = moving_shape(collider_a, collider_b, table)
            body = table[shape * collider_record.SIZE + collider_record.BODY]
            bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_LOST] = float(NEW)
    found, m, old = False, 0, cache_record.HEAD
    for _ in range(int(cache[cache_record.MANIFOLDS])):
        pair = cache[old + cache_record.PAIR_ID]
        while (
            m < manifold_count
            and manifolds[m * manifold_record.SIZE + manifold_record.PAIR_ID] < pair
        ):
            m += 1
        is_lost = (
            m == manifold_count
            or manifolds[m * manifold_record.SIZE + manifold_record.PAIR_ID] > pair
        )
        if is_lost and cache[old + cache_record.POINTS] == 2.0:
            shape = moving_shape(int(pair) // colliders, int(pair) % colliders, table)
            body = table[shape * collider_record.SIZE + collider_record.BODY]
            if body >= 0:  # what sleeps, and is none in the table, has a cache of its own
                head = body * solver_bodies.SIZE + solver_bodies.FIRST_LOST
                cache[old + cache_record.NEXT_LOST] = bodies[head]
                bodies[head] = float(old)
                found = True
        old = cache_record.next_entry(old, cache)
    return found


@inline
def load_of(entry: int, cache: Array) -> float:
    """Return what a manifold of the cache has carried [N s]."""
    total = 0.0
    for point in range(int(cache[entry + cache_record.POINTS])):
        place = entry + cache_record.MANIFOLD_HEAD + point * cache_record.POINT_SIZE
        total += cache[place + cache_record.NORMAL_IMPULSE]
    return total


@kernel
def begin_cache(
    manifold_count: int, h: float, manifolds: Array, records: Array, places: Indices, cache: Array
) -> None:
    """Begin the cache of a tick: find where each manifold goes in it; h: substep [s]."""
    cache[cache_record.SUBSTEP] = h
    cache[cache_record.MANIFOLDS] = float(manifold_count)
    to = cache_record.HEAD
    for m in range(manifold_count):
        places[m] = to
        points = int(manifolds[m * manifold_record.SIZE + manifold_record.POINT_COUNT])
        to += cache_record.MANIFOLD_HEAD + points * cache_record.POINT_SIZE
        recycled = int(manifolds[m * manifold_record.SIZE + manifold_record.RECYCLED])
        if recycled >= 0:
            to += recycled_record.size_in_use(recycled, records)


@kernel
def find_recycled(pairs: int, pair_ids: Indices, cache: Array, places: Indices) -> None:
    """Find where in the cache the record of each pair is, or NEW: see `collision.recycling`."""
    left = int(cache[cache_record.MANIFOLDS])
    old = cache_record.HEAD
    for index in range(pairs):
        pair = float(pair_ids[index])
        old, left = _walk_to(pair, old, left, cache)
        places[index] = NEW
        if (
            left > 0
            and cache[old + cache_record.PAIR_ID] == pair
            and cache[old + cache_record.RECYCLED] > 0.0
        ):
            places[index] = cache_record.behind_points(old, cache)


@inline
def _most_loaded(pair: float, old: int, left: int, cache: Array) -> int:
    """
    Return which manifold of a pair in the cache bore most, or NEW; old : where the first one is
    that is of this pair or a later one;   left : how many there are from there on
    """
    found, most = NEW, -1.0
    for _ in range(left):
        if not cache[old + cache_record.PAIR_ID] < pair + 1.0:
            break
        load = load_of(old, cache)
        if load > most:
            found, most = old, load
        old = cache_record.next_entry(old, cache)
    return found


@kernel
def find_held(pairs: int, pair_ids: Indices, cache: Array, held: Array) -> None:
    """
    Find the features of the points that each pair had in the last tick, and their impulses, of
    several manifolds those of the one that bore most; held: see `collision.held_features`.
    """
    left = int(cache[cache_record.MANIFOLDS])
    old = cache_record.HEAD
    for index in range(pairs):
        pair = float(pair_ids[index])
        old, left = _walk_to(pair, old, left, cache)
        row = index * held_features.SIZE
        count, entry = 0, _most_loaded(pair, old, left, cache)
        if entry != NEW:
            count = int(cache[entry + cache_record.POINTS])
            held[row + held_features.KEY] = surface_scratch.key_of_pair_id(
                cache[entry + cache_record.PAIR_ID]
            )
        held[row + held_features.COUNT] = float(count)
        for point in range(count):
            place = entry + cache_record.MANIFOLD_HEAD + point * cache_record.POINT_SIZE
            held[row + held_features.FEATURES + point] = cache[place + cache_record.FEATURE]
            pressed = cache[place + cache_record.NORMAL_IMPULSE]
            held[row + held_features.IMPULSES + point] = pressed


@kernel
def recall(
    width: int, h: float, angular: bool, bounds: Array, poses: Array, order: Indices,
    places: Indices, manifolds: Array, cache: Array, rows: Array,
) -> None:  # fmt: skip
    """
    Match the points of a group with those of the cache and give them their accumulated impulses,
    those of the last substep, along the new normals and tangents.

        width   : numbers of a point
        h       : [s] substep
        angular : whether anything rolls or twists with friction
        order   : manifolds of the group, as they lie in the rows
        places  : of all manifolds in the cache: see `find_places`
    """
    factor = share_recalled(h, cache)
    for index in range(len(order)):
        m = order[index]
        record = m * manifold_record.SIZE
        lane = int(manifolds[record + manifold_record.LANE])
        old = places[m]
        is_known = old != NEW
        count = int(cache[old + cache_record.POINTS]) if is_known else 0
        old_points = old + cache_record.MANIFOLD_HEAD
        a = int(manifolds[record + manifold_record.COLLIDER_A])
        b = int(manifolds[record + manifold_record.COLLIDER_B])
        radius = bounds_record.smaller_radius(bounds, a, b)
        load = cache[old + cache_record.LOAD] if is_known else 0.0
        static_sink.recall(lane, h, radius, load, rows)
        near = SAME_PLACE * SAME_PLACE * radius * radius
        taken = 0
        for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            found = record + manifold_record.POINTS + point * manifold.POINT
            row = lane + constraint.SIZE + point * width
            feature = manifolds[found + manifold.FEATURE]
            same = _same_feature(feature, old_points, count, taken, cache)
            if same == NEW and count > 0:
                same = _nearest(
                    found, old_points, count, taken, near, a * pose.SIZE, poses, manifolds,
                    cache,
                )  # fmt: skip
            place = NEW
            if same != NEW:
                taken |= 1 << same
                place = old_points + same * cache_record.POINT_SIZE
            _recall_point(lane, row, place, factor, cache, rows)
            if angular:
                _recall_angular(row, place, factor, cache, rows)
        is_round = rows[lane + constraint.ROUNDNESS] != constraint.NOT_ROUND
        if taken + 1 < 1 << count and not is_round:
            lost_points.pass_on(
                taken, old, record, width, factor, radius, poses, manifolds, cache, rows
            )


@inline
def _recall_point(
    lane: int, row: int, place: int, factor: float, cache: Array, rows: Array
) -> None:
    """Give a point the impulses of a place of the cache; NEW: none."""
    normal_impulse, friction, share = 0.0, (0.0, 0.0, 0.0), 1.0
    if place != NEW:
        share = cache[place + cache_record.SINK_SHARE]
        normal_impulse = factor * cache[place + cache_record.NORMAL_IMPULSE]
        friction = scale(factor, load(cache, place + cache_record.FRICTION_IMPULSE))
    tangent_1 = wide_lanes.vector(rows, lane + constraint.TANGENT_1)
    tangent_2 = wide_lanes.vector(rows, lane + constraint.TANGENT_2)
    rows[row + contact_point.SINK_SHARE] = share
    rows[row + contact_point.NORMAL_IMPULSE] = normal_impulse
    rows[row + contact_point.TANGENT_IMPULSE_1] = dot(tangent_1, friction)
    rows[row + contact_point.TANGENT_IMPULSE_2] = dot(tangent_2, friction)


@inline
def _recall_angular(row: int, place: int, factor: float, cache: Array, rows: Array) -> None:
    """Give a point the angular impulse of a place of the cache; NEW: none."""
    impulse = (0.0, 0.0, 0.0)
    if place != NEW:
        impulse = scale(factor, load(cache, place + cache_record.ANGULAR_IMPULSE))
    wide_lanes.put_vector(rows, row + contact_point.RECALLED_ANGULAR_IMPULSE, impulse)


@inline
def _stored_share(lane: int, row: int, rows: Array) -> Any:
    """
    Share of the impulses of a point from which the next tick starts: its load. A point that
    bounced leaves: its friction would pull the body back for a substep.
    """
    bounced = (
        rows[lane + constraint.RESTITUTION] > 0.0
        and rows[row + contact_point.APPROACH_VELOCITY] < 0.0
    )
    return 0.0 if bounced else warm_start.lasting_share(lane, row, rows, rows)


@inline
def _share_that_goes_on(lane: int, count: int, width: int, rows: Array) -> Any:
    """Share of their change with which the loads of a manifold go on: see `warm_start`."""
    of_none = rows[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE
    share = warm_start.GOES_ON if of_none else 0.0
    first = lane + constraint.SIZE
    for row in range(first, first + count * width, width):
        lasts = _stored_share(lane, row, rows) * rows[row + contact_point.NORMAL_IMPULSE]
        share = warm_start.share_that_goes_on(row, lasts, share, rows)
    return share


@inline
def _load_of_point(lane: int, row: int, h: float, rows: Array) -> Any:
    """Load of a point over the mass of its spring [m/s^2]; h: substep [s]."""
    lasts = _stored_share(lane, row, rows) * rows[row + contact_point.NORMAL_IMPULSE]
    return static_sink.load_of_point(lane, row, lasts, h, rows)


@inline
def _lasting_impulse(lane: int, count: int, width: int, rows: Array) -> float:
    """Return the impulse of the points of a manifold that is their load."""
    total = 0.0
    first = lane + constraint.SIZE
    for row in range(first, first + count * width, width):
        stored = _stored_share(lane, row, rows) * rows[row + contact_point.NORMAL_IMPULSE]
        total += static_sink.lasting_impulse(row, stored, rows)
    return total


@kernel
def _note_loads_of_springs(width: int, order: Indices, manifolds: Array, rows: Array) -> None:
    """
    Note of each manifold, or surface of several, that has one spring which share of its impulses
    lasts, and what is the load of the others.
    """
    for index in range(len(order)):
        first = int(manifolds[order[index] * manifold_record.SIZE + manifold_record.LANE])
        of_another = rows[first + constraint.SURFACE] == constraint.OF_SURFACE
        if of_another or not rows[first + constraint.SPRING_MASS] > 0.0:
            continue
        surface_chain.note_lasting_share(first, width, rows)
        total = 0.0
        lane = first
        while lane > 0:
            own = _lasting_impulse(lane, int(rows[lane + constraint.SURFACE_POINTS]), width, rows)
            rows[lane + constraint.OTHERS_IMPULSE] = own
            total += own
            lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
        lane = first
        while lane > 0:
            rows[lane + constraint.OTHERS_IMPULSE] = total - rows[lane + constraint.OTHERS_IMPULSE]
            lane = int(rows[lane + constraint.NEXT_OF_SURFACE])


@inline
def _mean_load(lane: int, count: int, width: int, h: float, rows: Array) -> Any:
    """Mean load of the points of a manifold that bear, over their masses [m/s^2]."""
    largest, total, bearing = 0.0, 0.0, 0.0
    first = lane + constraint.SIZE
    spring = rows[lane + constraint.SPRING_MASS]
    if spring > 0.0:
        own = _lasting_impulse(lane, count, width, rows)
        return (own + rows[lane + constraint.OTHERS_IMPULSE]) / (h * spring)
    for row in range(first, first + count * width, width):
        largest = max(largest, _load_of_point(lane, row, h, rows))
    for row in range(first, first + count * width, width):
        of_point = _load_of_point(lane, row, h, rows)
        total += of_point
        bearing += static_sink.share_that_bears(of_point, largest)
    return total / bearing if bearing > 0.0 else 0.0


@kernel
def _middle_of_pressure(
    record: int, entry: int, table: Indices, poses: Array, manifolds: Array, cache: Array
) -> Any:
    """Return the middle of what a manifold leaves, which is in its entry of the cache already."""
    collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    shape = moving_shape(collider_a, collider_b, table)
    origin = load(poses, shape * pose.SIZE + pose.POSITION)
    total, moment = 0.0, (0.0, 0.0, 0.0)
    for point in range(int(cache[entry + cache_record.POINTS])):
        place = entry + cache_record.MANIFOLD_HEAD + point * cache_record.POINT_SIZE
        impulse = cache[place + cache_record.NORMAL_IMPULSE]
        found = record + manifold_record.POINTS + point * manifold.POINT
        total += impulse
        moment = add(moment, scale(impulse, subtract(load(manifolds, found), origin)))
    return scale(1.0 / total, moment) if total > 0.0 else moment


@kernel
def store_impulses(
    width: int, h: float, angular: bool, colliders: ColliderArrays, order: Indices,
    places: Indices, manifolds: Array, rows: Array, records: Array, cache: Array,
) -> None:  # fmt: skip
    """
    Write what the next tick starts from of a group, whose manifolds `order` names; colliders are
    where they are at the start of this one, records those of `collision.recycling`.
    """
    poses = colliders.poses
    _note_loads_of_springs(width, order, manifolds, rows)
    for index in range(len(order)):
        m = order[index]
        to = places[m]
        record = m * manifold_record.SIZE
        count = int(manifolds[record + manifold_record.POINT_COUNT])
        cache[to + cache_record.PAIR_ID] = manifolds[record + manifold_record.PAIR_ID]
        cache[to + cache_record.POINTS] = float(count)
        head = to
        to += cache_record.MANIFOLD_HEAD
        lane = int(manifolds[record + manifold_record.LANE])
        shape = int(manifolds[record + manifold_record.COLLIDER_A]) * pose.SIZE
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
        goes_on = _share_that_goes_on(lane, count, width, rows)
        load_of_all = _mean_load(lane, count, width, h, rows)
        for point in range(count):
            found = record + manifold_record.POINTS + point * manifold.POINT
            row = lane + constraint.SIZE + point * width
            share = _stored_share(lane, row, rows)
            cache[to + cache_record.FEATURE] = manifolds[found + manifold.FEATURE]
            cache[to + cache_record.SINK_SHARE] = static_sink.share_that_stays(
                rows[row + contact_point.SINK_SHARE], _load_of_point(lane, row, h, rows),
                load_of_all,
            )  # fmt: skip
            cache[to + cache_record.NORMAL_IMPULSE] = warm_start.foreseen(
                row, share * rows[row + contact_point.NORMAL_IMPULSE], goes_on, rows
            )
            friction = angular_impulse = (0.0, 0.0, 0.0)
            pressed = rows[row + contact_point.TOTAL_IMPULSE]
            if pressed + rows[row + contact_point.NORMAL_IMPULSE] > 0.0:  # else nothing rubs
                friction = add(
                    scale(share * rows[row + contact_point.TANGENT_IMPULSE_1], tangent_1),
                    scale(share * rows[row + contact_point.TANGENT_IMPULSE_2], tangent_2),
                )
                if angular:
                    angular_impulse = wide_lanes.angular_impulse_of(
                        share * rows[row + contact_point.ROLLING_IMPULSE_1],
                        share * rows[row + contact_point.ROLLING_IMPULSE_2],
                        share * rows[row + contact_point.TWIST_IMPULSE],
                        normal, tangent_1, tangent_2,
                    )  # fmt: skip
            store(cache, to + cache_record.FRICTION_IMPULSE, friction)
            store(cache, to + cache_record.ANGULAR_IMPULSE, angular_impulse)
            store(cache, to + cache_record.ANCHOR, _anchor(load(manifolds, found), shape, poses))
            to += cache_record.POINT_SIZE
        cache[head + cache_record.LOAD] = static_sink.filtered(lane, load_of_all, rows)
        middle = (0.0, 0.0, 0.0)
        if count <= 2:
            middle = _middle_of_pressure(record, head, colliders.table, poses, manifolds, cache)
        store(cache, head + cache_record.MIDDLE, middle)
        cache[head + cache_record.NEXT_LOST] = 0.0
        recycled = int(manifolds[record + manifold_record.RECYCLED])
        cache[head + cache_record.RECYCLED] = 0.0
        if recycled >= 0:
            size = recycled_record.size_in_use(recycled, records)
            cache[head + cache_record.RECYCLED] = float(size)
            for entry in range(size):
                cache[to + entry] = records[recycled + entry]


@kernel
def size_in_use(cache: Array) -> int:
    """Count the numbers of the cache that are in use; 0 where they are no cache."""
    end, size = cache_record.HEAD, len(cache)
    if end > size:
        return 0
    for _ in range(int(cache[cache_record.MANIFOLDS])):
        if end + cache_record.MANIFOLD_HEAD > size:
            return 0
        behind = cache_record.next_entry(end, cache)
        if behind <= end:
            return 0
        end = behind
    return end


@kernel
def keep_cache(cache: Array, kept: Array) -> None:
    """Copy the numbers of the cache that are in use."""
    for place in range(size_in_use(cache)):
        kept[place] = cache[place]
