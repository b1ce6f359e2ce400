# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the points of a manifold carry that are not among those of the next tick.

Four points stand for a face of many corners, and which four is chosen anew in each tick: one that
carries may be another corner while a pile trembles by micrometres. Its impulse goes to the points
that are near now, with force and torque kept. With their places d_i from their middle c, in the
plane of the contact, and p that of the lost point from c,

    J_i <- J_i + w_i J,   w_i = 1/k + d_i . M^+ p,   M = sum d_i d_i^T

sum w_i = 1 and sum w_i d_i = p, as far as the points span the plane: the least change in the sense
of squares, a pressure that is linear over the face. Friction likewise. No w_i is more than MOST
beyond 1/k; points that would pull carry nothing, and the others as much more as all of them did.
Without this a pile of hulls never comes to rest: each tick some contact loses its load.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import manifold_record, pose
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.contact_point import ONE_POINT
from rigid_body_sim.physics.vectors import add, dot, load, scale, subtract

STILL_CARRIES = 1e-3  # [-] of the radius: what is no farther apart may carry
ASIDE = (
    0.2  # [-] of the radius: a point so far from the plane of the others was of another contact
)
MOST = 1.0  # [-] of w_i - 1/k
LINE = 1e-6  # [-] of its square: determinant of M of what is a line


class Carriers(NamedTuple):
    """
    The points of a manifold that may carry what others have lost.

    which            : a bit for each
    number           : k
    middle           : c, world axes [m]
    m_11, m_12, m_22 : M along the tangents [m^2]
    """

    which: int
    number: float
    middle: Any
    m_11: float
    m_12: float
    m_22: float


@inline
def _in_frame(way: Any, lane: int, rows: Array) -> Any:
    """Return a vector of the world along the two tangents and the normal."""
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    return dot(way, tangent_1), dot(way, tangent_2), dot(way, normal)


@kernel
def _find_carriers(
    record: int, lane: int, width: int, radius: float, manifolds: Array, rows: Array
) -> Carriers:
    """Find who may carry: what is pressed already, or near."""
    begin = record + manifold_record.POINTS
    first, middle = load(manifolds, begin), (0.0, 0.0, 0.0)
    which, count, m_11, m_12, m_22 = 0, 0.0, 0.0, 0.0, 0.0
    for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        found = begin + point * manifold.POINT
        row = lane + constraint.SIZE + point * width
        if (
            rows[row + contact_point.NORMAL_IMPULSE] > 0.0
            or manifolds[found + manifold.SEPARATION] <= STILL_CARRIES * radius
        ):
            way = subtract(load(manifolds, found), first)
            one, other, _ = _in_frame(way, lane, rows)
            which |= 1 << point
            count += 1.0
            middle = add(middle, way)
            m_11, m_12, m_22 = m_11 + one * one, m_12 + one * other, m_22 + other * other
    middle = scale(1.0 / max(count, 1.0), middle)
    one, other, _ = _in_frame(middle, lane, rows)
    m_11, m_12 = m_11 - count * one * one, m_12 - count * one * other
    return Carriers(which, count, add(first, middle), m_11, m_12, m_22 - count * other * other)


@inline
def _slope(one: float, other: float, carriers: Carriers) -> Any:
    """Return M^+ p [1/m]."""
    trace = carriers.m_11 + carriers.m_22
    determinant = carriers.m_11 * carriers.m_22 - carriers.m_12 * carriers.m_12
    if not trace > ONE_POINT:
        return 0.0, 0.0
    if determinant > LINE * trace * trace:
        along_1 = carriers.m_22 * one - carriers.m_12 * other
        along_2 = carriers.m_11 * other - carriers.m_12 * one
        return along_1 / determinant, along_2 / determinant
    along_1 = carriers.m_11 * one + carriers.m_12 * other
    along_2 = carriers.m_12 * one + carriers.m_22 * other
    return along_1 / (trace * trace), along_2 / (trace * trace)


@inline
def _beyond(
    point: int, slope: Any, carriers: Carriers, record: int, lane: int, manifolds: Array,
    rows: Array,
) -> Any:  # fmt: skip
    """Return w_i - 1/k."""
    found = record + manifold_record.POINTS + point * manifold.POINT
    way = subtract(load(manifolds, found), carriers.middle)
    one, other, _ = _in_frame(way, lane, rows)
    return slope[0] * one + slope[1] * other


@kernel
def _share_out(
    impulse: float, friction: Any, slope: Any, carriers: Carriers, record: int, lane: int,
    width: int, manifolds: Array, rows: Array,
) -> None:  # fmt: skip
    """Give an impulse along the normal and its friction, world axes, to those who may carry."""
    along_1, along_2, _ = _in_frame(friction, lane, rows)
    points = int(manifolds[record + manifold_record.POINT_COUNT])
    most = MOST
    for point in range(points):
        if (carriers.which >> point) & 1:
            most = max(most, abs(_beyond(point, slope, carriers, record, lane, manifolds, rows)))
    for point in range(points):
        if not (carriers.which >> point) & 1:
            continue
        row = lane + constraint.SIZE + point * width
        beyond = _beyond(point, slope, carriers, record, lane, manifolds, rows)
        weight = 1.0 / carriers.number + MOST / most * beyond
        rows[row + contact_point.NORMAL_IMPULSE] += weight * impulse
        rows[row + contact_point.TANGENT_IMPULSE_1] += weight * along_1
        rows[row + contact_point.TANGENT_IMPULSE_2] += weight * along_2


@kernel
def _press_only(points: int, lane: int, width: int, rows: Array) -> None:
    """Let points that would pull carry nothing, and the others as much as all did."""
    total, presses = 0.0, 0.0
    for point in range(points):
        row = lane + constraint.SIZE + point * width
        total += rows[row + contact_point.NORMAL_IMPULSE]
        presses += max(rows[row + contact_point.NORMAL_IMPULSE], 0.0)
    share = max(total, 0.0) / presses if presses > 0.0 else 0.0
    for point in range(points if presses > total else 0):
        row = lane + constraint.SIZE + point * width
        impulse = rows[row + contact_point.NORMAL_IMPULSE]
        rows[row + contact_point.NORMAL_IMPULSE] = share * max(impulse, 0.0)


@kernel
def pass_on(
    taken: int, old: int, record: int, width: int, factor: float, radius: float, poses: Array,
    manifolds: Array, cache: Array, rows: Array,
) -> None:  # fmt: skip
    """
    Let the points of a manifold that may carry it have what those of the cache held that are not
    among them.

        taken  : a bit for each point of the cache that is one of the manifold
        old    : where the manifold begins in the cache
        record : where it begins now
        width  : numbers of a point
        factor : [-] substep over that of the cache
        radius : [m] of the smaller of the two colliders
    """
    lane = int(manifolds[record + manifold_record.LANE])
    shape = int(manifolds[record + manifold_record.COLLIDER_A]) * pose.SIZE
    carriers = _find_carriers(record, lane, width, radius, manifolds, rows)
    if carriers.which == 0:
        return
    origin = subtract(load(poses, shape + pose.POSITION), carriers.middle)
    for point in range(int(cache[old + cache_record.POINTS])):
        place = old + cache_record.MANIFOLD_HEAD + point * cache_record.POINT_SIZE
        impulse = factor * cache[place + cache_record.NORMAL_IMPULSE]
        if (taken >> point) & 1 or not impulse > 0.0:
            continue
        anchor = load(cache, place + cache_record.ANCHOR)
        one, other, away = _in_frame(add(origin, pose.to_world(poses, shape, anchor)), lane, rows)
        if abs(away) > ASIDE * radius:
            continue
        friction = scale(factor, load(cache, place + cache_record.FRICTION_IMPULSE))
        _share_out(
            impulse, friction, _slope(one, other, carriers), carriers, record, lane, width,
            manifolds, rows,
        )  # fmt: skip
    _press_only(int(manifolds[record + manifold_record.POINT_COUNT]), lane, width, rows)
