# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of bodies whose mass changes.

The blocks keep p* = m0 v and L* = R I0 R^T omega (`variable_mass`); the solver's impulses act on

    p = p*/s,  L = L*/s,  1/m = s/m0,  I^-1 = s I0^-1        s = m0 / m(t)

So before the solver visits contacts the rows of such bodies are brought to what they are now, and
afterwards back. Velocities are the same either way. s is that of the middle of the tick.

    flows : FLOW per body: core index, rate/m0 [1/s], end of the flow [s], s
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.model.variable_mass import end_of_flow, flow_of
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

CORE, RATE, END, SCALE = range(4)
FLOW = 4


def flows_of(layout: Layout, cores: Iterable[int]) -> Array:
    """Make the table of those of some bodies (core indices, -1: none) whose mass changes."""
    table = []
    for core in sorted({core for core in cores if core >= 0}):
        body = layout.body(core)
        flow = flow_of(body)
        if flow is not None:
            table.append((float(core), flow.rate / body.mass, end_of_flow(body), 1.0))
    return np.array(table, dtype=np.float64).ravel()


@kernel
def find_mass_scale(time: float, flows: Array) -> None:
    """Find s at a time since the start of the scene."""
    for k in range(len(flows) // FLOW):
        o = k * FLOW
        flows[o + SCALE] = 1.0 / (1.0 + flows[o + RATE] * min(time, flows[o + END]))


@inline
def _multiply(b, momentum, inverse, bodies):
    for axis in range(3):
        bodies[b + solver_bodies.MOMENTUM + axis] *= momentum
        bodies[b + solver_bodies.ANGULAR_MOMENTUM + axis] *= momentum
    bodies[b + solver_bodies.INVERSE_MASS] *= inverse
    for entry in range(6):
        bodies[b + solver_bodies.INVERSE_INERTIA + entry] *= inverse


@kernel
def scale_to_present_mass(flows: Array, bodies: Array) -> None:
    """Bring rows to the masses of now."""
    for k in range(len(flows) // FLOW):
        s = flows[k * FLOW + SCALE]
        _multiply(int(flows[k * FLOW + CORE]) * solver_bodies.SIZE, 1.0 / s, s, bodies)


@kernel
def scale_to_start_mass(flows: Array, bodies: Array) -> None:
    """Bring rows back to the masses of the start."""
    for k in range(len(flows) // FLOW):
        s = flows[k * FLOW + SCALE]
        _multiply(int(flows[k * FLOW + CORE]) * solver_bodies.SIZE, s, 1.0 / s, bodies)


@kernel
def scale_warm_start(flows: Array, bodies: Array) -> None:
    """Bring what contacts hold of the rows to the masses of the start."""
    for k in range(len(flows) // FLOW):
        s = flows[k * FLOW + SCALE]
        b = int(flows[k * FLOW + CORE]) * solver_bodies.SIZE
        for axis in range(3):
            bodies[b + solver_bodies.WARM_IMPULSE + axis] *= s
            bodies[b + solver_bodies.WARM_ANGULAR_IMPULSE + axis] *= s


KERNELS = {
    'find_mass_scale': find_mass_scale,
    'scale_to_present_mass': scale_to_present_mass,
    'scale_to_start_mass': scale_to_start_mass,
    'scale_warm_start': scale_warm_start,
}
