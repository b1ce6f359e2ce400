# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Explicit midpoint rule: the slope at the half step carries the whole one."""

from rigid_body_sim.physics.integrators.integrator import Integrator
from rigid_body_sim.physics.integrators.options import ORIENTATION, oriented
from rigid_body_sim.physics.schemes.runge_kutta import RungeKutta

INTEGRATOR = Integrator(
    name='midpoint',
    order=2,
    free_order=2,
    keeps='nothing; parabolas of free fall are exact',
    stability='h |omega| <= 0.05 keeps the energy of a free top within 1 % over 5000 steps; '
    'damping: h k <= 2',
    source='Runge, Math. Ann. 46 (1895)',
    scheme=RungeKutta(a=((), (0.5,)), b=(0.0, 1.0)),
    options=ORIENTATION,
    configure=oriented,
)
