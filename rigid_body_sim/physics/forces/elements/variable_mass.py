# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The last word on a body whose mass changes: thrust, and the factor m0/m(t) on all that acts on it.

    F <- m0 g + (m0/m) (F + rate u),   torque <- (m0/m) torque
    m = m0 + rate t while the flow lasts

Not an element that a scene names: it follows all others, see `model.variable_mass` for the
equations and the model.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.element import Places
from rigid_body_sim.physics.forces.power import DRIVES
from rigid_body_sim.physics.model.scene import Body, Vector
from rigid_body_sim.physics.model.variable_mass import flow_of
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ROTATION,
    TRANSLATION,
    angular_velocity,
    at,
    position,
    to_world,
    velocity,
)
from rigid_body_sim.physics.vectors import add, dot, load, load_strided, scale, store_strided

NAME = 'variable_mass'

columns = Record()
BODY = columns.number('-', 'core index')
RIGID = columns.number('-', 'index among the rigid bodies; -1: none of them')
MASS = columns.number('kg', 'm0: at the start of the scene')
RATE = columns.number('kg/s', 'of the mass')
FINAL_RATIO = columns.number('-', 'm0 / m after the flow')
EXHAUST_VELOCITY = columns.vector('m/s', 'u, principal axes; of a point mass, world axes')
WEIGHT = columns.vector('N', 'm0 g')
FLOWS = columns.number('-', '1 while the flow lasts, else 0: the switch')
COLUMNS = columns.size
SWITCH = FLOWS


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Scale what acts on each body, and add thrust and weight."""
    for number in range(count):
        row = start + COLUMNS * number
        body = int(elements[row + BODY])
        rigid = int(elements[row + RIGID])
        rate = elements[row + RATE]
        ratio = elements[row + FINAL_RATIO]
        thrust = (0.0, 0.0, 0.0)
        if elements[row + FLOWS] != 0.0:
            ratio = elements[row + MASS] / (elements[row + MASS] + rate * time)
            thrust = scale(rate, load(elements, row + EXHAUST_VELOCITY))
            if rigid >= 0:
                thrust = to_world(rotation, rigid, thrust)
        k = at(body, TRANSLATION) + blocks.FORCE
        force = scale(ratio, add(load_strided(translation, k, LANES), thrust))
        store_strided(translation, k, LANES, add(load(elements, row + WEIGHT), force))
        if rigid >= 0:
            k = at(rigid, ROTATION) + blocks.TORQUE
            store_strided(rotation, k, LANES, scale(ratio, load_strided(rotation, k, LANES)))


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """
    Add what the flows bring in: rate (v^2 / 2 + omega . L* / 2 m0 - g . r + u . v).

    The mass that comes brings its kinetic and potential energy, the mass that leaves takes it;
    u . v is the power of the thrust.
    """
    for number in range(count):
        row = start + COLUMNS * number
        if elements[row + FLOWS] != 0.0:
            body = int(elements[row + BODY])
            rigid = int(elements[row + RIGID])
            mass = elements[row + MASS]
            exhaust = load(elements, row + EXHAUST_VELOCITY)
            v = velocity(translation, body)
            weight = load(elements, row + WEIGHT)
            carried = 0.5 * dot(v, v) - dot(weight, position(translation, body)) / mass
            if rigid >= 0:
                exhaust = to_world(rotation, rigid, exhaust)
                k = at(rigid, ROTATION) + blocks.ANGULAR_MOMENTUM
                momentum = load_strided(rotation, k, LANES)
                carried += 0.5 * dot(angular_velocity(rotation, rigid), momentum) / mass
            out[DRIVES] += elements[row + RATE] * (carried + dot(exhaust, v))


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
