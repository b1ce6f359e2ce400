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
    tau_0^2 = C(q) k tr Sigma,   q = 4 det Sigma / (tr Sigma)^2
    k = 1/3 + (k_face - 1/3) q

k is the second moment of a uniform patch over that of its points: 1/3 of a line, a rectangle,
1/4 of a triangle; where the points are some of many corners, or of a rim, it is such that tau_0 is
that of the whole face (`pressure_of_face`). C is a polynomial, fitted to the tau_0 of rectangles:
to 6e-4 as far as 4 : 1, to 1.2e-3 as far as the line (where it is exact), with 5e-5 for squares.
One point has no tau_0.

A visit changes force and torque by

    f <- f - g v,   tau <- tau - g l^2 omega,   l^2 = tau_0^2 G_X / G_Y,   then both by 1/sqrt(G)

if G > 1, with 1/g the largest eigenvalue of J M^-1 J^T in the lengths of l: only with this ratio
of steps is to scale both alike the projection of maximum dissipation. c, tau_0, l and g are found
at the start of a tick, and anew where more or less presses. G_X / G_Y is a polynomial of u, to
1e-3.

What is stored is force and torque about a centre that moves with the points: it is c at the start
of the tick, so c of now is measured from it. Both its arms end in one point, whatever presses.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    friction_patch,
    lane_scratch,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.contact_point import ONE_POINT
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
LINE = 1.0 / 3.0  # [-] k
C_0, C_1, C_2, C_3, C_4 = 0.75, 0.26650, -0.35798, 0.35238, -0.13264  # [-] of C
L_0, L_1, L_2, L_3, L_4 = 0.56298, 0.80088, 1.09004, -1.82472, 0.87236  # [-] G_X / G_Y
START = 1e-6  # [m/s] change of a tangential velocity that is left alone where a contact starts
STALE = 0.1  # [-] of what presses: a patch on which so much more or less does is measured anew
SETTLED = 1e-12  # [-] of what presses: friction that changes by less has settled

TURNS = slot('[-] whether the inertia of anything turns with it, or changes')


@inline
def flatness(trace: float, determinant: float) -> Any:
    """Return q of Sigma: 0 of a line, 1 where no direction is before another."""
    scale_of = 1.0 / (trace if trace > ONE_POINT else 1.0)
    q = 4.0 * determinant * scale_of * scale_of
    q = q if q > 0.0 else 0.0
    return q if q < 1.0 else 1.0


@inline
def shape_factor(q: float) -> Any:
    """Return C."""
    return C_0 + q * (C_1 + q * (C_2 + q * (C_3 + q * C_4)))


@inline
def _place(constraints: Array, points: Array, patch: Array, lane: int) -> Any:
    """Return where a point is from the centre, along the two tangents."""
    arm = subtract(
        wide_lanes.vector(points, lane + contact_point.ARM_A),
        wide_lanes.vector(patch, lane + friction_patch.ARM_A),
    )
    return (
        dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_1)),
        dot(arm, wide_lanes.vector(constraints, lane + constraint.TANGENT_2)),
    )


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
def add_to_center(lanes: int, weights: Array, points: Array, patch: Array) -> None:
    """Add one point of each lane, with its weights (8,), to the centre."""
    for lane in range(lanes):
        share = weights[lane]
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
def weigh(lanes: int, weights: Array, points: Array, scratch: Array) -> None:
    """
    Weigh one point of each lane by what it pressed in the last tick, of what all did
    (`add_press`); where nothing did they keep the weights that they have by nearness.
    """
    for lane in range(lanes):
        total = scratch[lane + lane_scratch.PRESS]
        share = points[lane + contact_point.NORMAL_IMPULSE] / (total if total > 0.0 else 1.0)
        weights[lane] = share if total > 0.0 else weights[lane]


@kernel
def add_press(lanes: int, points: Array, scratch: Array) -> None:
    """Add one point of each lane to what presses."""
    for lane in range(lanes):
        scratch[lane + lane_scratch.PRESS] += points[lane + contact_point.NORMAL_IMPULSE]


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
        place_1, place_2 = _place(constraints, points, patch, lane)
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
        twist = twist if limit > 0.0 else 0.0
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
def clear_moments(lanes: int, scratch: Array) -> None:
    """Begin the sums of what presses."""
    for lane in range(lanes):
        wide_lanes.put_vector(scratch, lane + lane_scratch.PRESS, (0.0, 0.0, 0.0))
        wide_lanes.put_vector(scratch, lane + lane_scratch.PRESS_11, (0.0, 0.0, 0.0))


@kernel
def find_slide(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Find how much of what presses the friction of each lane is: `solve`; begin the sum of what does
    now.
    """
    for lane in range(lanes):
        scratch[lane + lane_scratch.PRESS] = 0.0
        along_1 = patch[lane + friction_patch.IMPULSE_1]
        along_2 = patch[lane + friction_patch.IMPULSE_2]
        mu = constraints[lane + constraint.FRICTION]
        least = math.sqrt(along_1 * along_1 + along_2 * along_2) / (mu if mu > 0.0 else 1.0)
        press = patch[lane + friction_patch.MEASURED]
        press = press if press > least else least
        share = 1.0 / (press if press > 0.0 else 1.0)
        scratch[lane + lane_scratch.SLIDE_1] = share * along_1
        scratch[lane + lane_scratch.SLIDE_2] = share * along_2


@kernel
def add_moments(
    lanes: int, field: int, constraints: Array, points: Array, patch: Array, scratch: Array
) -> None:
    """
    Add one point of each lane to what presses, and where.

    field : of `contact_point`: its impulse along the normal
    """
    for lane in range(lanes):
        press = points[lane + field]
        place_1, place_2 = _place(constraints, points, patch, lane)
        along_1, along_2 = press * place_1, press * place_2
        scratch[lane + lane_scratch.PRESS] += press
        scratch[lane + lane_scratch.PRESS_1] += along_1
        scratch[lane + lane_scratch.PRESS_2] += along_2
        scratch[lane + lane_scratch.PRESS_11] += along_1 * place_1
        scratch[lane + lane_scratch.PRESS_12] += along_1 * place_2
        scratch[lane + lane_scratch.PRESS_22] += along_2 * place_2


@inline
def _moments(scratch: Array, lane: int) -> Any:
    """Return the middle of what presses, from the centre (c_1, c_2), and Sigma (11, 12, 22)."""
    press = scratch[lane + lane_scratch.PRESS]
    share = 1.0 / (press if press > 0.0 else 1.0)
    c_1 = share * scratch[lane + lane_scratch.PRESS_1]
    c_2 = share * scratch[lane + lane_scratch.PRESS_2]
    s_11 = share * scratch[lane + lane_scratch.PRESS_11] - c_1 * c_1
    s_12 = share * scratch[lane + lane_scratch.PRESS_12] - c_1 * c_2
    s_22 = share * scratch[lane + lane_scratch.PRESS_22] - c_2 * c_2
    return c_1, c_2, s_11, s_12, s_22


@inline
def _put(active: Any, value: float, row: int, patch: Array) -> None:
    """Write a number; a lane that is not visited keeps its bits, whatever is struck beside it."""
    patch[row] = value if active else patch[row]


@inline
def _is_stale(patch: Array, scratch: Array, lane: int) -> Any:
    """Tell whether something else presses on a lane than when it was measured."""
    press = scratch[lane + lane_scratch.PRESS]
    return abs(press - patch[lane + friction_patch.MEASURED]) > STALE * press


@kernel
def measure(lanes: int, wrench: int, all_lanes: bool, patch: Array, scratch: Array) -> None:
    """
    Find middle, size and steps of the patch of each lane from what presses (`add_moments`).

    wrench    : of the patch, on whose direction the steps depend
    all_lanes : False: of lanes that are visited and stale, see `any_stale`
    """
    for lane in range(lanes):
        c_1, c_2, s_11, s_12, s_22 = _moments(scratch, lane)
        trace = s_11 + s_22
        is_patch = trace > ONE_POINT
        determinant = s_11 * s_22 - s_12 * s_12
        q = flatness(trace, determinant)
        k = LINE + (patch[lane + friction_patch.UNIFORM] - LINE) * q
        radius_squared = k * shape_factor(q) * trace if is_patch else 0.0
        inverse = 1.0 / radius_squared if is_patch else 0.0
        impulse_1, impulse_2, twist = _wrench(patch, lane + wrench)
        twist -= c_1 * impulse_2 - c_2 * impulse_1
        by_twist = twist * twist
        both = radius_squared * (impulse_1 * impulse_1 + impulse_2 * impulse_2) + by_twist
        u = by_twist / (both if both > 0.0 else 1.0)
        ratio = L_0 + u * (L_1 + u * (L_2 + u * (L_3 + u * L_4)))
        length_squared = radius_squared * ratio
        away_squared = c_1 * c_1 + c_2 * c_2
        away = math.sqrt(away_squared)
        twist_rate = patch[lane + friction_patch.TWIST_RATE]
        coupling = patch[lane + friction_patch.COUPLING]
        force_rate = patch[lane + friction_patch.FORCE_RATE] + (
            2.0 * coupling * away + twist_rate * away_squared
        )
        coupling += twist_rate * away
        twist_rate *= length_squared
        half = 0.5 * (force_rate - twist_rate)
        rate = 0.5 * (force_rate + twist_rate) + math.sqrt(
            half * half + length_squared * coupling * coupling
        )
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        active = active & (all_lanes | _is_stale(patch, scratch, lane))
        _put(active, scratch[lane + lane_scratch.PRESS], lane + friction_patch.MEASURED, patch)
        _put(active, c_1, lane + friction_patch.MIDDLE_1, patch)
        _put(active, c_2, lane + friction_patch.MIDDLE_2, patch)
        _put(active, radius_squared, lane + friction_patch.RADIUS_SQUARED, patch)
        _put(active, inverse, lane + friction_patch.INVERSE_SQUARED, patch)
        _put(active, length_squared, lane + friction_patch.LENGTH_SQUARED, patch)
        step = 1.0 / rate if rate > 0.0 else 0.0
        _put(active, step, lane + friction_patch.STEP, patch)


@inline
def any_starts(used: int, scratch: Array) -> bool:
    """
    Tell whether friction that starts has not settled on some lane; let the others stand still.
    """
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.STARTS] > 0.0
    if found:
        for lane in range(used):
            scratch[lane + lane_scratch.ACTIVE] = scratch[lane + lane_scratch.STARTS]
    return found


@inline
def any_stale(used: int, patch: Array, scratch: Array) -> bool:
    """Tell whether some lane must be measured anew."""
    found = False
    for lane in range(used):
        found = found or _is_stale(patch, scratch, lane)
    return found


@inline
def _gauge(force: float, twist: float) -> Any:
    """
    Return G of squares of a force and a torque.

    force, twist : X and Y, of one unit
    """
    both = force + twist
    u = twist / (both if both > 0.0 else 1.0)
    w = 1.0 - u
    return both * (1.0 + u * w * (SLIDES * w + DRILLS * u + BETWEEN * u * w))


@inline
def _change(
    old: Any, left: Any, constraints: Array, patch: Array, scratch: Array, lane: int, turns: bool
) -> Any:
    """
    Return how a visit changes a wrench about the centre, and the square of the change as an
    impulse.

    left : slip along the two tangents that friction does not take [m/s]
    """
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
    arm_a = wide_lanes.vector(patch, lane + friction_patch.ARM_A)
    arm_b = wide_lanes.vector(patch, lane + friction_patch.ARM_B)
    c_1, c_2 = patch[lane + friction_patch.MIDDLE_1], patch[lane + friction_patch.MIDDLE_2]
    inverse = patch[lane + friction_patch.INVERSE_SQUARED]
    step = patch[lane + friction_patch.STEP]
    twist_step = step * patch[lane + friction_patch.LENGTH_SQUARED]
    limit = constraints[lane + constraint.FRICTION] * scratch[lane + lane_scratch.PRESS]
    omega_a, omega_b = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
    velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, turns)
    turn = dot(normal, subtract(omega_b, omega_a))
    velocity_1 = dot(tangent_1, velocity) - left[0] - turn * c_2
    velocity_2 = dot(tangent_2, velocity) - left[1] + turn * c_1
    old_1, old_2, old_about_center = old
    old_twist = old_about_center - (c_1 * old_2 - c_2 * old_1)
    new_1 = old_1 - step * velocity_1
    new_2 = old_2 - step * velocity_2
    twist = old_twist - twist_step * turn
    twist = twist if inverse > 0.0 else 0.0
    square = _gauge(new_1 * new_1 + new_2 * new_2, twist * twist * inverse)
    outside = square > limit * limit
    factor = limit / math.sqrt(square if outside else 1.0) if outside else 1.0
    change_1, change_2 = factor * new_1 - old_1, factor * new_2 - old_2
    turned = factor * twist - old_twist
    size = (change_1 * change_1 + change_2 * change_2) + turned * turned * inverse
    return (change_1, change_2, turned + (c_1 * change_2 - c_2 * change_1)), size


def _relax(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Solve the friction of each lane, after all its normals, which add up what presses: `solve`.

    A contact that starts has no friction yet. Friction that tips a body changes what presses, and
    a visit finds less than half of it: so such a lane is visited until it changes by less than
    START, or it would keep a slip that friction at its limit never takes back.
    """
    for lane in range(lanes):
        old = _wrench(patch, lane + friction_patch.IMPULSE_1)
        change, size = _change(old, (0.0, 0.0), constraints, patch, scratch, lane, TURNS)
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        size = size if active else 0.0
        change = (
            change[0] if active else 0.0,
            change[1] if active else 0.0,
            change[2] if active else 0.0,
        )
        is_new = patch[lane + friction_patch.WARM_NORMAL] <= 0.0
        slip = math.sqrt(size)
        starts = is_new & (slip > START * patch[lane + friction_patch.STEP])
        scratch[lane + lane_scratch.STARTS] = 1.0 if starts else 0.0
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        scratch[lane + lane_scratch.LARGEST_CHANGE] = slip if slip > largest else largest
        wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, add(old, change))
        _apply(change, constraints, patch, scratch, lane)


@kernel
def go_ahead(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Let the friction of each lane go on by a share of its last step: `islands.unsettled`."""
    for lane in range(lanes):
        given = _wrench(patch, lane + friction_patch.IMPULSE_1)
        before = _wrench(patch, lane + friction_patch.BEGUN_BEFORE_1)
        was = _wrench(patch, lane + friction_patch.BEGUN_1)
        change = scale(scratch[lane + lane_scratch.AHEAD], subtract(was, before))
        begun = add(given, change)
        wide_lanes.put_vector(patch, lane + friction_patch.BEGUN_BEFORE_1, was)
        wide_lanes.put_vector(patch, lane + friction_patch.BEGUN_1, begun)
        wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, begun)
        _apply(change, constraints, patch, scratch, lane)


def relaxation(*, turns: bool) -> Callable[..., Any]:
    """Make the kernel that solves friction; turns: the inertia of something turns with it."""
    return specialise(_relax, name='turns' if turns else 'round', TURNS=turns)


@kernel
def apply_restitution(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Solve the friction on the impulses of restitution of each lane: see `restitution`."""
    for lane in range(lanes):
        old = _wrench(patch, lane + friction_patch.RESTITUTION_1)
        left = (
            constraints[lane + constraint.SLIP_LEFT_1], constraints[lane + constraint.SLIP_LEFT_2]
        )  # fmt: skip
        change, size = _change(old, left, constraints, patch, scratch, lane, True)
        settled = SETTLED * scratch[lane + lane_scratch.PRESS]
        changes = size > settled * settled
        size = size if changes else 0.0
        change = (
            change[0] if changes else 0.0,
            change[1] if changes else 0.0,
            change[2] if changes else 0.0,
        )
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
        wide_lanes.put_vector(patch, lane + friction_patch.RESTITUTION_1, add(old, change))
        _apply(change, constraints, patch, scratch, lane)


@inline
def _lets_go(patch: Array, scratch: Array, lane: int) -> Any:
    """Tell whether the patch of a lane was pressed in the last substep, and is not any more."""
    was_pressed = patch[lane + friction_patch.WARM_NORMAL] > 0.0
    was_pressed = was_pressed & (patch[lane + friction_patch.FIRST_OTHER] == 0.0)
    return was_pressed & (not scratch[lane + lane_scratch.PRESSES] > 0.0)


@inline
def any_lets_go(used: int, patch: Array, scratch: Array) -> bool:
    """Tell whether some patch that was pressed in the last substep is not any more."""
    found = False
    for lane in range(used):
        found = found or _lets_go(patch, scratch, lane)
    return found


@kernel
def take_back(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Take back the first half of the warm start of each lane on which nothing presses any more, and
    give no second one.
    """
    for lane in range(lanes):
        goes = _lets_go(patch, scratch, lane)
        old = _wrench(patch, lane + friction_patch.IMPULSE_1)
        warm = _wrench(patch, lane + friction_patch.WARM_1)
        back = scale(-1.0 if goes else 0.0, warm)
        kept = 0.0 if goes else 1.0
        wide_lanes.put_vector(patch, lane + friction_patch.IMPULSE_1, scale(kept, old))
        wide_lanes.put_vector(patch, lane + friction_patch.WARM_1, scale(kept, warm))
        _apply(back, constraints, patch, scratch, lane)


@kernel
def apply_second_half(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """Give each lane the second half of its warm start, at the centre after the motion."""
    for lane in range(lanes):
        warm = _wrench(patch, lane + friction_patch.WARM_1)
        _apply(warm, constraints, patch, scratch, lane)


@kernel
def start_substep(lanes: int, constraints: Array, patch: Array, scratch: Array) -> None:
    """
    Start each lane from the share that lasts of the substep that ends; add what it gave to the
    totals of the tick.

    After the points (`warm_start`), which add up what they pressed, and what of it lasts.
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
def _turn(wrench: Any, c_1: float, c_2: float, inverse_trace: float) -> Any:
    """Return the twist about the middle over the trace of Sigma: impulse per distance."""
    return inverse_trace * (wrench[2] - (c_1 * wrench[1] - c_2 * wrench[0]))


@kernel
def spread(lanes: int, constraints: Array, points: Array, patch: Array, scratch: Array) -> None:
    """
    Give one point of each lane its part of the friction of the last substep, and of all else in
    the tick, so that the parts have the force and the torque of the whole: as the points have
    pressed over the tick (`add_moments`), J_i = w_i f + (tau / tr Sigma) w_i n x (r_i - c).
    """
    for lane in range(lanes):
        place_1, place_2 = _place(constraints, points, patch, lane)
        c_1, c_2, s_11, _, s_22 = _moments(scratch, lane)
        total = scratch[lane + lane_scratch.PRESS]
        trace = s_11 + s_22
        inverse_trace = 1.0 / (trace if trace > ONE_POINT else 1.0) if trace > ONE_POINT else 0.0
        press = (
            points[lane + contact_point.TOTAL_IMPULSE]
            + points[lane + contact_point.NORMAL_IMPULSE]
        )
        share = press / total if total > 0.0 else 0.0
        arm_1, arm_2 = share * (place_1 - c_1), share * (place_2 - c_2)
        own = 1.0 if patch[lane + friction_patch.FIRST_OTHER] == 0.0 else 0.0
        wrench = scale(own, _wrench(patch, lane + friction_patch.IMPULSE_1))
        turn = _turn(wrench, c_1, c_2, inverse_trace)
        points[lane + contact_point.TANGENT_IMPULSE_1] = share * wrench[0] - turn * arm_2
        points[lane + contact_point.TANGENT_IMPULSE_2] = share * wrench[1] + turn * arm_1
        wrench = add(
            scale(own, _wrench(patch, lane + friction_patch.TOTAL_1)),
            _wrench(patch, lane + friction_patch.RESTITUTION_1),
        )
        turn = _turn(wrench, c_1, c_2, inverse_trace)
        total_1, total_2 = share * wrench[0] - turn * arm_2, share * wrench[1] + turn * arm_1
        points[lane + contact_point.TOTAL_IMPULSE + LANES] = total_1
        points[lane + contact_point.TOTAL_IMPULSE + 2 * LANES] = total_2
