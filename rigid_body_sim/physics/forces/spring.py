# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A spring with a damper between two points: Hooke's law.

    d = x_b - x_a,  u = d' = v_b - v_a           [m], [m/s]
    force on a = k (|d| - l) n + c (u . n) n,  n = d / |d|
    force on b = -force on a, each with the torque of its arm
    energy     = k (|d| - l)^2 / 2

        k : stiffness [N/m]    c : damping [N s/m]    l : rest length [m]

With l = 0 the spring is linear in d, and so is its damper, which then acts on all of u: force on a = k d + c u. A
spring with l > 0 whose ends meet has no direction and exerts no force.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rigid_body_sim.physics.blocks import (
    add_force,
    add_torque,
    angular_velocity,
    position,
    to_world,
    velocity,
)
from rigid_body_sim.physics.forces.element import BodyState, Places, key
from rigid_body_sim.physics.kernels import inline, kernel
from rigid_body_sim.physics.model import Vector


@inline
def _end(elements, m, translation, rotation):
    """Position, velocity and arm of one end, in world axes."""
    index = int(elements[m])
    turns = int(elements[m + 1])
    ax, ay, az = elements[m + 2], elements[m + 3], elements[m + 4]
    if index < 0:
        return ax, ay, az, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z = position(translation, index)
    u, v, w = velocity(translation, index)
    if turns < 0:
        return x, y, z, u, v, w, 0.0, 0.0, 0.0
    ax, ay, az = to_world(rotation, turns, ax, ay, az)
    a, b, c = angular_velocity(rotation, turns)
    return (
        x + ax,
        y + ay,
        z + az,
        u + (b * az - c * ay),
        v + (c * ax - a * az),
        w + (a * ay - b * ax),
        ax,
        ay,
        az,
    )


@inline
def _push(elements, m, translation, rotation, ax, ay, az, fx, fy, fz):
    """Apply a force at one end."""
    index = int(elements[m])
    turns = int(elements[m + 1])
    if index >= 0:
        add_force(translation, index, fx, fy, fz)
    if turns >= 0:
        add_torque(
            rotation, turns, ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx
        )


@kernel
def accumulate(elements, start, count, time, translation, rotation):
    """Add the forces of all springs."""
    for e in range(count):
        m = start + 13 * e
        x, y, z, u, v, w, ax, ay, az = _end(elements, m, translation, rotation)
        p, q, r, s, t, o, bx, by, bz = _end(elements, m + 5, translation, rotation)
        stiffness = elements[m + 10]
        damping = elements[m + 11]
        rest = elements[m + 12]
        dx, dy, dz = p - x, q - y, r - z
        ux, uy, uz = s - u, t - v, o - w
        if rest == 0.0:
            fx = stiffness * dx + damping * ux
            fy = stiffness * dy + damping * uy
            fz = stiffness * dz + damping * uz
        else:
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            over = 1.0 / length if length > 0.0 else 0.0
            nx, ny, nz = dx * over, dy * over, dz * over
            f = stiffness * (length - rest) + damping * (ux * nx + uy * ny + uz * nz)
            fx, fy, fz = f * nx, f * ny, f * nz
        _push(elements, m, translation, rotation, ax, ay, az, fx, fy, fz)
        _push(elements, m + 5, translation, rotation, bx, by, bz, -fx, -fy, -fz)


@dataclass(frozen=True)
class Spring:
    """A spring between a point of `a` and a point of `b`, bodies or the world; without a point, the centre of mass."""

    a: str = key('body_or_world')
    b: str = key('body_or_world')
    stiffness: float = key('number', unit='N/m', minimum=0.0)
    damping: float = key('number', unit='N s/m', minimum=0.0, default=0.0)
    rest_length: float = key('number', unit='m', minimum=0.0, default=0.0)
    a_point: Vector | None = key('point', unit='m', default=None)
    b_point: Vector | None = key('point', unit='m', default=None)

    TYPE = 'spring'
    COLUMNS = 13
    accumulate = staticmethod(accumulate)

    def row(self, places: Places) -> tuple[float, ...]:
        """Both ends, then stiffness, damping, rest length."""
        a = places.place(self.a, self.a_point)
        b = places.place(self.b, self.b_point)
        return (*a.numbers(), *b.numbers(), self.stiffness, self.damping, self.rest_length)

    def bodies(self) -> tuple[str, ...]:
        """Both ends."""
        return (self.a, self.b)

    def depends_on_velocity(self) -> bool:
        """With a damper."""
        return self.damping != 0.0

    def conserves_energy(self) -> bool:
        """Without a damper."""
        return self.damping == 0.0

    def potential_energy(self, state: BodyState) -> float:
        """k (|d| - l)^2 / 2 [J]."""
        length = math.dist(state.point(self.a, self.a_point), state.point(self.b, self.b_point))
        stretch = length - self.rest_length
        return 0.5 * self.stiffness * stretch * stretch


ELEMENT = Spring
