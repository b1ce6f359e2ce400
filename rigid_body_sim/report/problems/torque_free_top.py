# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A free body turns about its middle axis and flips: case a of the comparison of engines.

The exact end is Jacobi's solution; it agrees with a Taylor series in 34 digits to 1e-14 rad.
"""

from __future__ import annotations

from rigid_body_sim.exact import free_asymmetric_top
from rigid_body_sim.report.problem import (
    Problem,
    attitude_error,
    ladder,
    principal,
    scene_document,
)

MOMENTS = (1.0, 2.0, 3.0)  # [kg m^2]
RATE = (0.01, 1.0, 0.01)  # [rad/s] body axes
DURATION = 100.0  # [s]

PROBLEM = Problem(
    name='torque_free_top',
    title='Torque-free top: flips about the middle axis',
    description='A body with moments 1, 2 and 3 kg m^2 is spun at 1 rad/s about its middle axis, '
    'a hundredth beside it, and flips over and over for 100 s; nothing acts on it.',
    shows='Each flip amplifies what went wrong before: phase errors of a method show here.',
    document=scene_document(
        'torque_free_top',
        [
            {
                'name': 'top',
                'mass': 1.0,
                'inertia': principal(MOMENTS),
                'initial': {'angular_velocity_body': list(RATE)},
            }
        ],
    ),
    duration=DURATION,
    error=attitude_error(
        free_asymmetric_top.rotation(
            DURATION, inertia=MOMENTS, angular_velocity_body=RATE
        ).orientation
    ),
    error_unit='rad',
    reference="Jacobi's elliptic functions, right to 1e-14 rad",
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'five_rotations',
        'implicit_midpoint',
        'rk4',
        'lie_rk4',
        'rk45',
        'rk8',
        'dmv6',
        'dmv10',
        'taylor16',
        'exact_rotor',
    ),
    steps=ladder(5.0, 0.001),
    steps_of={name: ladder(100.0, 0.001) for name in ('taylor16', 'exact_rotor')},
    tick=10.0,
    closed_form=('exact_rotor',),
)
