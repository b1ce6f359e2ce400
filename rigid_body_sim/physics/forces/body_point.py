# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A point of a body in the row of a force element: where it is, how it moves, a force at it.

    x = r + a,   v = v_r + omega x a,   torque about the centre of mass = a x F

        r : centre of mass    a : arm from it to the point, world axes

A row that names a point begins a field of SIZE numbers with `point_field`; `Place.numbers` fills
it. What cannot move (a fixed body, the world) has neither velocity nor arm and takes no force.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.state.blocks import (
    add_force,
    add_torque,
    angular_velocity,
    position,
    to_world,
    velocity,
)
from rigid_body_sim.physics.vectors import add, cross, load

point = Record()
BODY = point.number('-', 'core index of the body; -1: what cannot move')
RIGID = point.number('-', 'its index among the rigid bodies; -1: it has no orientation')
OFFSET = point.vector('m', 'from the centre of mass, principal axes; without a body, the point')
SIZE = point.size

NO_VECTOR = (0.0, 0.0, 0.0)


def point_field(columns: Record, meaning: str) -> int:
    """Add a point of a body to the columns of a force element; give where it begins."""
    return columns.numbers(SIZE, '-, -, m', f'{meaning}: see `body_point`')


@inline
def locate(elements, place, translation, rotation):
    """Position and arm of a point, world axes."""
    body = int(elements[place + BODY])
    rigid = int(elements[place + RIGID])
    offset = load(elements, place + OFFSET)
    if body < 0:
        return offset, NO_VECTOR
    center = position(translation, body)
    if rigid < 0:
        return center, NO_VECTOR
    arm = to_world(rotation, rigid, offset)
    return add(center, arm), arm


@inline
def point_velocity(elements, place, translation, rotation, arm):
    """Velocity of a point whose arm is known, world axes."""
    body = int(elements[place + BODY])
    rigid = int(elements[place + RIGID])
    if body < 0:
        return NO_VECTOR
    if rigid < 0:
        return velocity(translation, body)
    return add(velocity(translation, body), cross(angular_velocity(rotation, rigid), arm))


@inline
def point_rate(elements, place, rotation):
    """Angular velocity of the body of a point, world axes."""
    rigid = int(elements[place + RIGID])
    if rigid < 0:
        return NO_VECTOR
    return angular_velocity(rotation, rigid)


@inline
def apply_force(elements, place, translation, rotation, arm, force):
    """Add a force at a point whose arm is known, and its torque about the centre of mass."""
    body = int(elements[place + BODY])
    rigid = int(elements[place + RIGID])
    if body >= 0:
        add_force(translation, body, force)
    if rigid >= 0:
        add_torque(rotation, rigid, cross(arm, force))
