# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forces add: a point mass under three forces goes as under their sum; free fall is a parabola."""

import numpy as np
from lesson import claim, follow

MASS, GRAVITY = 2.0, np.array([0, 0, -9.81])  # [kg], [m/s^2]
WIND, ENGINE = np.array([3.0, 0, 0]), np.array([0, 4.0, 1.0])  # [N]


def thrown(forces):
    """A stone thrown at (1, 2, 10) m/s under these forces [N] and its weight."""
    acting = [{'type': 'constant', 'body': 'stone', 'force': force.tolist()} for force in forces]
    return {
        'dt': 0.01,
        'gravity': GRAVITY.tolist(),
        'bodies': [
            {
                'name': 'stone',
                'shape': {'type': 'particle'},
                'mass': MASS,
                'initial': {'velocity': [1, 2, 10]},
            }
        ],
        'forces': acting,
    }


def parabola(t, force):
    """Position under a constant force [m]: v t + (g + F/m) t^2 / 2."""
    return np.outer(t, (1, 2, 10)) + np.outer(t**2 / 2, GRAVITY + force / MASS)


fall = follow(thrown([]), 2.0, 0.05)
both = follow(thrown([WIND, ENGINE]), 2.0, 0.05)
summed = follow(thrown([WIND + ENGINE]), 2.0, 0.05)

error = fall.position[:, 0] - parabola(fall.time, np.zeros(3))
claim('free fall is the parabola v t + g t²/2', error, within=1e-13, unit='m')
error = both.position - summed.position
claim('two forces move a body as their sum does', error, within=1e-13, unit='m')
error = both.position[:, 0] - parabola(both.time, WIND + ENGINE)
claim('and that is v t + (g + F/m) t²/2', error, within=1e-13, unit='m')


def draw(axes):
    """Height over distance of the two flights."""
    axes.plot(fall.position[:, 0, 0], fall.position[:, 0, 2], label='weight alone')
    axes.plot(both.position[:, 0, 0], both.position[:, 0, 2], '--', label='with wind and engine')
    axes.set(xlabel='x [m]', ylabel='z [m]')
