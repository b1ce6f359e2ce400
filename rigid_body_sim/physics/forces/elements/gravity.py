# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Mutual attraction of bodies: Newton's law of gravitation, with softening on request.

    force on a = G m_a m_b d / (|d|^2 + s^2)^(3/2) = - force on b,   d = x_b - x_a     [N]
    energy     = -G m_a m_b / (|d|^2 + s^2)^(1/2)                                       [J]

        G : constant [m^3/(kg s^2)]   s : softening [m] (Plummer, Mon. Not. R. Astron. Soc. 71
                                      (1911) 460)

The force acts at the centres of mass: exact for balls and point masses, without the tidal torque
on other shapes. It counts all pairs. Without softening, bodies that meet exert no force at that
point and an unbounded one beside it. The uniform field of the ground is the scene's key `gravity`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.element import BodyState, Places, key
from rigid_body_sim.physics.state.blocks import add_force, position

G = 6.67430e-11  # [m^3/(kg s^2)] CODATA 2018


@inline
def _body(elements, b, time, translation):
    """
    Place and mass of one of the bodies: columns index, place if fixed (3), mass, rate, how long it
    lasts.
    """
    index = int(elements[b])
    mass = elements[b + 4] + elements[b + 5] * min(time, elements[b + 6])
    if index < 0:
        return elements[b + 1], elements[b + 2], elements[b + 3], mass
    x, y, z = position(translation, index)
    return x, y, z, mass


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the attraction between all pairs."""
    m = start
    for _e in range(count):
        constant = elements[m + 1]
        soft = elements[m + 2] * elements[m + 2]
        n = int(elements[m + 3])
        for i in range(n - 1):
            a = m + 4 + 7 * i
            x, y, z, mass = _body(elements, a, time, translation)
            fx = fy = fz = 0.0
            for j in range(i + 1, n):
                b = m + 4 + 7 * j
                u, v, w, other = _body(elements, b, time, translation)
                u, v, w = u - x, v - y, w - z
                square = u * u + v * v + w * w + soft
                over = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
                f = constant * mass * other * over * over * over
                fx, fy, fz = fx + f * u, fy + f * v, fz + f * w
                if elements[b] >= 0.0:
                    add_force(translation, int(elements[b]), -f * u, -f * v, -f * w)
            if elements[a] >= 0.0:
                add_force(translation, int(elements[a]), fx, fy, fz)
        m += int(elements[m])


@dataclass(frozen=True)
class Gravity:
    """Attraction among the bodies named; a scene that names none means all of them."""

    among: tuple[str, ...] = key('bodies', default=())
    constant: float = key('number', unit='m^3/(kg s^2)', minimum=0.0, default=G)
    softening: float = key('number', unit='m', minimum=0.0, default=0.0)

    TYPE = 'gravity'
    COLUMNS = None
    accumulate = staticmethod(accumulate)

    def __post_init__(self) -> None:
        if len(set(self.among)) != len(self.among) or len(self.among) < 2:
            raise InvalidModel(
                f'gravity among {self.among}; at least two bodies are needed, each once'
            )

    def row(self, places: Places) -> tuple[float, ...]:
        """
        Width, constant, softening, count, then index, place and mass of each body; those without
        mass attract nothing.
        """
        numbers: list[float] = []
        for body in self.among:
            mass, rate, lasts = places.mass(body)
            if mass > 0.0:
                place = places.place(body, None)
                numbers += [float(place.index), *place.offset, mass, rate, lasts]
        head = (self.constant, self.softening, float(len(numbers) // 7))
        return (4.0 + len(numbers), *head, *numbers)

    def bodies(self) -> tuple[str, ...]:
        """All that attract each other."""
        return self.among

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """Always."""
        return True

    def potential_energy(self, state: BodyState) -> float:
        """-G m m' / (|d|^2 + s^2)^(1/2), over all pairs [J]."""
        found = [state.bodies[name] for name in self.among if state.bodies[name][0].mass > 0.0]
        return -self.constant * math.fsum(
            a.mass * b.mass / math.hypot(*(x - y), self.softening)
            for i, (a, x, _) in enumerate(found)
            for b, y, _ in found[i + 1 :]
            if not (a.fixed and b.fixed)
        )


ELEMENT = Gravity
