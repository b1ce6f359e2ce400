# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Stability: explicit methods blow up beyond a step; implicit Euler damps at any."""

import numpy as np
from lesson import claim, follow
from scenes import OMEGA, START, hung

H = 0.05  # [s]: ω h = 0.5


def growth(method, h=H, steps=40):
    """Growth of the energy in a step, as a factor on the amplitude."""
    run = follow(hung(0, method), steps * h, steps * h, dt=h)
    return (run.energy[-1] / run.energy[0]) ** (0.5 / steps)


z = OMEGA * H
claim(
    'explicit Euler grows by √(1 + (ωh)²) a step',
    growth('explicit_euler') - np.sqrt(1 + z**2),
    within=1e-12,
)
claim(
    'implicit Euler shrinks by 1/√(1 + (ωh)²)',
    growth('implicit_euler') - 1 / np.sqrt(1 + z**2),
    within=1e-12,
)
claim('implicit midpoint keeps the energy', growth('implicit_midpoint') - 1, within=1e-12)
rk4 = abs(1 + 1j * z + (1j * z) ** 2 / 2 + (1j * z) ** 3 / 6 + (1j * z) ** 4 / 24)
claim('RK4 shrinks by |1 + iωh + … + (iωh)⁴/24|', growth('rk4') - rk4, within=1e-12)
inside, beyond = growth('rk4', h=0.28, steps=20), growth('rk4', h=0.29, steps=20)
print(f'RK4 at ωh = 2.8: {inside:.3f} a step, at ωh = 2.9: {beyond:.3f}')
assert inside < 1 < beyond
stiff = follow(hung(0, 'implicit_euler'), 40.0, 1.0, dt=1.0)  # ωh = 10
claim('implicit Euler dies away even at ωh = 10', stiff.position[-1, 0, 0] / START, within=1e-12)


def draw(axes):
    """Two seconds of the spring with each method."""
    for method in ('explicit_euler', 'implicit_euler', 'implicit_midpoint', 'rk4'):
        run = follow(hung(0, method), 2.0, H, dt=H)
        axes.plot(run.time, run.position[:, 0, 0], label=method)
    axes.set(xlabel='time [s]', ylabel='x [m]', ylim=(-1, 1))
