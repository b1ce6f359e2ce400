# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Restitution of one batch of contacts, lane by lane: Newton's law of impact after the last substep.

    J <- J - m (v_n + e v_approach),  J >= 0,  for contacts that pressed in this tick

v_approach: see `prepare`. Contacts that press but do not bounce keep v_n >= 0, if something that
bounces presses on their bodies; others take no part (`islands.bouncing`). Friction acts on
the impulse of restitution: with that of the substeps it adds up to Coulomb's law for the whole.
What bounds the energy that comes back is `energy.restitution_bound`.

Where friction of two contacts presses each on the other by more than it got (a ball in a corner,
the product of the two coefficients above 1), passes never settle: the wall asks for its speed, the
ground for its own, and each takes what the other gave. Then what holds has the last word: v_n >= 0
by normal impulses alone, which take energy.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import kernel, slot, specialise
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import dot, scale

RUBS = slot('[-] whether friction is that of the points, not of a patch of them')
SETTLED = 1e-12  # [-] of what a point gives in this tick: what changes by less has settled


def _apply_restitution(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Solve one point of each lane after the last substep: v_n <- -e v_approach where it bounces,
    v_n >= 0 elsewhere; friction on the impulse of restitution.
    """
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, True)
        approach = points[lane + contact_point.APPROACH_VELOCITY]
        target = -constraints[lane + constraint.RESTITUTION] * approach if approach < 0.0 else 0.0
        old = points[lane + contact_point.RESTITUTION_NORMAL]
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        new = old - points[lane + contact_point.NORMAL_MASS] * (dot(normal, velocity) - target)
        new = new if new > 0.0 else 0.0
        pressure = (
            points[lane + contact_point.LARGEST_NORMAL_IMPULSE]
            + points[lane + contact_point.NORMAL_IMPULSE]
        )
        takes_part = constraints[lane + constraint.BOUNCES] > 0.0
        new = new if (pressure > 0.0) & takes_part else 0.0
        change = new - old
        size = abs(change)
        if RUBS:
            old_1 = points[lane + contact_point.RESTITUTION_TANGENT_1]
            old_2 = points[lane + contact_point.RESTITUTION_TANGENT_2]
            tangent_mass = points[lane + contact_point.TANGENT_MASS]
            slip_1 = dot(tangent_1, velocity) - constraints[lane + constraint.SLIP_LEFT_1]
            slip_2 = dot(tangent_2, velocity) - constraints[lane + constraint.SLIP_LEFT_2]
            new_1 = old_1 - tangent_mass * (
                slip_1 + points[lane + contact_point.CROSS_TERM_1] * change
            )
            new_2 = old_2 - tangent_mass * (
                slip_2 + points[lane + contact_point.CROSS_TERM_2] * change
            )
            new_1, new_2 = wide_lanes.clamp_to_disc(
                new_1, new_2, constraints[lane + constraint.FRICTION] * new
            )
            size += abs(new_1 - old_1) + abs(new_2 - old_2)
            # what is settled keeps its bits, however long others take
            changes = size > SETTLED * (pressure + new)
            new, new_1, new_2 = (new, new_1, new_2) if changes else (old, old_1, old_2)
            impulse = wide_lanes.impulse_of(
                new - old, new_1 - old_1, new_2 - old_2, normal, tangent_1, tangent_2
            )
            points[lane + contact_point.RESTITUTION_TANGENT_1] = new_1
            points[lane + contact_point.RESTITUTION_TANGENT_2] = new_2
        else:
            changes = size > SETTLED * (pressure + new)
            new = new if changes else old
            impulse = scale(new - old, normal)
        size = size if changes else 0.0
        points[lane + contact_point.RESTITUTION_NORMAL] = new
        scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


@kernel
def hold(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """Keep v_n >= 0 at one point of each lane, if it takes part and does not bounce."""
    for lane in range(lanes):
        normal, _, _ = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, True)
        speed = dot(normal, velocity)
        more = -points[lane + contact_point.NORMAL_MASS] * (speed if speed < 0.0 else 0.0)
        old = points[lane + contact_point.RESTITUTION_NORMAL]
        pressure = (
            points[lane + contact_point.LARGEST_NORMAL_IMPULSE]
            + points[lane + contact_point.NORMAL_IMPULSE]
        )
        bounces = (points[lane + contact_point.APPROACH_VELOCITY] < 0.0) & (
            constraints[lane + constraint.RESTITUTION] > 0.0
        )
        holds = (pressure > 0.0) & (constraints[lane + constraint.BOUNCES] > 0.0) & (not bounces)
        more = more if holds & (more > SETTLED * (pressure + old)) else 0.0
        points[lane + contact_point.RESTITUTION_NORMAL] = old + more
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        scratch[lane + lane_scratch.LARGEST_CHANGE] = more if more > largest else largest
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, scale(more, normal))


def visit(*, rubs: bool) -> Callable[..., Any]:
    """Make the kernel that applies restitution to a point; rubs: with its friction."""
    return specialise(_apply_restitution, name='rubs' if rubs else 'smooth', RUBS=rubs)
