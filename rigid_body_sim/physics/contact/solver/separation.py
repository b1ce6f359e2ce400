# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Separation and anchors of contact points after the motion over a substep: both follow the bodies.

And there they get the second half of their warm start. A load J, what lasts of the last substep,
acts in two halves, as other forces do (velocity Verlet): J/2 before the motion, at the arms of
then, and J/2 after it, at those of now. So what is carried, slides or rolls moves with its mean
velocity, to second order in the substep, and the two halves of a point at rest cancel its weight
exactly. A point that did not press during the motion gets neither half.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    transfers,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import add, add_scaled, dot, scale, subtract

RUBS = slot('[-] whether friction is that of the points, not of a patch of them')
LAYERED = slot('[-] whether anything is a ball or a capsule')


@kernel
def gather_motion(constraints: Array, scratch: Array, bodies: Array) -> None:
    """Fetch how the bodies of a batch have moved over the substep."""
    transfers.fetch_seven(
        constraints, constraint.BODY_A, bodies, solver_bodies.DISPLACEMENT, scratch,
        lane_scratch.DISPLACEMENT_A,
    )  # fmt: skip
    transfers.fetch_seven(
        constraints, constraint.BODY_B, bodies, solver_bodies.DISPLACEMENT, scratch,
        lane_scratch.DISPLACEMENT_B,
    )  # fmt: skip


@inline
def apply_second_half(
    points: Array, scratch: Array, lane: int, frame: Any, arm_a: Any, arm_b: Any
) -> None:
    """
    Give one point of a lane the second half of its warm start, where it is now.

    A point that did not press during the motion has none.
    """
    presses = points[lane + contact_point.NORMAL_IMPULSE] > 0.0
    warm = points[lane + contact_point.WARM_NORMAL] if presses else 0.0
    warm_1 = points[lane + contact_point.WARM_TANGENT_1] if presses else 0.0
    warm_2 = points[lane + contact_point.WARM_TANGENT_2] if presses else 0.0
    normal, tangent_1, tangent_2 = frame
    impulse = wide_lanes.impulse_of(warm, warm_1, warm_2, normal, tangent_1, tangent_2)
    wide_lanes.put_vector(points, lane + contact_point.ARM_A, arm_a)
    wide_lanes.put_vector(points, lane + contact_point.ARM_B, arm_b)
    wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


@inline
def turn_total(points: Array, lane: int, frame: Any, new_frame: Any) -> None:
    """
    Let what a point has given so far keep its direction where the axes of its lane turn: `readout`
    takes all of it along those of the end of the tick.

    Of this substep that is what was accumulated before the motion, less the second half of the
    warm start: with w = total + given in the old axes F, total' = F'^T F w - given in the new.
    """
    presses = points[lane + contact_point.NORMAL_IMPULSE] > 0.0
    impulses = wide_lanes.vector(points, lane + contact_point.NORMAL_IMPULSE)
    warm = wide_lanes.vector(points, lane + contact_point.WARM_NORMAL)
    total = wide_lanes.vector(points, lane + contact_point.TOTAL_IMPULSE)
    given = scale(1.0 if presses else 0.0, subtract(impulses, warm))
    whole = add(total, given)
    normal, tangent_1, tangent_2 = frame
    new_normal, new_tangent_1, new_tangent_2 = new_frame
    turns = (
        (normal[0] != new_normal[0]) | (normal[1] != new_normal[1]) | (normal[2] != new_normal[2])
    )
    along = wide_lanes.impulse_of(whole[0], whole[1], whole[2], normal, tangent_1, tangent_2)
    turned = (dot(new_normal, along), dot(new_tangent_1, along), dot(new_tangent_2, along))
    change = scale(1.0 if turns else 0.0, subtract(turned, whole))
    wide_lanes.put_vector(points, lane + contact_point.TOTAL_IMPULSE, add(total, change))


@inline
def _apply_second_half_normal(
    points: Array, scratch: Array, lane: int, normal: Any, arm_a: Any, arm_b: Any
) -> None:
    """Do the same where friction is that of a patch (`patch_friction`)."""
    presses = points[lane + contact_point.NORMAL_IMPULSE] > 0.0
    warm = points[lane + contact_point.WARM_NORMAL] if presses else 0.0
    wide_lanes.put_vector(points, lane + contact_point.ARM_A, arm_a)
    wide_lanes.put_vector(points, lane + contact_point.ARM_B, arm_b)
    wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, scale(warm, normal))


def _update_points(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Find separation and arms of a point of each lane after the motion over a substep, and give it
    the second half of its warm start there.

    The point moves as the surface of A, of B, or in the middle (`SURFACE_WEIGHT`), and both arms
    end in it: impulses at it keep the angular momentum of the two to the last digits. The layer of
    a ball or a capsule about its core does not turn with it: r = c + layer n moves by D c.

    What bounces off something that no impulse moves keeps its arms: it bounces at the end of the
    tick by the law of the place where it hit.
    """
    for lane in range(lanes):
        arm_a, arm_b = wide_lanes.arms(points, lane)
        fixed = (not wide_lanes.gives_way_a(constraints, lane)) | (
            not wide_lanes.gives_way_b(constraints, lane)
        )
        bounces = (constraints[lane + constraint.RESTITUTION] > 0.0) & (
            points[lane + contact_point.APPROACH_VELOCITY] < 0.0
        )
        follows = 0.0 if fixed & bounces else 1.0
        frame = wide_lanes.contact_frame(constraints, lane)
        normal = frame[0]
        turn_a = wide_lanes.vector(scratch, lane + lane_scratch.TURN_A)
        turn_b = wide_lanes.vector(scratch, lane + lane_scratch.TURN_B)
        scalar_a = scratch[lane + lane_scratch.TURN_SCALAR_A]
        scalar_b = scratch[lane + lane_scratch.TURN_SCALAR_B]
        if LAYERED:
            radius_a = constraints[lane + constraint.RADIUS_A]
            radius_b = constraints[lane + constraint.RADIUS_B]
            core_a = subtract(arm_a, scale(radius_a, normal))
            moved_a = wide_lanes.displacement_by_turn(turn_a, scalar_a, core_a)
            core_b = add_scaled(arm_b, radius_b, normal)
            moved_b = wide_lanes.displacement_by_turn(turn_b, scalar_b, core_b)
        else:
            moved_a = wide_lanes.displacement_by_turn(turn_a, scalar_a, arm_a)
            moved_b = wide_lanes.displacement_by_turn(turn_b, scalar_b, arm_b)
        of_centers = subtract(
            wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_B),
            wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_A),
        )
        apart = add(of_centers, subtract(moved_b, moved_a))
        separation = points[lane + contact_point.SEPARATION]
        separation += dot(normal, apart)
        points[lane + contact_point.SEPARATION] = separation
        weight = constraints[lane + constraint.SURFACE_WEIGHT]
        arm_a = add_scaled(arm_a, follows, add_scaled(moved_a, weight, apart))
        weight = 1.0 - weight
        arm_b = add_scaled(arm_b, follows, subtract(moved_b, scale(weight, apart)))
        if RUBS:
            apply_second_half(points, scratch, lane, frame, arm_a, arm_b)
        else:
            _apply_second_half_normal(points, scratch, lane, normal, arm_a, arm_b)


def update_kernel(*, layered: bool, rubs: bool) -> Callable[..., Any]:
    """
    Make the kernel of a scene.

        layered : it has balls or capsules
        rubs    : with friction of the points, not of a patch of them
    """
    name = f'{"layered" if layered else "bare"}_{"rubs" if rubs else "smooth"}'
    return specialise(_update_points, name=name, LAYERED=layered, RUBS=rubs)


@inline
def _turned(tangent: Any, share: float, new_normal: Any, both: Any) -> Any:
    """Turn a tangent with the normal: t - (n' . t)/(1 + n . n') (n + n')."""
    turn = share * dot(tangent, new_normal)
    return subtract(tangent, scale(turn, both))


@inline
def turned_frame(frame: Any, new_normal: Any) -> Any:
    """Turn normal and tangents by the smallest turn that takes the normal to a new one."""
    normal, tangent_1, tangent_2 = frame
    share = 1.0 / (1.0 + dot(normal, new_normal))
    both = add(normal, new_normal)
    return (
        new_normal,
        _turned(tangent_1, share, new_normal, both),
        _turned(tangent_2, share, new_normal, both),
    )


@kernel
def update_balls(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Do what `update_kernel` does where a ball meets a ball, or what cannot move.

    Between two balls the normal turns into their line of centres, and the separation is not
    linearised:

        d = x_B - x_A = r_A - r_B,  n' = d / |d|,  s' = s + |d'| - |d|
        t' = t - (n' . t)/(1 + n . n') (n + n'), the smallest turn that takes n to n'

    Two that meet in this tick keep the normal of that instant: `ball_impacts`.
    """
    for lane in range(lanes):
        arm_a, arm_b = wide_lanes.arms(points, lane)
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        motion = subtract(
            wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_B),
            wide_lanes.vector(scratch, lane + lane_scratch.DISPLACEMENT_A),
        )
        separation = points[lane + contact_point.SEPARATION]
        weight = constraints[lane + constraint.SURFACE_WEIGHT]
        line = subtract(arm_a, arm_b)
        way = add(line, motion)
        square = dot(way, way)
        stays = constraints[lane + constraint.WAITS] > 0.0
        balls = (
            (constraints[lane + constraint.ROUNDNESS] > constraint.BALL_ON_FIXED)
            & (square > manifold.TINY)
            & (not stays)
        )
        length = math.sqrt(square if balls else 1.0)
        before = dot(normal, line)
        opening = length - before if balls else dot(normal, motion)
        new_normal = (
            way[0] / length if balls else normal[0],
            way[1] / length if balls else normal[1],
            way[2] / length if balls else normal[2],
        )
        reach = dot(normal, arm_a) + weight * opening
        shift = 0.0 if stays else weight
        new_arm_a = (
            reach * new_normal[0] if balls else arm_a[0] + shift * motion[0],
            reach * new_normal[1] if balls else arm_a[1] + shift * motion[1],
            reach * new_normal[2] if balls else arm_a[2] + shift * motion[2],
        )
        way = (
            line[0] if stays else way[0], line[1] if stays else way[1],
            line[2] if stays else way[2],
        )  # fmt: skip
        points[lane + contact_point.SEPARATION] = separation + opening
        frame = turned_frame((normal, tangent_1, tangent_2), new_normal)
        turn_total(points, lane, (normal, tangent_1, tangent_2), frame)
        wide_lanes.put_vector(constraints, lane + constraint.NORMAL, frame[0])
        wide_lanes.put_vector(constraints, lane + constraint.TANGENT_1, frame[1])
        wide_lanes.put_vector(constraints, lane + constraint.TANGENT_2, frame[2])
        apply_second_half(points, scratch, lane, frame, new_arm_a, subtract(new_arm_a, way))
