# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box slides to rest between the axes of the ground: case e1b of the comparison of engines.

    distance = v^2/(2 mu g), along the velocity it began with
"""

from __future__ import annotations

import math

from rigid_body_sim.exact.sliding import stopping
from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
)

GRAVITY, FRICTION, SPEED = 9.81, 0.3, 5.0  # [m/s^2], [-], [m/s]
DIRECTION = (math.cos(math.pi / 8.0), math.sin(math.pi / 8.0))
SIZE = (0.4, 0.4, 0.2)  # [m]
_, WAY = stopping(speed=SPEED, friction=FRICTION, gravity=GRAVITY)  # [m]

PROBLEM = Problem(
    name='slide',
    title='Slide: a box comes to rest by friction',
    description='A box of 1 kg slides at 5 m/s, 22.5 degrees off the axes, friction 0.3, and '
    'rests after 4.25 m and 1.7 s; looked at after 2.5 s.',
    shows='A friction pyramid pulls the box off its way; a late stop leaves it too far.',
    document=scene_document(
        'slide',
        [
            {
                'name': 'ground',
                'shape': {'type': 'plane', 'normal': [0, 0, 1]},
                'friction': FRICTION,
            },
            {
                'name': 'box',
                'shape': {'type': 'box', 'size': list(SIZE)},
                'mass': 1.0,
                'friction': FRICTION,
                'initial': {
                    'position': [0.0, 0.0, SIZE[2] / 2.0],
                    'velocity': [SPEED * DIRECTION[0], SPEED * DIRECTION[1], 0.0],
                },
            },
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=2.5,
    error=position_error(
        [(0.0, 0.0, 0.0), (WAY * DIRECTION[0], WAY * DIRECTION[1], SIZE[2] / 2.0)]
    ),
    error_unit='m',
    reference="Coulomb's friction",
    useless=1.0,
    integrators=('dmv6',),
    steps=ladder(0.1, 0.0005),
    errors=CONTACT_ERRORS,
    tick=0.02,
)
