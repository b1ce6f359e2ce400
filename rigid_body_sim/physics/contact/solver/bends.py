# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bends: by how much the motion of a point over a substep departs from its velocity.

A point at arm r of a body that turns moves on an arc. Its separation changes by n . D r, not by
h n . (omega x r), D the turn over the substep. Before the motion, normals are therefore solved for
the velocity with which the separation will really change,

    v_n + b,   b = n . D r / h - n . (omega x r) = r . (D^T n / h + omega x n) = r . beta

of B, less the same of A. Else what spins fast would sink in by h^2/2 of n . r'' in each substep,
and be pushed out again, with gains and losses of energy: centripetal alone, 15 rad/s and 10 cm
take 10 micrometres in a substep of 1 ms.

D is that of free rotation from the momenta of the visit, by the midpoint rule:

    theta = h (omega + h/2 I^-1 (L x omega)),  D: the turn about theta by |theta|

with tan(|theta|/2) = x (1 + x^2/3 + 2 x^4/15), x = |theta|/2. Bodies of revolution with rims turn
with their axis alone, or with the frame of their lowest points: `rolling_frame` writes their beta.
Of a ball or a capsule it is the core that turns: r = c + (layer + half the gap, where both move) n
moves by D c.

Two layers about cores have no bend (`curved_cores`): there the normal turns too, and the nearest
points run along the cores, far in a substep where these lie nearly side by side. Solved for the
distance that they will have, what is pressed at one end to hold up the other gains energy.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import add_scaled, cross, dot, scale


@inline
def turn_over(h: float, omega: Any, momentum: Any, inverse: int, rows: Array, turns: bool) -> Any:
    """
    Return vector and scalar part of the turn of a body over a substep of free rotation.

        inverse : where its inverse inertia begins in the rows
        turns   : see `wide_lanes.apply_inverse_inertia`
    """
    change = wide_lanes.apply_inverse_inertia(rows, inverse, turns, cross(momentum, omega))
    half = scale(0.5 * h, add_scaled(omega, 0.5 * h, change))
    square = dot(half, half)
    tangent = scale(1.0 + square * (1.0 / 3.0 + square * (2.0 / 15.0)), half)
    cosine = 1.0 / math.sqrt(1.0 + dot(tangent, tangent))
    return scale(cosine, tangent), cosine


@inline
def bend_of_turn(normal: Any, turn: Any, scalar: float, omega: Any, inverse_h: float) -> Any:
    """Return beta, see the module [1/s]; turn, scalar: of the quaternion of D."""
    back = wide_lanes.displacement_by_turn(scale(-1.0, turn), scalar, normal)
    return add_scaled(cross(omega, normal), inverse_h, back)


@inline
def find_bends_of_lane(
    lane: int, turns: bool, layered: bool, inverse_h: float, constraints: Array, scratch: Array
) -> None:  # fmt: skip
    """Find the bends of the bodies of one lane: see `find_bends`."""
    h = 1.0 / inverse_h
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
    turn_a, scalar_a = turn_over(
        h, omega_a,
        wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A),
        lane + constraint.INVERSE_INERTIA_A, constraints, turns,
    )  # fmt: skip
    turn_b, scalar_b = turn_over(
        h, omega_b,
        wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B),
        lane + constraint.INVERSE_INERTIA_B, constraints, turns,
    )  # fmt: skip
    share = 0.0 if constraints[lane + constraint.ROUNDNESS] > constraint.NOT_ROUND else 1.0
    bend_a = scale(share, bend_of_turn(normal, turn_a, scalar_a, omega_a, inverse_h))
    bend_b = scale(share, bend_of_turn(normal, turn_b, scalar_b, omega_b, inverse_h))
    wide_lanes.put_vector(scratch, lane + lane_scratch.BEND_A, bend_a)
    wide_lanes.put_vector(scratch, lane + lane_scratch.BEND_B, bend_b)
    if layered:
        # from the arms, which end midway where both bodies give way, to the cores
        radius_a = constraints[lane + constraint.RADIUS_A]
        radius_b = constraints[lane + constraint.RADIUS_B]
        gives_a = wide_lanes.gives_way_a(constraints, lane)
        gives_b = wide_lanes.gives_way_b(constraints, lane)
        along_a, along_b = dot(normal, bend_a), dot(normal, bend_b)
        midway = 0.5 if gives_a & gives_b else 0.0
        scratch[lane + lane_scratch.BEND] = radius_a * along_a + radius_b * along_b
        scratch[lane + lane_scratch.BEND_BY_GAP] = midway * (
            (along_a if radius_a > 0.0 else 0.0) + (along_b if radius_b > 0.0 else 0.0)
        )


@kernel
def find_bends(
    lanes: int, turns: bool, layered: bool, inverse_h: float, constraints: Array, scratch: Array
) -> None:
    """
    Find the bends of the bodies of a batch over the substep, zeros between layers about cores.

        turns   : whether the inertia of anything turns with it, or changes
        layered : whether anything is a ball or a capsule
    """
    for lane in range(lanes):
        find_bends_of_lane(lane, turns, layered, inverse_h, constraints, scratch)


@inline
def bend_of_point(row: int, lane: int, layered: bool, points: Array, scratch: Array) -> Any:
    """Return b of a point of a lane, see the module [m/s]; row: where it begins in the lane."""
    arm_a, arm_b = wide_lanes.arms(points, row)
    bend_a = wide_lanes.vector(scratch, lane + lane_scratch.BEND_A)
    bend_b = wide_lanes.vector(scratch, lane + lane_scratch.BEND_B)
    bend = dot(bend_b, arm_b) - dot(bend_a, arm_a)
    if layered:
        gap = points[row + contact_point.SEPARATION]
        bend += scratch[lane + lane_scratch.BEND] + gap * scratch[lane + lane_scratch.BEND_BY_GAP]
    return bend
