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

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces import body_point
from rigid_body_sim.physics.forces.body_point import (
    NO_VECTOR,
    apply_force,
    locate,
    point_field,
    point_rate,
    point_velocity,
)
from rigid_body_sim.physics.forces.derivatives import (
    DAMPING_MATRIX,
    STIFFNESS_MATRIX,
    add_between_points,
    add_turning_arm,
)
from rigid_body_sim.physics.forces.element import (
    BodyState,
    Places,
    Tie,
    ends_meet,
    key,
    need_two_ends,
)
from rigid_body_sim.physics.forces.power import DISSIPATION
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.vectors import add, dot, negate, scale, subtract

columns = Record()
END_A = point_field(columns, 'end on a')
END_B = point_field(columns, 'end on b')
STIFFNESS = columns.number('N/m', '')
DAMPING = columns.number('N s/m', '')
REST_LENGTH = columns.number('m', '')
SIZE = columns.size


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the forces of all springs."""
    for number in range(count):
        row = start + SIZE * number
        x_a, arm_a = locate(elements, row + END_A, translation, rotation)
        x_b, arm_b = locate(elements, row + END_B, translation, rotation)
        stiffness = elements[row + STIFFNESS]
        damping = elements[row + DAMPING]
        rest = elements[row + REST_LENGTH]
        distance = subtract(x_b, x_a)
        relative = NO_VECTOR
        if damping != 0.0:
            v_a = point_velocity(elements, row + END_A, translation, rotation, arm_a)
            v_b = point_velocity(elements, row + END_B, translation, rotation, arm_b)
            relative = subtract(v_b, v_a)
        if rest == 0.0:
            force = add(scale(stiffness, distance), scale(damping, relative))
        else:
            length = math.sqrt(dot(distance, distance))
            normal = scale(1.0 / length if length > 0.0 else 0.0, distance)
            force = scale(stiffness * (length - rest) + damping * dot(relative, normal), normal)
        apply_force(elements, row + END_A, translation, rotation, arm_a, force)
        apply_force(elements, row + END_B, translation, rotation, arm_b, negate(force))


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what the dampers take: c (u . n)^2, without rest length c u . u."""
    for number in range(count):
        row = start + SIZE * number
        damping = elements[row + DAMPING]
        if damping != 0.0:
            x_a, arm_a = locate(elements, row + END_A, translation, rotation)
            x_b, arm_b = locate(elements, row + END_B, translation, rotation)
            v_a = point_velocity(elements, row + END_A, translation, rotation, arm_a)
            v_b = point_velocity(elements, row + END_B, translation, rotation, arm_b)
            relative = subtract(v_b, v_a)
            if elements[row + REST_LENGTH] == 0.0:
                out[DISSIPATION] += damping * dot(relative, relative)
            else:
                distance = subtract(x_b, x_a)
                square = dot(distance, distance)
                along = dot(relative, distance)
                out[DISSIPATION] += damping * along * along / square if square > 0.0 else 0.0


@inline
def _outer_plus(s, v, w):
    """Matrix s 1 + v w^T, row by row."""
    return (
        (s + v[0] * w[0], v[0] * w[1], v[0] * w[2]),
        (v[1] * w[0], s + v[1] * w[1], v[1] * w[2]),
        (v[2] * w[0], v[2] * w[1], s + v[2] * w[2]),
    )


@inline
def _damping_matrix(s, c, n):
    """Symmetric matrix s 1 + c n n^T, row by row."""
    xy, xz, yz = c * n[0] * n[1], c * n[0] * n[2], c * n[1] * n[2]
    return (
        (s + c * n[0] * n[0], xy, xz),
        (xy, s + c * n[1] * n[1], yz),
        (xz, yz, s + c * n[2] * n[2]),
    )


@inline
def _derivatives(stiffness, damping, rest, distance, relative, definite):
    """Force on a, and its change with the position and with the velocity of the end on b."""
    length = math.sqrt(dot(distance, distance))
    if rest == 0.0:
        force = add(scale(stiffness, distance), scale(damping, relative))
        normal, turning = NO_VECTOR, NO_VECTOR
        across, damped_across = stiffness, damping
        along, damped_along = 0.0 - across, 0.0 - damped_across
    else:
        over = 1.0 / length if length > 0.0 else 0.0
        normal = scale(over, distance)
        approach = dot(relative, normal)
        pull = stiffness * (length - rest) + damping * approach
        force = scale(pull, normal)
        across, damped_across = pull * over, 0.0
        swing = damping * over
        if definite > 0:
            across, swing = max(across, 0.0), 0.0
        turning = scale(swing, subtract(relative, scale(approach, normal)))
        along, damped_along = stiffness - across, damping - damped_across
    of_position = _outer_plus(across, normal, add(scale(along, normal), turning))
    return force, of_position, _damping_matrix(damped_across, damped_along, normal)


@inline
def _scaled(factor, matrix):
    return scale(factor, matrix[0]), scale(factor, matrix[1]), scale(factor, matrix[2])


@kernel
def linearise(elements, start, count, time, translation, rotation, table, definite):
    """
    Add the derivatives of all springs.

        d force on a / d x_b = k n n^T + (f / |d|) (1 - n n^T) + c n ((1 - n n^T) u)^T / |d|
        d force on a / d v_b = c n n^T        f = k (|d| - l) + c (u . n);  without rest length k 1
        and c 1
    """
    for number in range(count):
        row = start + SIZE * number
        x_a, arm_a = locate(elements, row + END_A, translation, rotation)
        x_b, arm_b = locate(elements, row + END_B, translation, rotation)
        v_a = point_velocity(elements, row + END_A, translation, rotation, arm_a)
        v_b = point_velocity(elements, row + END_B, translation, rotation, arm_b)
        force, of_position, of_velocity = _derivatives(
            elements[row + STIFFNESS], elements[row + DAMPING], elements[row + REST_LENGTH],
            subtract(x_b, x_a), subtract(v_b, v_a), definite,
        )  # fmt: skip
        for of in range(2):
            end = row + (END_A if of == 0 else END_B)
            i = int(elements[end + body_point.BODY])
            if i < 0:
                continue
            arm = arm_a if of == 0 else arm_b
            for with_of in range(2):
                other_end = row + (END_A if with_of == 0 else END_B)
                j = int(elements[other_end + body_point.BODY])
                if j < 0:
                    continue
                other = arm_a if with_of == 0 else arm_b
                rate = NO_VECTOR if definite > 0 else point_rate(elements, other_end, rotation)
                sign = 1.0 if of != with_of else -1.0
                k, c = _scaled(sign, of_position), _scaled(sign, of_velocity)
                add_between_points(table, i, j, arm, k, STIFFNESS_MATRIX, other, rate)
                add_between_points(table, i, j, arm, c, DAMPING_MATRIX, other, rate)
            if definite == 0:
                add_turning_arm(table, i, arm, scale(1.0 if of == 0 else -1.0, force))


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
    COLUMNS = SIZE
    accumulate = staticmethod(accumulate)
    power = staticmethod(power)
    linearise = staticmethod(linearise)

    def __post_init__(self) -> None:
        need_two_ends(self.TYPE, self.a, self.b)

    def row(self, places: Places) -> tuple[float, ...]:
        """Both ends, then stiffness, damping, rest length."""
        a = places.place(self.a, self.a_point)
        b = places.place(self.b, self.b_point)
        return (*a.numbers(), *b.numbers(), self.stiffness, self.damping, self.rest_length)

    def tie(self) -> Tie:
        """Its stiffness and damping."""
        ends = ((self.a, self.a_point), (self.b, self.b_point))
        linear = self.rest_length == 0.0
        return Tie(*ends, stiffness=self.stiffness, damping=self.damping, linear=linear)

    def bodies(self) -> tuple[str, ...]:
        """Both ends."""
        return (self.a, self.b)

    def turns(self, body: str) -> bool:
        """Unless it acts at the centre of mass."""
        ends = ((self.a, self.a_point), (self.b, self.b_point))
        return any(name == body and point is not None for name, point in ends)

    def depends_on_velocity(self) -> bool:
        """With a damper."""
        return self.damping != 0.0

    def conserves_energy(self) -> bool:
        """Without a damper."""
        return self.damping == 0.0

    def no_direction(self, state: BodyState) -> str | None:
        """Tell whether its ends are at one point, and it should push them apart."""
        return ends_meet(self, state) if self.stiffness * self.rest_length != 0.0 else None

    def potential_energy(self, state: BodyState) -> float:
        """k (|d| - l)^2 / 2 [J]."""
        length = math.dist(state.point(self.a, self.a_point), state.point(self.b, self.b_point))
        stretch = length - self.rest_length
        return 0.5 * self.stiffness * stretch * stretch


ELEMENT = Spring
