# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Velocities of approach, from which restitution follows: those with which two surfaces that are a
separation s apart would meet,

    v_n'^2 = v_n^2 - 2 s'' s        for v_n < 0, s > 0; else v_n

With it a ball bounces to the height that its energy allows, wherever in the tick it lands.

s'' is the acceleration of the separation, not that of two material points. With witness points p
and normal n from A to B, s = n . (p_B - p_A), and

    s'' = n . (a_B - a_A) + 2 n' . (v_B - v_A) - (s + R_A + R_B) |n'|^2

    v, a : of the core of each body below the witness point; R: layer of a ball or a capsule about
           its core
    n'   : rate of the normal, across it: of two cores that of the line of their nearest points,
           (v_B - v_A)_t / (s + R_A + R_B), but along a core that is a line with the axis a as that
           turns, n' . a = a . (omega x n); of a face that of the body whose face it is, omega x n
           (of two faces the one that turns less); else none: it stays for the tick

A core turns as its body does, of a body of revolution with its axis c alone: spin about it moves
no surface. With c' = omega x c, c'' = alpha x c + omega x (omega x c):

    angular velocity c x c', acceleration c x c'';  of a ball about its centre none

The lowest point of a rim also goes round it as the heading of the axis turns, at the rate omega_n
of the reduced omega over the squared sine of the tilt, which lowers it: with q the arm from the
axis to the point,

    s'' += (n . c)^2 (omega_n / sin^2)^2 n . q_B,  of A: -n . q_A

Source: second derivative of the support function h(n, t) of each body at its normal; the terms of
the curvature are those of Montana, Int. J. Robotics Research 7 (1988) 17. Not seen is how s''
itself changes until the surfaces meet: of what tumbles by a large angle in a tick.
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
    contact_point,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    scale,
    subtract,
)


@inline
def _turning_of_core(body: int, bodies: Array) -> Any:
    """Angular velocity and acceleration with which the surface of a body turns, see the module."""
    omega = solver_bodies.surface_spin(body, bodies)
    alpha = load(bodies, body + solver_bodies.FREE_ANGULAR_ACCELERATION)
    kind = bodies[body + solver_bodies.SYMMETRY]
    if kind == solver_bodies.CENTRED_BALL:
        alpha = (0.0, 0.0, 0.0)
    elif kind == solver_bodies.ABOUT_AXIS:
        axis = solver_bodies.start_axis(body, bodies)
        spin = solver_bodies.spin(body, bodies)
        change = add(cross(alpha, axis), cross(spin, cross(spin, axis)))
        alpha = cross(axis, change)
    return omega, alpha


@kernel
def gather_accelerations(used: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Fetch how the cores of the bodies of a batch move and turn without contact."""
    for lane in range(used):
        body_a = int(constraints[lane + constraint.BODY_A])
        body_b = int(constraints[lane + constraint.BODY_B])
        linear_a = load(bodies, body_a + solver_bodies.FREE_ACCELERATION)
        linear_b = load(bodies, body_b + solver_bodies.FREE_ACCELERATION)
        omega_a, alpha_a = _turning_of_core(body_a, bodies)
        omega_b, alpha_b = _turning_of_core(body_b, bodies)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ACCELERATION_A, linear_a)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ACCELERATION_B, linear_b)
        wide_lanes.put_vector(scratch, lane + lane_scratch.CORE_SPIN_A, omega_a)
        wide_lanes.put_vector(scratch, lane + lane_scratch.CORE_SPIN_B, omega_b)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_ACCELERATION_A, alpha_a)
        wide_lanes.put_vector(scratch, lane + lane_scratch.ANGULAR_ACCELERATION_B, alpha_b)
        axis, rounding = (0.0, 0.0, 0.0), 0.0
        whose = constraints[lane + constraint.ROUNDNESS]
        if whose < constraint.NOT_ROUND:
            of_a = whose == constraint.RIM_OF_A
            axis = solver_bodies.start_axis(body_a if of_a else body_b, bodies)
            normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
            cosine = dot(normal, axis)
            square = 1.0 - cosine * cosine
            if square > FLAT * FLAT:
                heading = dot(omega_a if of_a else omega_b, normal) / square
                rounding = cosine * cosine * heading * heading
        wide_lanes.put_vector(scratch, lane + lane_scratch.RIM_AXIS, axis)
        scratch[lane + lane_scratch.ROUNDING] = rounding


@inline
def _acceleration(linear: Any, angular: Any, omega: Any, arm: Any) -> Any:
    """Acceleration of a point at an arm r: a + (alpha x r + omega x (omega x r))."""
    return add(linear, add(cross(angular, arm), cross(omega, cross(omega, arm))))


@inline
def _turning_of_line(across: Any, by_line: float, lines: Any, omegas: Any, normal: Any) -> Any:
    """
    Return the rate n' of the line between two cores, see the module; lines: their axes, or zeros.
    """
    line_a, line_b = lines
    cosine = dot(line_a, line_b)
    rate_a = dot(line_a, cross(omegas[0], normal))
    rate_b = dot(line_b, cross(omegas[1], normal))
    square = 1.0 - cosine * cosine
    along_a, along_b = (rate_a - cosine * rate_b) / square, (rate_b - cosine * rate_a) / square
    free_a = (dot(across, line_a) - cosine * dot(across, line_b)) / square
    free_b = (dot(across, line_b) - cosine * dot(across, line_a)) / square
    free = subtract(across, add(scale(free_a, line_a), scale(free_b, line_b)))
    return add(scale(by_line, free), add(scale(along_a, line_a), scale(along_b, line_b)))


@inline
def _separation_acceleration(
    constraints: Array, scratch: Array, lane: int, normal: Any, velocity: Any, arms: Any,
    separation: float,
) -> Any:  # fmt: skip
    """
    Find s'' of a point, see the module [m/s^2].

    velocity : of the centre of B from that of A [m/s]
    arms     : of A and B
    """
    both = wide_lanes.gives_way_a(constraints, lane) & wide_lanes.gives_way_b(constraints, lane)
    # both arms end midway where both bodies give way, else on the surface of the one that does
    midway = 0.5 * separation if both else 0.0
    radius_a = constraints[lane + constraint.RADIUS_A]
    radius_b = constraints[lane + constraint.RADIUS_B]
    arm_a = add_scaled(arms[0], -(radius_a + midway), normal)
    arm_b = add_scaled(arms[1], radius_b + midway, normal)
    omega_a = wide_lanes.vector(scratch, lane + lane_scratch.CORE_SPIN_A)
    omega_b = wide_lanes.vector(scratch, lane + lane_scratch.CORE_SPIN_B)
    acceleration_a = _acceleration(
        wide_lanes.vector(scratch, lane + lane_scratch.ACCELERATION_A),
        wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_ACCELERATION_A),
        omega_a,
        arm_a,
    )
    acceleration_b = _acceleration(
        wide_lanes.vector(scratch, lane + lane_scratch.ACCELERATION_B),
        wide_lanes.vector(scratch, lane + lane_scratch.ANGULAR_ACCELERATION_B),
        omega_b,
        arm_b,
    )
    velocity = add(velocity, subtract(cross(omega_b, arm_b), cross(omega_a, arm_a)))
    across = add_scaled(velocity, -dot(normal, velocity), normal)
    distance = separation + radius_a + radius_b
    balls = (constraints[lane + constraint.ROUNDNESS] == constraint.TWO_BALLS) | (
        scratch[lane + lane_scratch.CURVED] > 0.0
    )
    faces = constraints[lane + constraint.FACES]
    rate_a, rate_b = cross(omega_a, normal), cross(omega_b, normal)
    calmer_a = dot(rate_a, rate_a) <= dot(rate_b, rate_b)
    of_a = (faces == constraint.FACE_OF_A) | ((faces == constraint.TWO_FACES) & calmer_a)
    of_b = (faces == constraint.FACE_OF_B) | ((faces == constraint.TWO_FACES) & (not calmer_a))
    by_line = 1.0 / distance if balls & (distance > 0.0) else 0.0
    share_a = 1.0 if of_a else 0.0
    share_b = 1.0 if of_b else 0.0
    line_a = wide_lanes.vector(scratch, lane + lane_scratch.LINE_A)
    line_b = wide_lanes.vector(scratch, lane + lane_scratch.LINE_B)
    of_cores = _turning_of_line(across, by_line, (line_a, line_b), (omega_a, omega_b), normal)
    turns = add_scaled(add_scaled(of_cores, share_a, rate_a), share_b, rate_b)
    axis = wide_lanes.vector(scratch, lane + lane_scratch.RIM_AXIS)
    of_rim_a = constraints[lane + constraint.ROUNDNESS] == constraint.RIM_OF_A
    low = dot(normal, axis)
    level_a = dot(normal, arm_a) - low * dot(axis, arm_a)
    level_b = dot(normal, arm_b) - low * dot(axis, arm_b)
    return (
        dot(normal, subtract(acceleration_b, acceleration_a))
        + (2.0 * dot(turns, across) - distance * dot(turns, turns))
        + scratch[lane + lane_scratch.ROUNDING] * (-level_a if of_rim_a else level_b)
    )


@kernel
def approach_velocities(
    lanes: int, threshold: float, constraints: Array, points: Array, scratch: Array
) -> None:
    """Find the velocity of approach of one point of each lane; 0 for what does not bounce."""
    for lane in range(lanes):
        constraints[lane + constraint.BOUNCE_SPEED] = threshold
        normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, True)
        normal_velocity = dot(normal, velocity)
        separation = points[lane + contact_point.INITIAL_SEPARATION]
        of_centers = wide_lanes.vector(scratch, lane + lane_scratch.RELATIVE_VELOCITY)
        square = normal_velocity * normal_velocity - 2.0 * separation * _separation_acceleration(
            constraints, scratch, lane, normal, of_centers, (arm_a, arm_b), separation
        )
        is_ahead = (normal_velocity < 0.0) & (separation > 0.0)
        met = -math.sqrt(square if square > 0.0 else 0.0) if is_ahead else normal_velocity
        points[lane + contact_point.APPROACH_VELOCITY] = met if met < -threshold else 0.0
