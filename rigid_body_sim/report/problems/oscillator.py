# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A point mass on a spring for a hundred periods: case c2 of the comparison of engines.

The error is the distance in phase space, sqrt(|dx|^2 + |dv / omega|^2).
"""

from __future__ import annotations

import math

import numpy as np

from rigid_body_sim.exact.oscillator import oscillation
from rigid_body_sim.report.problem import Final, Problem, ladder, scene_document

OMEGA = 2.0 * math.pi  # [rad/s]
MASS, STIFFNESS = 1.0, OMEGA**2  # [kg], [N/m]
START = (1.0, 0.0, 0.0)  # [m]
DURATION = 100.0  # [s] a hundred periods
END = oscillation(DURATION, mass=MASS, stiffness=STIFFNESS, position=START)


def error(final: Final) -> float:
    """Distance [m] in phase space."""
    apart = final.position[0] - END.position
    slower = (final.velocity[0] - END.velocity) / OMEGA
    return float(np.sqrt(apart @ apart + slower @ slower))


PROBLEM = Problem(
    name='oscillator',
    title='Oscillator: a hundred periods of a spring',
    description='A point mass of 1 kg swings on a spring with a period of 1 s and an amplitude of '
    '1 m for 100 s.',
    shows='The phase runs away by the error of the frequency; energy is kept by symmetric '
    'methods alone.',
    document=scene_document(
        'oscillator',
        [
            {
                'name': 'ball',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'position': list(START)},
            }
        ],
        forces=[{'type': 'spring', 'a': 'ball', 'b': 'world', 'stiffness': STIFFNESS}],
    ),
    duration=DURATION,
    error=error,
    error_unit='m',
    reference='cosine and sine',
    useless=0.5,
    integrators=(
        'semi_implicit_euler',
        'dmv6',
        'force_gradient4',
        'blanes_moan4',
        'implicit_midpoint',
        'rk4',
        'rk45',
        'rk8',
        'linear_propagator',
    ),
    steps=ladder(0.5, 0.001),
    steps_of={'linear_propagator': ladder(100.0, 0.1)},
    tick=10.0,
    closed_form=('linear_propagator',),
)
