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
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import FLAT
from rigid_body_sim.physics.contact.solver import (
    constraint,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.state.blocks import rotate
from rigid_body_sim.physics.vectors import add, cross, dot, load, scale

# [-] what points follow in a substep: cosine of the largest change of the heading, and of half the
# largest change of the tilt
TURNED, TILTED = 0.0, 0.1


@kernel
def turn_rims(used: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Let the points of the rims of a batch turn with the frame of their lowest points."""
    for lane in range(used):
        whose = constraints[lane + constraint.ROUNDNESS]
        if whose >= constraint.NOT_ROUND:
            continue
        of_a = whose == constraint.RIM_OF_A
        body = int(constraints[lane + (constraint.BODY_A if of_a else constraint.BODY_B)])
        orientation = body + solver_bodies.SUBSTEP_ORIENTATION
        symmetry_axis = load(bodies, body + solver_bodies.SYMMETRY_AXIS)
        axis = rotate(
            bodies[orientation], bodies[orientation + 1], bodies[orientation + 2],
            bodies[orientation + 3],
            symmetry_axis[0], symmetry_axis[1], symmetry_axis[2],
        )  # fmt: skip
        turn = load(bodies, body + solver_bodies.TURN)
        scalar = bodies[body + solver_bodies.TURN_SCALAR]
        new_axis = add(axis, wide_lanes.displacement_by_turn(turn, scalar, axis))
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        level, new_level = cross(normal, axis), cross(normal, new_axis)
        sine, new_sine = math.sqrt(dot(level, level)), math.sqrt(dot(new_level, new_level))
        if not (sine > FLAT and new_sine > FLAT):
            continue
        level = level[0] / sine, level[1] / sine, level[2] / sine
        new_level = new_level[0] / new_sine, new_level[1] / new_sine, new_level[2] / new_sine
        heading = dot(level, new_level)
        if not heading > TURNED:
            continue
        heading_cosine = math.sqrt(0.5 * (1.0 + heading))
        heading_sine = 0.5 * dot(normal, cross(level, new_level)) / heading_cosine
        cosine, new_cosine = dot(normal, axis), dot(normal, new_axis)
        tilt_cosine = math.sqrt(max(0.5 * (1.0 + (cosine * new_cosine + sine * new_sine)), 0.0))
        if not tilt_cosine > TILTED:
            continue
        tilt_sine = 0.5 * (new_sine * cosine - sine * new_cosine) / tilt_cosine
        about_normal = add(
            scale(tilt_cosine * heading_sine, normal),
            scale(tilt_sine * heading_sine, cross(normal, level)),
        )
        wide_lanes.put_vector(
            scratch,
            lane + (lane_scratch.TURN_A if of_a else lane_scratch.TURN_B),
            add(scale(tilt_sine * heading_cosine, level), about_normal),
        )
        scratch[lane + (lane_scratch.TURN_SCALAR_A if of_a else lane_scratch.TURN_SCALAR_B)] = (
            tilt_cosine * heading_cosine
        )
