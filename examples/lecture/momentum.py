# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Momentum and angular momentum: forces between bodies change neither sum."""

import numpy as np
from lesson import claim, follow

scene = {
    'dt': 0.001,
    'bodies': [
        {
            'name': name,
            'shape': {'type': 'particle'},
            'mass': mass,
            'initial': {'position': position, 'velocity': velocity},
        }
        for name, mass, position, velocity in (
            ('red', 1.0, [0, 0, 0], [0, 1, 0]),
            ('blue', 3.0, [1, 0, 0], [0, -1, 0.5]),
        )
    ],
    'forces': [{'type': 'spring', 'a': 'red', 'b': 'blue', 'stiffness': 20, 'rest_length': 0.5}],
}
run = follow(scene, 5.0, 0.02)
masses = np.array([1.0, 3.0])

change = run.momentum - run.momentum[0]
claim('the sum of m v stays', change, within=1e-12, unit='kg m/s')
change = run.angular_momentum - run.angular_momentum[0]
claim('the sum of r × m v stays', change, within=1e-12, unit='kg m²/s')
centre = np.tensordot(masses, run.position, axes=(0, 1)) / masses.sum()
steady = centre[0] + np.outer(run.time, run.momentum[0] / masses.sum())
claim('the centre of mass goes straight', centre - steady, within=1e-12, unit='m')
claim('the energy stays while they swing', run.energy / run.energy[0] - 1, within=1e-4)


def draw(axes):
    """The two paths and that of their centre."""
    for body, name in enumerate(('red', 'blue')):
        axes.plot(run.position[:, body, 1], run.position[:, body, 0], label=name)
    axes.plot(centre[:, 1], centre[:, 0], '--', label='centre of mass')
    axes.set(xlabel='y [m]', ylabel='x [m]', aspect='equal')
