# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Implicit (backward) Euler on (r, p, q, omega_body): what is stiff dies out at once, and so does
what is not.

    y1 = y0 + h f(y1),   q1 = q0 cayley(h omega1)

L-stable. A spring loses the factor 1 / sqrt(1 + (h omega)^2) a step, a free top its energy and its
angular momentum.
"""

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.implicit.scheme import Implicit

INTEGRATOR = Integrator(
    name='implicit_euler',
    order=1,
    free_order=1,
    keeps='momentum; nothing else: it damps',
    stability='springs and damping: any step (L-stable); h |omega| <= 0.001 keeps the energy of '
    'any free body within 1 % over 5000 steps',
    source='Hairer & Wanner, Solving Ordinary Differential Equations II, IV.3',
    scheme=Implicit(stages=1, gamma=1.0),
    plan=coupling.plan,
    wants_derivatives=True,
    limits=Limits(rotation=0.001, gyroscopic=True),
)
