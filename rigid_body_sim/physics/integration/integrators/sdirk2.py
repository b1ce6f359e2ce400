# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
SDIRK2 on (r, p, q, omega_body): two implicit Euler stages, L-stable and of order two.

    g = 1 - 1/sqrt 2:   Y = y0 + g h f(Y),   y1 = y0 + (1 - g) h f(Y) + g h f(y1)

Attitudes are composed of Cayley rotations, q1 = q0 cayley((1 - g) h omega_Y) cayley(g h omega_1):
the commutator left out
is of order h^3, as the error of the method.

The order is that of steps which resolve the springs. On stiffer ones, h omega >> 1, which hold a
body off its centre of mass, the first stage is of order one and so is the trajectory, until the
step resolves them (order reduction; Hairer & Wanner II, IV.15).
"""

import math

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.implicit.scheme import Implicit

INTEGRATOR = Integrator(
    name='sdirk2',
    order=2,
    free_order=2,
    keeps='momentum; nothing else: it damps motion that the step does not resolve',
    stability='springs and damping: any step (L-stable); h |omega| <= 0.125 keeps the energy of '
    'any free body within 1 % over 5000 steps',
    source='Alexander, SIAM J. Numer. Anal. 14 (1977) 1006; Hairer & Wanner, Solving Ordinary'
    ' Differential Equations II, '
    'IV.6',
    scheme=Implicit(stages=2, gamma=1.0 - 1.0 / math.sqrt(2.0)),
    plan=coupling.plan,
    wants_derivatives=True,
    limits=Limits(rotation=0.125, gyroscopic=True),
)
