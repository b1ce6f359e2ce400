# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ten boxes stand on each other: case f of the comparison of engines.

They begin in exact contact and at rest, and that is where they belong.
"""

from __future__ import annotations

from rigid_body_sim.report.problem import (
    CONTACT_ERRORS,
    Problem,
    ladder,
    position_error,
    scene_document,
)

GRAVITY, FRICTION, SIZE, BOXES = 9.81, 0.5, 0.2, 10  # [m/s^2], [-], [m]
PLACES = [(0.0, 0.0, SIZE * (index + 0.5)) for index in range(BOXES)]

PROBLEM = Problem(
    name='stack',
    title='Stack: ten boxes at rest',
    description='Ten boxes of 1 kg and 0.2 m stand on each other for 10 s, friction 0.5.',
    shows='Soft contacts sink, unconverged ones creep, and some stacks fall.',
    document=scene_document(
        'stack',
        [
            {
                'name': 'ground',
                'shape': {'type': 'plane', 'normal': [0, 0, 1]},
                'friction': FRICTION,
            },
            *(
                {
                    'name': f'box_{index + 1}',
                    'shape': {'type': 'box', 'size': [SIZE] * 3},
                    'mass': 1.0,
                    'friction': FRICTION,
                    'initial': {'position': list(place)},
                }
                for index, place in enumerate(PLACES)
            ),
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=10.0,
    error=position_error([(0.0, 0.0, 0.0), *PLACES]),
    error_unit='m',
    reference='statics: nothing moves',
    useless=0.1,
    integrators=('dmv6',),
    steps=ladder(0.1, 0.001),
    errors=CONTACT_ERRORS,
    tick=0.02,
)
