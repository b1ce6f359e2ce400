# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reference: Radau of scipy, implicit, order five, L-stable: for stiff scenes. See
`schemes.scipy_reference`.
"""

from rigid_body_sim.physics.integration.integrator import Integrator, within_tolerances
from rigid_body_sim.physics.integration.options import tolerances
from rigid_body_sim.physics.integration.schemes.scipy_reference import ScipyReference

INTEGRATOR = Integrator(
    name='scipy_radau',
    order=5,
    free_order=5,
    keeps='nothing, each to within the tolerances',
    stability='none',
    source='Hairer & Wanner, Solving Ordinary Differential Equations II; '
    'scipy.integrate.solve_ivp',
    scheme=ScipyReference('Radau'),
    failure='the solver of scipy did not reach the end of the tick',
    options=tolerances(1e-10, 1e-12),
    configure=within_tolerances,
    is_reference=True,
)
