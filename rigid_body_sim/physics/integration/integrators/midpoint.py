# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Explicit midpoint rule: the slope at the half step carries the whole one."""

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits, Slender
from rigid_body_sim.physics.integration.orientation import ORIENTATION, oriented
from rigid_body_sim.physics.integration.schemes.runge_kutta import RungeKutta

INTEGRATOR = Integrator(
    name='midpoint',
    order=2,
    free_order=2,
    keeps='nothing; parabolas of free fall are exact',
    stability='h |omega| <= 0.05 keeps the energy of any free body within 1 % over 5000 steps, '
    'h omega <= 0.053 that of a spring (with damping c >= h k any); drag: h k <= 2',
    source='Runge, Math. Ann. 46 (1895)',
    scheme=RungeKutta(a=((), (0.5,)), b=(0.0, 1.0)),
    options=ORIENTATION,
    configure=oriented,
    limits=Limits(
        rotation=0.05,
        gyroscopic=True,
        matrix=0.05,
        matrix_slender=Slender(ratio=1e3, power=0.25),
        oscillation=0.053,
        resists=True,
        relaxation=2.0,
    ),
)
