# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two carts push each other off by an elastic buffer: momentum and energy tell where they go.

The push lasts pi sqrt(mu/k), half a swing of the reduced mass, and leaves the buffer as it met it:
from there on the carts part with the speeds of an elastic impact.
"""

from __future__ import annotations

import math

from rigid_body_sim.exact.collision import impact
from rigid_body_sim.report.problem import (
    LECTURE,
    Problem,
    ladder,
    position_error,
    scene_document,
)

HEAVY, LIGHT, SPEED, APART = 2.0, 1.0, 3.0, 1.5  # [kg], [kg], [m/s] of the heavy one, [m]
STIFFNESS, LENGTH = 2000.0, 0.2  # [N/m], [m] of the buffer
DURATION = 2.0  # [s]
REDUCED = HEAVY * LIGHT / (HEAVY + LIGHT)
PARTING = (APART - LENGTH) / SPEED + math.pi * math.sqrt(REDUCED / STIFFNESS)  # [s]
AFTER = impact(
    mass_a=HEAVY,
    mass_b=LIGHT,
    velocity_a=[SPEED],
    velocity_b=[0.0],
    normal=[1.0],
    restitution=1.0,
)


def ends() -> list[tuple[float, float, float]]:
    """Where both are at the end [m]: about their centre of mass, which nothing pushes."""
    center = (HEAVY * SPEED * DURATION + LIGHT * APART) / (HEAVY + LIGHT)
    leaving = float(AFTER.velocity_b[0] - AFTER.velocity_a[0])
    apart = LENGTH + leaving * (DURATION - PARTING)
    shares = (-LIGHT / (HEAVY + LIGHT), HEAVY / (HEAVY + LIGHT))
    return [(center + share * apart, 0.0, 0.0) for share in shares]


PROBLEM = Problem(
    name='elastic_collision',
    heading=LECTURE,
    title='Elastic push: two carts meet once',
    description='A cart of 2 kg runs at 3 m/s into the buffer, 2000 N/m, of a cart of 1 kg at '
    'rest, and both are looked at after 2 s.',
    shows='Momentum stays to rounding whatever the method; the force has a kink where the buffer '
    'is met, which takes all methods back to order two.',
    document=scene_document(
        'elastic_collision',
        [
            {
                'name': 'heavy',
                'shape': {'type': 'particle'},
                'mass': HEAVY,
                'initial': {'velocity': [SPEED, 0.0, 0.0]},
            },
            {
                'name': 'light',
                'shape': {'type': 'particle'},
                'mass': LIGHT,
                'initial': {'position': [APART, 0.0, 0.0]},
            },
        ],
        forces=[
            {
                'type': 'bumper',
                'a': 'heavy',
                'b': 'light',
                'stiffness': STIFFNESS,
                'length': LENGTH,
            }
        ],
    ),
    duration=DURATION,
    error=position_error(ends()),
    error_unit='m',
    reference='momentum and energy before and after, and half a swing between',
    useless=0.5,
    integrators=(
        'explicit_euler',
        'semi_implicit_euler',
        'dmv6',
        'implicit_midpoint',
        'rk4',
        'rk45',
        'rk8',
    ),
    steps=ladder(0.02, 0.00002),
    tick=0.02,
)
