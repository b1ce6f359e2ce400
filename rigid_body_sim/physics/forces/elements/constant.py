# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A constant force and torque on one body, in world axes or in the axes of the body.

    F acts at a point of the body: torque about the centre of mass = arm x F + torque
    energy = -F . x                   for a force in world axes without a torque
"""

from __future__ import annotations

from dataclasses import dataclass

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.derivatives import add_turning_arm, add_turning_wrench
from rigid_body_sim.physics.forces.element import BodyState, Places, key, pushed
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.state.blocks import add_force, add_torque, to_world


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add all constant wrenches."""
    for e in range(count):
        m = start + 12 * e
        index = int(elements[m])
        turns = int(elements[m + 1])
        fx, fy, fz = elements[m + 5], elements[m + 6], elements[m + 7]
        tx, ty, tz = elements[m + 8], elements[m + 9], elements[m + 10]
        if turns >= 0:
            ax, ay, az = to_world(
                rotation, turns, elements[m + 2], elements[m + 3], elements[m + 4]
            )
            if elements[m + 11] != 0.0:
                fx, fy, fz = to_world(rotation, turns, fx, fy, fz)
                tx, ty, tz = to_world(rotation, turns, tx, ty, tz)
            add_torque(
                rotation,
                turns,
                tx + (ay * fz - az * fy),
                ty + (az * fx - ax * fz),
                tz + (ax * fy - ay * fx),
            )
        add_force(translation, index, fx, fy, fz)


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """Add the derivatives: the arm turns with the body, and so does a wrench in its axes."""
    for e in range(count):
        m = start + 12 * e
        index = int(elements[m])
        turns = int(elements[m + 1])
        if turns >= 0 and definite == 0:
            fx, fy, fz = elements[m + 5], elements[m + 6], elements[m + 7]
            ax, ay, az = to_world(
                rotation, turns, elements[m + 2], elements[m + 3], elements[m + 4]
            )
            if elements[m + 11] != 0.0:
                fx, fy, fz = to_world(rotation, turns, fx, fy, fz)
                tx, ty, tz = to_world(
                    rotation, turns, elements[m + 8], elements[m + 9], elements[m + 10]
                )
                tx, ty, tz = (
                    tx + (ay * fz - az * fy),
                    ty + (az * fx - ax * fz),
                    tz + (ax * fy - ay * fx),
                )
                add_turning_wrench(table, index, fx, fy, fz, tx, ty, tz)
            else:
                add_turning_arm(table, index, ax, ay, az, fx, fy, fz)


@dataclass(frozen=True)
class Constant:
    """A wrench that stays the same, in the axes of `frame`."""

    body: str = key('body')
    force: Vector = key('vector', unit='N', default=(0.0, 0.0, 0.0))
    torque: Vector = key('vector', unit='N m', default=(0.0, 0.0, 0.0))
    frame: str = key('choice', choices=('world', 'body'), default='world')
    point: Vector | None = key('point', unit='m', default=None)

    TYPE = 'constant'
    COLUMNS = 12
    accumulate = staticmethod(accumulate)
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

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """A force in world axes without a torque has a potential."""
        return self.frame == 'world' and not any(self.torque)

    def potential_energy(self, state: BodyState) -> float:
        """-F . x [J], from the origin of the world."""
        if not self.conserves_energy():
            return 0.0
        return -float(state.point(self.body, self.point) @ self.force)


ELEMENT = Constant
