# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a batch of contacts needs once in a tick: effective masses of its points.

    effective mass along the normal 1/K_nn, along the tangents 1/lambda_max:
    K_uv = u . (1/m_A + 1/m_B) v + (r_A x u) . I_A^-1 (r_A x v) + (r_B x u) . I_B^-1 (r_B x v)
    lambda_max = (K_11 + K_22)/2 + sqrt((K_11 - K_22)^2/4 + K_12^2)

an entry of J M^-1 J^T each.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.solver import constraint, contact_point, wide_lanes
from rigid_body_sim.physics.vectors import apply_symmetric, cross, dot

IMMOVABLE = 1e-24  # [1/kg] less gives way to no impulse: a normal through a pivot


@inline
def _largest_eigenvalue(k11: float, k12: float, k22: float) -> Any:
    """Larger eigenvalue of a symmetric matrix (2, 2)."""
    half = 0.5 * (k11 - k22)
    return 0.5 * (k11 + k22) + math.sqrt(half * half + k12 * k12)


@kernel
def effective_masses(lanes: int, constraints: Array, points: Array) -> None:
    """Find the effective masses of one point of each lane."""
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        inverse_a = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_A)
        inverse_b = wide_lanes.symmetric(constraints, lane + constraint.INVERSE_INERTIA_B)
        inverse_mass = (
            constraints[lane + constraint.INVERSE_MASS_A]
            + constraints[lane + constraint.INVERSE_MASS_B]
        )
        moment_a, moment_b = cross(arm_a, normal), cross(arm_b, normal)
        turn_a = apply_symmetric(inverse_a, moment_a)
        turn_b = apply_symmetric(inverse_b, moment_b)
        k_normal = inverse_mass + (dot(moment_a, turn_a) + dot(moment_b, turn_b))
        first_a, first_b = cross(arm_a, tangent_1), cross(arm_b, tangent_1)
        second_a, second_b = cross(arm_a, tangent_2), cross(arm_b, tangent_2)
        turn_2_a = apply_symmetric(inverse_a, second_a)
        turn_2_b = apply_symmetric(inverse_b, second_b)
        k11 = inverse_mass + (
            dot(first_a, apply_symmetric(inverse_a, first_a))
            + dot(first_b, apply_symmetric(inverse_b, first_b))
        )
        k22 = inverse_mass + (dot(second_a, turn_2_a) + dot(second_b, turn_2_b))
        k12 = dot(first_a, turn_2_a) + dot(first_b, turn_2_b)
        largest = _largest_eigenvalue(k11, k12, k22)
        points[lane + contact_point.CROSS_TERM_1] = dot(first_a, turn_a) + dot(first_b, turn_b)
        points[lane + contact_point.CROSS_TERM_2] = dot(second_a, turn_a) + dot(second_b, turn_b)
        points[lane + contact_point.NORMAL_MASS] = 1.0 / k_normal if k_normal > IMMOVABLE else 0.0
        points[lane + contact_point.TANGENT_MASS] = 1.0 / largest if largest > 0.0 else 0.0


@kernel
def angular_effective_masses(lanes: int, constraints: Array) -> None:
    """Find the effective masses against rolling and twisting; without inertia there are none."""
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        a_xx, a_xy, a_xz, a_yy, a_yz, a_zz = wide_lanes.symmetric(
            constraints, lane + constraint.INVERSE_INERTIA_A
        )
        b_xx, b_xy, b_xz, b_yy, b_yz, b_zz = wide_lanes.symmetric(
            constraints, lane + constraint.INVERSE_INERTIA_B
        )
        inverse = (a_xx + b_xx, a_xy + b_xy, a_xz + b_xz, a_yy + b_yy, a_yz + b_yz, a_zz + b_zz)
        second = apply_symmetric(inverse, tangent_2)
        k_twist = dot(normal, apply_symmetric(inverse, normal))
        k11 = dot(tangent_1, apply_symmetric(inverse, tangent_1))
        k22 = dot(tangent_2, second)
        k12 = dot(tangent_1, second)
        largest = _largest_eigenvalue(k11, k12, k22)
        constraints[lane + constraint.ROLLING_MASS] = 1.0 / largest if largest > 0.0 else 0.0
        constraints[lane + constraint.TWIST_MASS] = 1.0 / k_twist if k_twist > 0.0 else 0.0
