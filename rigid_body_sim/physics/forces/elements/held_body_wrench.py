# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Commands held in the axes of a body: they turn with it, so they are evaluated like a force element.

A command in world axes is part of what is held over the tick and costs nothing here.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import add_turning_wrench
from rigid_body_sim.physics.state.blocks import add_force, add_torque, to_world

NAME = 'held_body_wrench'
COLUMNS = 8


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """
    Add the held wrenches: rows of index, turns, force (3) [N], torque (3) [N m], principal axes.
    """
    for e in range(count):
        m = start + 8 * e
        index = int(elements[m])
        turns = int(elements[m + 1])
        a, b, c = to_world(rotation, turns, elements[m + 2], elements[m + 3], elements[m + 4])
        add_force(translation, index, a, b, c)
        a, b, c = to_world(rotation, turns, elements[m + 5], elements[m + 6], elements[m + 7])
        add_torque(rotation, turns, a, b, c)


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """Add the derivatives: the wrench turns with the body."""
    for e in range(count):
        m = start + 8 * e
        turns = int(elements[m + 1])
        if definite == 0:
            fx, fy, fz = to_world(
                rotation, turns, elements[m + 2], elements[m + 3], elements[m + 4]
            )
            tx, ty, tz = to_world(
                rotation, turns, elements[m + 5], elements[m + 6], elements[m + 7]
            )
            add_turning_wrench(table, int(elements[m]), fx, fy, fz, tx, ty, tz)
