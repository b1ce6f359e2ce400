# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, free rotation solved by Jacobi's elliptic functions, kick.

Free rotation is exact at any step but for round-off and keeps L to the last bit; torques that vary
within a tick bring the method to order two (Strang). For large steps, reference runs and thin
rods; half a microsecond per body and tick.
"""

import math

from rigid_body_sim.physics.integration.free_rotation import exact_rotor
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='exact_rotor',
    order=2,
    free_order=math.inf,
    keeps='L to the last bit and energy to rounding without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 1000 (free rotation); springs: h omega <= 2; drag: h k <= 4',
    source='Landau & Lifshitz, Mechanics, section 37; '
    'Celledoni et al., SIAM J. Sci. Comput. 30 (2008); Strang (1968)',
    scheme=Splitting(kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=exact_rotor.drift, order=2),
    coefficients=exact_rotor.coefficients,
    limits=Limits(rotation=1000.0, oscillation=2.0, relaxation=4.0),
)
