# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, five rotations about principal axes, kick: explicit and symplectic, order two.

Free rotation keeps L to the last bit; the energy error is bounded and of order h^2. A force held
over the tick is integrated exactly in translation.
"""

from rigid_body_sim.physics.drifts import five_rotations
from rigid_body_sim.physics.integrators.integrator import Integrator
from rigid_body_sim.physics.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='five_rotations',
    order=2,
    free_order=2,
    keeps='L to the last bit and energy within a bound without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 0.8 keeps the energy of a free top within 1 % over 5000 steps, '
    '0.5 that of a thin rod; springs: h omega <= 2',
    source='Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107 (1997); Strang (1968)',
    scheme=Splitting(
        kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=five_rotations.drift, order=2
    ),
)
