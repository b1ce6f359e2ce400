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
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.solve import OPEN
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    scale,
    subtract,
)

# [m/s] velocity along the normal, with the push-out, below which nothing is solved in common: then
# the points differ by less than this
STILL = 1e-9

# [rad/s] turn of the two bodies against each other, across the normal, above which nothing is
# solved in common: there is no symmetry to keep. A stack that trembles turns by less, and comes to
# rest ten times as fast by what its points have in common.
TURNING = 1.0

SOFT = slot('[-] whether overlaps are soft, before the motion')
BOUNCING = slot('[-] whether it is the impulse of restitution')
law = slot(
    'kernel (constraints, points, scratch, lane, ...): J, b, sigma, iota, and who takes part'
)


@kernel
def begin(lanes: int, constraints: Array, scratch: Array) -> None:
    """Find the lanes that are visited, and whose bodies do not turn against each other."""
    for lane in range(lanes):
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane)
        turn = cross(normal, subtract(omega_b, omega_a))
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        alike = active & (dot(turn, turn) < TURNING * TURNING)
        scratch[lane + lane_scratch.COMMON_ALIKE] = 1.0 if alike else 0.0


@kernel
def any_alike(used: int, scratch: Array) -> bool:
    """Tell whether the points of some lane are alike: see `begin`."""
    alike = 0.0
    for lane in range(used):
        alike += scratch[lane + lane_scratch.COMMON_ALIKE]
    return alike > 0.0


@inline
def _stirs(scratch: Array, lane: int) -> Any:
    """Tell whether what a lane has in common is not at rest, given the sums of its points."""
    mass = scratch[lane + lane_scratch.COMMON_MASS]
    drive = mass * scratch[lane + lane_scratch.COMMON_ALONG]
    drive += scratch[lane + lane_scratch.COMMON_DRIVE]
    return (scratch[lane + lane_scratch.COMMON_ALIKE] > 0.0) & (abs(drive) > STILL * mass)


@kernel
def stirs(used: int, scratch: Array) -> bool:
    """Tell whether what some lane has in common is not at rest."""
    found = False
    for lane in range(used):
        found = found or _stirs(scratch, lane)
    return found


@kernel
def rests(used: int, scratch: Array) -> bool:
    """
    Tell whether the first point of each lane whose points are alike is pressed, and at rest. Such
    lanes stand still, whatever lies beside them.
    """
    found = False
    for lane in range(used):
        pressed = scratch[lane + lane_scratch.COMMON_MASS] > 0.0
        alike = scratch[lane + lane_scratch.COMMON_ALIKE] > 0.0
        goes_on = alike and (not pressed or _stirs(scratch, lane))
        scratch[lane + lane_scratch.COMMON_ALIKE] = 1.0 if goes_on else 0.0
        found = found or goes_on
    return not found


@kernel
def is_clamped(used: int, scratch: Array) -> bool:
    """
    Tell whether some impulse would have become negative: then the sums are others. Let the other
    lanes stand still.
    """
    found = False
    for lane in range(used):
        clamped = scratch[lane + lane_scratch.COMMON_CLAMPED] > 0.0
        scratch[lane + lane_scratch.COMMON_ALIKE] = 1.0 if clamped else 0.0
        found = found or clamped
    return found


@kernel
def clear(lanes: int, constraints: Array, scratch: Array) -> None:
    """Begin the sums of a batch, with the velocity of the centres along the normal."""
    for lane in range(lanes):
        for row in range(
            lane + lane_scratch.COMMON_ARM_A, lane + lane_scratch.COMMON_ALIKE, LANES
        ):
            scratch[row] = 0.0
        inverse_mass = (
            constraints[lane + constraint.INVERSE_MASS_A]
            + constraints[lane + constraint.INVERSE_MASS_B]
        )
        velocity = add_scaled(
            wide_lanes.vector(scratch, lane + lane_scratch.RELATIVE_VELOCITY),
            inverse_mass,
            wide_lanes.vector(scratch, lane + lane_scratch.IMPULSE),
        )
        scratch[lane + lane_scratch.COMMON_ALONG] = dot(
            wide_lanes.vector(constraints, lane + constraint.NORMAL), velocity
        )


def _law(
    constraints: Array, points: Array, scratch: Array, lane: int, inverse_h: float, slop: float,
    cap: float,
) -> Any:  # fmt: skip
    """
    Return what `solve` has for a point: J, b, sigma, iota, how iota J changes with J, and whether
    it takes part.
    """
    separation = points[lane + contact_point.SEPARATION]
    is_open = separation > OPEN
    mass_scale, impulse_scale, softness = 1.0, 0.0, 0.0
    bounces = constraints[lane + constraint.RESTITUTION]
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
        depth = separation + slop
        depth = depth if depth < 0.0 else 0.0
        soft = constraints[lane + constraint.BIAS_RATE] * depth
        stiff = (
            constraints[lane + constraint.MASS_SCALE] * points[lane + contact_point.NORMAL_MASS]
        )
        bears = (
            constraints[lane + constraint.IMPULSE_SCALE]
            * impulse
            / (stiff if stiff > 0.0 else 1.0)
        )
        is_deep = depth < -constraints[lane + constraint.DEEP]
        fastest = -bears - (cap if is_deep else constraints[lane + constraint.PACE])
        follows = soft > fastest
        soft = soft if follows else fastest
        bias = separation * inverse_h if is_open else soft
        mass_scale = 1.0 if is_open else constraints[lane + constraint.MASS_SCALE]
        impulse_scale = 0.0 if is_open else constraints[lane + constraint.IMPULSE_SCALE]
        softness = impulse_scale if follows else 0.0
        may = True
    else:
        impulse = points[lane + contact_point.NORMAL_IMPULSE]
        is_new = points[lane + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        may = not (is_open & (bounces > 0.0) & (impulse <= 0.0))
    along = scratch[lane + lane_scratch.COMMON_ALONG]
    active = scratch[lane + lane_scratch.ACTIVE] > 0.0
    takes_part = may & active & ((impulse > 0.0) | (along + bias < 0.0))
    return impulse, bias, mass_scale, impulse_scale, softness, takes_part


def _add_point(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float, slop: float,
    cap: float,
) -> None:  # fmt: skip
    """Add one point of each lane to the sums."""
    for lane in range(lanes):
        impulse, bias, mass_scale, impulse_scale, softness, takes_part = law(
            constraints, points, scratch, lane, inverse_h, slop, cap
        )
        share = 1.0 if takes_part else 0.0
        bias = bias if takes_part else 0.0
        mass = share * mass_scale * points[lane + contact_point.NORMAL_MASS]
        arm_a, arm_b = wide_lanes.arms(points, lane)
        row_a, row_b = lane + lane_scratch.COMMON_ARM_A, lane + lane_scratch.COMMON_ARM_B
        sum_a = add(wide_lanes.vector(scratch, row_a), scale(share, arm_a))
        sum_b = add(wide_lanes.vector(scratch, row_b), scale(share, arm_b))
        wide_lanes.put_vector(scratch, row_a, sum_a)
        wide_lanes.put_vector(scratch, row_b, sum_b)
        scratch[lane + lane_scratch.COMMON_COUNT] += share
        scratch[lane + lane_scratch.COMMON_MASS] += mass
        scratch[lane + lane_scratch.COMMON_DRIVE] += mass * bias + share * impulse_scale * impulse
        scratch[lane + lane_scratch.COMMON_SOFTNESS] += share * softness


@kernel
def solve(lanes: int, constraints: Array, scratch: Array) -> None:
    """Find the common change J' of each lane."""
    for lane in range(lanes):
        count = scratch[lane + lane_scratch.COMMON_COUNT]
        several = count > 1.0
        share = 1.0 / count if several else 0.0
        arm_a = scale(share, wide_lanes.vector(scratch, lane + lane_scratch.COMMON_ARM_A))
        arm_b = scale(share, wide_lanes.vector(scratch, lane + lane_scratch.COMMON_ARM_B))
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        velocity = dot(
            normal, wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b)
        )
        inverse_a = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_A)
        inverse_b = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_B)
        moment_a, moment_b = cross(arm_a, normal), cross(arm_b, normal)
        rate = (
            constraints[lane + constraint.INVERSE_MASS_A]
            + constraints[lane + constraint.INVERSE_MASS_B]
            + dot(moment_a, apply_symmetric(inverse_a, moment_a))
            + dot(moment_b, apply_symmetric(inverse_b, moment_b))
        )
        mass = scratch[lane + lane_scratch.COMMON_MASS]
        stiffness = count * rate * mass + scratch[lane + lane_scratch.COMMON_SOFTNESS]
        drive = mass * velocity + scratch[lane + lane_scratch.COMMON_DRIVE]
        solvable = several & (stiffness > 0.0) & _stirs(scratch, lane)
        scratch[lane + lane_scratch.COMMON_CHANGE] = (
            -drive / (stiffness if solvable else 1.0) if solvable else 0.0
        )


def _apply_to_point(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float, slop: float,
    cap: float,
) -> None:  # fmt: skip
    """Give one point of each lane its part."""
    for lane in range(lanes):
        impulse, _, _, _, _, takes_part = law(
            constraints, points, scratch, lane, inverse_h, slop, cap
        )
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        common = scratch[lane + lane_scratch.COMMON_CHANGE]
        takes_part = takes_part & (common != 0.0)  # else it keeps its bits
        # half of the warm start is still to come, before the motion, of what presses
        warm = points[lane + contact_point.WARM_NORMAL] if SOFT and not BOUNCING else 0.0
        before = impulse - warm if impulse > 0.0 else 0.0
        now = before + common
        clamped = takes_part & (now < 0.0)
        scratch[lane + lane_scratch.COMMON_CLAMPED] += 1.0 if clamped else 0.0
        now = now if now > 0.0 else 0.0
        now = now if takes_part else before
        change = now - before
        new = now + warm if now > 0.0 else 0.0
        new = new if takes_part else impulse
        if BOUNCING:
            points[lane + contact_point.RESTITUTION_NORMAL] = new
        else:
            points[lane + contact_point.NORMAL_IMPULSE] = new
        size = abs(change)
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, scale(change, normal))


def visits(*, soft: bool, bouncing: bool) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Make the kernels that add a point and apply its part, of one of the three passes."""
    name = 'bouncing' if bouncing else 'soft' if soft else 'relaxed'
    offered: dict[str, Any] = {'SOFT': soft, 'BOUNCING': bouncing}
    offered['law'] = specialise(_law, name=name, inlined=True, offered=offered)
    return (
        specialise(_add_point, name=name, offered=offered),
        specialise(_apply_to_point, name=name, offered=offered),
    )
