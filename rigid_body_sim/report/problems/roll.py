# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball slides, then rolls: case e2 of the comparison of engines, by its place.

    sliding until t = 2 v/(7 mu g), then rolling at 5 v/7
"""

from __future__ import annotations

from rigid_body_sim.exact.sliding import wheel
from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
)

GRAVITY, FRICTION, SPEED, RADIUS = 9.81, 0.3, 5.0, 0.1  # [m/s^2], [-], [m/s], [m]
DURATION = 1.0  # [s]
WAY = wheel(DURATION, speed=SPEED, friction=FRICTION, gravity=GRAVITY, beta=0.4).distance  # [m]


PROBLEM = Problem(
    name='roll',
    title='Roll: a ball begins to roll',
    description='A ball of 1 kg and 0.1 m slides onto the ground at 5 m/s without spin, friction '
    '0.3, and rolls from 0.485 s on; looked at after 1 s.',
    shows='The instant at which sliding turns into rolling lies within a step.',
    document=scene_document(
        'roll',
        [
            {
                'name': 'ground',
                'shape': {'type': 'plane', 'normal': [0, 0, 1]},
                'friction': FRICTION,
            },
            {
                'name': 'ball',
                'shape': {'type': 'sphere', 'radius': RADIUS},
                'mass': 1.0,
                'friction': FRICTION,
                'initial': {'position': [0.0, 0.0, RADIUS], 'velocity': [SPEED, 0.0, 0.0]},
            },
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=position_error([(0.0, 0.0, 0.0), (float(WAY), 0.0, RADIUS)]),
    error_unit='m',
    reference="Coulomb's friction and the moment 2/5 m R^2",
    useless=0.5,
    integrators=('dmv6',),
    steps=ladder(0.1, 0.0002),
    errors=CONTACT_ERRORS,
    tick=0.02,
)
