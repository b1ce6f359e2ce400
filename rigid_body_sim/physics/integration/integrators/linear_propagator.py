# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The exact propagator of point masses on linear springs, dampers, drag and constant forces: no error
but round-off.

Any step will do: a held command is constant over it, and everything else is solved exactly.
"""

import math

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes import linear_propagator

INTEGRATOR = Integrator(
    name='linear_propagator',
    order=math.inf,
    free_order=math.inf,
    keeps='all that the exact motion keeps',
    stability='any step, any stiffness and damping: exact; refuses what is not linear',
    source='textbook; coefficients: schemes.linear_motion',
    scheme=linear_propagator.LinearPropagator(),
    plan=linear_propagator.plan,
    refuses=linear_propagator.refuses,
)
