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
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.solve import OPEN, soft_law
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
POINT = 1e-16  # [m^2] of the sum of squares: points that are no farther apart are one

SOFT = slot('[-] whether overlaps are soft, before the motion')
BOUNCING = slot('[-] whether it is the impulse of restitution')
WIDTH = slot('[-] numbers of a point')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')
law = slot('kernel (constraints, points, lane, ...): J, b, m sigma, iota, and who takes part')
apply_to_point = slot('kernel (lane, points, scratch): gives a point its part')


@inline
def any_stirs(used: int, scratch: Array) -> bool:
    """Tell whether some lane has anything to be solved in common: what rests has not."""
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.COMMON_STIRS] > 0.0
    return found


def _law(
    constraints: Array, points: Array, lane: int, along: float, inverse_h: float, slop: float,
    cap: float,
) -> Any:  # fmt: skip
    """
    Return what `solve` has for a point: J, b, m sigma, iota, and whether it takes part: what
    presses, or is about to.
    """
    separation = points[lane + contact_point.SEPARATION]
    mass = points[lane + contact_point.NORMAL_MASS]
    is_open = separation > OPEN
    bounces = constraints[lane + constraint.RESTITUTION]
    iota, may = 0.0, True
    if BOUNCING:
        impulse = points[lane + contact_point.RESTITUTION_NORMAL]
        approach = points[lane + contact_point.APPROACH_VELOCITY]
        bias = bounces * approach if approach < 0.0 else 0.0
        pressure = (
            points[lane + contact_point.LARGEST_NORMAL_IMPULSE]
            + points[lane + contact_point.NORMAL_IMPULSE]
        )
        may = (pressure > 0.0) & (constraints[lane + constraint.BOUNCES] > 0.0)
    elif SOFT:
        impulse = points[lane + contact_point.NORMAL_IMPULSE]
        mass, bias, iota = soft_law(
            constraints, points, lane, separation, impulse, inverse_h, slop, cap
        )
    else:
        impulse = points[lane + contact_point.NORMAL_IMPULSE]
        is_new = points[lane + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        may = not (is_open & (bounces > 0.0) & (impulse <= 0.0))
    # rows that have no point have no mass
    takes_part = may & (mass > 0.0) & ((impulse > 0.0) | (along + bias < 0.0))
    return impulse, bias, mass, iota, takes_part


@inline
def _begin_sums(lane: int, turns: bool, constraints: Array, first: Array, scratch: Array) -> None:
    """Begin the sums of a lane; first: the first point of each."""
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    spins = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
    turn = cross(normal, subtract(spins[1], spins[0]))
    of_centers = wide_lanes.velocity_of_centers(constraints, scratch, lane)
    nothing = (0.0, 0.0, 0.0)
    wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_TURN, turn)
    origin = wide_lanes.vector(first, lane + contact_point.ARM_B)
    wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_FIRST, origin)
    scratch[lane + lane_scratch.COMMON_ALONG] = dot(normal, of_centers)
    scratch[lane + lane_scratch.COMMON_COUNT] = 0.0
    scratch[lane + lane_scratch.COMMON_MASS] = 0.0
    scratch[lane + lane_scratch.COMMON_DRIVE] = 0.0
    scratch[lane + lane_scratch.COMMON_SOFTNESS] = 0.0
    scratch[lane + lane_scratch.COMMON_LENGTHS] = 0.0
    scratch[lane + lane_scratch.COMMON_RISES] = 0.0
    wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_ARM_A, nothing)
    wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_ARM_B, nothing)


@inline
def _add_point(lane: int, found: Any, points: Array, scratch: Array) -> None:
    """Add a point to the sums of its lane; found: of it, see `_law`."""
    impulse, bias, stiff, iota, takes_part = found
    share = 1.0 if takes_part else 0.0
    bias = bias if takes_part else 0.0
    stiff, iota = share * stiff, share * iota
    own_a, own_b = wide_lanes.arms(points, lane)
    way = subtract(own_b, wide_lanes.vector(scratch, lane + lane_scratch.COMMON_FIRST))
    rise = dot(wide_lanes.vector(scratch, lane + lane_scratch.COMMON_TURN), way)
    points[lane + contact_point.TAKES_PART] = share
    scratch[lane + lane_scratch.COMMON_COUNT] += share
    scratch[lane + lane_scratch.COMMON_MASS] += stiff
    scratch[lane + lane_scratch.COMMON_DRIVE] += stiff * bias + iota * impulse
    scratch[lane + lane_scratch.COMMON_SOFTNESS] += iota
    scratch[lane + lane_scratch.COMMON_LENGTHS] += share * dot(way, way)
    scratch[lane + lane_scratch.COMMON_RISES] += share * (rise * rise)
    wide_lanes.add_to_vector(scratch, lane + lane_scratch.COMMON_ARM_A, share, own_a)
    wide_lanes.add_to_vector(scratch, lane + lane_scratch.COMMON_ARM_B, share, own_b)


def _apply_to_point(lane: int, points: Array, scratch: Array) -> None:
    """Give a point its part, and add that to what all have been given so far."""
    field = contact_point.RESTITUTION_NORMAL if BOUNCING else contact_point.NORMAL_IMPULSE
    impulse = points[lane + field]
    common = scratch[lane + lane_scratch.COMMON_CHANGE]
    # else it keeps its bits
    takes_part = (points[lane + contact_point.TAKES_PART] > 0.0) & (common != 0.0)
    # half of the warm start is still to come, before the motion, of what presses
    warm = points[lane + contact_point.WARM_NORMAL] if SOFT else 0.0
    before = impulse - warm if impulse > 0.0 else 0.0
    now = before + common
    now = now if now > 0.0 else 0.0
    now = now if takes_part else before
    new = now + warm if now > 0.0 else 0.0
    points[lane + field] = new if takes_part else impulse
    change = now - before
    size, largest = abs(change), scratch[lane + lane_scratch.LARGEST_CHANGE]
    arm_a, arm_b = wide_lanes.arms(points, lane)
    scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
    scratch[lane + lane_scratch.COMMON_TOTAL] += change
    wide_lanes.add_to_vector(scratch, lane + lane_scratch.COMMON_MOMENT_A, change, arm_a)
    wide_lanes.add_to_vector(scratch, lane + lane_scratch.COMMON_MOMENT_B, change, arm_b)


@inline
def _move_alike(lane: int, scratch: Array) -> Any:
    """
    Tell whether the turn gives the points that take part one velocity along the normal: they
    differ by less than those of a face that turns by TURNING.
    """
    count = scratch[lane + lane_scratch.COMMON_COUNT]
    share = 1.0 / (count if count > 1.0 else 1.0)
    origin = wide_lanes.vector(scratch, lane + lane_scratch.COMMON_FIRST)
    arm = wide_lanes.vector(scratch, lane + lane_scratch.COMMON_ARM_B)
    middle = subtract(scale(share, arm), origin)
    rise = dot(wide_lanes.vector(scratch, lane + lane_scratch.COMMON_TURN), middle)
    spread = scratch[lane + lane_scratch.COMMON_LENGTHS] - count * dot(middle, middle)
    rises = scratch[lane + lane_scratch.COMMON_RISES] - count * (rise * rise)
    return rises < 0.5 * TURNING * TURNING * (spread - POINT)


@inline
def _stirs(lane: int, scratch: Array) -> Any:
    """Tell whether a lane has anything to be solved in common."""
    mass = scratch[lane + lane_scratch.COMMON_MASS]
    drive = scratch[lane + lane_scratch.COMMON_DRIVE]
    return abs(mass * scratch[lane + lane_scratch.COMMON_ALONG] + drive) > STILL * mass


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
    solvable = several & (stiffness > 0.0) & _stirs(lane, scratch)
    return -(mass * velocity + drive) / (stiffness if solvable else 1.0) if solvable else 0.0


@inline
def _apply_all(lane: int, constraints: Array, scratch: Array) -> None:
    """Give the bodies of a lane what all its points have been given."""
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    total = scratch[lane + lane_scratch.COMMON_TOTAL]
    moment_a = wide_lanes.vector(scratch, lane + lane_scratch.COMMON_MOMENT_A)
    moment_b = wide_lanes.vector(scratch, lane + lane_scratch.COMMON_MOMENT_B)
    angular_a = wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A)
    angular_b = wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B)
    angular_a = subtract(angular_a, cross(moment_a, normal))
    angular_b = add(angular_b, cross(moment_b, normal))
    wide_lanes.add_to_vector(scratch, lane + lane_scratch.IMPULSE, total, normal)
    wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, angular_a)
    wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, angular_b)


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
    for lane in range(lanes):
        _begin_sums(lane, TURNS, constraints, points, scratch)
    for point in range(near):
        own = points[point * WIDTH : (point + 1) * WIDTH]
        for lane in range(lanes):
            along = scratch[lane + lane_scratch.COMMON_ALONG]
            found = law(constraints, own, lane, along, inverse_h, slop, cap)
            _add_point(lane, found, own, scratch)
    for lane in range(lanes):
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        stirs = active & _stirs(lane, scratch) & _move_alike(lane, scratch)
        scratch[lane + lane_scratch.COMMON_STIRS] = 1.0 if stirs else 0.0


def _give(lanes: int, near: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Give what the points of each lane that stirs have in common to them and to its bodies.

    near   : points of each lane that are asked
    points : all points of each lane
    """
    for lane in range(lanes):
        stirs = scratch[lane + lane_scratch.COMMON_STIRS] > 0.0
        common = _change(lane, TURNS, constraints, scratch)
        scratch[lane + lane_scratch.COMMON_CHANGE] = common if stirs else 0.0
        scratch[lane + lane_scratch.COMMON_TOTAL] = 0.0
        wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_MOMENT_A, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(scratch, lane + lane_scratch.COMMON_MOMENT_B, (0.0, 0.0, 0.0))
    for point in range(near):
        own = points[point * WIDTH : (point + 1) * WIDTH]
        for lane in range(lanes):
            apply_to_point(lane, own, scratch)
    for lane in range(lanes):
        _apply_all(lane, constraints, scratch)


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
    for slot_name, source in (('law', _law), ('apply_to_point', _apply_to_point)):
        offered[slot_name] = specialise(source, name=name, inlined=True, offered=offered)
    return (
        specialise(_sum_up, name=name, offered=offered),
        specialise(_give, name=name, offered=offered),
    )
