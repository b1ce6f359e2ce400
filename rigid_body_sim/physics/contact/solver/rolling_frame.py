# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rolling frame of a rim: how the lowest points of a body of revolution go round its rim while
its axis turns over a plane or a side of a box that cannot move.

    n normal of the plane, a axis, p = n x a / |n x a| the level line across it, so that the lowest
    point of a rim of radius r lies at c a + r (a x p) from the centre of mass

The points of a manifold keep their places in the frame (a, p, a x p), whose turn from (a, p) to
(a', p') is one about p by the change of the tilt, then one about n by the change of the heading:

    q = (n S, C) (p s, c) = (s C p + c S n + s S n x p, c C)
        s, c : sine and cosine of half the change of the tilt, the angle from n to a
        S, C : the same of half the change of the heading, the angle from p to p' about n

So the point found at the start of a tick is the lowest one after each substep too, and its gap
that of the rim. Where the axis stands on the plane there is no heading: below FLAT, or where the
heading turns by a right angle or more, the points turn with the axis alone.

So a rim comes nearer, or parts, by more than its velocity, in second order: its lowest point goes
round. Before the motion, normals are therefore solved for the velocity with which the separation
will really change,

    n . D r / h   in place of   n . (omega x r)

D: the turn of the frame over the substep by the free rotation that the momenta of the visit give,
whose axis goes round L at the rate |L|/I_across. Else the rim would sink in by h^2/2 of that
acceleration in each substep and be pushed out again, with gains and losses of energy.

And what carries a body that goes round is a load which changes from substep to substep, and no
sink that follows slowly stands for it. Where one point of a rim carries all, its spring therefore
acts on what is beyond the load of the last substep, and rests without overlap:

    dJ = -m sigma (v_n + max(beta s, -pace)) - iota (J - J_last)
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import FLAT
from rigid_body_sim.physics.contact.solver import (
    constraint,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.state.blocks import rotate
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    divide,
    dot,
    load,
    scale,
    subtract,
)

# [-] what points follow in a substep: cosine of the largest change of the heading, and of half the
# largest change of the tilt
TURNED, TILTED = 0.0, 0.1

# [-] between a cylinder that stands and one that lies, one point of a rim carries all: least sine
# of the tilt, least cosine
STANDS, LEANS = 1e-3, 1e-2
TINY = 1e-30  # [-] cosine squared of half a turn: below, it is half a turn all the same


@inline
def _turn_of_frame(normal: Any, axis: Any, new_axis: Any) -> Any:
    """
    Return vector and scalar part of the turn of a rolling frame, and whether there is one.

    normal : of the plane;   axis, new_axis : before and after
    """
    level, new_level = cross(normal, axis), cross(normal, new_axis)
    sine, new_sine = math.sqrt(dot(level, level)), math.sqrt(dot(new_level, new_level))
    if not (sine > FLAT and new_sine > FLAT):
        return (0.0, 0.0, 0.0), 1.0, False
    level = level[0] / sine, level[1] / sine, level[2] / sine
    new_level = new_level[0] / new_sine, new_level[1] / new_sine, new_level[2] / new_sine
    heading = dot(level, new_level)
    if not heading > TURNED:
        return (0.0, 0.0, 0.0), 1.0, False
    heading_cosine = math.sqrt(0.5 * (1.0 + heading))
    heading_sine = 0.5 * dot(normal, cross(level, new_level)) / heading_cosine
    cosine, new_cosine = dot(normal, axis), dot(normal, new_axis)
    tilt_cosine = math.sqrt(max(0.5 * (1.0 + (cosine * new_cosine + sine * new_sine)), 0.0))
    if not tilt_cosine > TILTED:
        return (0.0, 0.0, 0.0), 1.0, False
    tilt_sine = 0.5 * (new_sine * cosine - sine * new_cosine) / tilt_cosine
    about_normal = add(
        scale(tilt_cosine * heading_sine, normal),
        scale(tilt_sine * heading_sine, cross(normal, level)),
    )
    turn = add(scale(tilt_sine * heading_cosine, level), about_normal)
    return turn, tilt_cosine * heading_cosine, True


@kernel
def turn_rims(used: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Let the points of the rims of a batch turn with the frame of their lowest points."""
    for lane in range(used):
        whose = constraints[lane + constraint.ROUNDNESS]
        if whose >= constraint.NOT_ROUND:
            continue
        of_a = whose == constraint.RIM_OF_A
        body = int(constraints[lane + (constraint.BODY_A if of_a else constraint.BODY_B)])
        axis = _axis(body, bodies)
        turn = load(bodies, body + solver_bodies.TURN)
        scalar = bodies[body + solver_bodies.TURN_SCALAR]
        new_axis = add(axis, wide_lanes.displacement_by_turn(turn, scalar, axis))
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        turn, scalar, goes_round = _turn_of_frame(normal, axis, new_axis)
        if goes_round:
            row = lane + (lane_scratch.TURN_A if of_a else lane_scratch.TURN_B)
            wide_lanes.put_vector(scratch, row, turn)
            row = lane + (lane_scratch.TURN_SCALAR_A if of_a else lane_scratch.TURN_SCALAR_B)
            scratch[row] = scalar


@inline
def _axis(body: int, bodies: Array) -> Any:
    """Axis of symmetry of a body at the start of the substep, world axes."""
    q = body + solver_bodies.SUBSTEP_ORIENTATION
    axis = load(bodies, body + solver_bodies.SYMMETRY_AXIS)
    return rotate(
        bodies[q], bodies[q + 1], bodies[q + 2], bodies[q + 3], axis[0], axis[1], axis[2]
    )


@inline
def _axis_after(h: float, axis: Any, inverse: Any, angular_momentum: Any) -> Any:
    """Axis of symmetry after a substep of free rotation: it goes round L at the rate |L|/I."""
    across = 0.5 * (
        inverse[0] + inverse[3] + inverse[5] - dot(axis, apply_symmetric(inverse, axis))
    )
    way = scale(h * across, angular_momentum)
    square = dot(way, way)
    angle = math.sqrt(square)
    by_sine = math.sin(angle) / angle if angle > 0.0 else 1.0
    half = 0.5 * angle
    by_cosine = math.sin(half) / half if angle > 0.0 else 1.0
    first = cross(way, axis)
    return add_scaled(
        add_scaled(axis, by_sine, first), 0.5 * by_cosine * by_cosine, cross(way, first)
    )


@kernel
def find_turns(
    used: int, inverse_h: float, constraints: Array, scratch: Array, bodies: Array
) -> bool:
    """Find how the rims of a batch will turn over the substep; tell whether there are any."""
    found = False
    for lane in range(used):
        whose = constraints[lane + constraint.ROUNDNESS]
        scratch[lane + lane_scratch.RIM_BENDS] = 0.0
        scratch[lane + lane_scratch.RIM_WHOSE] = 0.0
        scratch[lane + lane_scratch.RIM_ROLLS] = 0.0
        if whose >= constraint.NOT_ROUND:
            continue
        found = True
        of_a = whose == constraint.RIM_OF_A
        body = int(constraints[lane + (constraint.BODY_A if of_a else constraint.BODY_B)])
        inverse = wide_lanes.symmetric(
            constraints,
            lane + (constraint.INVERSE_INERTIA_A if of_a else constraint.INVERSE_INERTIA_B),
        )
        axis = _axis(body, bodies)
        angular_momentum = wide_lanes.vector(
            scratch,
            lane + (lane_scratch.ANGULAR_MOMENTUM_A if of_a else lane_scratch.ANGULAR_MOMENTUM_B),
        )
        new_axis = _axis_after(1.0 / inverse_h, axis, inverse, angular_momentum)
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        turn, scalar, goes_round = _turn_of_frame(normal, axis, new_axis)
        if not goes_round:
            scalar = math.sqrt(max(0.5 * (1.0 + dot(axis, new_axis)), TINY))
            turn = divide(scale(0.5, cross(axis, new_axis)), scalar)
        wide_lanes.put_vector(scratch, lane + lane_scratch.TURN_A, turn)
        scratch[lane + lane_scratch.TURN_SCALAR_A] = scalar
        wide_lanes.put_vector(
            scratch, lane + lane_scratch.CORE_SPIN_A, apply_symmetric(inverse, angular_momentum)
        )
        cosine = dot(normal, axis)
        square = cosine * cosine
        rolls = goes_round and LEANS * LEANS < square < 1.0 - STANDS * STANDS
        scratch[lane + lane_scratch.RIM_ROLLS] = 1.0 if rolls else 0.0
        scratch[lane + lane_scratch.RIM_WHOSE] = -1.0 if of_a else 1.0
    return found


@kernel
def find_bends(
    lanes: int, inverse_h: float, constraints: Array, points: Array, scratch: Array
) -> None:
    """Find how fast a point of each rim comes nearer beyond its velocity."""
    for lane in range(lanes):
        whose = scratch[lane + lane_scratch.RIM_WHOSE]
        arm_a, arm_b = wide_lanes.arms(points, lane)
        of_a = whose < 0.0
        arm = (
            arm_a[0] if of_a else arm_b[0],
            arm_a[1] if of_a else arm_b[1],
            arm_a[2] if of_a else arm_b[2],
        )
        turn = wide_lanes.vector(scratch, lane + lane_scratch.TURN_A)
        scalar = scratch[lane + lane_scratch.TURN_SCALAR_A]
        spin = wide_lanes.vector(scratch, lane + lane_scratch.CORE_SPIN_A)
        moved = scale(inverse_h, wide_lanes.displacement_by_turn(turn, scalar, arm))
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        scratch[lane + lane_scratch.RIM_BENDS] = (
            whose * dot(normal, subtract(moved, cross(spin, arm))) if whose != 0.0 else 0.0
        )
