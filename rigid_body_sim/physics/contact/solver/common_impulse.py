# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The common part of the normal impulses of a manifold, solved before its points are visited one by
one: so what is symmetric stays symmetric to the last digits.

Sequential impulses give a body that lands flat a turn with the first point and take it back with
the others, to the tolerance of the iteration. The impulse that is the same at all points that
press or are about to gives none: with their mean arms, v_n the velocity there, K its entry of
J M^-1 J^T, k points, and b, sigma, iota of `solve`,

    J' = -(sum m sigma (v_n + b) + sum iota J) / (k K sum m sigma + sum iota),  J <- max(J + J', 0)

is the change after which their visits change nothing, where they are alike; else it is a good
start (the coarse correction of a method of two grids: what all points have in common is what
sequential impulses are slowest in).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    face_spring,
    lane_scratch,
    static_sink,
    surface_chain,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.contact_point import ONE_POINT
from rigid_body_sim.physics.contact.solver.solve import OPEN, soft_law, waits_to_bounce
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    dot,
    scale,
    subtract,
)

# [m/s] velocity along the normal, with the push-out, below which nothing is solved in common: then
# the points differ by less than this
STILL = 1e-9

# [rad/s] turn of the two bodies against each other, as far as it gives the points of a face unlike
# velocities along the normal, above which nothing is solved in common: there is no symmetry to
# keep. What rolls turns about the line on which it lies: its points move alike however fast it is.
# A stack that trembles turns by less, and comes to rest ten times as fast by what is common.
TURNING = 1.0

SOFT = slot('[-] whether overlaps are soft, before the motion')
BOUNCING = slot('[-] whether it is the impulse of restitution')
WIDTH = slot('[-] numbers of a point')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')
law = slot('kernel (constraints, points, ...): b + c J, m sigma, iota, and who takes part')
give_to_point = slot('kernel (row, common, points): gives a point its part')


class Sums(NamedTuple):
    """
    Sums over the points of a lane that take part.

    point_count  : how many they are
    mass         : m sigma [kg]
    drive        : m sigma (b + c J) [N s]
    softness     : iota
    lengths      : squares of their ways from the first point [m^2]
    rises        : squares of what the turn gives these ways along the normal [m^2/s^2]
    arm_a, arm_b : [m] their arms on A and B
    """

    point_count: float
    mass: float
    drive: float
    softness: float
    lengths: float
    rises: float
    arm_a: Any
    arm_b: Any


@inline
def any_stirs(used: int, scratch: Array) -> bool:
    """Tell whether some lane has anything to be solved in common: what rests has not."""
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.COMMON_STIRS] > 0.0
    return found


def _law(
    constraints: Array, points: Array, scratch: Array, lane: int, row: int, along: float,
    inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Return what `solve` has for a point: b + c J, m sigma, iota, and whether it takes part: what
    presses, or is about to.

    row   : where the point begins in this lane
    along : [m/s] velocity of the centres along the normal
    """
    separation = points[row + contact_point.SEPARATION]
    mass = points[row + contact_point.NORMAL_MASS]
    is_open = separation > OPEN
    bounces = constraints[lane + constraint.RESTITUTION]
    iota, may = 0.0, True
    if BOUNCING:
        impulse = points[row + contact_point.RESTITUTION_NORMAL]
        approach = points[row + contact_point.APPROACH_VELOCITY]
        bias = bounces * approach if approach < 0.0 else 0.0
        pressure = (
            points[row + contact_point.LARGEST_NORMAL_IMPULSE]
            + points[row + contact_point.NORMAL_IMPULSE]
        )
        may = (pressure > 0.0) & (constraints[lane + constraint.BOUNCES] > 0.0)
    elif SOFT:
        impulse = points[row + contact_point.NORMAL_IMPULSE]
        sudden = impulse - 2.0 * points[row + contact_point.WARM_NORMAL]
        one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
        beyond = scratch[lane + lane_scratch.SPRING_IMPULSE] if one_spring else impulse
        sink = static_sink.of_point(lane, row, constraints, points)
        bias, softness = soft_law(
            constraints, lane, mass, separation, sink, beyond, sudden, inverse_h, slop, cap
        )
        mass /= 1.0 + softness * mass
        iota = softness * mass
        bias += softness * beyond
    else:
        impulse = points[row + contact_point.NORMAL_IMPULSE]
        is_new = points[row + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        gap = separation * inverse_h
        may = not waits_to_bounce(lane, along, gap, impulse, mass, constraints)
    # rows that have no point have no mass
    takes_part = may & (mass > 0.0) & ((impulse > 0.0) | (along + bias < 0.0))
    return bias, mass, iota, takes_part


@inline
def _find_motion(lane: int, turns: bool, constraints: Array, scratch: Array) -> Any:
    """
    Return how a lane moves along its normal: its centres [m/s], and n x (omega_B - omega_A), which
    is what an arm gives [rad/s].
    """
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    spins = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
    of_centers = wide_lanes.velocity_of_centers(constraints, scratch, lane)
    return dot(normal, of_centers), cross(normal, subtract(spins[1], spins[0]))


@inline
def _sums_of_point(
    row: int, asked: bool, motion: Any, origin: Any, found: Any, points: Array
) -> Sums:
    """
    Return what a point adds to the sums of its lane; nothing where it takes no part.

    row    : where it begins in this lane
    asked  : it may take part
    motion : of the lane: see `_find_motion`
    origin : arm of the first point on B [m]
    found  : of it, see `_law`
    """
    bias, stiff, iota, takes_part = found
    takes_part = takes_part & asked
    share = 1.0 if takes_part else 0.0
    bias = bias if takes_part else 0.0
    stiff, iota = share * stiff, share * iota
    arm_a, arm_b = wide_lanes.arms(points, row)
    way = subtract(arm_b, origin)
    rise = dot(motion[1], way)
    points[row + contact_point.TAKES_PART] = share
    return Sums(
        share, stiff, stiff * bias, iota, share * dot(way, way),
        share * (rise * rise), scale(share, arm_a), scale(share, arm_b),
    )  # fmt: skip


@inline
def _added(sums: Sums, more: Sums) -> Sums:
    """Add the sums of points."""
    return Sums(
        sums.point_count + more.point_count, sums.mass + more.mass, sums.drive + more.drive,
        sums.softness + more.softness, sums.lengths + more.lengths, sums.rises + more.rises,
        add(sums.arm_a, more.arm_a), add(sums.arm_b, more.arm_b),
    )  # fmt: skip


@inline
def _move_alike(sums: Sums, motion: Any, origin: Any) -> Any:
    """
    Tell whether the turn gives the points that take part one velocity along the normal: they
    differ by less than those of a face that turns by TURNING.
    """
    count = sums.point_count
    share = 1.0 / (count if count > 1.0 else 1.0)
    middle = subtract(scale(share, sums.arm_b), origin)
    rise = dot(motion[1], middle)
    spread = sums.lengths - count * dot(middle, middle)
    return sums.rises - count * (rise * rise) < 0.5 * TURNING * TURNING * (spread - ONE_POINT)


def _sum_up(
    lanes: int, near: int, constraints: Array, points: Array, scratch: Array, inverse_h: float,
    slop: float, cap: float,
) -> None:  # fmt: skip
    """
    Add up what takes part of each lane, and find the lanes that stir: of those that are visited,
    and whose points move alike.

    near   : points of each lane that are asked
    points : all points of each lane
    """
    if SOFT and surface_chain.any_whole(scratch):
        # what lies with a face of others rolls on no rim
        face_spring.find_impulses(lanes, manifold.MOST, WIDTH, False, constraints, points, scratch)
    for lane in range(lanes):
        motion = _find_motion(lane, TURNS, constraints, scratch)
        origin = wide_lanes.vector(points, lane + contact_point.ARM_B)
        found = law(constraints, points, scratch, lane, lane, motion[0], inverse_h, slop, cap)
        sums = _sums_of_point(lane, near > 0, motion, origin, found, points)
        row = lane + WIDTH
        found = law(constraints, points, scratch, lane, row, motion[0], inverse_h, slop, cap)
        sums = _added(sums, _sums_of_point(row, near > 1, motion, origin, found, points))
        row = lane + 2 * WIDTH
        found = law(constraints, points, scratch, lane, row, motion[0], inverse_h, slop, cap)
        sums = _added(sums, _sums_of_point(row, near > 2, motion, origin, found, points))
        row = lane + 3 * WIDTH
        found = law(constraints, points, scratch, lane, row, motion[0], inverse_h, slop, cap)
        sums = _added(sums, _sums_of_point(row, near > 3, motion, origin, found, points))
        stirs = abs(sums.mass * motion[0] + sums.drive) > STILL * sums.mass
        stirs = stirs & (scratch[lane + lane_scratch.ACTIVE] > 0.0)
        stirs = stirs & _move_alike(sums, motion, origin)
        scratch[lane + lane_scratch.COMMON_STIRS] = 1.0 if stirs else 0.0
        scratch[lane + lane_scratch.COMMON_COUNT] = sums.point_count
        scratch[lane + lane_scratch.COMMON_MASS] = sums.mass
        scratch[lane + lane_scratch.COMMON_DRIVE] = sums.drive
        scratch[lane + lane_scratch.COMMON_SOFTNESS] = sums.softness
        wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_ARM_A, sums.arm_a)
        wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_ARM_B, sums.arm_b)


@inline
def _change(lane: int, turns: bool, constraints: Array, scratch: Array) -> Any:
    """Return the common change J' of a lane, 0 where it has none."""
    count = scratch[lane + lane_scratch.COMMON_COUNT]
    mass = scratch[lane + lane_scratch.COMMON_MASS]
    drive = scratch[lane + lane_scratch.COMMON_DRIVE]
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    several = count > 1.0
    share = 1.0 / (count if several else 1.0)
    arm_a = scale(share, wide_lanes.vector(scratch, lane + lane_scratch.COMMON_ARM_A))
    arm_b = scale(share, wide_lanes.vector(scratch, lane + lane_scratch.COMMON_ARM_B))
    velocity = dot(
        normal, wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, turns)
    )
    moment_a, moment_b = cross(arm_a, normal), cross(arm_b, normal)
    turn_a = wide_lanes.apply_inverse_inertia(
        constraints, lane + constraint.INVERSE_INERTIA_A, turns, moment_a
    )
    turn_b = wide_lanes.apply_inverse_inertia(
        constraints, lane + constraint.INVERSE_INERTIA_B, turns, moment_b
    )
    rate = (
        constraints[lane + constraint.INVERSE_MASS_A]
        + constraints[lane + constraint.INVERSE_MASS_B]
        + dot(moment_a, turn_a)
        + dot(moment_b, turn_b)
    )
    stiffness = count * rate * mass + scratch[lane + lane_scratch.COMMON_SOFTNESS]
    stirs = scratch[lane + lane_scratch.COMMON_STIRS] > 0.0
    solvable = several & (stiffness > 0.0) & stirs
    return -(mass * velocity + drive) / (stiffness if solvable else 1.0) if solvable else 0.0


def _give_to_point(row: int, common: float, points: Array) -> Any:
    """Give a point its part; return what it is given, and that times its arms."""
    field = contact_point.RESTITUTION_NORMAL if BOUNCING else contact_point.NORMAL_IMPULSE
    impulse = points[row + field]
    # else it keeps its bits
    takes_part = (points[row + contact_point.TAKES_PART] > 0.0) & (common != 0.0)
    # half of the warm start is still to come, before the motion, of what presses
    warm = points[row + contact_point.WARM_NORMAL] if SOFT else 0.0
    before = impulse - warm if impulse > 0.0 else 0.0
    now = before + common
    now = now if now > 0.0 else 0.0
    now = now if takes_part else before
    new = now + warm if now > 0.0 else 0.0
    points[row + field] = new if takes_part else impulse
    change = now - before
    arm_a, arm_b = wide_lanes.arms(points, row)
    return change, scale(change, arm_a), scale(change, arm_b)


def _give(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Give what the points of each lane that stirs have in common to them and to its bodies.

    points : all points of each lane
    """
    for lane in range(lanes):
        common = _change(lane, TURNS, constraints, scratch)
        one = give_to_point(lane, common, points)
        two = give_to_point(lane + WIDTH, common, points)
        three = give_to_point(lane + 2 * WIDTH, common, points)
        four = give_to_point(lane + 3 * WIDTH, common, points)
        wide_lanes.apply_along_normal(lane, (one, two, three, four), constraints, scratch)


def visit(kind: str, width: int, *, turns: bool) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """
    Make the kernels of a pass: they sum up what points have in common, and give it to them.

        kind  : solve, relax or restore
        width : numbers of a point
        turns : whether the inertia of anything turns with it
    """
    offered: dict[str, Any] = {
        'SOFT': kind == 'solve',
        'BOUNCING': kind == 'restore',
        'WIDTH': width,
        'TURNS': turns,
    }
    name = f'{kind}_{width}'
    for slot_name, source in (('law', _law), ('give_to_point', _give_to_point)):
        offered[slot_name] = specialise(source, name=name, inlined=True, offered=offered)
    return (
        specialise(_sum_up, name=name, offered=offered),
        specialise(_give, name=name, offered=offered),
    )
