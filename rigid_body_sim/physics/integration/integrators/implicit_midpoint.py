# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The implicit midpoint rule with a Cayley rotation: symmetric, A-stable, of order two for any
forces.

Without torque it keeps L to the last bit and the energy to rounding at any step. On a stiff linear
spring it neither gains nor loses energy, and so never settles: take `sdirk2` where the fast motion
is to die out.

A-stability speaks of linear forces. The rule asks the forces at a state half-way, and where the
ends of a spring move on circles, half-way lies a sagitta s ~ |arm| (h |omega|)^2 / 8 off the
chord: a spring so stiff that it keeps the middle closed (h omega >> 1, where |R| -> 1) opens the
ends by d1 = 2 s - d0, a gap whose energy is that of no motion, and which grows while s changes; a
damper sees the motion half-way alone and takes hardly any of it. Hence the limit h omega <= 1
(`Limits.bent`) for springs off the centre of mass or with a rest length. See Simo, Tarnow & Wong,
Comput. Methods Appl. Mech. Eng. 100 (1992) 63, for the rule on nonlinear springs.
"""

from rigid_body_sim.physics.integration.free_rotation import implicit_midpoint
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.limits import Limits, Slender
from rigid_body_sim.physics.integration.schemes.implicit import coupling
from rigid_body_sim.physics.integration.schemes.implicit.midpoint import ImplicitMidpoint

INTEGRATOR = Integrator(
    name='implicit_midpoint',
    order=2,
    free_order=2,
    keeps='L to the last bit and energy to rounding without torque; momentum, angular '
    'momentum and the energy of linear '
    'springs to rounding',
    stability='springs without rest length at centres of mass, and damping: any step (A-stable; a '
    'stiff motion keeps its amplitude and hardly decays); springs that have a rest length or hold '
    'a body off its centre: h omega <= 1, beyond that they may gain energy, damped or not; '
    'h |omega| <= 3 keeps the energy of a free body to rounding, 1.9 where I_max/I_min > 4',
    source='Austin, Krishnaprasad & Wang, J. Comput. Phys. 107 (1993); Hairer, Lubich & '
    'Wanner, Geometric Numerical '
    'Integration, II.1',
    scheme=ImplicitMidpoint(),
    coefficients=implicit_midpoint.coefficients,
    plan=coupling.plan,
    wants_derivatives=True,
    limits=Limits(rotation=3.0, slender=Slender(ratio=3.0, power=2.0, least=1.9), bent=1.0),
)
