# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Adaptive steps: an error is asked for, and the method chooses its steps."""

import numpy as np
from lesson import claim, follow
from scenes import A, orbit

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
TICK, END = 1.05, 6.3  # [s]: six ticks of one orbit; the steps within are the method's own


def solved(tolerance):
    """One orbit, from the nearest point to the nearest point."""
    integrator = {'name': 'rk45', 'rtol': tolerance, 'atol': tolerance * 1e-3}
    run = follow(orbit(integrator, dt=TICK), END, TICK)
    return run.position[:, 1], run.simulation.steps_taken


reference = follow(orbit('rk8', dt=TICK / 210), END, TICK).position[:, 1]
errors, steps = [], []
for tolerance in TOLERANCES:
    position, taken = solved(tolerance)
    errors.append(np.max(np.abs(position - reference)) / A)
    steps.append(taken)
    print(f'rtol {tolerance:g}: {taken:g} steps, largest error / a {errors[-1]:.1e}')
    claim(f'rtol {tolerance:g}: error of one orbit', errors[-1], within=100 * tolerance)
ratio = steps[-1] / steps[-2]
claim(
    'a hundredth of the tolerance takes 100^(1/5) = 2.5 times the steps', ratio - 2.5, within=0.4
)


def draw(axes):
    """Error against steps."""
    axes.loglog(steps, errors, 'o-', label='rk45')
    axes.set(xlabel='steps of one orbit', ylabel='largest error / a')
