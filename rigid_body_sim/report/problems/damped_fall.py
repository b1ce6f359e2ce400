# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball is thrown and falls against the resistance of the air, linear in its speed.

    v = v_inf + (v0 - v_inf) e^(-c t/m),   v_inf = m g/c
"""

from __future__ import annotations

from rigid_body_sim.exact.drag import linear
from rigid_body_sim.report.problem import Problem, ladder, position_error, scene_document

MASS, DRAG = 1.0, 0.5  # [kg], [N s/m]
GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]
VELOCITY = (10.0, 0.0, 10.0)  # [m/s]
DURATION = 5.0  # [s]
END = linear(
    DURATION,
    mass=MASS,
    coefficient=DRAG,
    acceleration=GRAVITY,
    position=(0.0, 0.0, 0.0),
    velocity=VELOCITY,
)

PROBLEM = Problem(
    name='damped_fall',
    title='Damped fall: drag linear in speed',
    description='A point mass of 1 kg is thrown at (10, 0, 10) m/s and falls for 5 s against a '
    'drag of 0.5 N s/m.',
    shows='A force that depends on velocity costs splitting methods twice the evaluations.',
    document=scene_document(
        'damped_fall',
        [
            {
                'name': 'ball',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'velocity': list(VELOCITY)},
            }
        ],
        forces=[{'type': 'drag', 'body': 'ball', 'linear': DRAG}],
        gravity=GRAVITY,
    ),
    duration=DURATION,
    error=position_error(END.position),
    error_unit='m',
    reference='an exponential',
    useless=1.0,
    integrators=(
        'semi_implicit_euler',
        'dmv6',
        'sdirk2',
        'force_gradient4',
        'rk4',
        'rk45',
        'rk8',
        'linear_propagator',
    ),
    steps=ladder(1.0, 0.0005),
    steps_of={'linear_propagator': (5.0, *ladder(1.0, 0.5))},
    tick=5.0,
    closed_form=('linear_propagator',),
)
