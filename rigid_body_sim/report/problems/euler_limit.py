# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Friction alone, v' = -k v: explicit Euler multiplies by 1 - k h, and grows from h = 2/k on.

    |1 - k h| <= 1   <=>   h <= 2/k
"""

from __future__ import annotations

import math

from rigid_body_sim.report.problem import LECTURE, Final, Problem, scene_document

MASS, RATE, SPEED = 1.0, 10.0, 1.0  # [kg], k [1/s]: the limit is 0.2 s, [m/s]
DURATION = 6.0  # [s]
LEFT = SPEED * math.exp(-RATE * DURATION)


def error(final: Final) -> float:
    """Difference of the speed [m/s]."""
    return float(abs(final.velocity[0, 0] - LEFT))


PROBLEM = Problem(
    name='euler_limit',
    heading=LECTURE,
    title='The limit 2/k of explicit Euler',
    description='A point mass of 1 kg is braked by a friction of 10 N s/m for 6 s, after which '
    'nothing is left of its 1 m/s.',
    shows='With steps above 2/k = 0.2 s explicit Euler throws the speed beyond zero, further each '
    'time; other explicit methods have limits of their own; implicit Euler none.',
    document=scene_document(
        'euler_limit',
        [
            {
                'name': 'sled',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'velocity': [SPEED, 0.0, 0.0]},
            }
        ],
        forces=[{'type': 'drag', 'body': 'sled', 'linear': RATE * MASS}],
    ),
    duration=DURATION,
    error=error,
    error_unit='m/s',
    reference='the exponential',
    useless=SPEED,
    enough=1e-12,
    integrators=('explicit_euler', 'midpoint', 'rk4', 'implicit_euler', 'sdirk2', 'rk45'),
    # about the limits h k: 2 of Euler and midpoint, 2.78 of rk4
    steps=(0.5, 0.4, 0.3, 0.25, 0.24, 0.2, 0.15, 0.12, 0.1, 0.05, 0.02, 0.01),
    tick=0.5,
)
