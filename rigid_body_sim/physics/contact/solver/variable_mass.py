# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of bodies whose mass changes.

The blocks keep p* = m0 v and L* = R I0 R^T omega (`variable_mass`); the solver's impulses act on

    p = p*/s,  L = L*/s,  1/m = s/m0,  I^-1 = s I0^-1        s = m0 / m(t)

So before the solver visits contacts the rows of such bodies are brought to what they are now, and
afterwards back. Velocities are the same either way. s is that of the middle of the tick.

    flows : one record per body whose mass changes, see below
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.model.variable_mass import end_of_flow, flow_of
from rigid_body_sim.physics.state.layout import Layout

flow = Record()
BODY = flow.number('-', 'index of the body among those that move')
RATE = flow.number('1/s', 'of its mass, over m0')
END = flow.number('s', 'end of the flow')
SCALE = flow.number('-', 's')
SIZE = flow.size


def flows_of(layout: Layout, indices: Iterable[int]) -> Array:
    """Make the table of those of some bodies (indices, -1: none) whose mass changes."""
    table = []
    for index in sorted({index for index in indices if index >= 0}):
        body = layout.body(index)
        change = flow_of(body)
        if change is not None:
            table.append((float(index), change.rate / body.mass, end_of_flow(body), 1.0))
    return np.array(table, dtype=np.float64).ravel()


@kernel
def find_mass_scale(time: float, flows: Array) -> None:
    """Find s at a time since the start of the scene."""
    for row in range(0, len(flows), SIZE):
        flows[row + SCALE] = 1.0 / (1.0 + flows[row + RATE] * min(time, flows[row + END]))


@inline
def _scale(row: int, momentum: float, inverse: float, flows: Array, bodies: Array) -> None:
    """Multiply momenta and energy, and inverse mass and inertia, of the body of a flow."""
    body = int(flows[row + BODY]) * solver_bodies.SIZE
    for axis in range(3):
        bodies[body + solver_bodies.MOMENTUM + axis] *= momentum
        bodies[body + solver_bodies.ANGULAR_MOMENTUM + axis] *= momentum
    bodies[body + solver_bodies.ENERGY] *= momentum
    bodies[body + solver_bodies.INVERSE_MASS] *= inverse
    for entry in range(6):
        bodies[body + solver_bodies.INVERSE_INERTIA + entry] *= inverse


@kernel
def scale_to_present_mass(flows: Array, bodies: Array) -> None:
    """Bring rows to the masses of now."""
    for row in range(0, len(flows), SIZE):
        scale = flows[row + SCALE]
        _scale(row, 1.0 / scale, scale, flows, bodies)


@kernel
def scale_to_start_mass(flows: Array, bodies: Array) -> None:
    """Bring rows back to the masses of the start."""
    for row in range(0, len(flows), SIZE):
        scale = flows[row + SCALE]
        _scale(row, scale, 1.0 / scale, flows, bodies)


@kernel
def scale_warm_start(flows: Array, bodies: Array) -> None:
    """Bring the warm start of the bodies to the masses of the start."""
    for row in range(0, len(flows), SIZE):
        body = int(flows[row + BODY]) * solver_bodies.SIZE
        for axis in range(3):
            bodies[body + solver_bodies.WARM_IMPULSE + axis] *= flows[row + SCALE]
            bodies[body + solver_bodies.WARM_ANGULAR_IMPULSE + axis] *= flows[row + SCALE]
