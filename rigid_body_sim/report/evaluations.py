# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How often a method asks for forces or for the right-hand side in one step, read from its scheme.

    splitting             : kicks that are not zero; the last of a step and the first of the next
                            share one; twice as many where a force depends on velocity, from order
                            two on; none in a scene whose forces depend on nothing
    force gradient        : three, the last of a step shared with the next; four where a force
                            depends on velocity
    Runge–Kutta           : its stages
    exact propagator      : none
    linearly implicit     : one
    implicit, adaptive    : as many as Newton's method or the tolerance wants: None
    contact               : the solver's own business: None
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.schemes.force_gradient import ForceGradient
from rigid_body_sim.physics.integration.schemes.implicit.linearly_implicit import LinearlyImplicit
from rigid_body_sim.physics.integration.schemes.implicit.midpoint import ImplicitMidpoint
from rigid_body_sim.physics.integration.schemes.lie_group import LieRungeKutta4
from rigid_body_sim.physics.integration.schemes.linear_propagator import LinearPropagator
from rigid_body_sim.physics.integration.schemes.runge_kutta import RungeKutta
from rigid_body_sim.physics.integration.schemes.splitting import Splitting
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.variable_mass import flow_of


def evaluations_per_step(integrator: Integrator, scene: Scene) -> int | None:
    """Count the evaluations in one step of one integrator on one scene; None where it varies."""
    if scene.contact.get('mode', 'none') != 'none':
        return None
    scheme: Any = integrator.scheme
    coupled = bool(scene.forces) or any(
        body.pivot is not None or flow_of(body) is not None for body in scene.bodies
    )
    damped = any(force.depends_on_velocity() for force in scene.forces)
    if isinstance(scheme, ForceGradient):
        return scheme.evaluations(velocity_dependent=damped) if coupled else 0
    if isinstance(scheme, Splitting):
        return _of_splitting(scheme, damped=damped) if coupled else 0
    if isinstance(scheme, RungeKutta):
        return len(scheme.b)
    if isinstance(scheme, LieRungeKutta4):
        return 4
    if isinstance(scheme, LinearPropagator):
        return 0
    if isinstance(scheme, LinearlyImplicit):
        return 1 if coupled else 0
    if isinstance(scheme, ImplicitMidpoint) and not coupled:
        return 0
    return None


def _of_splitting(scheme: Splitting, *, damped: bool) -> int:
    kicks = [share for share in scheme.kicks if share != 0.0]
    if damped:
        return len(kicks) * (2 if scheme.order > 1 else 1)
    ends = scheme.kicks[0] != 0.0 and scheme.kicks[-1] != 0.0
    return len(kicks) - (1 if ends else 0)
