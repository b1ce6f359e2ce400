# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Commands held in the axes of a body: they turn with it, so they are evaluated like a force element.

A command in world axes is part of what is held over the tick and costs nothing here.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import add_turning_wrench
from rigid_body_sim.physics.state.blocks import add_force, add_torque, to_world
from rigid_body_sim.physics.vectors import load

NAME = 'held_body_wrench'

columns = Record()
BODY = columns.number('-', 'core index')
RIGID = columns.number('-', 'index among the rigid bodies')
FORCE = columns.vector('N', 'principal axes')
TORQUE = columns.vector('N m', 'principal axes')
COLUMNS = columns.size

FORCES = slice(FORCE, TORQUE)  # of a row as numpy takes it
TORQUES = slice(TORQUE, COLUMNS)


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the held wrenches."""
    for number in range(count):
        row = start + COLUMNS * number
        rigid = int(elements[row + RIGID])
        force = to_world(rotation, rigid, load(elements, row + FORCE))
        add_force(translation, int(elements[row + BODY]), force)
        add_torque(rotation, rigid, to_world(rotation, rigid, load(elements, row + TORQUE)))


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """Add the derivatives: the wrench turns with the body."""
    for number in range(count):
        row = start + COLUMNS * number
        rigid = int(elements[row + RIGID])
        if definite == 0:
            force = to_world(rotation, rigid, load(elements, row + FORCE))
            torque = to_world(rotation, rigid, load(elements, row + TORQUE))
            add_turning_wrench(table, int(elements[row + BODY]), force, torque)
