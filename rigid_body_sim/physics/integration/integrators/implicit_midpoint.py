# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The implicit midpoint rule with a Cayley rotation: symmetric, A-stable, of order two for any
forces.

Without torque it keeps L to the last bit and the energy to rounding at any step. On a stiff spring
it neither gains nor loses energy, and so never settles: take `sdirk2` or `linearly_implicit` where
the fast motion is to die out.
"""

from rigid_body_sim.physics.integration.free_rotation import implicit_midpoint
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.implicit.midpoint import ImplicitMidpoint

INTEGRATOR = Integrator(
    name='implicit_midpoint',
    order=2,
    free_order=2,
    keeps='L to the last bit and energy to rounding without torque; momentum, angular '
    'momentum and the energy of linear '
    'springs to rounding',
    stability='springs and damping: any step (A-stable; a stiff motion keeps its amplitude and '
    'hardly decays); h |omega| <= 3 keeps the energy of a free body to rounding',
    source='Austin, Krishnaprasad & Wang, J. Comput. Phys. 107 (1993); Hairer, Lubich & '
    'Wanner, Geometric Numerical '
    'Integration, II.1',
    scheme=ImplicitMidpoint(),
    coefficients=implicit_midpoint.coefficients,
    plan=coupling.plan,
    wants_derivatives=True,
    limits=Limits(rotation=3.0),
)
