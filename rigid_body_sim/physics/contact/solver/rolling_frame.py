# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rolling frame of a rim: how the lowest points of a body of revolution go round its rim while
its axis turns over a plane or a side of a box.

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

So a rim comes nearer, or parts, by more than its velocity: its lowest point goes round. That is
the bend of its point (`bends`), with D the turn of the frame over the substep by the free rotation
that the momenta of the visit give, whose axis goes round L at the rate |L|/I_across. Elsewhere D
is the turn of the axis alone: spin about it moves no surface.

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
from rigid_body_sim.physics.contact.solver.bends import bend_of_turn
from rigid_body_sim.physics.contact.solver_bodies import ABOUT_AXIS
from rigid_body_sim.physics.state.blocks import rotated
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    divide,
    dot,
    load,
    load_quaternion,
    scale,
    trace,
)

# [-] what points follow in a substep: cosine of the largest change of the heading, and of half the
# largest change of the tilt
TURNED, TILTED = 0.0, 0.1

# [-] between a cylinder that stands and one that lies, one point of a rim carries all: least sine
# of the tilt, least cosine
STANDS, LEANS = 1e-3, 1e-2


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
    orientation = load_quaternion(bodies, body + solver_bodies.SUBSTEP_ORIENTATION)
    return rotated(orientation, load(bodies, body + solver_bodies.SYMMETRY_AXIS))


@inline
def _axis_after(h: float, axis: Any, inverse: Any, angular_momentum: Any) -> Any:
    """Axis of symmetry after a substep of free rotation: it goes round L at the rate |L|/I."""
    across = 0.5 * (trace(inverse) - dot(axis, apply_symmetric(inverse, axis)))
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


@inline
def _bend(
    body: int, normal: Any, angular_momentum: Any, inverse: Any, is_rim: bool, inverse_h: float,
    bodies: Array,
) -> Any:  # fmt: skip
    """
    Return the bend of a body of revolution (`bends`), and whether it goes round its rim and one
    point of that carries all.
    """
    axis = _axis(body, bodies)
    new_axis = _axis_after(1.0 / inverse_h, axis, inverse, angular_momentum)
    turn, scalar, goes_round = _turn_of_frame(normal, axis, new_axis)
    if not (is_rim and goes_round):
        scalar = math.sqrt(max(0.5 * (1.0 + dot(axis, new_axis)), solver_bodies.HALF_TURN))
        turn = divide(scale(0.5, cross(axis, new_axis)), scalar)
    spin = apply_symmetric(inverse, angular_momentum)
    cosine = dot(normal, axis)
    square = cosine * cosine
    rolls = is_rim and goes_round and LEANS * LEANS < square < 1.0 - STANDS * STANDS
    return bend_of_turn(normal, turn, scalar, spin, inverse_h), rolls


@inline
def _turns_about(body: int, layer: float, bodies: Array) -> bool:
    """Tell whether a body of revolution meets with what is no layer about its axis."""
    return bodies[body + solver_bodies.SYMMETRY] == ABOUT_AXIS and layer == 0.0


@inline
def find_bends_of_lane(
    lane: int, inverse_h: float, constraints: Array, scratch: Array, bodies: Array
) -> None:
    """Find the bends of the bodies of revolution of one lane: see `find_bends`."""
    whose = constraints[lane + constraint.ROUNDNESS]
    scratch[lane + lane_scratch.RIM_ROLLS] = 0.0
    if whose > constraint.NOT_ROUND:
        return
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    for of_a in (True, False):
        body = int(constraints[lane + (constraint.BODY_A if of_a else constraint.BODY_B)])
        layer = lane + (constraint.RADIUS_A if of_a else constraint.RADIUS_B)
        if not _turns_about(body, constraints[layer], bodies):
            continue
        inverse = lane + (constraint.INVERSE_INERTIA_A if of_a else constraint.INVERSE_INERTIA_B)
        momentum = lane + (
            lane_scratch.ANGULAR_MOMENTUM_A if of_a else lane_scratch.ANGULAR_MOMENTUM_B
        )
        bend, rolls = _bend(
            body, normal, wide_lanes.vector(scratch, momentum),
            wide_lanes.symmetric(constraints, inverse),
            whose == (constraint.RIM_OF_A if of_a else constraint.RIM_OF_B), inverse_h, bodies,
        )  # fmt: skip
        place = lane + (lane_scratch.BEND_A if of_a else lane_scratch.BEND_B)
        wide_lanes.put_vector(scratch, place, bend)
        if rolls:
            scratch[lane + lane_scratch.RIM_ROLLS] = 1.0


@kernel
def find_bends(
    used: int, inverse_h: float, constraints: Array, scratch: Array, bodies: Array
) -> None:
    """Find the bends of the bodies of revolution of a batch, and which roll on a rim."""
    for lane in range(used):
        find_bends_of_lane(lane, inverse_h, constraints, scratch, bodies)
