# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A stack of ten boxes: it stands, and each box carries what lies above it.

Statics: the contact force below box k of n is (n - k) m g. What the soft contacts
give way under these loads is taken out whole: the top stays where it is, to 1e-11 m.
"""

from pathlib import Path

import numpy as np

from rigid_body_sim import Simulation, load_scene

simulation = Simulation(load_scene(Path(__file__).parents[1] / 'config/scenes/stack.yaml'))
start = simulation.state.position.copy()
simulation.step(round(2.0 / simulation.dt))

names = [body.name for body in simulation.scene.bodies]
contacts = simulation.contacts()
force = contacts.impulse[:, 2] / simulation.dt  # [N], the mean over the last tick
print('box        sunk [mm]   pressed from below [N]')
weight = 9.81 * simulation.scene.bodies[-1].mass
for k, name in enumerate(names):
    if name == 'ground':
        continue
    height = simulation.state.position[k, 2]
    below = (contacts.bodies == k).any(axis=1) & (contacts.point[:, 2] < height)
    carried = np.abs(force[below]).sum()
    sunk = start[k, 2] - simulation.state.position[k, 2]
    print(f'{name:10} {1e3 * sunk:8.4f} {carried:18.4f}')
    above = len(names) - k
    assert abs(carried - above * weight) < 1e-3 * weight  # what is left of its motion
assert np.abs(start - simulation.state.position).max() < 1e-9  # m
assert np.abs(simulation.state.velocity).max() < 1e-8  # m/s
