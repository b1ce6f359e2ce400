# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rocket climbs and burns three quarters of its mass: Tsiolkovsky's equation."""

from __future__ import annotations

from rigid_body_sim.exact.rocket import ascent
from rigid_body_sim.report.problem import (
    LECTURE,
    Problem,
    ladder,
    position_error,
    scene_document,
)

MASS, FLOW, EXHAUST, GRAVITY = 1000.0, 15.0, 2500.0, 9.81  # [kg], [kg/s], [m/s], [m/s^2]
DURATION = 50.0  # [s]
END = ascent(DURATION, mass=MASS, mass_flow=FLOW, exhaust_speed=EXHAUST, gravity=GRAVITY)

PROBLEM = Problem(
    name='rocket',
    heading=LECTURE,
    title='Rocket: d(mv)/dt',
    description='A rocket of 1000 kg blows 15 kg/s downwards at 2500 m/s and climbs for 50 s.',
    shows='A force over mass that grows with time: no state enters, so the error is that of the '
    'quadrature of each method.',
    document=scene_document(
        'rocket',
        [
            {
                'name': 'rocket',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'mass_rate': -FLOW,
                'exhaust_velocity': [0.0, 0.0, -EXHAUST],
            }
        ],
        gravity=(0.0, 0.0, -GRAVITY),
    ),
    duration=DURATION,
    error=position_error([(0.0, 0.0, float(END.position[0]))]),
    error_unit='m',
    reference="Tsiolkovsky's equation",
    useless=1000.0,
    errors=(1e-1, 1e-3, 1e-5, 1e-7),
    integrators=('explicit_euler', 'semi_implicit_euler', 'dmv6', 'rk4', 'rk45', 'rk8'),
    steps=ladder(10.0, 0.001),
    tick=10.0,
)
