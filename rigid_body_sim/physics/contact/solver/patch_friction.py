# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Friction of a face on a face: that of a patch of uniform pressure, lane by lane.

The friction of a manifold of several points is one force f at the middle of what presses and one
torque tau about the normal there. They are bounded together: with the mean impulse N of the patch,

    X = f^2 / (mu N)^2,  Y = tau^2 / (mu N tau_0)^2,  u = Y / (X + Y),  w = 1 - u
    G = (X + Y)(1 + u w p) <= 1,   p = 7/9 w + 1/2 u - 1/4 u w

and at the bound the velocity v there and the turn omega go by the gradient of G (maximum
dissipation: Goyal, Ruina, Papadopoulos, Wear 143 (1991) 307):

    v || f G_X,   omega || tau G_Y / tau_0^2

For a disc G is the exact surface to 0.06 % (7/9 and 1/2 are the exact expansions where sliding,
and where drilling leads), for a square to 0.6 %; for a rectangle a : b it is the mean of its
directions, 6 % off at 2 : 1, 9 % at 4 : 1, for a line 12 %.

How large a patch is follows from what presses, so that a body which tips, stands on an edge or
lies on a line needs no other law: with the impulses N_i of its points at r_i in the plane,

    c = sum N_i r_i / N,   Sigma = sum N_i (r_i - c)(r_i - c)^T / N
    tau_0^2 = C(e)^2 k tr Sigma,   e = 2 sqrt(det Sigma) / tr Sigma
    C = 0.866 + 0.0465 e + 0.0247 e^2
    k = 1/3 + (k_face - 1/3) e,   k_face = (2 + cos(2 pi/n)) / 6 for a face of n corners

k is the second moment of a uniform patch over that of its corners: 1/3 of a line, a rectangle,
1/4 of a triangle; for a disc, whose points are on its rim, 0.506 with what C lacks there. tau_0 of
discs and rectangles to 2 : 1 is exact to 5e-5, to 4 : 1 to 3e-3. One point has none.

A visit changes force and torque by

    f <- f - g v,   tau <- tau - g l^2 omega,   l^2 = tau_0^2 G_X / G_Y,   then both by 1/sqrt(G)

if G > 1, with 1/g the largest eigenvalue of J M^-1 J^T in the lengths of l: only with this ratio
of steps is to scale both alike the projection of maximum dissipation.

What is stored is force and torque about the mean of the points, on which weights have no
influence, so that both arms end in one point, whatever presses.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import ROUND
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    friction_patch,
    lane_scratch,
    warm_start,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.solve import START
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    scale,
    subtract,
)

SLIDES, DRILLS, BETWEEN = 7.0 / 9.0, 0.5, -0.25  # [-] of p, see above
LINE, DISC = 1.0 / 3.0, 0.50595  # [-] k
C_LINE, C_FIRST, C_SECOND = 0.866, 0.0465, 0.0247  # [-] of C(e)
POINT = 1e-16  # [m^2] a patch with less of a second moment is a point
FAR = 1e8  # [m] separation beyond which a point is none of the manifold: `colouring.NOWHERE`
SETTLED = 1e-12  # [-] of what presses: friction that changes by less has settled


@inline
def uniform_share(corners: float) -> Any:
    """Return k of a face of so many corners."""
    regular = (2.0 + math.cos(2.0 * math.pi / corners)) / 6.0
    return regular if corners < ROUND else DISC


@inline
def _exists(points: Array, lane: int) -> Any:
    """1 for a point that the manifold has, else 0."""
    return 1.0 if points[lane + contact_point.INITIAL_SEPARATION] < FAR else 0.0


@inline
def _wrench(patch: Array, row: int) -> Any:
    """Force along the tangents and twist: three rows."""
    return wide_lanes.vector(patch, row)


@inline
def _force(along_1: float, along_2: float, constraints: Array, lane: int) -> Any:
    """Make a vector of components along the two tangents."""
    return add(
        scale(along_1, wide_lanes.vector(constraints, lane + constraint.TANGENT_1)),
        scale(along_2, wide_lanes.vector(constraints, lane + constraint.TANGENT_2)),
    )


@inline
def _apply(wrench: Any, constraints: Array, patch: Array, scratch: Array, lane: int) -> None:
    """Give the bodies of a lane a force at the centre of the patch, and a twist."""
    wide_lanes.apply_impulse(
        scratch,
        lane,
        wide_lanes.vector(patch, lane + friction_patch.ARM_A),
        wide_lanes.vector(patch, lane + friction_patch.ARM_B),
        _force(wrench[0], wrench[1], constraints, lane),
    )
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    wide_lanes.apply_angular_impulse(scratch, lane, scale(wrench[2], normal))


@kernel
def clear_center(lanes: int, patch: Array) -> None:
    """Begin the sums of `add_to_center`."""
    for lane in range(lanes):
        wide_lanes.put_vector(patch, lane + friction_patch.ARM_A, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(patch, lane + friction_patch.ARM_B, (0.0, 0.0, 0.0))


@kernel
def add_to_center(lanes: int, points: Array, patch: Array) -> None:
    """Add one point of each lane to the mean of the points."""
    for lane in range(lanes):
        share = patch[lane + friction_patch.SHARE] * _exists(points, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        center_a = wide_lanes.vector(patch, lane + friction_patch.ARM_A)
        center_b = wide_lanes.vector(patch, lane + friction_patch.ARM_B)
        wide_lanes.put_vector(
            patch, lane + friction_patch.ARM_A, add_scaled(center_a, share, arm_a)
        )
        wide_lanes.put_vector(
            patch, lane + friction_patch.ARM_B, add_scaled(center_b, share, arm_b)
        )


@kernel
def clear_wrench(lanes: int, patch: Array) -> None:
    """Begin a tick: no friction yet."""
    for lane in range(lanes):
        for row in range(friction_patch.IMPULSE_1, friction_patch.SIZE, LANES):
            patch[lane + row] = 0.0


@kernel
def take_recalled(lanes: int, constraints: Array, points: Array, patch: Array) -> None:
    """Move the friction that is recalled of one point of each lane into that of the patch."""
    for lane in range(lanes):
        impulse_1 = points[lane + contact_point.TANGENT_IMPULSE_1]
        impulse_2 = points[lane + contact_point.TANGENT_IMPULSE_2]
        arm = subtract(
            wide_lanes.vector(points, lane + contact_point.ARM_A),
            wide_lanes.vector(patch, lane + friction_patch.ARM_A),
        )
        place_1 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_1))
        place_2 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_2))
        patch[lane + friction_patch.IMPULSE_1] += impulse_1
        patch[lane + friction_patch.IMPULSE_2] += impulse_2
        patch[lane + friction_patch.TWIST] += place_1 * impulse_2 - place_2 * impulse_1
        patch[lane + friction_patch.WARM_NORMAL] += (
            0.5 * points[lane + contact_point.NORMAL_IMPULSE]
        )
        points[lane + contact_point.TANGENT_IMPULSE_1] = 0.0
        points[lane + contact_point.TANGENT_IMPULSE_2] = 0.0


@inline
def _warm_start(wrench: Any, constraints: Array, patch: Array, scratch: Array, lane: int) -> None:
    """Start a substep from a wrench: halve it; sum up what that is to the bodies."""
    half = scale(0.5, wrench)
    wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, wrench)
    wide_lanes.put_vector(patch, lane + friction_patch.WARM_1, half)
    _apply(half, constraints, patch, scratch, lane)


@kernel
def start_tick(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Start each lane from the friction of the last tick."""
    for lane in range(lanes):
        limit = constraints[lane + constraint.FRICTION] * (
            2.0 * patch[lane + friction_patch.WARM_NORMAL]
        )
        impulse_1, impulse_2, twist = _wrench(patch, lane + friction_patch.IMPULSE_1)
        impulse_1, impulse_2 = wide_lanes.clamp_to_disc(impulse_1, impulse_2, limit)
        _warm_start((impulse_1, impulse_2, twist), constraints, patch, scratch, lane)


@kernel
def find_rates(lanes: int, constraints: Array, patch: Array) -> None:
    """Find what velocities force and twist at the centre of each lane give."""
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a = wide_lanes.vector(patch, lane + friction_patch.ARM_A)
        arm_b = wide_lanes.vector(patch, lane + friction_patch.ARM_B)
        inverse_a = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_A)
        inverse_b = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_B)
        inverse_mass = (
            constraints[lane + constraint.INVERSE_MASS_A]
            + constraints[lane + constraint.INVERSE_MASS_B]
        )
        first_a, first_b = cross(arm_a, tangent_1), cross(arm_b, tangent_1)
        second_a, second_b = cross(arm_a, tangent_2), cross(arm_b, tangent_2)
        turn_a, turn_b = apply_symmetric(inverse_a, first_a), apply_symmetric(inverse_b, first_b)
        k11 = inverse_mass + (dot(first_a, turn_a) + dot(first_b, turn_b))
        k12 = dot(second_a, turn_a) + dot(second_b, turn_b)
        k1n = dot(normal, add(turn_a, turn_b))
        turn_a, turn_b = apply_symmetric(inverse_a, second_a), apply_symmetric(inverse_b, second_b)
        k22 = inverse_mass + (dot(second_a, turn_a) + dot(second_b, turn_b))
        k2n = dot(normal, add(turn_a, turn_b))
        knn = dot(
            normal, add(apply_symmetric(inverse_a, normal), apply_symmetric(inverse_b, normal))
        )
        half = 0.5 * (k11 - k22)
        patch[lane + friction_patch.FORCE_RATE] = 0.5 * (k11 + k22) + math.sqrt(
            half * half + k12 * k12
        )
        patch[lane + friction_patch.TWIST_RATE] = knn
        patch[lane + friction_patch.COUPLING] = math.sqrt(k1n * k1n + k2n * k2n)


@kernel
def clear_press(lanes: int, scratch: Array) -> None:
    """Begin the sums of `add_press`."""
    for lane in range(lanes):
        for row in range(lane_scratch.PRESS, lane_scratch.PRESS_END, LANES):
            scratch[lane + row] = 0.0


@kernel
def add_press(
    lanes: int, field: int, constraints: Array, points: Array, patch: Array, scratch: Array
) -> None:
    """
    Add one point of each lane to what presses, and where.

    field : of `contact_point`: its impulse along the normal
    """
    for lane in range(lanes):
        press = points[lane + field]
        arm = subtract(
            wide_lanes.vector(points, lane + contact_point.ARM_A),
            wide_lanes.vector(patch, lane + friction_patch.ARM_A),
        )
        place_1 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_1))
        place_2 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_2))
        along_1, along_2 = press * place_1, press * place_2
        scratch[lane + lane_scratch.PRESS] += press
        scratch[lane + lane_scratch.PRESS_1] += along_1
        scratch[lane + lane_scratch.PRESS_2] += along_2
        scratch[lane + lane_scratch.PRESS_11] += along_1 * place_1
        scratch[lane + lane_scratch.PRESS_12] += along_1 * place_2
        scratch[lane + lane_scratch.PRESS_22] += along_2 * place_2


@inline
def _pressed(scratch: Array, lane: int) -> Any:
    """Return what presses, its middle from the centre (c_1, c_2), and Sigma (11, 12, 22)."""
    press = scratch[lane + lane_scratch.PRESS]
    presses = press > 0.0
    share = 1.0 / (press if presses else 1.0)
    c_1 = share * scratch[lane + lane_scratch.PRESS_1]
    c_2 = share * scratch[lane + lane_scratch.PRESS_2]
    s_11 = share * scratch[lane + lane_scratch.PRESS_11] - c_1 * c_1
    s_12 = share * scratch[lane + lane_scratch.PRESS_12] - c_1 * c_2
    s_22 = share * scratch[lane + lane_scratch.PRESS_22] - c_2 * c_2
    return press, c_1, c_2, s_11, s_12, s_22


@inline
def _radius_squared(s_11: float, s_12: float, s_22: float, k_face: float) -> Any:
    """Return tau_0^2: of the radius at which friction would give the same torque [m^2]."""
    trace = s_11 + s_22
    is_patch = trace > POINT
    determinant = s_11 * s_22 - s_12 * s_12
    determinant = determinant if determinant > 0.0 else 0.0
    e = 2.0 * math.sqrt(determinant) / (trace if is_patch else 1.0)
    e = e if e < 1.0 else 1.0
    c = C_LINE + e * (C_FIRST + C_SECOND * e)
    k = LINE + (k_face - LINE) * e
    return c * c * k * trace if is_patch else 0.0


@inline
def _gauge(force: float, twist: float) -> Any:
    """
    Return G, G_X and G_Y of squares of a force and a torque.

    force, twist : X and Y, of one unit
    """
    both = force + twist
    u = twist / (both if both > 0.0 else 1.0)
    w = 1.0 - u
    p = SLIDES * w + DRILLS * u + BETWEEN * u * w
    h = 1.0 + u * w * p
    slope = (w - u) * p + u * w * ((DRILLS - SLIDES) + BETWEEN * (w - u))
    return both * h, h - u * slope, h + w * slope


@inline
def _next_wrench(
    old: Any, limit: float, c_1: float, c_2: float, radius_squared: float, constraints: Array,
    patch: Array, scratch: Array, lane: int,
) -> Any:  # fmt: skip
    """Return the wrench about the centre after a visit, and its step g."""
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
    arm_a = wide_lanes.vector(patch, lane + friction_patch.ARM_A)
    arm_b = wide_lanes.vector(patch, lane + friction_patch.ARM_B)
    omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane)
    velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b)
    turn = dot(normal, subtract(omega_b, omega_a))
    velocity_1 = dot(tangent_1, velocity) - turn * c_2
    velocity_2 = dot(tangent_2, velocity) + turn * c_1
    is_patch = radius_squared > 0.0
    inverse = 1.0 / (radius_squared if is_patch else 1.0)
    old_1, old_2, old_twist = old
    twist = old_twist - (c_1 * old_2 - c_2 * old_1)
    twist = twist if is_patch else 0.0
    _, by_force, by_twist = _gauge(old_1 * old_1 + old_2 * old_2, twist * twist * inverse)
    length_squared = radius_squared * by_force / by_twist
    away = math.sqrt(c_1 * c_1 + c_2 * c_2)
    twist_rate = patch[lane + friction_patch.TWIST_RATE]
    coupling = patch[lane + friction_patch.COUPLING]
    force_rate = patch[lane + friction_patch.FORCE_RATE] + away * (
        2.0 * coupling + twist_rate * away
    )
    coupling += twist_rate * away
    twist_rate *= length_squared
    half = 0.5 * (force_rate - twist_rate)
    rate = 0.5 * (force_rate + twist_rate) + math.sqrt(
        half * half + length_squared * coupling * coupling
    )
    step = 1.0 / rate if rate > 0.0 else 0.0
    new_1 = old_1 - step * velocity_1
    new_2 = old_2 - step * velocity_2
    twist -= step * length_squared * turn
    square, _, _ = _gauge(new_1 * new_1 + new_2 * new_2, twist * twist * inverse)
    outside = square > limit * limit
    factor = limit / math.sqrt(square if outside else 1.0) if outside else 1.0
    new_1, new_2, twist = factor * new_1, factor * new_2, factor * twist
    return (new_1, new_2, twist + (c_1 * new_2 - c_2 * new_1)), step


@kernel
def relax(lanes: int, constraints: Array, patch: Array, scratch: Array, rest: float) -> None:
    """
    Solve the friction of each lane, after all its normals: see `add_press`.

    A contact that starts has no friction yet. Friction that tips a body changes what presses, and
    a visit finds less than half of it: so such a lane is visited until it changes by less than
    `START`, or it would keep a slip that friction at its limit never takes back.

        rest : [m/s] change of a velocity below which a lane is settled
    """
    for lane in range(lanes):
        press, c_1, c_2, s_11, s_12, s_22 = _pressed(scratch, lane)
        k_face = patch[lane + friction_patch.UNIFORM]
        radius_squared = _radius_squared(s_11, s_12, s_22, k_face)
        old = _wrench(patch, lane + friction_patch.IMPULSE_1)
        limit = constraints[lane + constraint.FRICTION] * press
        new, step = _next_wrench(
            old, limit, c_1, c_2, radius_squared, constraints, patch, scratch, lane
        )
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        new = (
            new[0] if active else old[0],
            new[1] if active else old[1],
            new[2] if active else old[2],
        )
        change = subtract(new, old)
        twist = change[2] - (c_1 * change[1] - c_2 * change[0])
        reach = math.sqrt(radius_squared if radius_squared > POINT else 1.0)
        size = abs(change[0]) + abs(change[1])
        size += abs(twist) / reach if radius_squared > POINT else 0.0
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        either = size - rest * step
        scratch[lane + lane_scratch.LARGEST_CHANGE] = either if either > largest else largest
        is_new = patch[lane + friction_patch.WARM_NORMAL] <= 0.0
        largest = scratch[lane + lane_scratch.NORMAL_CHANGE]
        start = size - START * step if is_new else 0.0
        scratch[lane + lane_scratch.NORMAL_CHANGE] = start if start > largest else largest
        wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, new)
        _apply(change, constraints, patch, scratch, lane)


@kernel
def apply_restitution(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Solve the friction on the impulses of restitution of each lane: see `restitution`."""
    for lane in range(lanes):
        press, c_1, c_2, s_11, s_12, s_22 = _pressed(scratch, lane)
        k_face = patch[lane + friction_patch.UNIFORM]
        radius_squared = _radius_squared(s_11, s_12, s_22, k_face)
        old = _wrench(patch, lane + friction_patch.RESTITUTION_1)
        limit = constraints[lane + constraint.FRICTION] * press
        new, _ = _next_wrench(
            old, limit, c_1, c_2, radius_squared, constraints, patch, scratch, lane
        )
        change = subtract(new, old)
        twist = change[2] - (c_1 * change[1] - c_2 * change[0])
        reach = math.sqrt(radius_squared if radius_squared > POINT else 1.0)
        size = abs(change[0]) + abs(change[1])
        size += abs(twist) / reach if radius_squared > POINT else 0.0
        changes = size > SETTLED * press
        size = size if changes else 0.0
        change = (
            change[0] if changes else 0.0,
            change[1] if changes else 0.0,
            change[2] if changes else 0.0,
        )
        largest = scratch[lane + lane_scratch.NORMAL_CHANGE]
        scratch[lane + lane_scratch.NORMAL_CHANGE] = size if size > largest else largest
        wide_lanes.put_vector(patch, lane + friction_patch.RESTITUTION_1, add(old, change))
        _apply(change, constraints, patch, scratch, lane)


@kernel
def add_normals(lanes: int, points: Array, scratch: Array) -> None:
    """Add up what one point of each lane presses, and what of it lasts."""
    for lane in range(lanes):
        press = points[lane + contact_point.NORMAL_IMPULSE]
        scratch[lane + lane_scratch.PRESS] += press
        scratch[lane + lane_scratch.PRESS_1] += press * warm_start.lasting_share(points, lane)


@kernel
def keep_share(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Bring the friction of the last substep within what presses now (`add_normals`): friction is
    none of this substep where less presses, and keeps its share.

    Half of the warm start is still to come, of what presses.
    """
    for lane in range(lanes):
        press = scratch[lane + lane_scratch.PRESS]
        before = 2.0 * patch[lane + friction_patch.WARM_NORMAL]
        less = press < before
        share = press / (before if less else 1.0) if less else 1.0
        presses = press > 0.0
        share = share if presses else 0.0
        old = _wrench(patch, lane + friction_patch.IMPULSE_1)
        warm = _wrench(patch, lane + friction_patch.WARM_1)
        new = scale(share, old)
        still = (
            warm[0] if presses else 0.0,
            warm[1] if presses else 0.0,
            warm[2] if presses else 0.0,
        )
        wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, new)
        wide_lanes.put_vector(patch, lane + friction_patch.WARM_1, still)
        change = subtract(subtract(new, still), subtract(old, warm))
        _apply(change, constraints, patch, scratch, lane)


@kernel
def apply_second_half(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Give each lane the second half of its warm start, at the centre after the motion."""
    for lane in range(lanes):
        warm = _wrench(patch, lane + friction_patch.WARM_1)
        _apply(warm, constraints, patch, scratch, lane)


@kernel
def start_substep(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Start each lane from the share that lasts of the substep that ends (`add_normals`); add what it
    gave to the totals of the tick.
    """
    for lane in range(lanes):
        press = scratch[lane + lane_scratch.PRESS]
        lasts = scratch[lane + lane_scratch.PRESS_1]
        share = lasts / (press if press > 0.0 else 1.0)
        wrench = _wrench(patch, lane + friction_patch.IMPULSE_1)
        total = _wrench(patch, lane + friction_patch.TOTAL_1)
        wide_lanes.put_vector(patch, lane + friction_patch.TOTAL_1, add(total, wrench))
        patch[lane + friction_patch.WARM_NORMAL] = 0.5 * lasts
        _warm_start(scale(share, wrench), constraints, patch, scratch, lane)


@inline
def _spread(
    place_1: float, place_2: float, press: float, row: int, patch: Array, scratch: Array, lane: int
) -> Any:
    """Return what a point has of a wrench of the patch, along the two tangents."""
    total, c_1, c_2, s_11, _, s_22 = _pressed(scratch, lane)
    impulse_1, impulse_2, twist = _wrench(patch, lane + row)
    twist -= c_1 * impulse_2 - c_2 * impulse_1
    trace = s_11 + s_22
    turn = twist / trace if trace > POINT else 0.0
    share = press / total if total > 0.0 else 0.0
    return (
        share * (impulse_1 - turn * (place_2 - c_2)),
        share * (impulse_2 + turn * (place_1 - c_1)),
    )


@kernel
def spread(
    lanes: int, field: int, wrench: int, to: int, constraints: Array, points: Array, patch: Array,
    scratch: Array,
) -> None:  # fmt: skip
    """
    Add to one point of each lane its part of a wrench, so that the parts have the force and the
    torque of the whole.

        field  : impulse of the points along the normal, of which `add_press` has added up all
        wrench : of the patch
        to     : where the point keeps its part
    """
    for lane in range(lanes):
        arm = subtract(
            wide_lanes.vector(points, lane + contact_point.ARM_A),
            wide_lanes.vector(patch, lane + friction_patch.ARM_A),
        )
        place_1 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_1))
        place_2 = dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_2))
        impulse_1, impulse_2 = _spread(
            place_1, place_2, points[lane + field], wrench, patch, scratch, lane
        )
        points[lane + to] += impulse_1
        points[lane + to + LANES] += impulse_2
