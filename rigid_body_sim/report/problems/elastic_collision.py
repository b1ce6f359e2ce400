# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two balls push each other off without loss: momentum and energy tell where they go."""

from __future__ import annotations

from rigid_body_sim.exact.collision import impact
from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    LECTURE,
    Problem,
    ladder,
    position_error,
    scene_document,
)

RADIUS, GAP = 0.1, 1.0  # [m], [m] between their surfaces at the start
MASSES, SPEEDS = (2.0, 1.0), (1.3, -0.45)  # [kg], [m/s] along x
DURATION = 2.0  # [s]
MEETING = GAP / (SPEEDS[0] - SPEEDS[1])  # [s]
STARTS = (-RADIUS - 0.5 * GAP, RADIUS + 0.5 * GAP)  # [m]
AFTER = impact(
    mass_a=MASSES[0],
    mass_b=MASSES[1],
    velocity_a=[SPEEDS[0]],
    velocity_b=[SPEEDS[1]],
    normal=[1.0],
    restitution=1.0,
)
ENDS = [
    (start + speed * MEETING + float(later[0]) * (DURATION - MEETING), 0.0, 0.0)
    for start, speed, later in zip(
        STARTS, SPEEDS, (AFTER.velocity_a, AFTER.velocity_b), strict=True
    )
]

PROBLEM = Problem(
    name='elastic_collision',
    heading=LECTURE,
    title='Elastic push: two balls meet once',
    description='Balls of 2 and 1 kg meet at 1.3 and -0.45 m/s and part without loss, looked at '
    'after 2 s.',
    shows='Momentum and energy are kept to rounding; what is left is the instant of the impact, '
    'which a step does not resolve.',
    document=scene_document(
        'elastic_collision',
        [
            {
                'name': name,
                'shape': {'type': 'sphere', 'radius': RADIUS},
                'mass': mass,
                'restitution': 1.0,
                'friction': 0.0,
                'initial': {'position': [start, 0.0, 0.0], 'velocity': [speed, 0.0, 0.0]},
            }
            for name, mass, start, speed in zip(
                ('heavy', 'light'), MASSES, STARTS, SPEEDS, strict=True
            )
        ],
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=position_error(ENDS),
    error_unit='m',
    reference='momentum and energy before and after',
    useless=0.2,
    integrators=('dmv6',),
    steps=ladder(0.02, 0.0001),
    errors=CONTACT_ERRORS,
    tick=0.02,
)
