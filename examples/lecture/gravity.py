# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gravity between two masses: Kepler's laws."""

import numpy as np
from lesson import claim, follow
from scenes import PERIOD, SPEED, SUN, A, E, G, orbit

run = follow(orbit('rk8'), 6.3, 0.015)
r, v = run.position[:, 1], run.velocity[:, 1]
x, y = (r[:, :2] / A).T

ellipse = (x + E) ** 2 + y**2 / (1 - E**2) - 1
claim('the orbit is an ellipse with the sun in a focus', ellipse, within=1e-8)
area = np.cross(r, v)[:, 2] / 2
claim('equal areas in equal times', area / area[0] - 1, within=1e-9)
crossed = np.interp(PERIOD, run.time, y)  # where the planet began: y = 0
claim('the period is 2π √(a³/GM)', crossed * A / SPEED, within=1e-4, unit='s')
energy = SPEED**2 / 2 - G * SUN / np.linalg.norm(r[0])
claim('energy per mass is -GM/2a', energy / (-G * SUN / (2 * A)) - 1, within=1e-12)


def draw(axes):
    """The orbit, and the sun in its focus."""
    axes.plot(*r[:, :2].T, label='planet')
    axes.plot(0, 0, 'o', label='sun')
    axes.set(xlabel='x [m]', ylabel='y [m]', aspect='equal')
