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

from rigid_body_sim.physics.blocks import add_force, add_torque, angular_velocity, velocity
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.element import BodyState, Places, key
from rigid_body_sim.physics.kernels import kernel


@kernel
def accumulate(elements, start, count, time, translation, rotation):
    """Add the drag of all bodies that have it."""
    for e in range(count):
        m = start + 6 * e
        index = int(elements[m])
        turns = int(elements[m + 1])
        u, v, w = velocity(translation, index)
        f = -(elements[m + 2] + elements[m + 3] * math.sqrt(u * u + v * v + w * w))
        add_force(translation, index, f * u, f * v, f * w)
        if turns >= 0:
            a, b, c = angular_velocity(rotation, turns)
            g = -(elements[m + 4] + elements[m + 5] * math.sqrt(a * a + b * b + c * c))
            add_torque(rotation, turns, g * a, g * b, g * c)


@dataclass(frozen=True)
class Drag:
    """Resistance of a fluid at rest to the motion of one body."""

    body: str = key('body')
    linear: float = key('number', unit='N s/m', minimum=0.0, default=0.0)
    quadratic: float = key('number', unit='N s^2/m^2', minimum=0.0, default=0.0)
    angular: float = key('number', unit='N m s', minimum=0.0, default=0.0)
    angular_quadratic: float = key('number', unit='N m s^2', minimum=0.0, default=0.0)

    TYPE = 'drag'
    COLUMNS = 6
    accumulate = staticmethod(accumulate)

    def row(self, places: Places) -> tuple[float, ...]:
        """Body, then the four coefficients."""
        place = places.place(self.body, None)
        if place.turns < 0 and (self.angular or self.angular_quadratic):
            raise InvalidModel(
                f'force drag: {self.body!r} is a point mass, which does not turn; leave angular and angular_quadratic out'
            )
        coefficients = (self.linear, self.quadratic, self.angular, self.angular_quadratic)
        return (float(place.index), float(place.turns), *coefficients)

    def bodies(self) -> tuple[str, ...]:
        """The one body; the fluid takes the counterforce."""
        return (self.body,)

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
