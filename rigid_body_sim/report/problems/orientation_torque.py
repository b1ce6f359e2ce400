# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An asymmetric body in a field that pulls its axis upright: the torque depends on the orientation.

    torque = kappa e x z,   e : third axis of the body,   z : up

Two long weak springs make the field: from (0, 0, l) of the body to a point high above, from
(0, 0, -l) to one as far below. Their forces cancel, and kappa = 2 k l H is exact at any attitude.
The end is known from a Taylor series in 34 digits of w, q and g = R^T z, g' = g x w.
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
ARM, HEIGHT, STIFFNESS = 0.5, 8.0, 0.5  # l [m], H [m], k [N/m]
KAPPA = 2.0 * STIFFNESS * ARM * HEIGHT  # 4 N m
DURATION = 10.0  # [s]


def field(body: str, *, arm: float, height: float, stiffness: float) -> list[dict[str, object]]:
    """
    Write the two springs that turn the third axis of a body at the origin upright.

    height : [m] H; negative: they turn it upside down, as gravity turns a top
    """
    return [
        {
            'type': 'spring',
            'a': body,
            'a_point': [0.0, 0.0, side * arm],
            'b': 'world',
            'b_point': [0.0, 0.0, side * height],
            'stiffness': stiffness,
        }
        for side in (1.0, -1.0)
    ]


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
    description='A body with moments 1, 2 and 2.5 kg m^2 tumbles for 10 s in a field that pulls '
    'its third axis upright with 4 N m.',
    shows='A torque that varies within a step takes the free-rotation methods back to order two; '
    'compositions and Runge–Kutta methods keep theirs.',
    document=scene_document(
        'orientation_torque',
        [
            {
                'name': 'magnet',
                'mass': 1.0,
                'inertia': principal(MOMENTS),
                'initial': {'angular_velocity_body': list(RATE)},
            }
        ],
        forces=field('magnet', arm=ARM, height=HEIGHT, stiffness=STIFFNESS),
    ),
    duration=DURATION,
    error=attitude_error(exact_end()),
    error_unit='rad',
    reference='Taylor series in 34 digits',
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'dmv6',
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
