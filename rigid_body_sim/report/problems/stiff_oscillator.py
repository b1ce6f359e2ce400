# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A point mass on a stiff spring in treacle: two rates, four thousand apart.

    m x'' = -k x - c x',   c^2 >> 4 m k:   slow rate k/c = 5 1/s,   fast rate c/m = 20 000 1/s
"""

from __future__ import annotations

from rigid_body_sim.exact.oscillator import oscillation
from rigid_body_sim.report.problem import Problem, ladder, position_error, scene_document

MASS, STIFFNESS, DAMPING = 1.0, 1e5, 2e4  # [kg], [N/m], [N s/m]
START = (1.0, 0.0, 0.0)  # [m]
DURATION = 1.0  # [s]
END = oscillation(DURATION, mass=MASS, stiffness=STIFFNESS, damping=DAMPING, position=START)
IMPLICIT = ('implicit_euler', 'sdirk2', 'implicit_midpoint', 'linearly_implicit')

PROBLEM = Problem(
    name='stiff_oscillator',
    title='Stiff oscillator: a heavily damped spring',
    description='A point mass of 1 kg creeps back to rest on a spring of 1e5 N/m with a damper of '
    '2e4 N s/m for 1 s: the motion takes 0.2 s, the damper 50 us.',
    shows='Explicit methods must resolve what has long died out; implicit ones step with the '
    'motion.',
    document=scene_document(
        'stiff_oscillator',
        [
            {
                'name': 'ball',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'position': list(START)},
            }
        ],
        forces=[
            {
                'type': 'spring',
                'a': 'ball',
                'b': 'world',
                'stiffness': STIFFNESS,
                'damping': DAMPING,
            }
        ],
    ),
    duration=DURATION,
    error=position_error(END.position),
    error_unit='m',
    reference='two exponentials',
    useless=0.002,
    integrators=(*IMPLICIT, 'rk4', 'rk45', 'rk8', 'dmv6', 'linear_propagator'),
    steps=ladder(0.0005, 0.00001),
    steps_of={
        **{name: ladder(0.5, 0.0001) for name in IMPLICIT},
        'linear_propagator': ladder(1.0, 0.1),
    },
    tick=0.5,
    closed_form=('linear_propagator',),
)
