# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies that lose or gain mass at a steady rate: rockets, tanks, hoppers.

    m(t) = m0 + rate t   until m is the final mass        m v' = F + rate u        [N]
    I(t) = I0 m(t)/m0                                     I w' + w x I w = torque  [N m]
        u : [m/s] velocity of the flowing mass relative to the body, body axes

The shape does not change: mass leaves uniformly from everywhere in it, so the centre of mass stays
and the inertia goes with the mass. What leaves carries the momentum and angular momentum that it
had; the flow as a whole pushes at the centre of mass. Jet damping and the sloshing of what is left
are not modelled.

The kernels keep p* = m0 v and L* = R I0 R^T w, the momenta of the body as it was. Then

    p*' = (m0/m) (F + rate u),   L*' = (m0/m) torque,   r' = p*/m0

and the change of mass is a force that depends on time: the inverse mass of the blocks never
changes, drifts stay exact, every integrator keeps its order and what it conserves, and a body
spinning freely keeps L* to the last bit. The element `forces.elements.variable_mass` applies the
factor after all other forces. The flow ends at an instant of its own, at which `forces.schedule`
cuts the tick.

Source: Tsiolkovsky; Goldstein, Classical Mechanics, chapter 1, exercise on rockets.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Body, MassFlow

Array = NDArray[np.float64]


def check_flow(body: Body) -> None:
    """Refuse a flow that the body cannot have."""
    flow = body.mass_flow
    if flow is None:
        return
    if body.fixed:
        raise InvalidModel(
            f'{body.name!r} is fixed; its mass cannot change: remove mass_rate, or fixed'
        )
    numbers = (flow.rate, *flow.exhaust_velocity)
    if not all(map(math.isfinite, numbers)):
        raise InvalidModel(
            f'{body.name!r}: mass_rate and exhaust_velocity {numbers} must be finite'
        )
    if flow.final_mass is None:
        return
    if not (math.isfinite(flow.final_mass) and flow.final_mass > 0.0):
        raise InvalidModel(
            f'{body.name!r}: final_mass is {flow.final_mass} kg; it must be positive and finite'
        )
    if (flow.final_mass - body.mass) * flow.rate < 0.0 or flow.rate == 0.0:
        raise InvalidModel(
            f'{body.name!r}: final_mass {flow.final_mass:g} kg cannot be reached from '
            f'{body.mass:g} kg at {flow.rate:g} kg/s; '
            'a body that loses mass has a smaller one at the end'
        )


def end_of_flow(body: Body) -> float:
    """
    Instant [s] at which the flow of a body ends; infinity if never, minus infinity without a flow.
    """
    flow = body.mass_flow
    if flow is None or flow.rate == 0.0:
        return -math.inf
    return math.inf if flow.final_mass is None else (flow.final_mass - body.mass) / flow.rate


def end_of_mass(body: Body) -> float:
    """Instant [s] at which no mass would be left; infinity if never."""
    flow = body.mass_flow
    if flow is None or flow.rate >= 0.0 or flow.final_mass is not None:
        return math.inf
    return -body.mass / flow.rate


def mass_at(body: Body, time: float) -> float:
    """Mass [kg] at a time [s] since the start of the scene."""
    flow = body.mass_flow
    if flow is None or flow.rate == 0.0:
        return body.mass
    if flow.final_mass is not None and time >= end_of_flow(body):
        return flow.final_mass
    return body.mass + flow.rate * time


def masses_at(bodies: Sequence[Body], time: float) -> Array | None:
    """
    Masses (n,) [kg] at a time [s], scene order, zero for fixed bodies; None where none changes.
    """
    if all(body.mass_flow is None for body in bodies):
        return None
    return np.array([0.0 if body.fixed else mass_at(body, time) for body in bodies])


def flow_of(body: Body) -> MassFlow | None:
    """Flow of a body whose mass does change, else None."""
    flow = body.mass_flow
    return None if flow is None or flow.rate == 0.0 else flow
