# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hooke's law: a mass on a spring swings with ω = √(k/m); with a damper it dies away."""

import numpy as np
from lesson import claim, follow
from scenes import MASS, OMEGA, START, K, hung

free = follow(hung(0, 'blanes_moan4'), 3.0, 0.01)
x = free.position[:, 0, 0]
claim('undamped: x = A cos ωt', x - START * np.cos(OMEGA * free.time), within=1e-9, unit='m')
claim('and the energy kA²/2 stays', free.energy / (K * START**2 / 2) - 1, within=1e-9)

damped = follow(hung(1.0, 'rk4'), 3.0, 0.01)
rate, t = 1.0 / (2 * MASS), damped.time  # [1/s]: c / 2m
omega = np.sqrt(OMEGA**2 - rate**2)
exact = START * np.exp(-rate * t) * (np.cos(omega * t) + rate / omega * np.sin(omega * t))
y = damped.position[:, 0, 0]
claim('damped: x dies away as exp(-ct/2m)', y - exact, within=1e-9, unit='m')


def draw(axes):
    """Both motions, and the envelope."""
    axes.plot(free.time, x, label='undamped')
    axes.plot(t, y, '--', label='damped')
    axes.plot(t, START * np.exp(-rate * t), ':', label='A exp(-ct/2m)')
    axes.set(xlabel='time [s]', ylabel='x [m]')
