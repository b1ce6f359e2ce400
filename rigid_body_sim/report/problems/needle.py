# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A thin rod spins about an axis oblique to its own: case b of the comparison of engines.

Its moments differ a thousandfold; an attitude error changes the fast rate by as much.
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

MOMENTS = (0.001, 1.0, 1.0)  # [kg m^2]
RATE = (60.0, 80.0, 0.0)  # [rad/s] body axes
DURATION = 10.0  # [s]

PROBLEM = Problem(
    name='needle',
    title='Needle: a thin rod that spins',
    description='A rod with moments 0.001, 1 and 1 kg m^2 turns at 100 rad/s, 60 of them about '
    'its own axis, for 10 s; nothing acts on it.',
    shows='Methods that treat the gyroscopic term explicitly lose a thin rod at any affordable '
    'step.',
    document=scene_document(
        'needle',
        [
            {
                'name': 'needle',
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
    reference="Jacobi's elliptic functions, right to 1e-13 rad: the round-off of 1000 rad",
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'five_rotations',
        'rk4',
        'lie_rk4',
        'rk45',
        'rk8',
        'dmv6',
        'dmv10',
        'taylor16',
        'exact_rotor',
    ),
    steps=ladder(0.02, 0.0001),
    steps_of={name: ladder(10.0, 0.0001) for name in ('taylor16', 'exact_rotor')},
    tick=1.0,
    closed_form=('exact_rotor',),
)
