# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, discrete Moser–Veselov drift without preprocessing, kick.

Free rotation has order two: energy and L are kept as by the higher orders, but the phase runs away
a thousand times faster. For comparison.
"""

from rigid_body_sim.physics.integration.free_rotation import moser_veselov
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='dmv2',
    order=2,
    free_order=2,
    keeps='L to the last bit and energy to rounding without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 4 (free rotation, from 1 on the drift is divided); springs: h omega '
    '<= 2; drag: h k <= 4',
    source='Moser & Veselov, Commun. Math. Phys. 139 (1991); Strang (1968)',
    scheme=Splitting(
        kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=moser_veselov.drift(2), order=2
    ),
    coefficients=moser_veselov.coefficients(2),
    limits=Limits(rotation=4.0, oscillation=2.0, relaxation=4.0),
)
