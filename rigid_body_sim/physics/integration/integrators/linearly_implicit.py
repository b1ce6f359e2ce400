# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A linearly implicit solve for the velocities, then the drift of `dmv6`: for bodies that stiff
springs and dampers join.

One linear solve a tick and no iteration. Of order one, and it damps springs: for soft ones take
`dmv6`. On stiff springs off the centre of mass `sdirk2` is of order one as well, and at the same
step not the more accurate; a smaller step is what helps there, or `rk45`, `rk8` at a step that
resolves the springs.

Bounded at any stiffness and any step on linear springs between centres of mass. Springs off the
centre it closes along the tangent, and the drift opens them again by the sagitta
|arm| (h |omega|)^2 / 2: a gap whose energy is that of no motion, and which on undamped chains has
been seen to drive them (`benchmark/stiff_chains.py`).
"""

from rigid_body_sim.physics.integration.free_rotation import moser_veselov
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.implicit.linearly_implicit import (
    LinearlyImplicit,
    refuses,
)

INTEGRATOR = Integrator(
    name='linearly_implicit',
    order=1,
    free_order=6,
    keeps='L to the last bit and energy to rounding without torque; momentum',
    stability='springs without rest length at centres of mass, and damping: any step and '
    'stiffness; springs that have a rest length or hold a body off its centre: h omega <= 3 is '
    'sure, beyond that gaps may store energy; h |omega| <= 4 (free rotation, from 1 on the drift '
    'is divided)',
    source='Baraff & Witkin, SIGGRAPH (1998); Hairer & Vilmart, J. Phys. A 39 (2006) 13225',
    scheme=LinearlyImplicit(moser_veselov.drift(6)),
    coefficients=moser_veselov.coefficients(6),
    plan=coupling.plan,
    wants_derivatives=True,
    refuses=refuses,
    limits=Limits(rotation=4.0, bent=3.0),
)
