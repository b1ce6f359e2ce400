# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Warm start: the impulses from which a substep starts, those of the last one, lane by lane.

What lasts of the accumulated impulse of a substep, its load, acts on the next one in two halves
about the motion, as other forces do (`separation`):

    warm start of B: J/2, r_B x J/2; of A: -J/2, -r_A x J/2

and Coulomb's law holds for it: |J_t| <= mu J_n. Between substeps the arms are those of now, so
that angular momentum stays. The first substep of a tick starts from what `impulse_cache` recalls.

What lasts goes on along the normal as it has changed, J + g (J - J_before): passes find the loads
of what rocks slowly (heavy on light, a high stack) only in part in each substep, and what follows
late feeds the motion that it follows. One of three stacks of boxes of unlike sizes rocked for
ever, at up to 0.05 rad/s. One g for all points of a manifold, GOES_ON at most: so what turns
nothing goes on turning nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    static_sink,
    transfers,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.softness import spring_mass
from rigid_body_sim.physics.vectors import dot, scale

RUBS = slot('[-] whether friction is that of the points, not of a patch of them')

LOAD = 0.02  # [m/s] what gravity gives in two milliseconds
GROWTH = 4.0  # [-] of half a warm start: a load is at most twice the last one
# [-] of the change of a load, and of the load at most: with less GOES_ON stacks rock, with 1
# loads that are found in part swing, and pyramids never rest
GOES_ON, MOST = 0.6, 0.5


@inline
def share_of_load(impulse: float, warm: float, mass: float) -> Any:
    """
    Share of an impulse [N s] that is a load, from which the next substep starts.

    The impulse of an impact does not last: what it gives once too much lifts the body before it
    is taken back. A load changes the velocity of the point by less than LOAD, or is at most twice
    what this substep started from; warm : [N s] half of that, mass : [kg] on which it acts.
    """
    limit = max(GROWTH * warm, LOAD * mass)
    return limit / impulse if impulse > limit else 1.0


@inline
def share_of_point(lane: int, row: int, constraints: Array, points: Array) -> Any:
    """Share of the impulse of a point that is a load, alone."""
    return share_of_load(
        points[row + contact_point.NORMAL_IMPULSE], points[row + contact_point.WARM_NORMAL],
        spring_mass(lane, row, constraints, points),
    )  # fmt: skip


@inline
def lasting_share(lane: int, row: int, constraints: Array, points: Array) -> Any:
    """Share of the impulse of a point that lasts: its load, or that of all with its spring."""
    one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
    own = share_of_point(lane, row, constraints, points)
    return constraints[lane + constraint.LASTS] if one_spring else own


@inline
def share_that_goes_on(row: int, impulse: float, share: Any, points: Array) -> Any:
    """
    Return the share g of the change of a load with which a manifold goes on, a point more known:
    none changes by more than MOST of it, and none that has begun or ended in this substep goes on.

        impulse : [N s] what lasts of the point
        share   : of the points before
    """
    before = 2.0 * points[row + contact_point.WARM_NORMAL]
    change = abs(impulse - before)
    most = MOST * impulse if before > 0.0 else 0.0
    return most / change if share * change > most else share


@inline
def foreseen(row: int, impulse: float, share: float, points: Array) -> Any:
    """
    Return what a point starts from in the next substep [N s]: a load goes on as it has changed.

        impulse : [N s] what lasts of it in this one
        share   : see `share_that_goes_on`
    """
    return impulse + share * (impulse - 2.0 * points[row + contact_point.WARM_NORMAL])


@inline
def find_shares_that_go_on(
    lanes: int, count: int, width: int, constraints: Array, points: Array
) -> None:
    """
    Find with which share of their change the loads of each lane of a batch go on; those of a
    surface of several manifolds stay as they are.
    """
    for lane in range(lanes):
        of_none = constraints[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE
        share = GOES_ON if of_none else 0.0
        for row in range(lane, lane + count * width, width):
            lasts = lasting_share(lane, row, constraints, points)
            lasts *= points[row + contact_point.NORMAL_IMPULSE]
            share = share_that_goes_on(row, lasts, share, points)
        constraints[lane + constraint.GOES_ON] = share


@inline
def _warm_start(constraints: Array, points: Array, scratch: Array, lane: int) -> None:
    """Halve the accumulated impulse of a point; sum up what that is to its bodies."""
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
    arm_a, arm_b = wide_lanes.arms(points, lane)
    warm = 0.5 * points[lane + contact_point.NORMAL_IMPULSE]
    warm_1 = 0.5 * points[lane + contact_point.TANGENT_IMPULSE_1]
    warm_2 = 0.5 * points[lane + contact_point.TANGENT_IMPULSE_2]
    points[lane + contact_point.WARM_NORMAL] = warm
    points[lane + contact_point.WARM_TANGENT_1] = warm_1
    points[lane + contact_point.WARM_TANGENT_2] = warm_2
    impulse = wide_lanes.impulse_of(warm, warm_1, warm_2, normal, tangent_1, tangent_2)
    wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


@inline
def _warm_start_normal(constraints: Array, points: Array, scratch: Array, lane: int) -> None:
    """Do the same where friction is that of a patch (`patch_friction`)."""
    arm_a, arm_b = wide_lanes.arms(points, lane)
    warm = 0.5 * points[lane + contact_point.NORMAL_IMPULSE]
    points[lane + contact_point.WARM_NORMAL] = warm
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, scale(warm, normal))


@kernel
def start_tick(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Start one point of each lane from the impulses of the last tick: clear what is summed over the
    tick, bring friction within its cone, sum up the warm start of its bodies.
    """
    for lane in range(lanes):
        impulse_1, impulse_2 = wide_lanes.clamp_to_disc(
            points[lane + contact_point.TANGENT_IMPULSE_1],
            points[lane + contact_point.TANGENT_IMPULSE_2],
            constraints[lane + constraint.FRICTION] * points[lane + contact_point.NORMAL_IMPULSE],
        )
        points[lane + contact_point.TANGENT_IMPULSE_1] = impulse_1
        points[lane + contact_point.TANGENT_IMPULSE_2] = impulse_2
        wide_lanes.put_vector(points, lane + contact_point.TOTAL_IMPULSE, (0.0, 0.0, 0.0))
        points[lane + contact_point.LARGEST_NORMAL_IMPULSE] = 0.0
        points[lane + contact_point.SEPARATION] = points[
            lane + contact_point.INITIAL_SEPARATION
        ] - static_sink.of_point(lane, lane, constraints, points)
        _warm_start(constraints, points, scratch, lane)


@kernel
def start_tick_angular(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for lane in range(lanes):
        impulse = wide_lanes.vector(points, lane + contact_point.RECALLED_ANGULAR_IMPULSE)
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        rolling_1, rolling_2 = dot(tangent_1, impulse), dot(tangent_2, impulse)
        twist = dot(normal, impulse)
        points[lane + contact_point.ROLLING_IMPULSE_1] = rolling_1
        points[lane + contact_point.ROLLING_IMPULSE_2] = rolling_2
        points[lane + contact_point.TWIST_IMPULSE] = twist
        points[lane + contact_point.WARM_ROLLING_1] = 0.5 * rolling_1
        points[lane + contact_point.WARM_ROLLING_2] = 0.5 * rolling_2
        points[lane + contact_point.WARM_TWIST] = 0.5 * twist
        wide_lanes.apply_angular_impulse(scratch, lane, scale(0.5, impulse))


def _start_substep(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Start one point of each lane from the loads of the substep that ends; add what it gave to the
    totals of the tick.
    """
    for lane in range(lanes):
        normal_impulse = points[lane + contact_point.NORMAL_IMPULSE]
        largest = points[lane + contact_point.LARGEST_NORMAL_IMPULSE]
        points[lane + contact_point.LARGEST_NORMAL_IMPULSE] = (
            normal_impulse if normal_impulse > largest else largest
        )
        points[lane + contact_point.TOTAL_IMPULSE] += normal_impulse
        share = lasting_share(lane, lane, constraints, points)
        points[lane + contact_point.NORMAL_IMPULSE] = foreseen(
            lane, share * normal_impulse, constraints[lane + constraint.GOES_ON], points
        )
        if RUBS:
            impulse_1 = points[lane + contact_point.TANGENT_IMPULSE_1]
            impulse_2 = points[lane + contact_point.TANGENT_IMPULSE_2]
            points[lane + contact_point.TOTAL_IMPULSE + LANES] += impulse_1
            points[lane + contact_point.TOTAL_IMPULSE + 2 * LANES] += impulse_2
            points[lane + contact_point.TANGENT_IMPULSE_1] = share * impulse_1
            points[lane + contact_point.TANGENT_IMPULSE_2] = share * impulse_2
            _warm_start(constraints, points, scratch, lane)
        else:
            scratch[lane + lane_scratch.PRESS] += normal_impulse
            scratch[lane + lane_scratch.PRESS_1] += share * normal_impulse
            _warm_start_normal(constraints, points, scratch, lane)


def substep_starter(*, rubs: bool) -> Callable[..., Any]:
    """Make the kernel that starts a substep of a point; rubs: with its friction."""
    return specialise(_start_substep, name='rubs' if rubs else 'smooth', RUBS=rubs)


@kernel
def start_substep_angular(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """Do the same with the angular impulses of one point of each lane."""
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        rolling_1 = 0.5 * points[lane + contact_point.ROLLING_IMPULSE_1]
        rolling_2 = 0.5 * points[lane + contact_point.ROLLING_IMPULSE_2]
        twist = 0.5 * points[lane + contact_point.TWIST_IMPULSE]
        points[lane + contact_point.WARM_ROLLING_1] = rolling_1
        points[lane + contact_point.WARM_ROLLING_2] = rolling_2
        points[lane + contact_point.WARM_TWIST] = twist
        impulse = wide_lanes.angular_impulse_of(
            rolling_1, rolling_2, twist, normal, tangent_1, tangent_2
        )
        wide_lanes.apply_angular_impulse(scratch, lane, impulse)


@kernel
def scatter(field: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """
    Add the warm start of the points of a batch to a field of its bodies, and the one behind it.

    field : of `solver_bodies`
    """
    transfers.add_on_a(
        constraints, constraint.BODY_A, bodies, field, scratch, lane_scratch.IMPULSE,
        lane_scratch.ANGULAR_MOMENTUM_A, lane_scratch.VISITED,
    )  # fmt: skip
    transfers.add_on_b(
        constraints, constraint.BODY_B, bodies, field, scratch, lane_scratch.IMPULSE,
        lane_scratch.ANGULAR_MOMENTUM_B, lane_scratch.VISITED,
    )  # fmt: skip


@kernel
def clear(lanes: int, scratch: Array) -> None:
    """Begin the sums of a batch."""
    for lane in range(lanes):
        wide_lanes.put_vector(scratch, lane + lane_scratch.IMPULSE, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, (0.0, 0.0, 0.0))
        scratch[lane + lane_scratch.VISITED] = 1.0
