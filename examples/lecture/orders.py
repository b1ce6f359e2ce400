# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Euler, midpoint, RK4: halving the step divides the error by 2, 4 and 16."""

import numpy as np
from lesson import claim, follow
from scenes import hung

END, STEPS = 1.0, (0.02, 0.01, 0.005, 0.0025, 0.00125)  # [s]
METHODS = {'explicit_euler': 1, 'semi_implicit_euler': 1, 'midpoint': 2, 'rk4': 4}
EXACT = 0.2 * np.cos(10 * END)


def error(method, h):
    """Error at the end [m] of an undamped spring."""
    run = follow(hung(0, method), END, END, dt=h)
    return abs(run.position[-1, 0, 0] - EXACT)


errors = {method: [error(method, h) for h in STEPS] for method in METHODS}
for method, order in METHODS.items():
    slope = np.log2(errors[method][-2] / errors[method][-1])
    claim(f'{method} is of order {order}', slope - order, within=0.1)


def draw(axes):
    """Error against step."""
    for method, found in errors.items():
        axes.loglog(STEPS, found, 'o-', label=method)
    axes.set(xlabel='step [s]', ylabel='error at 1 s [m]')
