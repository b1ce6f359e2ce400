# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, preprocessed discrete Moser–Veselov drift of order ten, kick.

As `dmv6` with the whole series: 3e-10 rad over 100 rad at h |omega| = 0.4, round-off at 0.2.
"""

from rigid_body_sim.physics.integration.free_rotation import moser_veselov
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='dmv10',
    order=2,
    free_order=10,
    keeps='L to the last bit and energy to rounding without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 4 (free rotation, from 1 on the drift is divided); springs: h omega '
    '<= 2; drag: h k <= 4',
    source='Hairer & Vilmart, J. Phys. A 39 (2006) 13225; Strang (1968)',
    scheme=Splitting(
        kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=moser_veselov.drift(10), order=2
    ),
    coefficients=moser_veselov.coefficients(10),
    limits=Limits(rotation=4.0, oscillation=2.0, relaxation=4.0),
)
