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
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.solve import OPEN, soft_law
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
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
add_stir = slot('kernel (point, lane, ...): adds a point to the sums of what stirs')
add_point = slot('kernel (point, lane, ...): adds a point to the sums')
apply_to_point = slot('kernel (point, lane, ...): gives a point its part')


@inline
def any_stirs(used: int, scratch: Array) -> bool:
    """Tell whether some lane has anything to be solved in common: what rests has not."""
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.COMMON_STIRS] > 0.0
    return found


@kernel
def is_clamped(used: int, scratch: Array) -> bool:
    """
    Tell whether some impulse would have become negative: then the sums are others. The other lanes
    stand still.
    """
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.COMMON_CLAMPED] > 0.0
    return found


def _law(
    constraints: Array, points: Array, lane: int, row: int, along: float, inverse_h: float,
    slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Return what `solve` has for a point: J, b, m sigma, iota, and whether it takes part: what
    presses, or is about to.

    row : of the point
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
        mass, bias, iota = soft_law(
            constraints, points, lane, row, separation, impulse, inverse_h, slop, cap
        )
    else:
        impulse = points[row + contact_point.NORMAL_IMPULSE]
        is_new = points[row + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        may = not (is_open & (bounces > 0.0) & (impulse <= 0.0))
    # rows that have no point have no mass
    takes_part = may & (mass > 0.0) & ((impulse > 0.0) | (along + bias < 0.0))
    return impulse, bias, mass, iota, takes_part


def _add_stir(
    point: int, lane: int, along: float, sums: Any, constraints: Array, points: Array,
    inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """Add a point to the sums that tell whether a lane stirs: m sigma, m sigma b + iota J."""
    mass, drive = sums
    impulse, bias, stiff, iota, takes_part = law(
        constraints, points, lane, lane + point * WIDTH, along, inverse_h, slop, cap
    )
    added = stiff * bias + iota * impulse
    return mass + (stiff if takes_part else 0.0), drive + (added if takes_part else 0.0)


def _find_stirring(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float, slop: float,
    cap: float,
) -> None:  # fmt: skip
    """
    Find the lanes with something to be solved in common, of those that are visited.

        points : all points of each lane
    """
    for lane in range(lanes):
        along = dot(
            wide_lanes.vector(constraints, lane + constraint.NORMAL),
            wide_lanes.velocity_of_centers(constraints, scratch, lane),
        )
        sums = (0.0, 0.0)
        sums = add_stir(0, lane, along, sums, constraints, points, inverse_h, slop, cap)
        sums = add_stir(1, lane, along, sums, constraints, points, inverse_h, slop, cap)
        sums = add_stir(2, lane, along, sums, constraints, points, inverse_h, slop, cap)
        mass, drive = add_stir(3, lane, along, sums, constraints, points, inverse_h, slop, cap)
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        stirs = active & (abs(mass * along + drive) > STILL * mass)
        scratch[lane + lane_scratch.COMMON_STIRS] = 1.0 if stirs else 0.0


def _add_point(
    point: int, lane: int, along: float, turn: Any, sums: Any, constraints: Array, points: Array,
    inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Add a point to the sums: how many take part, m sigma, m sigma b + iota J, iota, arms; squares
    of the ways from the first point, and of what the turn gives them along the normal. Return
    them, and 1 if it takes part.
    """
    count, mass, drive, softness, arm_a, arm_b, lengths, rises = sums
    row = lane + point * WIDTH
    impulse, bias, stiff, iota, takes_part = law(
        constraints, points, lane, row, along, inverse_h, slop, cap
    )
    share = 1.0 if takes_part else 0.0
    bias = bias if takes_part else 0.0
    stiff, iota = share * stiff, share * iota
    own_a, own_b = wide_lanes.arms(points, row)
    way = subtract(own_b, wide_lanes.vector(points, lane + contact_point.ARM_B))
    rise = dot(turn, way)
    added = (
        count + share,
        mass + stiff,
        drive + (stiff * bias + iota * impulse),
        softness + iota,
        add_scaled(arm_a, share, own_a),
        add_scaled(arm_b, share, own_b),
        lengths + share * dot(way, way),
        rises + share * (rise * rise),
    )
    return added, share


def _apply_to_point(
    point: int, lane: int, share: float, common: float, given: Any, points: Array
) -> Any:
    """
    Give a point its part. Return what all have been given so far: the sum, the same times their
    arms, the largest, and how many impulses would have become negative.
    """
    total, moment_a, moment_b, largest, clamped = given
    row = lane + point * WIDTH
    field = contact_point.RESTITUTION_NORMAL if BOUNCING else contact_point.NORMAL_IMPULSE
    impulse = points[row + field]
    takes_part = (share > 0.0) & (common != 0.0)  # else it keeps its bits
    # half of the warm start is still to come, before the motion, of what presses
    warm = points[row + contact_point.WARM_NORMAL] if SOFT else 0.0
    before = impulse - warm if impulse > 0.0 else 0.0
    now = before + common
    is_clamped = takes_part & (now < 0.0)
    now = now if now > 0.0 else 0.0
    now = now if takes_part else before
    new = now + warm if now > 0.0 else 0.0
    points[row + field] = new if takes_part else impulse
    change = now - before
    size = abs(change)
    arm_a, arm_b = wide_lanes.arms(points, row)
    return (
        total + change,
        add_scaled(moment_a, change, arm_a),
        add_scaled(moment_b, change, arm_b),
        size if size > largest else largest,
        clamped + (1.0 if is_clamped else 0.0),
    )


@inline
def _move_alike(sums: Any, turn: Any, points: Array, lane: int) -> Any:
    """
    Tell whether the turn gives the points that take part one velocity along the normal: they
    differ by less than those of a face that turns by TURNING.
    """
    count, _, _, _, _, arm, lengths, rises = sums
    share = 1.0 / (count if count > 1.0 else 1.0)
    first = wide_lanes.vector(points, lane + contact_point.ARM_B)
    middle = subtract(scale(share, arm), first)
    rise = dot(turn, middle)
    spread = lengths - count * dot(middle, middle)
    return rises - count * (rise * rise) < 0.5 * TURNING * TURNING * (spread - POINT)


@inline
def _change(
    sums: Any, along: float, normal: Any, spins: Any, of_centers: Any, constraints: Array,
    lane: int, turns: bool,
) -> Any:  # fmt: skip
    """Return the common change J' of a lane, 0 where it has none."""
    count, mass, drive, softness, arm_a, arm_b, _, _ = sums
    several = count > 1.0
    share = 1.0 / (count if several else 1.0)
    arm_a, arm_b = scale(share, arm_a), scale(share, arm_b)
    spin_a, spin_b = spins
    turning = subtract(cross(spin_b, arm_b), cross(spin_a, arm_a))
    velocity = dot(normal, add(of_centers, turning))
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
    stiffness = count * rate * mass + softness
    stirs = abs(mass * along + drive) > STILL * mass
    solvable = several & (stiffness > 0.0) & stirs
    return -(mass * velocity + drive) / (stiffness if solvable else 1.0) if solvable else 0.0


def _solve_in_common(
    lanes: int, starts: bool, constraints: Array, points: Array, scratch: Array, inverse_h: float,
    slop: float, cap: float,
) -> None:  # fmt: skip
    """
    Solve what the points of each lane have in common: of lanes that are visited, and whose points
    move alike.

    starts : False: only where an impulse was clamped the last time
    points : all points of each lane
    """
    for lane in range(lanes):
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        spins = wide_lanes.angular_velocities(constraints, scratch, lane, TURNS)
        turn = cross(normal, subtract(spins[1], spins[0]))
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        linear = wide_lanes.vector(scratch, lane + lane_scratch.IMPULSE)
        of_centers = wide_lanes.velocity_of_centers(constraints, scratch, lane)
        along = dot(normal, of_centers)
        nothing = (0.0, 0.0, 0.0)
        sums = (0.0, 0.0, 0.0, 0.0, nothing, nothing, 0.0, 0.0)
        given = (0.0, nothing, nothing, scratch[lane + lane_scratch.LARGEST_CHANGE], 0.0)
        sums, share_0 = add_point(
            0, lane, along, turn, sums, constraints, points, inverse_h, slop, cap
        )
        sums, share_1 = add_point(
            1, lane, along, turn, sums, constraints, points, inverse_h, slop, cap
        )
        sums, share_2 = add_point(
            2, lane, along, turn, sums, constraints, points, inverse_h, slop, cap
        )
        sums, share_3 = add_point(
            3, lane, along, turn, sums, constraints, points, inverse_h, slop, cap
        )
        alike = active & _move_alike(sums, turn, points, lane)
        alike = alike if starts else scratch[lane + lane_scratch.COMMON_CLAMPED] > 0.0
        common = _change(sums, along, normal, spins, of_centers, constraints, lane, TURNS)
        common = common if alike else 0.0
        given = apply_to_point(0, lane, share_0, common, given, points)
        given = apply_to_point(1, lane, share_1, common, given, points)
        given = apply_to_point(2, lane, share_2, common, given, points)
        total, moment_a, moment_b, largest, clamped = apply_to_point(
            3, lane, share_3, common, given, points
        )
        angular_a = wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A)
        angular_b = wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B)
        angular_a = subtract(angular_a, cross(moment_a, normal))
        angular_b = add(angular_b, cross(moment_b, normal))
        linear = add_scaled(linear, total, normal)
        wide_lanes.put_vector(scratch, lane + lane_scratch.IMPULSE, linear)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, angular_a)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, angular_b)
        scratch[lane + lane_scratch.LARGEST_CHANGE] = largest
        scratch[lane + lane_scratch.COMMON_CLAMPED] = clamped


def visit(kind: str, width: int, *, turns: bool) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """
    Make the kernels of a pass: which lanes stir, and what they have in common.

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
    for slot_name, source in (
        ('law', _law),
        ('add_stir', _add_stir),
        ('add_point', _add_point),
        ('apply_to_point', _apply_to_point),
    ):
        offered[slot_name] = specialise(source, name=name, inlined=True, offered=offered)
    return (
        specialise(_find_stirring, name=name, offered=offered),
        specialise(_solve_in_common, name=name, offered=offered),
    )
