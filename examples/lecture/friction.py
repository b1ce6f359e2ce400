# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Friction: drag slows exponentially, dry friction stops after v²/(2µg)."""

import numpy as np
from lesson import claim, follow

MASS, DRAG, SPEED, MU, G = 1.0, 0.5, 2.0, 0.3, 9.81

boat = {
    'dt': 0.01,
    'integrator': 'linear_propagator',
    'bodies': [
        {
            'name': 'boat',
            'shape': {'type': 'particle'},
            'mass': MASS,
            'initial': {'velocity': [SPEED, 0, 0]},
        }
    ],
    'forces': [{'type': 'drag', 'body': 'boat', 'linear': DRAG}],
}
block = {
    'dt': 0.004,
    'gravity': [0, 0, -G],
    'contact': {'mode': 'timestep'},
    'bodies': [
        {'name': 'table', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}, 'friction': MU},
        {
            'name': 'block',
            'shape': {'type': 'box', 'size': [0.2, 0.2, 0.2]},
            'mass': MASS,
            'friction': MU,
            'initial': {'position': [0, 0, 0.1], 'velocity': [SPEED, 0, 0]},
        },
    ],
}

slow = follow(boat, 3.0, 0.05)
exact = SPEED * np.exp(-DRAG / MASS * slow.time)
claim('drag: v = v₀ exp(-ct/m)', slow.velocity[:, 0, 0] - exact, within=1e-13, unit='m/s')

slide = follow(block, 1.0, 0.02)
v = slide.velocity[:, 1, 0]
exact = np.maximum(SPEED - MU * G * slide.time, 0.0)
claim('dry friction: v = v₀ - µgt until it stops', v - exact, within=1e-3, unit='m/s')
stopped = slide.position[-1, 1, 0] - SPEED**2 / (2 * MU * G)
claim('it stops after v₀²/(2µg)', stopped, within=1e-4, unit='m')
claim('and then stands', slide.velocity[-1, 1], within=1e-9, unit='m/s')


def draw(axes):
    """Speed over time."""
    axes.plot(slow.time, slow.velocity[:, 0, 0], label='drag')
    axes.plot(slide.time, v, '--', label='dry friction')
    axes.set(xlabel='time [s]', ylabel='speed [m/s]')
