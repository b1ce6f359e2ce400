# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a surface carries beside the impulses that are recalled: where something is put down, by what
pulls at its centre of mass; of lines that roll, as the body has felt them in the last tick, also
those that it has left since.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record, pose
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    impulse_cache,
    pressure_of_face,
)
from rigid_body_sim.physics.contact.solver.surface_members import owner_of
from rigid_body_sim.physics.vectors import add, cross, dot, load, scale, subtract

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FLUSH_DISTANCE = 1e-5  # [m] from a surface: what a body has lost there was a part of it


@kernel
def first_load(
    record: int, h: float, frame: Any, table: Indices, manifolds: Array, bodies: Array
) -> Any:  # fmt: skip
    """
    Return what a body that is put down on a surface that cannot move presses in a substep, by what
    pulls at its centre of mass: N, N x, N y; none, if it comes down faster than it is pulled.
    """
    body, side = owner_of(record, table, manifolds)
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    if table[other * collider_record.SIZE + collider_record.BODY] >= 0:
        return 0.0, 0.0, 0.0
    row = body * solver_bodies.SIZE
    normal = scale(2.0 * side - 1.0, load(manifolds, record + manifold_record.NORMAL))
    inverse_mass = bodies[row + solver_bodies.INVERSE_MASS]
    pull = -h * dot(normal, load(bodies, row + solver_bodies.FREE_ACCELERATION))
    speed = inverse_mass * dot(normal, load(bodies, row + solver_bodies.MOMENTUM))
    if not (abs(speed) < pull and inverse_mass > solver_bodies.HELD):
        return 0.0, 0.0, 0.0
    way = subtract(load(bodies, row + solver_bodies.START_POSITION), frame[0])
    total = pull / inverse_mass
    return total, total * dot(way, frame[1][0]), total * dot(way, frame[1][1])


@inline
def _with_carried(
    sums: Any, entry: int, factor: float, origin: Any, frame: Any, cache: Array
) -> Any:
    """Add what an entry of the cache has carried; origin: of the shape that moves."""
    total, total_1, total_2 = sums
    way = subtract(add(origin, load(cache, entry + cache_record.MIDDLE)), frame[0])
    own = factor * impulse_cache.load_of(entry, cache)
    return (
        total + own, total_1 + own * dot(way, frame[1][0]), total_2 + own * dot(way, frame[1][1])
    )  # fmt: skip


@kernel
def _with_lost(
    sums: Any, factor: float, record: int, frame: Any, colliders: ColliderArrays, manifolds: Array,
    cache: Array, bodies: Array,
) -> Any:  # fmt: skip
    """
    Add what the body of a manifold has lost of its surface to N, N x, N y: what lies in its plane
    and is of the same other body.
    """
    table = colliders.table
    shapes = len(table) // collider_record.SIZE
    body, side = owner_of(record, table, manifolds)
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    other_body = table[other * collider_record.SIZE + collider_record.BODY]
    normal = cross(frame[1][0], frame[1][1])
    entry = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_LOST])
    while entry >= cache_record.HEAD:
        pair = int(cache[entry + cache_record.PAIR_ID])
        first, second = pair // shapes, pair % shapes
        shape = impulse_cache.moving_shape(first, second, table)
        second = second if shape == first else first
        origin = load(colliders.poses, shape * pose.SIZE + pose.POSITION)
        way = subtract(add(origin, load(cache, entry + cache_record.MIDDLE)), frame[0])
        lies_in_plane = abs(dot(normal, way)) < FLUSH_DISTANCE
        if (
            lies_in_plane
            and table[second * collider_record.SIZE + collider_record.BODY] == other_body
        ):
            sums = _with_carried(sums, entry, factor, origin, frame, cache)
        entry = int(cache[entry + cache_record.NEXT_LOST])
    return sums


@kernel
def left_behind(
    count: int, members: Indices, width: int, h: float, lost: bool, frame: Any,
    colliders: ColliderArrays, constraints: Constraints, bodies: Array,
) -> Any:  # fmt: skip
    """
    Return what a surface carried in the last tick beyond what is recalled of it, seen from the
    body: N, N x, N y; h: substep [s]. Nothing, where it was more than lines.

    lost : whether some body has lost a line: see `impulse_cache.link_lost`
    """
    manifolds, rows, cache = constraints.manifolds, constraints.rows, constraints.impulse_cache
    factor = impulse_cache.share_recalled(h, cache)
    _, side = owner_of(members[0], colliders.table, manifolds)
    sums = 0.0, 0.0, 0.0
    for place in range(count):
        record = members[place]
        entry = constraints.places[record // manifold_record.SIZE]
        if entry != impulse_cache.NEW:
            if cache[entry + cache_record.POINTS] > 2.0:
                return 0.0, 0.0, 0.0
            shape = int(manifolds[record + manifold_record.COLLIDER_A + side])
            origin = load(colliders.poses, shape * pose.SIZE + pose.POSITION)
            sums = _with_carried(sums, entry, factor, origin, frame, cache)
        lane = int(manifolds[record + manifold_record.LANE])
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            impulse = rows[row + contact_point.NORMAL_IMPULSE]
            if impulse > 0.0:
                x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
                sums = sums[0] - impulse, sums[1] - impulse * x, sums[2] - impulse * y
    if not lost:
        return sums
    return _with_lost(sums, factor, members[0], frame, colliders, manifolds, cache, bodies)
