# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Newton's cradle: five balls that touch, the first comes with 1 m/s, restitution 0.9.

Impacts come at their instants, one pair after the other. With e the last ball leaves with
((1 + e)/2)^4 m/s, and what is left of the momentum follows with the others.
"""

from rigid_body_sim import Simulation, load_scene

E, RADIUS = 0.9, 0.05
ball = {'mass': 1.0, 'restitution': E, 'shape': {'type': 'sphere', 'radius': RADIUS}}
scene = {
    'version': 1,
    'name': 'cradle',
    'dt': 0.004,
    'contact': {'mode': 'event'},
    'bodies': [
        {'name': 'first', **ball, 'initial': {'position': [-0.23, 0, 0], 'velocity': [1, 0, 0]}},
        {'name': 'ball', **ball, 'repeat': {'count': [4, 1, 1], 'spacing': [0.1, 0, 0]}},
    ],
}
simulation = Simulation(load_scene(scene))
simulation.step(50)

names = [body.name for body in simulation.scene.bodies]
impacts = simulation.impacts()
print('instant [s]          of        on        impulse [N s]')
for time, (a, b), impulse in zip(impacts.time, impacts.bodies, impacts.impulse, strict=True):
    print(f'{time:.15f}    {names[a]:9} {names[b]:9} {impulse[0]:+.15f}')

last = max(simulation.state.velocity[:, 0])
print(f'the last ball leaves with {last:.15f} m/s; the law: {((1 + E) / 2) ** 4:.15f} m/s')
assert abs(impacts.time[0] - 0.13) < 1e-15
assert abs(last - ((1 + E) / 2) ** 4) < 1e-14
assert abs(simulation.momentum()[0] - 1.0) < 1e-14
