# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A constant force and torque on one body, in world axes or in the axes of the body.

    F acts at a point of the body: torque about the centre of mass = arm x F + torque
    energy = -F . x                   for a force in world axes without a torque
"""

from __future__ import annotations

from dataclasses import dataclass

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces import body_point
from rigid_body_sim.physics.forces.body_point import point_field
from rigid_body_sim.physics.forces.derivatives import add_turning_arm, add_turning_wrench
from rigid_body_sim.physics.forces.element import BodyState, Places, key, pushed
from rigid_body_sim.physics.forces.power import DRIVES, wrench_power
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.state.blocks import add_force, add_torque, to_world
from rigid_body_sim.physics.vectors import add, cross, dot, load

columns = Record()
POINT = point_field(columns, 'where the force acts')
FORCE = columns.vector('N', 'world axes, or principal axes')
TORQUE = columns.vector('N m', 'the same axes')
TURNS_WITH_BODY = columns.number('-', '1: both are in principal axes')
SIZE = columns.size


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add all constant wrenches."""
    for number in range(count):
        row = start + SIZE * number
        rigid = int(elements[row + POINT + body_point.RIGID])
        force = load(elements, row + FORCE)
        torque = load(elements, row + TORQUE)
        if rigid >= 0:
            arm = to_world(rotation, rigid, load(elements, row + POINT + body_point.OFFSET))
            if elements[row + TURNS_WITH_BODY] != 0.0:
                force = to_world(rotation, rigid, force)
                torque = to_world(rotation, rigid, torque)
            add_torque(rotation, rigid, add(torque, cross(arm, force)))
        add_force(translation, int(elements[row + POINT + body_point.BODY]), force)


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what the wrenches without a potential give: F . v + (arm x F + torque) . w."""
    for number in range(count):
        row = start + SIZE * number
        rigid = int(elements[row + POINT + body_point.RIGID])
        force = load(elements, row + FORCE)
        torque = load(elements, row + TORQUE)
        turns = elements[row + TURNS_WITH_BODY] != 0.0
        if rigid >= 0 and (turns or dot(torque, torque) > 0.0):
            arm = to_world(rotation, rigid, load(elements, row + POINT + body_point.OFFSET))
            if turns:
                force = to_world(rotation, rigid, force)
                torque = to_world(rotation, rigid, torque)
            body = int(elements[row + POINT + body_point.BODY])
            torque = add(torque, cross(arm, force))
            out[DRIVES] += wrench_power(translation, rotation, body, rigid, force, torque)


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """Add the derivatives: the arm turns with the body, and so does a wrench in its axes."""
    for number in range(count):
        row = start + SIZE * number
        body = int(elements[row + POINT + body_point.BODY])
        rigid = int(elements[row + POINT + body_point.RIGID])
        if rigid >= 0 and definite == 0:
            force = load(elements, row + FORCE)
            arm = to_world(rotation, rigid, load(elements, row + POINT + body_point.OFFSET))
            if elements[row + TURNS_WITH_BODY] != 0.0:
                force = to_world(rotation, rigid, force)
                torque = to_world(rotation, rigid, load(elements, row + TORQUE))
                add_turning_wrench(table, body, force, add(torque, cross(arm, force)))
            else:
                add_turning_arm(table, body, arm, force)


@dataclass(frozen=True)
class Constant:
    """A wrench that stays the same, in the axes of `frame`."""

    body: str = key('body')
    force: Vector = key('vector', unit='N', default=(0.0, 0.0, 0.0))
    torque: Vector = key('vector', unit='N m', default=(0.0, 0.0, 0.0))
    frame: str = key('choice', choices=('world', 'body'), default='world')
    point: Vector | None = key('point', unit='m', default=None)

    TYPE = 'constant'
    COLUMNS = SIZE
    accumulate = staticmethod(accumulate)
    power = staticmethod(power)
    linearise = staticmethod(linearise)

    def row(self, places: Places) -> tuple[float, ...]:
        """Place, force and torque (principal axes where the frame is the body's), frame."""
        place = pushed(places, self.body, self.point)
        if place.turns < 0 and (any(self.torque) or self.frame == 'body'):
            raise InvalidModel(
                f'force constant: {self.body!r} is a point mass, which takes no torque and has '
                'no axes; '
                'give a force in the frame world'
            )
        if self.frame == 'world':
            return (*place.numbers(), *self.force, *self.torque, 0.0)
        force = places.principal_axes(self.body, self.force)
        torque = places.principal_axes(self.body, self.torque)
        return (*place.numbers(), *force, *torque, 1.0)

    def bodies(self) -> tuple[str, ...]:
        """The one body; whatever pushes it is not in the scene."""
        return (self.body,)

    def turns(self, body: str) -> bool:
        """With a torque, or away from the centre of mass."""
        return any(self.torque) or self.point is not None

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """A force in world axes without a torque has a potential."""
        return self.frame == 'world' and not any(self.torque)

    def brings_energy(self) -> bool:
        """Where it has no potential."""
        return not self.conserves_energy()

    def potential_energy(self, state: BodyState) -> float:
        """-F . x [J], from the origin of the world."""
        if not self.conserves_energy():
            return 0.0
        return -float(state.point(self.body, self.point) @ self.force)


ELEMENT = Constant
