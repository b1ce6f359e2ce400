# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball bounces without loss: case d1 of the comparison of engines, looked at between two impacts.

    t0 = sqrt(2 h/g),   height = h - g s^2/2,   s = (t + t0) mod 2 t0 - t0
"""

from __future__ import annotations

import math

from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
)

GRAVITY, HEIGHT, RADIUS = 9.81, 1.0, 0.1  # [m/s^2], [m] under the ball, [m]
DURATION = 8.8  # [s] ten falls; not a multiple of the time between impacts


def height(t: float) -> float:
    """Height [m] of the lowest point at a time [s]."""
    fall = math.sqrt(2.0 * HEIGHT / GRAVITY)
    s = (t + fall) % (2.0 * fall) - fall
    return HEIGHT - 0.5 * GRAVITY * s * s


PROBLEM = Problem(
    name='bounce',
    title='Bounce: ten impacts without loss',
    description='A ball of 1 kg falls from 1 m above the ground and bounces for 8.8 s, '
    'restitution 1.',
    shows='An impact seen only at the end of a step comes late; what is lost or gained there '
    'adds up.',
    document=scene_document(
        'bounce',
        [
            {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.0},
            {
                'name': 'ball',
                'shape': {'type': 'sphere', 'radius': RADIUS},
                'mass': 1.0,
                'restitution': 1.0,
                'friction': 0.0,
                'initial': {'position': [0.0, 0.0, HEIGHT + RADIUS]},
            },
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=position_error([(0.0, 0.0, 0.0), (0.0, 0.0, RADIUS + height(DURATION))]),
    error_unit='m',
    reference='parabolas between reflections',
    useless=0.2,
    integrators=('dmv6', 'dmv6:contact=event'),
    steps=ladder(0.02, 0.0001),
    steps_of={'dmv6:contact=event': ladder(0.02, 0.002)},
    errors=CONTACT_ERRORS,
    tick=0.02,
)
