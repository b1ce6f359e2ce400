# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Rolling and torsional friction of one batch of contacts, lane by lane.

    twisting: J_s <- J_s - m_s omega_n,  |J_s| <= spin J_n
    rolling:  J_r <- J_r - m_r omega_t,  |J_r| <= roll J_n

omega = omega_B - omega_A; m: effective masses, 1/(n-entry) and 1/(largest eigenvalue of the
tangential block) of I_A^-1 + I_B^-1; spin, roll [m]: lengths, mu times the size of the patch for
instance.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import dot, subtract


@inline
def _apply(scratch: Array, lane: int, about: Any, frame: Any) -> None:
    """Give the bodies of a lane an angular impulse about the two tangents and the normal."""
    normal, tangent_1, tangent_2 = frame
    wide_lanes.apply_angular_impulse(
        scratch,
        lane,
        wide_lanes.angular_impulse_of(about[0], about[1], about[2], normal, tangent_1, tangent_2),
    )


@kernel
def apply_second_half(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """Give one point of each lane the second half of its angular warm start, after the motion."""
    for lane in range(lanes):
        warm = (
            points[lane + contact_point.WARM_ROLLING_1],
            points[lane + contact_point.WARM_ROLLING_2],
            points[lane + contact_point.WARM_TWIST],
        )
        _apply(scratch, lane, warm, wide_lanes.contact_frame(constraints, lane))


@kernel
def solve(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """Solve rolling and torsional friction of one point of each lane."""
    for lane in range(lanes):
        frame = wide_lanes.contact_frame(constraints, lane)
        normal, tangent_1, tangent_2 = frame
        omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane, True)
        omega = subtract(omega_b, omega_a)
        press = points[lane + contact_point.NORMAL_IMPULSE]
        old_1 = points[lane + contact_point.ROLLING_IMPULSE_1]
        old_2 = points[lane + contact_point.ROLLING_IMPULSE_2]
        old_twist = points[lane + contact_point.TWIST_IMPULSE]
        rolling_mass = constraints[lane + constraint.ROLLING_MASS]
        new_1 = old_1 - rolling_mass * dot(tangent_1, omega)
        new_2 = old_2 - rolling_mass * dot(tangent_2, omega)
        new_1, new_2 = wide_lanes.clamp_to_disc(
            new_1, new_2, constraints[lane + constraint.ROLLING_FRICTION] * press
        )
        limit = constraints[lane + constraint.TORSIONAL_FRICTION] * press
        twist_mass = constraints[lane + constraint.TWIST_MASS]
        twist = wide_lanes.clamp(old_twist - twist_mass * dot(normal, omega), limit)
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        new_1, new_2, twist = (new_1, new_2, twist) if active else (old_1, old_2, old_twist)
        _apply(scratch, lane, (new_1 - old_1, new_2 - old_2, twist - old_twist), frame)
        points[lane + contact_point.ROLLING_IMPULSE_1] = new_1
        points[lane + contact_point.ROLLING_IMPULSE_2] = new_2
        points[lane + contact_point.TWIST_IMPULSE] = twist


@kernel
def limit(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Bring the angular impulses of the last substep within what presses now; half of the warm start
    is still to come, of what presses.
    """
    for lane in range(lanes):
        press = points[lane + contact_point.NORMAL_IMPULSE]
        old_1 = points[lane + contact_point.ROLLING_IMPULSE_1]
        old_2 = points[lane + contact_point.ROLLING_IMPULSE_2]
        old_twist = points[lane + contact_point.TWIST_IMPULSE]
        old_warm_1 = points[lane + contact_point.WARM_ROLLING_1]
        old_warm_2 = points[lane + contact_point.WARM_ROLLING_2]
        old_warm_twist = points[lane + contact_point.WARM_TWIST]
        new_1, new_2 = wide_lanes.clamp_to_disc(
            old_1, old_2, constraints[lane + constraint.ROLLING_FRICTION] * press
        )
        twist = wide_lanes.clamp(
            old_twist, constraints[lane + constraint.TORSIONAL_FRICTION] * press
        )
        presses = press > 0.0
        warm_1 = old_warm_1 if presses else 0.0
        warm_2 = old_warm_2 if presses else 0.0
        warm_twist = old_warm_twist if presses else 0.0
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        new_1, new_2, twist = (new_1, new_2, twist) if active else (old_1, old_2, old_twist)
        warm_1 = warm_1 if active else old_warm_1
        warm_2 = warm_2 if active else old_warm_2
        warm_twist = warm_twist if active else old_warm_twist
        change = (
            (new_1 - warm_1) - (old_1 - old_warm_1),
            (new_2 - warm_2) - (old_2 - old_warm_2),
            (twist - warm_twist) - (old_twist - old_warm_twist),
        )
        _apply(scratch, lane, change, wide_lanes.contact_frame(constraints, lane))
        points[lane + contact_point.ROLLING_IMPULSE_1] = new_1
        points[lane + contact_point.ROLLING_IMPULSE_2] = new_2
        points[lane + contact_point.TWIST_IMPULSE] = twist
        points[lane + contact_point.WARM_ROLLING_1] = warm_1
        points[lane + contact_point.WARM_ROLLING_2] = warm_2
        points[lane + contact_point.WARM_TWIST] = warm_twist
