# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Contact: a ball does not enter the ground, and each bounce leaves e² of the height."""

import numpy as np
from lesson import claim, follow

HEIGHT, E, RADIUS, G = 1.0, 0.8, 0.1, 9.81
run = follow('bouncing_ball', 3.0, 0.004)
t, z = run.time, run.position[:, 1, 2] - RADIUS

tops = z[1:-1][(z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:])]
expected = HEIGHT * E ** (2 * np.arange(1, len(tops) + 1))
claim('each bounce rises to e² of the last', tops[:4] - expected[:4], within=1e-3, unit='m')
first = t[np.argmax(run.velocity[:, 1, 2] > 0)]
claim('the first impact is at √(2h/g)', first - np.sqrt(2 * HEIGHT / G), within=0.004, unit='s')
claim('it enters the ground by no more than', np.minimum(z, 0), within=1e-4, unit='m')
rise = np.max(run.energy - np.minimum.accumulate(run.energy))
claim('no bounce gives energy', rise, within=1e-4, unit='J')


def draw(axes):
    """Height over time, and e² from bounce to bounce."""
    axes.plot(t, z, label='height above the ground')
    at = np.flatnonzero((z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:])) + 1
    axes.plot(t[at], expected, 'o', label='e² of the last')
    axes.set(xlabel='time [s]', ylabel='height [m]')
