# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The last word on a body whose mass changes: thrust, and the factor m0/m(t) on all that acts on it.

    F <- m0 g + (m0/m) (F + rate u),   torque <- (m0/m) torque
    m = m0 + rate t while the flow lasts

Not an element that a scene names: it follows all others, see `physics.variable_mass` for the
equations and the model.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.forces.element import Places
from rigid_body_sim.physics.model.scene import Body, Vector
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state.blocks import (
    FX,
    FY,
    FZ,
    ROTATION,
    TRANSLATION,
    TX,
    TY,
    TZ,
    at,
    to_world,
)

NAME = 'variable_mass'
COLUMNS = 12
SWITCH = 11  # column: 1 while the flow lasts


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """
    Scale what acts on each body: rows of index, turns, m0, rate, m0/final mass, u (3), weight (3),
    flowing.
    """
    for e in range(count):
        m = start + 12 * e
        index = int(elements[m])
        turns = int(elements[m + 1])
        rate = elements[m + 3]
        ratio = elements[m + 4]
        tx = ty = tz = 0.0
        if elements[m + 11] != 0.0:
            ratio = elements[m + 2] / (elements[m + 2] + rate * time)
            tx, ty, tz = rate * elements[m + 5], rate * elements[m + 6], rate * elements[m + 7]
            if turns >= 0:
                tx, ty, tz = to_world(rotation, turns, tx, ty, tz)
        k = at(index, TRANSLATION)
        translation[k + FX] = elements[m + 8] + ratio * (translation[k + FX] + tx)
        translation[k + FY] = elements[m + 9] + ratio * (translation[k + FY] + ty)
        translation[k + FZ] = elements[m + 10] + ratio * (translation[k + FZ] + tz)
        if turns >= 0:
            k = at(turns, ROTATION)
            rotation[k + TX] *= ratio
            rotation[k + TY] *= ratio
            rotation[k + TZ] *= ratio


def row(body: Body, places: Places, gravity: Vector) -> tuple[float, ...]:
    """Give the row of one body that has a flow."""
    flow = flow_of(body)
    assert flow is not None
    place = places.place(body.name, None)
    exhaust = flow.exhaust_velocity
    if place.turns >= 0:
        exhaust = places.principal_axes(body.name, exhaust)
    ratio = 1.0 if flow.final_mass is None else body.mass / flow.final_mass
    weight = tuple(body.mass * g for g in gravity)
    head = (float(place.index), float(place.turns), body.mass, flow.rate, ratio)
    return (*head, *exhaust, *weight, 1.0)
