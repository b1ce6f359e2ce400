# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An elastic bumper between two points: Hooke's law while they are nearer than its length, nothing
beyond.

    d = x_b - x_a,  n = d / |d|                                                    [m]
    force on a = k (|d| - l) n  where |d| < l, else 0;   force on b = -force on a   [N]
    energy     = k (|d| - l)^2 / 2  where |d| < l, else 0                           [J]

        k : stiffness [N/m]    l : length at which it touches [m]

Two masses that meet head on rebound as in an elastic impact, whatever k is, once they have parted:
the push lasts pi sqrt(mu / k), 1/mu = 1/m_a + 1/m_b, and the tick has to resolve it. The force has
a kink at |d| = l, which lowers an integrator to order two there. Not a contact of shapes: points
alone push each other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.forces.body_point import apply_force, locate, point_field
from rigid_body_sim.physics.forces.element import (
    BodyState,
    Places,
    Tie,
    ends_meet,
    key,
    need_two_ends,
)
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.vectors import dot, negate, scale, subtract

columns = Record()
END_A = point_field(columns, 'end on a')
END_B = point_field(columns, 'end on b')
STIFFNESS = columns.number('N/m', '')
LENGTH = columns.number('m', 'at which it touches')
SIZE = columns.size


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the forces of all bumpers that touch."""
    for number in range(count):
        row = start + SIZE * number
        x_a, arm_a = locate(elements, row + END_A, translation, rotation)
        x_b, arm_b = locate(elements, row + END_B, translation, rotation)
        offset = subtract(x_b, x_a)
        distance = math.sqrt(dot(offset, offset))
        length = elements[row + LENGTH]
        if 0.0 < distance < length:
            force = scale(elements[row + STIFFNESS] * (distance - length) / distance, offset)
            apply_force(elements, row + END_A, translation, rotation, arm_a, force)
            apply_force(elements, row + END_B, translation, rotation, arm_b, negate(force))


@dataclass(frozen=True)
class Bumper:
    """
    A push between a point of `a` and a point of `b`, bodies or the world; without a point, the
    centre of mass.
    """

    a: str = key('body_or_world')
    b: str = key('body_or_world')
    stiffness: float = key('number', unit='N/m', minimum=0.0)
    length: float = key('number', unit='m', minimum=0.0)
    a_point: Vector | None = key('point', unit='m', default=None)
    b_point: Vector | None = key('point', unit='m', default=None)

    TYPE = 'bumper'
    COLUMNS = SIZE
    accumulate = staticmethod(accumulate)

    def __post_init__(self) -> None:
        need_two_ends(self.TYPE, self.a, self.b)

    def row(self, places: Places) -> tuple[float, ...]:
        """Both ends, then stiffness and length."""
        a = places.place(self.a, self.a_point)
        b = places.place(self.b, self.b_point)
        return (*a.numbers(), *b.numbers(), self.stiffness, self.length)

    def tie(self) -> Tie:
        """Its stiffness while it touches."""
        ends = ((self.a, self.a_point), (self.b, self.b_point))
        return Tie(*ends, stiffness=self.stiffness)

    def bodies(self) -> tuple[str, ...]:
        """Both ends."""
        return (self.a, self.b)

    def turns(self, body: str) -> bool:
        """Unless it acts at the centre of mass."""
        ends = ((self.a, self.a_point), (self.b, self.b_point))
        return any(name == body and point is not None for name, point in ends)

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """Always: what it takes in the approach it gives back."""
        return True

    def no_direction(self, state: BodyState) -> str | None:
        """Tell whether its ends are at one point, and it should push them apart."""
        return ends_meet(self, state) if self.stiffness * self.length != 0.0 else None

    def potential_energy(self, state: BodyState) -> float:
        """k (|d| - l)^2 / 2 where the points are nearer than l [J]."""
        distance = math.dist(state.point(self.a, self.a_point), state.point(self.b, self.b_point))
        overlap = min(distance - self.length, 0.0)
        return 0.5 * self.stiffness * overlap * overlap


ELEMENT = Bumper
