# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bits to which forces over time, mutual gravity, bumpers, flowing mass and pivots lead: also a
program, which prints whether kernels are compiled, and then a line for each integrator.
"""

import hashlib
import sys

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.physics.compile import kernels

SCENE = {
    'version': 1,
    'dt': 0.01,
    'gravity': [0, 0, -9.81],
    'bodies': [
        {
            'name': 'tank',
            'shape': {'type': 'box', 'size': [0.3, 0.2, 0.4]},
            'mass': 3.0,
            'mass_rate': -2.0,
            'exhaust_velocity': [1, 2, -9],
            'final_mass': 2.5123,
            'initial': {'angular_velocity': [1, 2, 3]},
        },
        {
            'name': 'a',
            'shape': {'type': 'particle'},
            'mass': 1.0,
            'initial': {'position': [1, 0, 0]},
        },
        {
            'name': 'b',
            'shape': {'type': 'particle'},
            'mass': 2.0,
            'initial': {'position': [1.3, 0.1, 0], 'velocity': [-3, 0, 0]},
        },
        {
            'name': 'pendulum',
            'shape': {'type': 'box', 'size': [0.1, 0.1, 0.5]},
            'mass': 1.0,
            'pivot': {'point': [0.02, 0, 0.25], 'at': [1, 1, 1]},
            'initial': {'angular_velocity': [1, 2, 30]},
        },
        {
            'name': 'spindle',
            'shape': {'type': 'box', 'size': [0.1, 0.1, 0.5]},
            'mass': 1.0,
            'pivot': {'point': [0, 0, -0.25], 'at': [0, 1, 1]},
            'initial': {'angular_velocity': [1, 2, 60]},
        },
    ],
    'forces': [
        {
            'type': 'spring',
            'a': 'pendulum',
            'a_point': [0, 0, -0.25],
            'b': 'spindle',
            'stiffness': 20,
            'damping': 0.1,
        },
        {'type': 'gravity', 'constant': 0.3, 'softening': 0.01},
        {'type': 'bumper', 'a': 'a', 'b': 'b', 'stiffness': 500, 'length': 0.25},
        {
            'type': 'time',
            'body': 'tank',
            'frame': 'body',
            'interpolation': 'cubic',
            'point': [0.1, 0, 0],
            'table': [
                [0.0512, 1, 2, 3, 0, 0.1, 0],
                [0.1, 0, 2, 3, 0.1, 0, 0],
                [0.2, 1, 0, 3, 0, 0, 0.2],
                [0.3123, 1, 2, 0, 0, 0, 0],
            ],
        },
        {
            'type': 'time',
            'body': 'a',
            'outside': 'hold',
            'table': [[0.1, 1, 0, 0], [0.2, 0, 1, 0]],
        },
    ],
}
METHODS = 'dmv6', 'rk4', 'implicit_euler'
SHORT = 'dmv6', 'implicit_euler'


def lines(*names):
    """
    Give name and digest of some integrators.
    """
    scene = load_scene(SCENE)
    for name in names or METHODS:
        sim = Simulation(scene, integrator=name)
        sim.step(20)
        for body in ('tank', 'pendulum'):
            sim.set_wrench(body, force=(1.0, 2.0, 3.0), torque=(0.1, 0.2, -0.3), frame='body')
        sim.step(20)
        sim.reset()
        sim.step(10)
        digest = hashlib.sha256(sim.state_bytes() + sim.state.values.tobytes())
        yield f'{name} {digest.hexdigest()}'


if __name__ == '__main__':
    print(kernels.COMPILED)
    print(*lines(*sys.argv[1:]), sep='\n')
