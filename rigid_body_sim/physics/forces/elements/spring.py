# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A spring with a damper between two points: Hooke's law.

    d = x_b - x_a,  u = d' = v_b - v_a           [m], [m/s]
    force on a = k (|d| - l) n + c (u . n) n,  n = d / |d|
    force on b = -force on a, each with the torque of its arm
    energy     = k (|d| - l)^2 / 2

        k : stiffness [N/m]    c : damping [N s/m]    l : rest length [m]

With l = 0 the spring is linear in d, and so is its damper, which then acts on all of u: force on a
= k d + c u. A spring with l > 0 whose ends meet has no direction and exerts no force.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import DAMPING, add_between_points, add_turning_arm
from rigid_body_sim.physics.forces.element import BodyState, Places, Tie, key
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.state.blocks import (
    add_force,
    add_torque,
    angular_velocity,
    position,
    to_world,
    velocity,
)


@inline
def end(elements, m, translation, rotation):
    """Position and arm of one end, in world axes."""
    index = int(elements[m])
    turns = int(elements[m + 1])
    ax, ay, az = elements[m + 2], elements[m + 3], elements[m + 4]
    if index < 0:
        return ax, ay, az, 0.0, 0.0, 0.0
    x, y, z = position(translation, index)
    if turns < 0:
        return x, y, z, 0.0, 0.0, 0.0
    ax, ay, az = to_world(rotation, turns, ax, ay, az)
    return x + ax, y + ay, z + az, ax, ay, az


@inline
def end_velocity(elements, m, translation, rotation, ax, ay, az):
    """Velocity of one end whose arm is (ax, ay, az), in world axes."""
    index = int(elements[m])
    turns = int(elements[m + 1])
    if index < 0:
        return 0.0, 0.0, 0.0
    u, v, w = velocity(translation, index)
    if turns < 0:
        return u, v, w
    a, b, c = angular_velocity(rotation, turns)
    return u + (b * az - c * ay), v + (c * ax - a * az), w + (a * ay - b * ax)


@inline
def push(elements, m, translation, rotation, ax, ay, az, fx, fy, fz):
    """Apply a force at one end."""
    index = int(elements[m])
    turns = int(elements[m + 1])
    if index >= 0:
        add_force(translation, index, fx, fy, fz)
    if turns >= 0:
        add_torque(rotation, turns, ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx)


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the forces of all springs."""
    for e in range(count):
        m = start + 13 * e
        x, y, z, ax, ay, az = end(elements, m, translation, rotation)
        p, q, r, bx, by, bz = end(elements, m + 5, translation, rotation)
        stiffness = elements[m + 10]
        damping = elements[m + 11]
        rest = elements[m + 12]
        dx, dy, dz = p - x, q - y, r - z
        ux = uy = uz = 0.0
        if damping != 0.0:
            u, v, w = end_velocity(elements, m, translation, rotation, ax, ay, az)
            ux, uy, uz = end_velocity(elements, m + 5, translation, rotation, bx, by, bz)
            ux, uy, uz = ux - u, uy - v, uz - w
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
        push(elements, m, translation, rotation, ax, ay, az, fx, fy, fz)
        push(elements, m + 5, translation, rotation, bx, by, bz, -fx, -fy, -fz)


@inline
def _rate(elements, m, rotation):
    """Angular velocity of the body of one end."""
    turns = int(elements[m + 1])
    if turns < 0:
        return 0.0, 0.0, 0.0
    return angular_velocity(rotation, turns)


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """
    Add the derivatives of all springs.

        d force on a / d x_b = k n n^T + (f / |d|) (1 - n n^T) + c n ((1 - n n^T) u)^T / |d|
        d force on a / d v_b = c n n^T        f = k (|d| - l) + c (u . n);  without rest length k 1
        and c 1
    """
    for e in range(count):
        m = start + 13 * e
        x, y, z, ax, ay, az = end(elements, m, translation, rotation)
        p, q, r, bx, by, bz = end(elements, m + 5, translation, rotation)
        u, v, w = end_velocity(elements, m, translation, rotation, ax, ay, az)
        s, t, o = end_velocity(elements, m + 5, translation, rotation, bx, by, bz)
        k = elements[m + 10]
        c = elements[m + 11]
        rest = elements[m + 12]
        dx, dy, dz = p - x, q - y, r - z
        ux, uy, uz = s - u, t - v, o - w
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        if rest == 0.0:
            fx, fy, fz = k * dx + c * ux, k * dy + c * uy, k * dz + c * uz
            nx = ny = nz = gx = gy = gz = 0.0
            across, damped_across = k, c
            k = c = 0.0
        else:
            over = 1.0 / length if length > 0.0 else 0.0
            nx, ny, nz = dx * over, dy * over, dz * over
            un = ux * nx + uy * ny + uz * nz
            f = k * (length - rest) + c * un
            fx, fy, fz = f * nx, f * ny, f * nz
            across, damped_across = f * over, 0.0
            g = c * over
            if definite > 0:
                across, g = max(across, 0.0), 0.0
            gx, gy, gz = g * (ux - un * nx), g * (uy - un * ny), g * (uz - un * nz)
        k -= across
        c -= damped_across
        k11 = across + nx * (k * nx + gx)
        k12, k13 = nx * (k * ny + gy), nx * (k * nz + gz)
        k22 = across + ny * (k * ny + gy)
        k21, k23 = ny * (k * nx + gx), ny * (k * nz + gz)
        k33 = across + nz * (k * nz + gz)
        k31, k32 = nz * (k * nx + gx), nz * (k * ny + gy)
        c11, c22, c33 = (
            damped_across + c * nx * nx,
            damped_across + c * ny * ny,
            damped_across + c * nz * nz,
        )
        c12, c13, c23 = c * nx * ny, c * nx * nz, c * ny * nz
        for of in range(2):
            i = int(elements[m + 5 * of])
            if i < 0:
                continue
            arm = (ax, ay, az) if of == 0 else (bx, by, bz)
            for with_of in range(2):
                j = int(elements[m + 5 * with_of])
                if j < 0:
                    continue
                other = (ax, ay, az) if with_of == 0 else (bx, by, bz)
                rate = (
                    (0.0, 0.0, 0.0) if definite > 0 else _rate(elements, m + 5 * with_of, rotation)
                )
                g = 1.0 if of != with_of else -1.0
                add_between_points(
                    table, i, j, arm, g * k11, g * k12, g * k13, g * k21, g * k22, g * k23,
                    g * k31, g * k32, g * k33, 0, other, rate,
                )  # fmt: skip
                add_between_points(
                    table, i, j, arm, g * c11, g * c12, g * c13, g * c12, g * c22, g * c23,
                    g * c13, g * c23, g * c33, DAMPING, other, rate,
                )  # fmt: skip
            if definite == 0:
                g = 1.0 if of == 0 else -1.0
                add_turning_arm(table, i, *arm, g * fx, g * fy, g * fz)


@dataclass(frozen=True)
class Spring:
    """
    A spring between a point of `a` and a point of `b`, bodies or the world; without a point, the
    centre of mass.
    """

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
    linearise = staticmethod(linearise)

    def row(self, places: Places) -> tuple[float, ...]:
        """Both ends, then stiffness, damping, rest length."""
        a = places.place(self.a, self.a_point)
        b = places.place(self.b, self.b_point)
        return (*a.numbers(), *b.numbers(), self.stiffness, self.damping, self.rest_length)

    def tie(self) -> Tie:
        """Its stiffness and damping."""
        ends = ((self.a, self.a_point), (self.b, self.b_point))
        return Tie(*ends, stiffness=self.stiffness, damping=self.damping)

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
