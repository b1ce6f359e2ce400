# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The free motion of a collider within a tick: where it stands at a time if nothing touches it.

    centre of mass  r + v t + a t^2 / 2
    turn            exp(w t + alpha t^2 / 2),  alpha = -I^-1 (w x L)

What a body of revolution turns about its own axis leaves its shape where it is: of such a body
only the motion of the axis is taken,

    w' = w - (w . u) u,   alpha' = alpha - (alpha . u) u + (w . u) u x w'     u : the axis

and of a ball about its centre of mass none.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    load,
    load_symmetric,
    negate,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]

NOWHERE = (0.0, 0.0, 0.0)
WANDER = 0.25  # [-] of |w| |alpha| t^3: what its third order turns at most [rad]


class FreeMotion(NamedTuple):
    """
    The motion of one collider; world axes, three numbers each but for the last.

    center       : centre of mass of its body [m]
    velocity     : [m/s];  acceleration : [m/s^2]
    spin         : [rad/s];  spin_change : [rad/s^2]
    bend         : bound of what turning adds to the acceleration of any of its points at the start
                   of the tick [m/s^2]; `bend_within`: until a time
    lever        : bound of how far any of its points is from the centre of mass [m]
    """

    center: Any
    velocity: Any
    acceleration: Any
    spin: Any
    spin_change: Any
    bend: float
    lever: float


@inline
def _turning(body: int, bodies: Array) -> Any:
    """Return what moves the shape of a body that turns: w' and alpha' of the module."""
    kind = bodies[body + solver_bodies.SYMMETRY]
    if kind == solver_bodies.CENTRED_BALL:
        return NOWHERE, NOWHERE
    spin = solver_bodies.spin(body, bodies)
    inverse = load_symmetric(bodies, body + solver_bodies.INVERSE_INERTIA)
    angular_momentum = load(bodies, body + solver_bodies.ANGULAR_MOMENTUM)
    change = negate(apply_symmetric(inverse, cross(spin, angular_momentum)))
    if kind == solver_bodies.ABOUT_AXIS:
        axis = solver_bodies.start_axis(body, bodies)
        rolling = dot(spin, axis)
        spin = add_scaled(spin, -rolling, axis)
        change = add_scaled(change, -dot(change, axis), axis)
        change = add_scaled(change, rolling, cross(axis, spin))
    return spin, change


@kernel
def free_motion(collider: int, colliders: ColliderArrays, bodies: Array) -> Any:
    """Return the free motion of a collider from the start of the tick on."""
    center = load(colliders.poses, collider * pose.SIZE + pose.POSITION)
    body = collider_record.solver_body(collider, colliders.table) * solver_bodies.SIZE
    row = collider * swept_aabbs.SIZE
    stands = bodies[body + solver_bodies.INVERSE_MASS] == 0.0
    mass_center = center if stands else load(bodies, body + solver_bodies.START_POSITION)
    arm = subtract(load(colliders.swept_aabbs, row + swept_aabbs.CENTER), mass_center)
    lever = (
        math.sqrt(dot(arm, arm))
        + colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.RADIUS]
    )
    if stands:
        return FreeMotion(center, NOWHERE, NOWHERE, NOWHERE, NOWHERE, 0.0, lever)
    spin, change = _turning(body, bodies)
    return FreeMotion(
        mass_center,
        load(colliders.swept_aabbs, row + swept_aabbs.VELOCITY),
        load(bodies, body + solver_bodies.FREE_ACCELERATION),
        spin,
        change,
        (dot(spin, spin) + math.sqrt(dot(change, change))) * lever,
        lever,
    )


@inline
def _jerked_by(motion: FreeMotion, time: float) -> Any:
    """
    Bound what alpha does to the angular velocity W until a time: of |W - w| [rad/s] and |W'|
    [rad/s^2].

    The turn is exp(u), u = w t + alpha t^2 / 2, so that W = J u', J the mean of exp(s u) over
    s = 0 to 1. J keeps what is along u; of u' no more than |alpha| t / 2 is across. Hence, with
    |J| <= 1, |J - 1| <= min(|u| / 2, 2) and |J' u'| <= across (along + across / 2),

        |W - w| <= |alpha| t (1 + min(|u| / 4, 1))
        |W'|    <= |alpha| (1 + (5/8) (|w| + |alpha| t) t)
    """
    change = math.sqrt(dot(motion.spin_change, motion.spin_change))
    angle = time * (math.sqrt(dot(motion.spin, motion.spin)) + time * change)
    return change * time * (1.0 + min(0.25 * angle, 1.0)), change * (1.0 + 0.625 * angle)


@inline
def bend_within(motion: FreeMotion, time: float) -> float:
    """Bound what turning adds to the acceleration of any point until a time [m/s^2]."""
    change = math.sqrt(dot(motion.spin_change, motion.spin_change))
    rate = math.sqrt(dot(motion.spin, motion.spin)) + time * change
    return (rate * rate + change * (1.0 + 0.625 * rate * time)) * motion.lever


@inline
def wander_of(motion: FreeMotion) -> float:
    """Bound how far the third order of the turn moves points: by t^3 [m/s^3]."""
    squared = dot(motion.spin, motion.spin) * dot(motion.spin_change, motion.spin_change)
    return WANDER * math.sqrt(squared) * motion.lever


@kernel
def bend_seen_from(
    frame: FreeMotion, other: FreeMotion, normal: Any, begun: float, span: float
) -> float:
    """
    Bound the acceleration of the points of one body along an axis that turns with another one
    [m/s^2].

        normal : the axis, towards the other, at the time `begun` [s];  span : [s] from then on

    With rho = d + r from the centre of the frame, d the centre of the other and r from there, it
    is n . of

        a + w x (w x d) - 2 w x v - alpha x rho + alpha' x r
          + w' x (w' x r) - 2 w x (w' x r) + w x (w x r)

    whose last three are (W x (W x r)) + (w' x w) x r, W = w' - w. The first three are taken as
    they are at the start, with room for what they and n turn by, and for what the spins change.
    """
    pull = subtract(other.acceleration, frame.acceleration)
    velocity = add_scaled(subtract(other.velocity, frame.velocity), begun, pull)
    apart = add_scaled(subtract(other.center, frame.center), begun, velocity)
    apart = add_scaled(apart, -0.5 * begun * begun, pull)
    spin, spin_of_other = frame.spin, other.spin
    inward = cross(spin, subtract(cross(spin, apart), scale(2.0, velocity)))
    along = add(pull, inward)
    strays, change = _jerked_by(frame, begun + span)
    strays_of_other, change_of_other = _jerked_by(other, begun + span)
    rate, speed = math.sqrt(dot(spin, spin)) + strays, math.sqrt(dot(velocity, velocity))
    pulled = math.sqrt(dot(pull, pull))
    reached = math.sqrt(dot(apart, apart)) + (speed + 0.5 * pulled * span) * span + other.lever
    drift = rate * (2.0 * pulled + rate * (speed + 0.5 * pulled * span)) * span
    bound = dot(normal, along) + rate * span * math.sqrt(dot(along, along)) + drift
    bound += strays * (2.0 * rate * reached + 2.0 * (speed + pulled * span))
    relative = subtract(spin_of_other, spin)
    twist = cross(spin, spin_of_other)
    passing = math.sqrt(dot(relative, relative)) + strays + strays_of_other
    twisting = math.sqrt(dot(twist, twist)) + rate * strays_of_other
    twisting += strays * math.sqrt(dot(spin_of_other, spin_of_other))
    bound += (passing * passing + twisting + change_of_other) * other.lever
    bound += change * reached
    return max(bound, 0.0)


@inline
def _turn(vector_part: Any, scalar_part: float, v: Any) -> Any:
    """Turn a vector by a unit quaternion."""
    twice = scale(2.0, cross(vector_part, v))
    return add(add_scaled(v, scalar_part, twice), cross(vector_part, twice))


@kernel
def move(collider: int, target: int, time: float, motion: FreeMotion, poses: Array) -> None:
    """Write the pose of a collider after free motion over a time; target: where it begins."""
    place = collider * pose.SIZE
    shift = add_scaled(scale(time, motion.velocity), 0.5 * time * time, motion.acceleration)
    turn = add_scaled(scale(time, motion.spin), 0.5 * time * time, motion.spin_change)
    angle = math.sqrt(dot(turn, turn))
    if angle == 0.0:
        store(poses, target + pose.POSITION, add(load(poses, place + pose.POSITION), shift))
        for entry in range(pose.ROW_X, pose.SIZE):
            poses[target + entry] = poses[place + entry]
        return
    half = scale(math.sin(0.5 * angle) / angle, turn)
    cosine = math.cos(0.5 * angle)
    for column in range(3):
        turned = _turn(half, cosine, pose.axis(poses, place, column))
        store_strided(poses, target + pose.ROW_X + column, pose.ROW_Y - pose.ROW_X, turned)
    arm = _turn(half, cosine, subtract(load(poses, place + pose.POSITION), motion.center))
    store(poses, target + pose.POSITION, add(add(motion.center, arm), shift))


@inline
def _moved(point: Any, time: float, motion: FreeMotion) -> Any:
    """Return where a point of a body is after a time, to second order in what it turns."""
    arm = subtract(point, motion.center)
    turn = add_scaled(scale(time, motion.spin), 0.5 * time * time, motion.spin_change)
    once = cross(turn, arm)
    shift = add_scaled(scale(time, motion.velocity), 0.5 * time * time, motion.acceleration)
    return add(add(point, shift), add_scaled(once, 0.5, cross(turn, once)))


@inline
def _moved_back(point: Any, time: float, motion: FreeMotion) -> Any:
    """Return where a point of the world was on a body a time ago: the inverse of `_moved`."""
    shift = add_scaled(scale(time, motion.velocity), 0.5 * time * time, motion.acceleration)
    arm = subtract(subtract(point, shift), motion.center)
    turn = add_scaled(scale(-time, motion.spin), -0.5 * time * time, motion.spin_change)
    once = cross(turn, arm)
    return add(add(motion.center, arm), add_scaled(once, 0.5, cross(turn, once)))


@kernel
def moved_with(point: Any, time: float, motion: FreeMotion, seen_from: FreeMotion) -> Any:
    """
    Return where a point that moves with one body is after a time, seen from another one as that
    stands now; both turn by small angles.
    """
    return _moved_back(_moved(point, time, motion), time, seen_from)


@inline
def angle_of(motion: FreeMotion, time: float) -> Any:
    """Bound of what a body turns in a time [rad]."""
    rate = math.sqrt(dot(motion.spin, motion.spin))
    return time * (rate + time * math.sqrt(dot(motion.spin_change, motion.spin_change)))
