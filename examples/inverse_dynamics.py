# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Inverse dynamics: which wrench explains a recorded motion?

A force that swings is applied, the poses alone are recorded, and the force is found from them:
F = m (a - g), with a from splines through the poses; splines of a higher degree tell the error.
"""

import numpy as np

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.analysis.inverse_dynamics import derive
from rigid_body_sim.analysis.run_steps import RunSteps

EVERY = 5  # [tick] between two recorded poses

scene = load_scene(
    {
        'name': 'shaken',
        'dt': 0.001,
        'bodies': [
            {'name': 'box', 'shape': {'type': 'box', 'size': [0.3, 0.2, 0.1]}, 'mass': 2.0}
        ],
        'forces': [
            {
                'type': 'time',
                'body': 'box',
                'table': [[t, 3 * np.sin(4 * t), 0, 0] for t in np.linspace(0, 2, 201).tolist()],
                'interpolation': 'cubic',
            }
        ],
    }
)

simulation = Simulation(scene)
times, positions, orientations = [], [], []
for _ in range(400):
    times.append(simulation.time)
    positions.append(simulation.state.position[0])
    orientations.append(simulation.state.orientation[0])
    simulation.step(EVERY)

arrays = np.array(times), np.array(positions), np.array(orientations)
# the run itself is in steps of order two, which leave h^2 F'' / 12 in its positions
steps = RunSteps(scene.dt_ns * 1e-9, order=2, turn_order=2, turns_free=True)
found, estimates = derive(*arrays, body=scene.bodies[0], steps=steps)
force = found.force[:, 0]
applied = 3 * np.sin(4 * np.array(times))
error = np.abs(force - applied)
print('  t [s]   force found [N]   force applied [N]')
for k in range(0, 400, 80):
    print(f'{times[k]:7.2f} {force[k]:14.5f} {applied[k]:18.5f}')
print(f'estimated error {estimates["force"].rms:.1e} N')
print(f'largest error {error.max():.1e} N, typical {np.median(error):.1e} N')
assert np.median(error) < 1e-4  # N
assert estimates['force'].rms / 3 < np.sqrt(np.mean(error**2)) < 3 * estimates['force'].rms
