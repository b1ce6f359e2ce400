# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An elastic smooth cube tumbles over the ground: its energy is that of the start.

    E = m v^2/2 + m a^2 w^2/12 + m g z
Where it is after some impacts no engine can tell: each multiplies an error. Energy all owe.
"""

from __future__ import annotations

import numpy as np

from rigid_body_sim.report.problem import CONTACT_ERRORS, Final, Problem, ladder, scene_document

MASS, SIDE, GRAVITY, HEIGHT = 1.0, 0.2, 9.81, 0.8  # [kg], [m], [m/s^2], [m]
VELOCITY, RATE = (0.5, 0.1, 0.0), (3.0, 2.0, 5.0)  # [m/s], [rad/s]
DURATION = 10.0  # [s]


def energy(position: object, velocity: object, angular_velocity: object) -> float:
    """Energy [J] of the cube."""
    v, w = np.asarray(velocity), np.asarray(angular_velocity)
    height = float(np.asarray(position)[2])
    return MASS * float(v @ v / 2 + SIDE**2 * (w @ w) / 12 + GRAVITY * height)


START = energy((0.0, 0.0, HEIGHT), VELOCITY, RATE)


def energy_error(final: Final) -> float:
    """Change of the energy, over that of the start."""
    end = energy(final.position[1], final.velocity[1], final.angular_velocity[1])
    return abs(end - START) / START


PROBLEM = Problem(
    name='tumbling_cube',
    title='Tumbling cube: impacts of edges and corners without loss',
    description='A smooth cube of 1 kg and 0.2 m falls turning from 0.8 m and tumbles for 10 s, '
    'restitution 1.',
    shows='Whoever takes the velocity of the start of a step for that of the impact loses energy '
    'at each one, or gains it.',
    document=scene_document(
        'tumbling_cube',
        [
            {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': 0.0},
            {
                'name': 'cube',
                'shape': {'type': 'box', 'size': [SIDE] * 3},
                'mass': MASS,
                'restitution': 1.0,
                'friction': 0.0,
                'initial': {
                    'position': [0.0, 0.0, HEIGHT],
                    'velocity': list(VELOCITY),
                    'angular_velocity': list(RATE),
                },
            },
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        contact={'mode': 'timestep'},
    ),
    duration=DURATION,
    error=energy_error,
    error_unit='of the energy',
    reference='the energy of the start',
    useless=0.5,
    integrators=('dmv6', 'dmv6:contact=event'),
    steps=ladder(0.02, 0.0001),
    steps_of={'dmv6:contact=event': ladder(0.02, 0.002)},
    errors=CONTACT_ERRORS,
    tick=0.02,
)
