# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Kick, Taylor series of order sixteen for the free rotation, kick.

Free rotation is right to round-off and keeps L to the last bit: the drift divides a step that
comes near to a pole of the motion (`free_rotation.taylor`). Round-off itself grows with
I_max / I_min, since L is kept in world axes. Torques that vary within a tick bring the method to
order two (Strang). The cheapest way to the last digit of a single body.
"""

from rigid_body_sim.physics.integration.free_rotation import taylor
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.splitting import Splitting

INTEGRATOR = Integrator(
    name='taylor16',
    order=2,
    free_order=16,
    keeps='L to the last bit and energy to rounding without torque; energy without drift while '
    'forces depend on position',
    stability='h |omega| <= 1000 (free rotation; where the nearest pole of the motion, or half a '
    'radian, is nearer the drift is divided); springs: h omega <= 2; drag: h k <= 4',
    source='Moore, Interval Analysis (1966); Corliss & Chang, ACM TOMS 8 (1982); Strang (1968)',
    scheme=Splitting(kicks=(0.5, 0.5), drifts=(1.0,), drift_rotation=taylor.drift(16), order=2),
    coefficients=taylor.coefficients,
    limits=Limits(rotation=1000.0, oscillation=2.0, relaxation=4.0),
)
