# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Points that cannot be reached: visits leave them out, and not one bit changes.

A manifold has what lies within the margin of contact, so of a body that leans on an edge the far
corners too. Such a point presses only where it closes its whole separation s in the substep. No
point of a pair approaches faster, along whatever normal, than

    |v_B - v_A| + sum over A and B of |omega| (1 + h |omega| / 2) r,     r : length of its arm

with its arc (`bends`): a chord is no longer than its arc. While h times that is less than s, a
visit would find no impulse and leave none. So a batch has

    NEAR_COUNT : points of each manifold that are visited; those behind are farther than FAR in
                 each lane when the tick starts, and nothing presses there

and what lies behind is asked after as a whole, by the least separation and the longest arms: first
when a batch is visited, and again after its near points have been, where it would be its turn.
Where the answer is no, all points are visited from then on, until the tick is over.

For that, the points of each manifold stand in this order, near ones first, and manifolds of a
colour share batches with those that have as many near points (`colouring`). Rims of cylinders that
roll keep all of theirs: they turn with their lowest points, which go round faster.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    friction_patch,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.softness import DEEP
from rigid_body_sim.physics.vectors import dot

# [-] of the radius of the smaller body: a separation from which a point is far. It decides how
# much is left out and nothing else: of a pile at rest, half or five times as much, by a tenth
FAR = 2e-3
NOWHERE = 1e9  # [m] separation of a point that a manifold does not have: it never presses
NONE = 0.5 * NOWHERE  # [m] what is no separation, also less a sink
SURELY = 1.0 + 1e-6  # times the largest approach, so that no rounding reaches a point


@inline
def count_near(record: int, radius: float, manifolds: Array) -> int:
    """Count the near points of the manifold of a record; radius: of the smaller body [m]."""
    near = 0
    first = record + manifold_record.POINTS + manifold.SEPARATION
    for point in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        near += 1 if manifolds[first + point * manifold.POINT] <= FAR * radius else 0
    return near


@inline
def put_behind(record: int, radius: float, manifolds: Array) -> None:
    """Put the far points of a manifold behind its near ones, each as they stood."""
    points = int(manifolds[record + manifold_record.POINT_COUNT])
    near = count_near(record, radius, manifolds)
    if near == 0 or near == points:
        return
    first = record + manifold_record.POINTS
    for _ in range(points - 1):
        for place in range(first, first + (points - 1) * manifold.POINT, manifold.POINT):
            behind = place + manifold.POINT
            if (
                manifolds[place + manifold.SEPARATION] > FAR * radius
                and manifolds[behind + manifold.SEPARATION] <= FAR * radius
            ):
                for number in range(manifold.POINT):
                    kept = manifolds[place + number]
                    manifolds[place + number] = manifolds[behind + number]
                    manifolds[behind + number] = kept


@inline
def _is_far(lane: int, angular: bool, constraints: Array, points: Array) -> bool:
    """Tell whether a point of a lane is far, and nothing presses there."""
    if not (
        points[lane + contact_point.SEPARATION] > FAR / DEEP * constraints[lane + constraint.DEEP]
        and constraints[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE
        and points[lane + contact_point.NORMAL_IMPULSE] == 0.0
        and points[lane + contact_point.TANGENT_IMPULSE_1] == 0.0
        and points[lane + contact_point.TANGENT_IMPULSE_2] == 0.0
        and constraints[lane + constraint.ROUNDNESS] >= constraint.NOT_ROUND
    ):
        return False
    return not angular or (
        points[lane + contact_point.ROLLING_IMPULSE_1] == 0.0
        and points[lane + contact_point.ROLLING_IMPULSE_2] == 0.0
        and points[lane + contact_point.TWIST_IMPULSE] == 0.0
    )


@kernel
def points_to_visit(
    used: int, point_count: int, width: int, angular: bool, constraints: Array, points: Array
) -> int:  # fmt: skip
    """
    Count the points of the manifolds of a batch that are visited in a tick, when it starts.

        used    : lanes in use
        width   : numbers of a point
        angular : whether anything rolls or twists with friction
        points  : all points of each lane, and their patch
    """
    near = point_count
    while near > 0:
        own = points[(near - 1) * width : near * width]
        for lane in range(used):
            if not _is_far(lane, angular, constraints, own):
                return near
        near -= 1
    if point_count > 1:  # friction that is left of what pressed has to go
        patch = points[manifold.MOST * width : manifold.MOST * width + friction_patch.SIZE]
        for lane in range(used):
            wrench = wide_lanes.vector(patch, lane + friction_patch.IMPULSE_1)
            if wrench[0] != 0.0 or wrench[1] != 0.0 or wrench[2] != 0.0:
                return 1
    return near


@kernel
def begin(
    lanes: int, used: int, near: int, point_count: int, first: int, width: int, rows: Array
) -> None:  # fmt: skip
    """
    Find how far the points of a batch are that are not visited, when a tick starts.

        lanes, used : to go over, and in use: the others never press
        near        : points that are visited
        first       : where the rows of the points begin
    """
    if near == point_count:
        return
    constraints = rows[first - constraint.SIZE : first]
    for lane in range(LANES):
        constraints[lane + constraint.FAR_SEPARATION] = NOWHERE
        constraints[lane + constraint.FAR_ARM_A] = 0.0
        constraints[lane + constraint.FAR_ARM_B] = 0.0
    for point in range(near, point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        for lane in range(lanes):
            arm_a, arm_b = wide_lanes.arms(points, lane)
            separation = points[lane + contact_point.SEPARATION]
            # of a layer about a core it is the core that turns, from beyond the gap
            beyond = separation if separation < NONE else 0.0
            far_a = math.sqrt(dot(arm_a, arm_a)) + beyond + constraints[lane + constraint.RADIUS_A]
            far_b = math.sqrt(dot(arm_b, arm_b)) + beyond + constraints[lane + constraint.RADIUS_B]
            before_a = constraints[lane + constraint.FAR_ARM_A]
            before_b = constraints[lane + constraint.FAR_ARM_B]
            constraints[lane + constraint.FAR_ARM_A] = far_a if far_a > before_a else before_a
            constraints[lane + constraint.FAR_ARM_B] = far_b if far_b > before_b else before_b
    _find_least(lanes, used, near, point_count, first, width, rows)


@inline
def _find_least(
    lanes: int, used: int, near: int, point_count: int, first: int, width: int, rows: Array
) -> None:  # fmt: skip
    """Find the least separation of the points that are not visited."""
    constraints = rows[first - constraint.SIZE : first]
    for point in range(near, point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        for lane in range(lanes):
            separation = points[lane + contact_point.SEPARATION]
            least = constraints[lane + constraint.FAR_SEPARATION]
            least = separation if separation < least else least
            constraints[lane + constraint.FAR_SEPARATION] = least
    for lane in range(used, LANES):
        constraints[lane + constraint.FAR_SEPARATION] = NOWHERE
        constraints[lane + constraint.FAR_ARM_A] = 0.0
        constraints[lane + constraint.FAR_ARM_B] = 0.0


@kernel
def follow(
    lanes: int, used: int, near: int, point_count: int, first: int, width: int, rows: Array
) -> None:  # fmt: skip
    """
    Do the same after a substep, in which no surface came nearer to another than by their least
    separation, and no arm became longer by more.
    """
    if near == point_count:
        return
    constraints = rows[first - constraint.SIZE : first]
    for lane in range(lanes):
        least = constraints[lane + constraint.FAR_SEPARATION]
        most = least if least < NONE else 0.0
        constraints[lane + constraint.FAR_ARM_A] += most
        constraints[lane + constraint.FAR_ARM_B] += most
        constraints[lane + constraint.FAR_SEPARATION] = NOWHERE
    _find_least(lanes, used, near, point_count, first, width, rows)


@inline
def _at_most(v: Any) -> Any:
    """Return no less than the length of a vector."""
    return abs(v[0]) + abs(v[1]) + abs(v[2])


@inline
def _fastest(spin: Any, arm: float, h: float) -> Any:
    """Return how fast the end of an arm can come nearer, as its body turns [m/s]."""
    rate = _at_most(spin)
    return rate * (1.0 + 0.5 * h * rate) * arm


@kernel
def may_press(
    lanes: int, inverse_h: float, turns: bool, constraints: Array, scratch: Array
) -> bool:
    """
    Tell whether some far point of a batch might press, with the momenta of the visit under way.

        turns : whether the inertia of anything turns with it, or changes
    """
    h = 1.0 / inverse_h
    count = 0
    for lane in range(lanes):
        spin_a, spin_b = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
        approach = (
            _at_most(wide_lanes.velocity_of_centers(constraints, scratch, lane))
            + _fastest(spin_a, constraints[lane + constraint.FAR_ARM_A], h)
            + _fastest(spin_b, constraints[lane + constraint.FAR_ARM_B], h)
        )
        away = constraints[lane + constraint.FAR_SEPARATION] * inverse_h
        count += 0 if SURELY * approach < away else 1
    return count > 0


@inline
def points_asked(
    number: int, lanes: int, inverse_h: float, turns: bool, constraints: Array, scratch: Array,
    batches: Indices,
) -> Any:  # fmt: skip
    """Return how many points of each manifold a visit of a batch asks: all, if any may press."""
    batch = number * batch_record.SIZE
    point_count = batches[batch + batch_record.POINT_COUNT]
    near = batches[batch + batch_record.NEAR_COUNT]
    if near < point_count and may_press(lanes, inverse_h, turns, constraints, scratch):
        batches[batch + batch_record.NEAR_COUNT] = near = point_count
    return near


@inline
def points_pressed(
    number: int, near: int, used: int, width: int, points: Array, batches: Indices
) -> Any:
    """
    Return how many points of each manifold the visits of a batch ask from now on: all, if one that
    was not asked presses since manifolds were solved as a whole, which looks at all of them.

        near, used : points asked so far; lanes in use
        points     : all points of each lane
    """
    batch = number * batch_record.SIZE
    point_count = batches[batch + batch_record.POINT_COUNT]
    for point in range(near, point_count):
        row = point * width + contact_point.NORMAL_IMPULSE
        for lane in range(row, row + used):
            if points[lane] > 0.0:
                batches[batch + batch_record.NEAR_COUNT] = near = point_count
    return near
