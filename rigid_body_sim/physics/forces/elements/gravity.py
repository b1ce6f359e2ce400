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

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.forces.element import BodyState, Places, key
from rigid_body_sim.physics.forces.power import DRIVES
from rigid_body_sim.physics.model.numbers import exact_sum, shown
from rigid_body_sim.physics.model.scene import Body
from rigid_body_sim.physics.state.blocks import add_force, position
from rigid_body_sim.physics.vectors import add, dot, load, scale, subtract

G = 6.67430e-11  # [m^3/(kg s^2)] CODATA 2018

head = Record()
WIDTH = head.number('-', 'numbers of the row, which differs from row to row')
CONSTANT = head.number('m^3/(kg s^2)', 'G')
SOFTENING = head.number('m', 's')
COUNT = head.number('-', 'bodies that follow')
SIZE_HEAD = head.size

attractor = Record()
BODY = attractor.number('-', 'core index; -1: it is fixed')
FIXED_POSITION = attractor.vector('m', 'where it is fixed')
MASS = attractor.number('kg', 'at the start of the scene')
RATE = attractor.number('kg/s', 'of the mass')
LASTS = attractor.number('s', 'how long the mass changes')
SIZE = attractor.size
TOUCHING = 5e-324  # [m] in place of no distance at all, where the energy is minus infinity


@inline
def _position_and_mass(elements, place, time, translation):
    """Position and mass of one of the bodies."""
    body = int(elements[place + BODY])
    mass = elements[place + MASS] + elements[place + RATE] * min(time, elements[place + LASTS])
    if body < 0:
        return load(elements, place + FIXED_POSITION), mass
    return position(translation, body), mass


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the attraction between all pairs."""
    row = start
    for _number in range(count):
        constant = elements[row + CONSTANT]
        soft = elements[row + SOFTENING] * elements[row + SOFTENING]
        bodies = int(elements[row + COUNT])
        for i in range(bodies - 1):
            of_a = row + SIZE_HEAD + SIZE * i
            x_a, mass_a = _position_and_mass(elements, of_a, time, translation)
            on_a = (0.0, 0.0, 0.0)
            for j in range(i + 1, bodies):
                of_b = row + SIZE_HEAD + SIZE * j
                x_b, mass_b = _position_and_mass(elements, of_b, time, translation)
                offset = subtract(x_b, x_a)
                square = dot(offset, offset) + soft
                over = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
                factor = constant * mass_a * mass_b * over * over * over
                on_a = add(on_a, scale(factor, offset))
                if elements[of_b + BODY] >= 0.0:
                    add_force(translation, int(elements[of_b + BODY]), scale(-factor, offset))
            if elements[of_a + BODY] >= 0.0:
                add_force(translation, int(elements[of_a + BODY]), on_a)
        row += int(elements[row + WIDTH])


@inline
def _rate(elements, place, time):
    """Rate of the mass of one of the bodies now."""
    return elements[place + RATE] if time < elements[place + LASTS] else 0.0


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what flows of mass bring into the potential: -G (m_a' m_b + m_a m_b') / |d|."""
    row = start
    for _number in range(count):
        soft = elements[row + SOFTENING] * elements[row + SOFTENING]
        bodies = int(elements[row + COUNT])
        for i in range(bodies - 1):
            of_a = row + SIZE_HEAD + SIZE * i
            x_a, mass_a = _position_and_mass(elements, of_a, time, translation)
            for j in range(i + 1, bodies):
                of_b = row + SIZE_HEAD + SIZE * j
                x_b, mass_b = _position_and_mass(elements, of_b, time, translation)
                product = _rate(elements, of_a, time) * mass_b
                product += _rate(elements, of_b, time) * mass_a
                offset = subtract(x_b, x_a)
                square = dot(offset, offset) + soft
                if product != 0.0 and square > 0.0:
                    out[DRIVES] -= elements[row + CONSTANT] * product / math.sqrt(square)
        row += int(elements[row + WIDTH])


@dataclass(frozen=True)
class Gravity:
    """Attraction among the bodies named; a scene that names none means all of them."""

    among: tuple[str, ...] = key('bodies', default=())
    constant: float = key('number', unit='m^3/(kg s^2)', minimum=0.0, default=G)
    softening: float = key('number', unit='m', minimum=0.0, default=0.0)

    TYPE = 'gravity'
    COLUMNS = None
    accumulate = staticmethod(accumulate)
    power = staticmethod(power)

    def __post_init__(self) -> None:
        names = self.among if isinstance(self.among, list | tuple) else ()
        if not all(isinstance(name, str) for name in names):
            names = ()
        if len(set(names)) != len(names) or len(names) < 2:
            raise InvalidModel(
                f'gravity among {shown(self.among)}; at least two bodies are needed, each once'
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
        settings = (self.constant, self.softening, float(len(numbers) // SIZE))
        return (float(SIZE_HEAD + len(numbers)), *settings, *numbers)

    def bodies(self) -> tuple[str, ...]:
        """All that attract each other."""
        return self.among

    def turns(self, body: str) -> bool:
        """Never: it acts at the centres of mass."""
        return False

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """Always."""
        return True

    def no_energy(self, state: BodyState) -> str | None:
        """Name two that are at one point; None: none are, or softening parts them."""
        if self.softening > 0.0 or self.constant == 0.0:
            return None
        at: dict[tuple[float, ...], Body] = {}
        for name in self.among:
            body, position, _ = state.bodies[name]
            other = at.setdefault(tuple(position.tolist()), body) if body.mass > 0.0 else body
            if other is not body and not (other.fixed and body.fixed):
                return (
                    f'{other.name!r} and {name!r} attract each other and are both at '
                    f'({", ".join(f"{x:g}" for x in position)}) m, where their energy is minus '
                    'infinity; allowed: a distance above zero; put one elsewhere, or give the '
                    'force a softening > 0 m'
                )
        return None

    def potential_energy(self, state: BodyState) -> float:
        """-G m m' / (|d|^2 + s^2)^(1/2), over all pairs [J]."""
        found = [state.bodies[name] for name in self.among if state.bodies[name][0].mass > 0.0]
        return -self.constant * exact_sum(
            [
                state.mass(a) * state.mass(b) / (math.hypot(*(x - y), self.softening) or TOUCHING)
                for i, (a, x, _) in enumerate(found)
                for b, y, _ in found[i + 1 :]
                if not (a.fixed and b.fixed)
            ]
        )


ELEMENT = Gravity
