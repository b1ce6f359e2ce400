# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A body hangs on a balloon: the torque depends on the orientation.

    torque = kappa e x z,   e : third axis of the body,   z : up,   kappa = m g l

The balloon lifts by the weight at the point (0, 0, l) of the body, so the centre of mass stays
where it is. The end is known from a Taylor series in 34 digits of w, q and g = R^T z, g' = g x w.
"""

from __future__ import annotations

from decimal import Decimal

from rigid_body_sim.exact import quadratic_flow
from rigid_body_sim.report.problem import (
    Problem,
    attitude_error,
    ladder,
    principal,
    scene_document,
)

MOMENTS = (1.0, 2.0, 2.5)  # [kg m^2]
RATE = (0.5, 1.0, 1.5)  # [rad/s] body axes
MASS, ARM, GRAVITY = 1.0, 0.5, 8.0  # [kg], l [m], [m/s^2]
KAPPA = MASS * GRAVITY * ARM  # 4 N m
DURATION = 10.0  # [s]


def exact_end() -> list[float]:
    """Orientation xyzw after the duration."""
    kappa = Decimal(KAPPA)
    terms = [
        *quadratic_flow.euler_terms(MOMENTS),  # w in y[1:4]
        (1, -kappa / Decimal(MOMENTS[0]), 9, 0),  # torque = kappa (-g_y, g_x, 0)
        (2, kappa / Decimal(MOMENTS[1]), 8, 0),
        *quadratic_flow.rotation_terms(1, 4),  # q in y[4:8]
        *((8, 1, 9, 3), (8, -1, 10, 2)),  # g' = g x w, g in y[8:11]
        *((9, 1, 10, 1), (9, -1, 8, 3)),
        *((10, 1, 8, 2), (10, -1, 9, 1)),
    ]
    start = [*RATE, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]
    return quadratic_flow.solution(terms, start, [DURATION], step=0.1)[0, 3:7].tolist()


PROBLEM = Problem(
    name='orientation_torque',
    title='A torque that depends on orientation',
    description='A body with moments 1, 2 and 2.5 kg m^2 tumbles for 10 s below a balloon that '
    'bears its weight of 8 N, tied to it 0.5 m from the centre.',
    shows='A torque that varies within a step takes the free-rotation methods back to order two; '
    'compositions and Runge–Kutta methods keep theirs.',
    document=scene_document(
        'orientation_torque',
        [
            {
                'name': 'load',
                'mass': MASS,
                'inertia': principal(MOMENTS),
                'initial': {'angular_velocity_body': list(RATE)},
            }
        ],
        forces=[
            {
                'type': 'constant',
                'body': 'load',
                'force': [0.0, 0.0, MASS * GRAVITY],
                'point': [0.0, 0.0, ARM],
            }
        ],
        gravity=(0.0, 0.0, -GRAVITY),
    ),
    duration=DURATION,
    error=attitude_error(exact_end()),
    error_unit='rad',
    reference='Taylor series in 34 digits',
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'dmv6',
        'force_gradient4',
        'blanes_moan4',
        'implicit_midpoint',
        'rk4',
        'lie_rk4',
        'rk45',
        'rk8',
    ),
    steps=ladder(0.5, 0.0002),
    tick=2.0,
)
