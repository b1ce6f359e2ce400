# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, five rotations about principal axes, kick: explicit and symplectic, order two.

Free rotation keeps L to the last bit; the energy error is bounded and of order h^2. A force held
over the tick is integrated exactly in translation.
"""

from rigid_body_sim.physics.integration.free_rotation import five_rotations
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits, Slender
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='five_rotations',
    order=2,
    free_order=2,
    keeps='L to the last bit and energy within a bound without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 0.5 keeps the energy of any free body within 1 % over 5000 steps '
    '(0.8 but for a thin rod; from I_max/I_min = r = 100 on 1.58 r^(-1/4)); '
    'springs: h omega <= 2; drag: h k <= 4',
    source='Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107 (1997); Strang (1968)',
    scheme=Splitting(
        kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=five_rotations.drift, order=2
    ),
    limits=Limits(
        rotation=0.5, slender=Slender(ratio=100.0, power=0.25), oscillation=2.0, relaxation=4.0
    ),
)
