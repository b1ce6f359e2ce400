# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reference: LSODA of scipy, Adams and BDF with automatic switching. See `schemes.scipy_reference`.
"""

from rigid_body_sim.physics.integration.integrator import Integrator, within_tolerances
from rigid_body_sim.physics.integration.options import tolerances
from rigid_body_sim.physics.integration.schemes.scipy_reference import ScipyReference

INTEGRATOR = Integrator(
    name='scipy_lsoda',
    order=12,
    free_order=12,
    keeps='nothing, each to within the tolerances',
    stability='none',
    source='Petzold, SIAM J. Sci. Stat. Comput. 4 (1983); scipy.integrate.solve_ivp',
    scheme=ScipyReference('LSODA'),
    failure='the solver of scipy did not reach the end of the tick',
    options=tolerances(1e-12, 1e-14),
    configure=within_tolerances,
    is_reference=True,
)
