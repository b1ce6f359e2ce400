# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Variable mass: a rocket gains u ln(m₀/m), whatever the time it takes."""

import numpy as np
from lesson import claim, follow

START, RATE, EXHAUST, EMPTY, G = 1000.0, -10.0, 2500.0, 400.0, 9.81
BURN = (EMPTY - START) / RATE  # [s]

scene = {
    'dt': 0.1,
    'integrator': 'rk8',
    'gravity': [0, 0, -G],
    'bodies': [
        {
            'name': 'rocket',
            'shape': {'type': 'particle'},
            'mass': START,
            'mass_rate': RATE,
            'exhaust_velocity': EXHAUST,  # along -z
            'final_mass': EMPTY,
        }
    ],
}
run = follow(scene, 80.0, 1.0)
t = run.time
mass = np.maximum(START + RATE * t, EMPTY)
exact = EXHAUST * np.log(START / mass) - G * t
v = run.velocity[:, 0, 2]
claim('v = u ln(m₀/m) - gt', v - exact, within=1e-8, unit='m/s')
gained = v[round(BURN)] + G * BURN
claim('the burn gives u ln(m₀/m₁)', gained - EXHAUST * np.log(2.5), within=1e-8, unit='m/s')


def draw(axes):
    """Speed over time."""
    axes.plot(t, v, label='speed')
    axes.axvline(BURN, linestyle=':', color='grey', label='burn-out')
    axes.set(xlabel='time [s]', ylabel='speed [m/s]')
