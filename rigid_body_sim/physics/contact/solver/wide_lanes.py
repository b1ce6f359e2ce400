# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Vectors, matrices, velocities and impulses of one lane of a wide constraint.

    constraints : rows of one batch, see `constraint`
    points      : rows of one of its points, see `contact_point`
    scratch     : its bodies under way, see `lane_scratch`
    lane        : 0 to 7

Vectors are tuples (x, y, z) in world axes (`vectors`); a loop over the lanes that uses them still
becomes SIMD, because all of this is inlined.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.solver import constraint, contact_point, lane_scratch
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver_bodies import HELD
from rigid_body_sim.physics.vectors import (
    XX,
    XY,
    XZ,
    YY,
    YZ,
    ZZ,
    add,
    add_scaled,
    apply_symmetric,
    cross,
    load_strided,
    scale,
    store_strided,
    subtract,
)


@inline
def vector(rows: Array, row: int) -> Any:
    """Three numbers of a lane, row after row."""
    return load_strided(rows, row, LANES)


@inline
def put_vector(rows: Array, row: int, v: Any) -> None:
    """Write three numbers of a lane."""
    store_strided(rows, row, LANES, v)


@inline
def add_to_vector(rows: Array, row: int, share: float, v: Any) -> None:
    """Add a share of a vector to three numbers of a lane."""
    put_vector(rows, row, add_scaled(vector(rows, row), share, v))


@inline
def symmetric(rows: Array, row: int) -> Any:
    """A symmetric matrix of a lane: xx, xy, xz, yy, yz, zz."""
    return (
        rows[row + XX * LANES], rows[row + XY * LANES], rows[row + XZ * LANES],
        rows[row + YY * LANES], rows[row + YZ * LANES], rows[row + ZZ * LANES],
    )  # fmt: skip


@inline
def contact_frame(constraints: Array, lane: int) -> Any:
    """Normal and the two tangents of a manifold."""
    return (
        vector(constraints, lane + constraint.NORMAL),
        vector(constraints, lane + constraint.TANGENT_1),
        vector(constraints, lane + constraint.TANGENT_2),
    )


@inline
def arms(points: Array, lane: int) -> Any:
    """Arms of a point from the centres of mass of A and B."""
    return (
        vector(points, lane + contact_point.ARM_A),
        vector(points, lane + contact_point.ARM_B),
    )


@inline
def apply_inverse_inertia(rows: Array, row: int, turns: bool, v: Any) -> Any:
    """
    Return I^-1 v of a body of a lane.

        row   : where its inverse inertia begins
        turns : whether the inertia of anything turns with it: else it is a number, of cubes and
                balls, and six of its nine entries are zero
    """
    if turns:
        return apply_symmetric(symmetric(rows, row), v)
    return scale(rows[row], v)


@inline
def gives_way_a(constraints: Array, lane: int) -> bool:
    """
    Tell whether an impulse moves A: neither what stands nor what is moved as told, of which both
    numbers are HELD, but what is free, or turns about a pivot.
    """
    inverse = constraints[lane + constraint.INVERSE_MASS_A]
    return inverse + constraints[lane + constraint.INVERSE_INERTIA_A] > 2.0 * HELD


@inline
def gives_way_b(constraints: Array, lane: int) -> bool:
    """Tell whether an impulse moves B: see `gives_way_a`."""
    inverse = constraints[lane + constraint.INVERSE_MASS_B]
    return inverse + constraints[lane + constraint.INVERSE_INERTIA_B] > 2.0 * HELD


@inline
def angular_velocities(constraints: Array, scratch: Array, lane: int, turns: bool) -> Any:
    """Angular velocities omega = I^-1 L of A and B [rad/s]; turns: see above."""
    angular_a = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A)
    angular_b = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B)
    return (
        apply_inverse_inertia(constraints, lane + constraint.INVERSE_INERTIA_A, turns, angular_a),
        apply_inverse_inertia(constraints, lane + constraint.INVERSE_INERTIA_B, turns, angular_b),
    )


@inline
def velocity_of_centers(constraints: Array, scratch: Array, lane: int) -> Any:
    """Velocity of the centre of B relative to that of A: v_B - v_A [m/s]."""
    inverse_mass = (
        constraints[lane + constraint.INVERSE_MASS_A]
        + constraints[lane + constraint.INVERSE_MASS_B]
    )
    return add_scaled(
        vector(scratch, lane + lane_scratch.RELATIVE_VELOCITY),
        inverse_mass,
        vector(scratch, lane + lane_scratch.IMPULSE),
    )


@inline
def relative_velocity(
    constraints: Array, scratch: Array, lane: int, arm_a: Any, arm_b: Any, turns: bool
) -> Any:
    """Velocity of B relative to A at a point: v_B - v_A + (w_B x r_B - w_A x r_A) [m/s]."""
    omega_a, omega_b = angular_velocities(constraints, scratch, lane, turns)
    of_centers = velocity_of_centers(constraints, scratch, lane)
    return add(of_centers, subtract(cross(omega_b, arm_b), cross(omega_a, arm_a)))


@inline
def impulse_of(
    along_normal: float,
    along_1: float,
    along_2: float,
    normal: Any,
    tangent_1: Any,
    tangent_2: Any,
) -> Any:
    """Make a vector of its components along the normal and the two tangents."""
    return add(
        scale(along_normal, normal), add(scale(along_1, tangent_1), scale(along_2, tangent_2))
    )


@inline
def angular_impulse_of(
    about_1: float, about_2: float, about_normal: float,
    normal: Any, tangent_1: Any, tangent_2: Any,
) -> Any:  # fmt: skip
    """Make an angular impulse of its components: rolling about the tangents, twisting."""
    rolling = add(scale(about_1, tangent_1), scale(about_2, tangent_2))
    return add_scaled(rolling, about_normal, normal)


@inline
def clamp_to_disc(along_1: float, along_2: float, limit: float) -> Any:
    """Bring a tangential vector onto a disc: Coulomb's cone at a normal impulse."""
    square = along_1 * along_1 + along_2 * along_2
    outside = square > limit * limit
    factor = limit / math.sqrt(square if outside else 1.0) if outside else 1.0
    return along_1 * factor, along_2 * factor


@inline
def clamp(value: float, limit: float) -> float:
    """Bring a number into [-limit, limit]."""
    value = value if value < limit else limit
    return value if value > -limit else -limit


@inline
def apply_impulse(scratch: Array, lane: int, arm_a: Any, arm_b: Any, impulse: Any) -> None:
    """Give B an impulse [N s] at its arm, and A the opposite at its own."""
    linear = vector(scratch, lane + lane_scratch.IMPULSE)
    angular_a = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A)
    angular_b = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B)
    linear = add(linear, impulse)
    angular_a = subtract(angular_a, cross(arm_a, impulse))
    angular_b = add(angular_b, cross(arm_b, impulse))
    put_vector(scratch, lane + lane_scratch.IMPULSE, linear)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, angular_a)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, angular_b)


@inline
def larger(one: float, other: float) -> Any:
    """Return the larger one of two sizes."""
    return other if other > one else one


@inline
def _together(given: Any, more: Any) -> Any:
    """Add what two points have been given, and that times their arms."""
    return given[0] + more[0], add(given[1], more[1]), add(given[2], more[2])


@inline
def apply_along_normal(lane: int, given: Any, constraints: Array, scratch: Array) -> None:
    """
    Give the bodies of a lane what its four points have been given along the normal; note the
    largest.

        given : of each point, what it has been given, and that times its arms on A and B
    """
    one, two, three, four = given
    largest = larger(scratch[lane + lane_scratch.LARGEST_CHANGE], abs(one[0]))
    largest = larger(larger(largest, abs(two[0])), abs(three[0]))
    scratch[lane + lane_scratch.LARGEST_CHANGE] = larger(largest, abs(four[0]))
    total, moment_a, moment_b = _together(_together(_together(one, two), three), four)
    normal = vector(constraints, lane + constraint.NORMAL)
    angular_a = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A)
    angular_b = vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B)
    angular_a = subtract(angular_a, cross(moment_a, normal))
    angular_b = add(angular_b, cross(moment_b, normal))
    add_to_vector(scratch, lane + lane_scratch.IMPULSE, total, normal)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, angular_a)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, angular_b)


@inline
def apply_angular_impulse(scratch: Array, lane: int, impulse: Any) -> None:
    """Give B an angular impulse [N m s], and A its opposite."""
    angular_a = subtract(vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A), impulse)
    angular_b = add(vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B), impulse)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_A, angular_a)
    put_vector(scratch, lane + lane_scratch.ANGULAR_MOMENTUM_B, angular_b)


@inline
def displacement_by_turn(turn: Any, scalar: float, arm: Any) -> Any:
    """
    Motion of the end of an arm by a turn: w t + u x t, t = 2 u x r.

    turn, scalar : vector part u and scalar part w of its quaternion
    """
    twice = scale(2.0, cross(turn, arm))
    return add(scale(scalar, twice), cross(turn, twice))
