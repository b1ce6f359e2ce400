# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A controller in Python: a satellite turns to where it should look, without ROS.

    torque = -k_p 2 q_v - k_d omega,   body axes        q_v : vector part of the attitude error

A wrench that is set is held until it is set anew, so the controller runs ten times slower than the
physics here, as a real one does.
"""

import numpy as np

from rigid_body_sim import Simulation, load_scene

PROPORTIONAL, DERIVATIVE = 2.0, 3.0  # [N m], [N m s]
EVERY = 10  # [tick] between two commands

scene = load_scene(
    {
        'name': 'pointing',
        'dt': 0.01,
        'bodies': [
            {
                'name': 'satellite',
                'mass': 12.0,
                'inertia': {'ixx': 0.8, 'iyy': 1.1, 'izz': 1.4},
                'initial': {
                    'orientation': [0.5, 0.5, 0.5, 0.5],
                    'angular_velocity_body': [0.2, -0.1, 0.3],
                },
            }
        ],
    }
)

simulation = Simulation(scene)
print('  t [s]   angle from the target [deg]   |omega| [rad/s]')
angle = np.inf
for command in range(400):
    q = simulation.state.orientation[0]  # the target is the identity, so q is the error itself
    omega = simulation.state.angular_velocity_body[0]
    angle = 2 * np.arctan2(np.linalg.norm(q[:3]), abs(q[3]))
    if command % 80 == 0:
        print(f'{simulation.time:7.1f} {np.degrees(angle):19.4f} {np.linalg.norm(omega):22.5f}')
    shortest = q if q[3] >= 0 else -q
    torque = -2 * PROPORTIONAL * shortest[:3] - DERIVATIVE * omega
    simulation.set_wrench('satellite', torque=tuple(torque), frame='body')
    simulation.step(EVERY)

assert np.degrees(angle) < 1e-3
