# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Drag at the centre of mass, linear and quadratic in the velocities relative to air at rest.

    F = -(c1 + c2 |v|) v          c1 : linear [N s/m]      c2 : quadratic [N s^2/m^2]
    torque = -(d1 + d2 |w|) w     d1 : angular [N m s]     d2 : angular_quadratic [N m s^2]
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.derivatives import add_angular_resistance, add_resistance
from rigid_body_sim.physics.forces.element import BodyState, Places, Tie, key, pushed
from rigid_body_sim.physics.forces.power import DISSIPATION
from rigid_body_sim.physics.state.blocks import add_force, add_torque, angular_velocity, velocity
from rigid_body_sim.physics.vectors import dot, scale

columns = Record()
BODY = columns.number('-', 'core index')
RIGID = columns.number('-', 'index among the rigid bodies; -1: no torque')
LINEAR = columns.number('N s/m', 'c1')
QUADRATIC = columns.number('N s^2/m^2', 'c2')
ANGULAR = columns.number('N m s', 'd1')
ANGULAR_QUADRATIC = columns.number('N m s^2', 'd2')
SIZE = columns.size


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the drag of all bodies that have it."""
    for number in range(count):
        row = start + SIZE * number
        body = int(elements[row + BODY])
        rigid = int(elements[row + RIGID])
        v = velocity(translation, body)
        resistance = elements[row + LINEAR] + elements[row + QUADRATIC] * math.sqrt(dot(v, v))
        add_force(translation, body, scale(-resistance, v))
        if rigid >= 0:
            w = angular_velocity(rotation, rigid)
            resistance = elements[row + ANGULAR] + elements[row + ANGULAR_QUADRATIC] * math.sqrt(
                dot(w, w)
            )
            add_torque(rotation, rigid, scale(-resistance, w))


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what all drags take: (c1 + c2 |v|) v^2 + (d1 + d2 |w|) w^2."""
    for number in range(count):
        row = start + SIZE * number
        rigid = int(elements[row + RIGID])
        v = velocity(translation, int(elements[row + BODY]))
        square = dot(v, v)
        resistance = elements[row + LINEAR] + elements[row + QUADRATIC] * math.sqrt(square)
        taken = resistance * square
        if rigid >= 0:
            w = angular_velocity(rotation, rigid)
            square = dot(w, w)
            resistance = elements[row + ANGULAR] + elements[row + ANGULAR_QUADRATIC] * math.sqrt(
                square
            )
            taken += resistance * square
        out[DISSIPATION] += taken


@inline
def _ratio(coefficient, speed):
    """Coefficient over speed, without speed nothing: then the product with v v^T is zero."""
    return coefficient / speed if speed > 0.0 else 0.0


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """
    Add the derivatives of all drags: -(c1 + c2 |v|) 1 - (c2 / |v|) v v^T, and so for the torque.
    """
    for number in range(count):
        row = start + SIZE * number
        body = int(elements[row + BODY])
        rigid = int(elements[row + RIGID])
        v = velocity(translation, body)
        speed = math.sqrt(dot(v, v))
        c1, c2 = elements[row + LINEAR], elements[row + QUADRATIC]
        add_resistance(table, body, -(c1 + c2 * speed), -_ratio(c2, speed), v)
        if rigid >= 0:
            w = angular_velocity(rotation, rigid)
            speed = math.sqrt(dot(w, w))
            c1, c2 = elements[row + ANGULAR], elements[row + ANGULAR_QUADRATIC]
            add_angular_resistance(table, rigid, -(c1 + c2 * speed), -_ratio(c2, speed), w)


@dataclass(frozen=True)
class Drag:
    """Resistance of a fluid at rest to the motion of one body."""

    body: str = key('body')
    linear: float = key('number', unit='N s/m', minimum=0.0, default=0.0)
    quadratic: float = key('number', unit='N s^2/m^2', minimum=0.0, default=0.0)
    angular: float = key('number', unit='N m s', minimum=0.0, default=0.0)
    angular_quadratic: float = key('number', unit='N m s^2', minimum=0.0, default=0.0)

    TYPE = 'drag'
    COLUMNS = SIZE
    accumulate = staticmethod(accumulate)
    power = staticmethod(power)
    linearise = staticmethod(linearise)

    def row(self, places: Places) -> tuple[float, ...]:
        """Body, its place among the rigid ones (-1: no torque), then the four coefficients."""
        place = pushed(places, self.body)
        if place.turns < 0 and (self.angular or self.angular_quadratic):
            raise InvalidModel(
                f'force drag: {self.body!r} is a point mass, which does not turn; leave angular '
                'and angular_quadratic out'
            )
        coefficients = (self.linear, self.quadratic, self.angular, self.angular_quadratic)
        turns = place.turns if self.angular or self.angular_quadratic else -1
        return (float(place.index), float(turns), *coefficients)

    def tie(self) -> Tie:
        """Its four coefficients."""
        return Tie(
            (self.body, None),
            damping=self.linear,
            quadratic=self.quadratic,
            angular=self.angular,
            angular_quadratic=self.angular_quadratic,
        )

    def bodies(self) -> tuple[str, ...]:
        """The one body; the fluid takes the counterforce."""
        return (self.body,)

    def turns(self, body: str) -> bool:
        """With an angular coefficient."""
        return bool(self.angular or self.angular_quadratic)

    def depends_on_velocity(self) -> bool:
        """Always."""
        return True

    def conserves_energy(self) -> bool:
        """Only where every coefficient is zero."""
        return not any((self.linear, self.quadratic, self.angular, self.angular_quadratic))

    def potential_energy(self, state: BodyState) -> float:
        """Drag stores nothing."""
        return 0.0


ELEMENT = Drag
