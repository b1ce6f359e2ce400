# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The springs of a face: how soft the normals of a manifold are that is solved as a whole, or of a
surface of several.

A spring at each point gives way by what that point carries. Were they alike, a face whose points
do not lie evenly about its load (four of five corners, a body that hangs over some of its tiles)
would tilt while it is pressed, by 1e-7 rad in an impact, and the next one would turn it. But which
point carries how much is a matter of where points were put. So these have one spring, pressed by
what all of them carry together: with c = iota/(M sigma), and b as of each point (`solve`),

    v_n + b + c sum_j J_j = 0         M = 1/(1/m_A + 1/m_B)

over the points j that do not stand off. It gives way as a whole, and never tilts; the turn of the
bodies is rigid, and what overlaps unevenly comes out by the bias. Likewise the same share of all
impulses lasts until the next substep (`warm_start`).

M does not hang on the points, so nothing changes where another tile is reached, or one is left. A
body on a pivot is pressed as it turns: there M is the sum of the effective masses of the points.

It is the spring of a flat blow, where nothing was pressed in the last tick and nothing tilts, and
of what lies alone. Of a stack each point has a spring of its own as soon as it stands: else
nothing but the bias answers to a tilt, and what the passes leave of it grows from tick to tick
(three boxes that stand a few millimetres beside each other trembled at 5e-3 rad/s, ten at 0.3, and
never came to rest). They are an elastic foundation of the face: each is as stiff as the part for
which its point stands, u_i of `pressure_of_face`,

    m_i = u_i sum_j m_j         m_j: effective masses; of a surface of several: `surface_springs`

in place of m_i, its own effective mass, where the points are alike. So what presses evenly gives
way evenly, and a load that changes tilts nothing. Impulses are changed with the same weights
(`whole_manifold`): then what springs take is linear over the face, as the motion of rigid bodies.

Alike are the springs of several lines, whose load goes from tile to tile as they roll
(`softness`), of several faces on a pivot, and of what touches more than FEW others.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    far_points,
    lane_scratch,
    warm_start,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.softness import DEEP
from rigid_body_sim.physics.contact.solver.solve import OPEN
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    dot,
    load,
    scale,
    subtract,
)

FEW = 2  # [-] others that a body touches: what touches more is not solved as a whole
# [-] of the mean part for which a point stands: a corner that strikes first does not sink in as if
# nothing bore it
LEAST = 0.1
UNEVEN = 1.0 + 1e-6  # [-] of the mean part: up to it points are alike
# [-] of the approach, and [m/s]: what tilts by less, seen from its radius, meets flat
FLAT_SHARE, FLAT_SPEED = 1e-3, 1e-9


@inline
def leave_points_alone(lane: int, rows: Array) -> None:
    """Let each point of a constraint have a spring of its own."""
    rows[lane + constraint.SPRING_MASS] = 0.0
    rows[lane + constraint.MEAN_SPRING_MASS] = 0.0
    rows[lane + constraint.OTHERS_IMPULSE] = 0.0


@inline
def mass_of(inverse_mass: float) -> float:
    """Return M [kg] from 1/m_A + 1/m_B [1/kg]; 0 where each point has a spring of its own."""
    return 1.0 / inverse_mass if inverse_mass > 2.0 * solver_bodies.HELD else 0.0


@inline
def _velocity_and_spin(row: int, bodies: Array) -> Any:
    """Return velocity and angular velocity of a body."""
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    velocity = scale(bodies[row + solver_bodies.INVERSE_MASS], momentum)
    return velocity, solver_bodies.spin(row, bodies)


@inline
def meets_flat(lane: int, rows: Array, points: Array, bodies: Array) -> Any:
    """
    Tell whether two bodies do not tilt against each other as they meet, but for rounding: else a
    blow has no symmetry to keep.

    points : the first of the lane
    """
    velocity_a, spin_a = _velocity_and_spin(int(rows[lane + constraint.BODY_A]), bodies)
    velocity_b, spin_b = _velocity_and_spin(int(rows[lane + constraint.BODY_B]), bodies)
    arm_a, arm_b = wide_lanes.arms(points, lane)
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    of_b, of_a = add(velocity_b, cross(spin_b, arm_b)), add(velocity_a, cross(spin_a, arm_a))
    approach = abs(dot(normal, subtract(of_b, of_a)))
    tilt = cross(normal, subtract(spin_b, spin_a))
    size = rows[lane + constraint.DEEP] / DEEP
    most = FLAT_SHARE * approach + FLAT_SPEED
    return size * size * dot(tilt, tilt) <= most * most


@inline
def keep_for_blows(
    used: int, width: int, constraints: Array, points: Array, bodies: Array
) -> None:  # fmt: skip
    """Leave one spring to the lanes of a batch that lie alone, or are struck flat."""
    for lane in range(used):
        of_surface = constraints[lane + constraint.SURFACE] != constraint.OF_NO_SURFACE
        if of_surface or constraints[lane + constraint.ALONE] > 0.0:
            continue
        warm = 0.0
        for row in range(lane, lane + manifold.MOST * width, width):
            warm += points[row + contact_point.WARM_NORMAL]
        if warm > 0.0 or not meets_flat(lane, constraints, points, bodies):
            constraints[lane + constraint.SPRING_MASS] = 0.0


@inline
def find_masses(lanes: int, width: int, constraints: Array, points: Array) -> None:
    """Give each manifold of a batch one spring; what is part of a surface keeps that of it."""
    for lane in range(lanes):
        inverse_mass = (
            constraints[lane + constraint.INVERSE_MASS_A]
            + constraints[lane + constraint.INVERSE_MASS_B]
        )
        total, count, most = 0.0, 0.0, 0.0
        for row in range(lane, lane + manifold.MOST * width, width):
            # what a manifold has not may have a mass
            is_point = points[row + contact_point.INITIAL_SEPARATION] < far_points.NONE
            total += points[row + contact_point.NORMAL_MASS] if is_point else 0.0
            count += 1.0 if is_point else 0.0
            share = points[row + contact_point.SPRING_SHARE] if is_point else 0.0
            most = share if share > most else most
        moves = inverse_mass > 2.0 * solver_bodies.HELD
        mass = 1.0 / (inverse_mass if moves else 1.0) if moves else total
        of_none = constraints[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE
        before = constraints[lane + constraint.SPRING_MASS]
        constraints[lane + constraint.SPRING_MASS] = mass if of_none else before
        mean = total / (count if count > 0.0 else 1.0) if most > UNEVEN else 0.0
        before = constraints[lane + constraint.MEAN_SPRING_MASS]
        constraints[lane + constraint.MEAN_SPRING_MASS] = mean if of_none else before


@inline
def find_lasting_shares(lanes: int, width: int, constraints: Array, points: Array) -> None:
    """
    Find which share of the impulses of each lane of a batch is its load: of all points the same,
    else they would turn the bodies; what is part of a surface keeps its own.
    """
    for lane in range(lanes):
        impulse, warm = 0.0, 0.0
        for row in range(lane, lane + manifold.MOST * width, width):
            impulse += points[row + contact_point.NORMAL_IMPULSE]
            warm += points[row + contact_point.WARM_NORMAL]
        share = warm_start.share_of_load(impulse, warm, constraints[lane + constraint.SPRING_MASS])
        alone = constraints[lane + constraint.SURFACE] == constraint.OF_NO_SURFACE
        before = constraints[lane + constraint.LASTS]
        constraints[lane + constraint.LASTS] = share if alone else before


@inline
def impulse_of_lane(
    lane: int, count: int, width: int, rims: bool, points: Array, scratch: Array
) -> Any:  # fmt: skip
    """Return by which impulse the points of a lane that do not stand off press its spring."""
    total = 0.0
    for row in range(lane, lane + count * width, width):
        impulse = points[row + contact_point.NORMAL_IMPULSE]
        if rims:
            rolls = scratch[lane + lane_scratch.RIM_ROLLS]
            impulse -= 2.0 * rolls * points[row + contact_point.WARM_NORMAL]
        total += impulse if points[row + contact_point.SEPARATION] <= OPEN else 0.0
    return total


@inline
def find_impulses(
    lanes: int, count: int, width: int, rims: bool, constraints: Array, points: Array,
    scratch: Array,
) -> None:  # fmt: skip
    """Find by which impulse the spring of each lane of a batch is pressed, by count points."""
    for lane in range(lanes):
        scratch[lane + lane_scratch.SPRING_IMPULSE] = constraints[
            lane + constraint.OTHERS_IMPULSE
        ] + impulse_of_lane(lane, count, width, rims, points, scratch)
