# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A stone is thrown: case c1 of the comparison of engines.

Any method of order two takes a parabola in one step; what is left is round-off and the cost of a
call.
"""

from __future__ import annotations

from rigid_body_sim.exact.ballistic import flight
from rigid_body_sim.report.problem import Problem, ladder, position_error, scene_document

GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]
VELOCITY = (3.0, 4.0, 20.0)  # [m/s]
DURATION = 4.0  # [s]
END = flight(DURATION, position=(0.0, 0.0, 0.0), velocity=VELOCITY, acceleration=GRAVITY)

PROBLEM = Problem(
    name='projectile',
    title='Projectile: a parabola',
    description='A point mass is thrown at (3, 4, 20) m/s and flies for 4 s under gravity.',
    shows='Methods of order two and more are exact at any step; those of order one are wrong by '
    'g T h / 2.',
    document=scene_document(
        'projectile',
        [
            {
                'name': 'stone',
                'shape': {'type': 'particle'},
                'mass': 1.0,
                'initial': {'velocity': list(VELOCITY)},
            }
        ],
        gravity=GRAVITY,
    ),
    duration=DURATION,
    error=position_error(END.position),
    error_unit='m',
    reference='the parabola',
    useless=5.0,
    integrators=('explicit_euler', 'semi_implicit_euler', 'dmv6', 'rk4', 'rk8'),
    steps=(4.0, 2.0, *ladder(1.0, 0.0001)),
    tick=4.0,
    most_steps=40_000,
)
