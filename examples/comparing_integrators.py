# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Integrators compared: the flip of a box about its middle axis, and what each method makes of it.

Without torque the angular momentum stays, and so does the energy; how far each drifts in 20 s
tells methods apart at one look. The end is compared with `exact_rotor`, which solves this motion
in closed form.
"""

import time
from pathlib import Path

import numpy as np

from rigid_body_sim import Simulation, load_scene

METHODS = ('explicit_euler', 'semi_implicit_euler', 'midpoint', 'rk4', 'lie_rk4', 'dmv6')
TICKS = 2000

scene = load_scene(Path(__file__).parents[1] / 'config/scenes/tumbling_box.yaml')


def end_of(method):
    """State at the end, drift of the energy [-], and the time of a tick [us]."""
    simulation = Simulation(scene, integrator=method, dt=0.01)
    simulation.prepare()  # compile first: that is not the cost of the method
    start = simulation.energy()
    began = time.process_time()
    simulation.step(TICKS)
    cost = 1e6 * (time.process_time() - began) / TICKS
    return simulation.state, abs(simulation.energy() / start - 1), cost


def angle_between(a, b):
    """Angle of the turn from one attitude to another [rad]."""
    return 4 * np.arcsin(min(np.linalg.norm(a - b), np.linalg.norm(a + b)) / 2)  # q is -q


exact, _, _ = end_of('exact_rotor')
print('method               attitude error [rad]   energy drift   us a tick')
errors = {}
for method in METHODS:
    state, drift, cost = end_of(method)
    errors[method] = angle_between(state.orientation[0], exact.orientation[0])
    print(f'{method:20} {errors[method]:18.1e} {drift:16.1e} {cost:11.2f}')

assert errors['dmv6'] < errors['rk4'] < errors['midpoint']
