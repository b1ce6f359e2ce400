# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Convex polyhedra: two hulls meet and keep the common momentum; a tetrahedron rests on a face."""

import numpy as np
from lesson import claim, follow

CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * 0.1
HULL = {'type': 'convex_hull', 'vertices': CORNERS.tolist()}

meeting = {
    'dt': 0.002,
    'contact': {'mode': 'timestep'},
    'bodies': [
        {
            'name': name,
            'shape': HULL,
            'mass': mass,
            'restitution': 1.0,
            'friction': 0.0,
            'initial': {'position': [x, y, 0], 'velocity': [v, 0, 0]},
        }
        for name, mass, x, y, v in (('left', 1.0, -0.5, 0.0, 1.0), ('right', 2.0, 0.5, 0.03, -0.5))
    ],
}
met = follow(meeting, 1.0, 0.01)
change = met.momentum - met.momentum[0]
claim('an impact keeps the common momentum', change, within=1e-12, unit='kg m/s')
change = met.angular_momentum - met.angular_momentum[0]
claim('and the common angular momentum', change, within=1e-6, unit='kg m²/s')
loss = 1 - met.energy / met.energy[0]
claim('with restitution 1 an impact loses little of the energy', loss, within=5e-3)
claim('and gives none', np.minimum(loss, 0), within=1e-12)

down = np.array([1, 1, 1]) / np.sqrt(3)  # the face opposite to a corner points to -down
axis, angle = np.cross(-down, [0, 0, -1]), np.arccos(down[2])
turn = np.append(axis / np.linalg.norm(axis) * np.sin(angle / 2), np.cos(angle / 2))
resting = {
    'dt': 0.004,
    'gravity': [0, 0, -9.81],
    'contact': {'mode': 'timestep'},
    'bodies': [
        {'name': 'floor', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
        {
            'name': 'tetrahedron',
            'shape': HULL,
            'mass': 1.0,
            'initial': {'position': [0, 0, 0.1], 'orientation': turn.tolist()},
        },
    ],
}
rest = follow(resting, 1.0, 0.02)
height = 0.1 / np.sqrt(3)  # of the centre above a face
claim('a tetrahedron comes to rest on a face', rest.velocity[-1, 1], within=1e-6, unit='m/s')
claim(
    'its centre a third of 0.1 √3 m above it',
    rest.position[-1, 1, 2] - height,
    within=1e-4,
    unit='m',
)


def draw(axes):
    """Velocities of the two hulls through their impact."""
    for body, name in enumerate(('left, 1 kg', 'right, 2 kg')):
        axes.plot(met.time, met.velocity[:, body, 0], label=name)
    axes.set(xlabel='time [s]', ylabel='velocity along x [m/s]')
