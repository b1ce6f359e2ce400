# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Explicit Euler: y <- y + h f(y). The first method of every lecture, and the one to avoid.

It gains energy wherever motion is oscillatory: a spring grows by sqrt(1 + (h omega)^2) a step, and
a damper k is unstable
beyond h = 2/k.
"""

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.orientation import ORIENTATION, oriented
from rigid_body_sim.physics.integration.schemes.runge_kutta import RungeKutta

INTEGRATOR = Integrator(
    name='explicit_euler',
    order=1,
    free_order=1,
    keeps='nothing',
    stability='h |omega| <= 0.001 keeps the energy of any free body within 1 % over 5000 steps, '
    'h omega <= 0.0014 that of a spring (with damping c >= h k any); drag: h k <= 2',
    source='Euler, Institutiones calculi integralis (1768)',
    scheme=RungeKutta(a=((),), b=(1.0,)),
    options=ORIENTATION,
    configure=oriented,
    limits=Limits(
        rotation=0.001,
        gyroscopic=True,
        matrix=0.001,
        oscillation=0.0014,
        resists=True,
        relaxation=2.0,
    ),
)
