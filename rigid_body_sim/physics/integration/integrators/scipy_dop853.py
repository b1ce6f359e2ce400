# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reference: DOP853 of scipy, explicit, order eight. See `schemes.scipy_reference`."""

from rigid_body_sim.physics.integration.integrator import Integrator, within_tolerances
from rigid_body_sim.physics.integration.options import tolerances
from rigid_body_sim.physics.integration.schemes.scipy_reference import ScipyReference

INTEGRATOR = Integrator(
    name='scipy_dop853',
    order=8,
    free_order=8,
    keeps='nothing, each to within the tolerances',
    stability='none',
    source='Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I; '
    'scipy.integrate.solve_ivp',
    scheme=ScipyReference('DOP853'),
    failure='the solver of scipy did not reach the end of the tick',
    options=tolerances(1e-12, 1e-14),
    configure=within_tolerances,
    is_reference=True,
)
