# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A heavy symmetric top precesses steadily about its pivot: case g of the comparison of engines.

    about the pivot  I = (A, A, C), A = 0.1 + m l^2,   torque = -m g l e x z

The end is the steady precession R_z(W t) R_x(tilt) R_z(psi t).
"""

from __future__ import annotations

import math

from rigid_body_sim.exact import heavy_top
from rigid_body_sim.report.problem import (
    Problem,
    attitude_error,
    ladder,
    principal,
    scene_document,
)

MASS, ARM, GRAVITY = 1.0, 0.5, 9.81  # [kg], l [m], [m/s^2]
CENTRAL, AXIAL = 0.1, 0.15  # across and along the axis, about the centre [kg m^2]
ACROSS = CENTRAL + MASS * ARM**2  # A, about the pivot
TILT, PRECESSION = math.radians(30.0), 2.0  # [rad], W [rad/s]
WEIGHT = MASS * GRAVITY * ARM  # [N m]
SPIN = heavy_top.spin_for(
    PRECESSION, inertia_across=ACROSS, inertia_axial=AXIAL, weight_moment=WEIGHT, tilt=TILT
)
DURATION = 10.0  # [s]

PROBLEM = Problem(
    name='heavy_top',
    title='Heavy top: steady precession',
    description='A top of 1 kg, its centre 0.5 m from the pivot, leans by 30 degrees, spins at '
    '20.4 rad/s and precesses at 2 rad/s for 10 s.',
    shows='The fast spin sets the step, the slow precession the accuracy wanted.',
    document=scene_document(
        'heavy_top',
        [
            {
                'name': 'top',
                'mass': MASS,
                'inertia': principal((CENTRAL, CENTRAL, AXIAL)),
                'pivot': {'point': [0.0, 0.0, -ARM], 'at': [0.0, 0.0, 0.0]},
                'initial': {
                    'orientation': [math.sin(TILT / 2), 0.0, 0.0, math.cos(TILT / 2)],
                    'angular_velocity_body': [0.0, PRECESSION * math.sin(TILT), SPIN],
                },
            }
        ],
        gravity=(0.0, 0.0, -GRAVITY),
    ),
    duration=DURATION,
    error=attitude_error(
        heavy_top.steady(DURATION, precession=PRECESSION, spin=SPIN, tilt=TILT).orientation
    ),
    error_unit='rad',
    reference='steady precession of the Lagrange top',
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'dmv6',
        'force_gradient4',
        'blanes_moan4',
        'blanes_moan4:drift=exact',
        'exact_rotor',
        'implicit_midpoint',
        'rk4',
        'lie_rk4',
        'rk45',
        'rk8',
    ),
    steps=ladder(0.5, 0.0001),
    tick=1.0,
)
