# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A force at a point: it moves the centre as if it acted there, and turns the body by r × F."""

import numpy as np
from lesson import claim, follow

MASS, EDGE, FORCE, ARM = 3.0, 0.4, 0.6, 0.2
MOMENT = MASS * EDGE**2 / 6  # [kg m^2] of a cube about any axis


def pushed(**force):
    """A cube pushed by a constant force."""
    return {
        'dt': 0.01,
        'bodies': [{'name': 'cube', 'shape': {'type': 'box', 'size': [EDGE] * 3}, 'mass': MASS}],
        'forces': [{'type': 'constant', 'body': 'cube', **force}],
    }


edge = follow(pushed(force=[FORCE, 0, 0], point=[0, ARM, 0], frame='body'), 2.0, 0.02)
centre = follow(pushed(force=[FORCE, 0, 0]), 2.0, 0.02)
couple = follow(pushed(torque=[0, 0, -ARM * FORCE]), 2.0, 0.02)

t = couple.time
w = couple.spin[:, 0, 2]
claim('a couple: ω = τ t / I', w + ARM * FORCE * t / MOMENT, within=1e-13, unit='rad/s')
claim('and moves no centre', couple.position, within=0, unit='m')
exact = FORCE / MASS * t**2 / 2
claim(
    'at the centre: x = F t² / 2m, no turn',
    centre.position[:, 0, 0] - exact,
    within=1e-13,
    unit='m',
)
w = edge.spin[:, 0, 2]
claim(
    'at a point of the body: τ = r × F', w + ARM * FORCE * t / MOMENT, within=1e-13, unit='rad/s'
)
grown = (
    edge.angular_momentum[:, 2] - np.cross(edge.position[:, 0], MASS * edge.velocity[:, 0])[:, 2]
)
claim('its spin is L less r × p', grown - MOMENT * w, within=1e-12, unit='kg m²/s')


def draw(axes):
    """The paths of the three centres."""
    axes.plot(*centre.position[:, 0, :2].T, label='at the centre')
    axes.plot(*edge.position[:, 0, :2].T, '--', label='at a point, turning with the body')
    axes.plot(*couple.position[:, 0, :2].T, 'o', label='a couple')
    axes.set(xlabel='x [m]', ylabel='y [m]')
