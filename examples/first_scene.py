# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A first scene: a stone is thrown, and lands where Galileo says.

    r(t) = r0 + v0 t + g t^2/2

A scene is a mapping of the same keys as a YAML file; any step is exact here, because the force is
constant.
"""

import numpy as np

from rigid_body_sim import Simulation, load_scene

scene = load_scene(
    {
        'name': 'throw',
        'dt': 0.01,
        'gravity': [0, 0, -9.81],
        'bodies': [
            {
                'name': 'stone',
                'shape': {'type': 'particle'},
                'mass': 0.2,
                'initial': {'position': [0, 0, 1.5], 'velocity': [12, 0, 8]},
            }
        ],
    }
)

simulation = Simulation(scene)
print('  t [s]     x [m]     z [m]   distance from the parabola [m]')
for _ in range(5):
    simulation.step(40)
    t = simulation.time
    exact = np.array([12 * t, 0, 1.5 + 8 * t - 0.5 * 9.81 * t * t])
    (position,) = simulation.state.position
    error = np.linalg.norm(position - exact)
    print(f'{t:7.2f} {position[0]:9.4f} {position[2]:9.4f} {error:12.1e}')
    assert error < 1e-13  # round-off of lengths of 24 m
