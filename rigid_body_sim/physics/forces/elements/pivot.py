# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The first and the last word on a body that turns about a pivot: see `physics.pivot`.

    first : r <- O + a,   p <- m omega x a               the centre of mass, for elements to read
    last  : torque <- torque + a x F,   F <- 0,   r <- O,   p <- 0

Not elements that a scene names: they stand about all others. Derivatives (`physics.derivatives`)
of what the others answered go the same way: with theta, a turn of the body,

    dr = theta x a,   dv = dw x a + omega x (theta x a)
    d(torque + a x F) = d torque + a x dF + (theta x a) x F
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.derivatives import (
    DAMPING,
    add_turning_arm,
    block_place,
    first_block,
    partner,
    place_of,
)
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.state.blocks import (
    FX,
    FY,
    FZ,
    IM,
    PX,
    PY,
    PZ,
    ROTATION,
    RX,
    RY,
    RZ,
    TRANSLATION,
    TX,
    TY,
    TZ,
    angular_velocity,
    at,
    to_world,
)

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

NAME = 'pivot'
COLUMNS = 10  # index, arm (3), pivot (3), sum of the forces at the last evaluation (3)


@inline
def show_center(elements, start, count, time, translation, rotation):
    """Write position and momentum of the centres of mass."""
    for e in range(count):
        m = start + 10 * e
        i = int(elements[m])
        ax, ay, az = to_world(rotation, i, elements[m + 1], elements[m + 2], elements[m + 3])
        ox, oy, oz = angular_velocity(rotation, i)
        k = at(i, TRANSLATION)
        mass = 1.0 / translation[k + IM]
        translation[k + RX] = elements[m + 4] + ax
        translation[k + RY] = elements[m + 5] + ay
        translation[k + RZ] = elements[m + 6] + az
        translation[k + PX] = mass * (oy * az - oz * ay)
        translation[k + PY] = mass * (oz * ax - ox * az)
        translation[k + PZ] = mass * (ox * ay - oy * ax)


@inline
def _stand_still(elements, m, k, translation):
    """Put the row of a body back to the pivot."""
    translation[k + RX], translation[k + PX] = elements[m + 4], 0.0
    translation[k + RY], translation[k + PY] = elements[m + 5], 0.0
    translation[k + RZ], translation[k + PZ] = elements[m + 6], 0.0


@inline
def turn_about_pivot(elements, start, count, time, translation, rotation):
    """Make torques about the pivot of all that acts."""
    for e in range(count):
        m = start + 10 * e
        i = int(elements[m])
        ax, ay, az = to_world(rotation, i, elements[m + 1], elements[m + 2], elements[m + 3])
        k = at(i, TRANSLATION)
        fx, fy, fz = translation[k + FX], translation[k + FY], translation[k + FZ]
        elements[m + 7], elements[m + 8], elements[m + 9] = fx, fy, fz
        translation[k + FX] = 0.0
        translation[k + FY] = 0.0
        translation[k + FZ] = 0.0
        _stand_still(elements, m, k, translation)
        k = at(i, ROTATION)
        rotation[k + TX] += ay * fz - az * fy
        rotation[k + TY] += az * fx - ax * fz
        rotation[k + TZ] += ax * fy - ay * fx


@kernel
def show_center_for_derivatives(
    elements, start, count, time, translation, rotation, table, definite
):
    """Write position and momentum of the centres of mass."""
    show_center(elements, start, count, time, translation, rotation)


@kernel
def _turn_columns(table, m, ax, ay, az, ox, oy, oz, definite):
    """Let a body move with its turns alone, in one block: columns 3 to 5 from columns 0 to 2."""
    for row in range(6):
        n = m + 6 * row
        kx, ky, kz = table[n], table[n + 1], table[n + 2]
        c = n + DAMPING
        cx, cy, cz = table[c], table[c + 1], table[c + 2]
        table[c + 3] += ay * cz - az * cy
        table[c + 4] += az * cx - ax * cz
        table[c + 5] += ax * cy - ay * cx
        if definite == 0:  # c . (omega x (theta x a)) = (a x (c x omega)) . theta
            kx, ky, kz = (
                kx + (cy * oz - cz * oy),
                ky + (cz * ox - cx * oz),
                kz + (cx * oy - cy * ox),
            )
        table[n + 3] += ay * kz - az * ky
        table[n + 4] += az * kx - ax * kz
        table[n + 5] += ax * ky - ay * kx
        for column in range(3):
            table[n + column] = 0.0
            table[c + column] = 0.0


@kernel
def _turn_rows(table, m, ax, ay, az):
    """Make torques about the pivot of forces, in one matrix: rows 3 to 5 from rows 0 to 2."""
    for column in range(6):
        n = m + column
        fx, fy, fz = table[n], table[n + 6], table[n + 12]
        table[n + 18] += ay * fz - az * fy
        table[n + 24] += az * fx - ax * fz
        table[n + 30] += ax * fy - ay * fx
        table[n] = 0.0
        table[n + 6] = 0.0
        table[n + 12] = 0.0


@kernel
def turn_derivatives(elements, start, count, time, translation, rotation, table, definite):
    """Make derivatives of torques about the pivot with turns of all derivatives."""
    for e in range(count):
        m = start + 10 * e
        i = int(elements[m])
        ax, ay, az = to_world(rotation, i, elements[m + 1], elements[m + 2], elements[m + 3])
        ox, oy, oz = angular_velocity(rotation, i)
        for number in range(first_block(table, i), first_block(table, i + 1)):
            place = block_place(table, number)
            _turn_rows(table, place, ax, ay, az)
            _turn_rows(table, place + DAMPING, ax, ay, az)
            place = place_of(table, partner(table, number), i)
            _turn_columns(table, place, ax, ay, az, ox, oy, oz, definite)
        if definite == 0:
            add_turning_arm(
                table, i, ax, ay, az, elements[m + 7], elements[m + 8], elements[m + 9]
            )
        _stand_still(elements, m, at(i, TRANSLATION), translation)


@dataclass(frozen=True)
class Link:
    """A link of the chain of elements."""

    accumulate: Callable[..., Any]
    linearise: Callable[..., Any]


FIRST = Link(show_center, show_center_for_derivatives)
LAST = Link(turn_about_pivot, turn_derivatives)


class Pivots:
    """
    The bodies of a scene that turn about a pivot.

    count : how many there are
    table : (count, COLUMNS) rows of the element
    """

    def __init__(self, layout: Layout) -> None:
        self._cores = layout.pivoted
        self.count = len(self._cores)
        self._arms = np.array([layout.arm(core) for core in self._cores]).reshape(-1, 3)
        self.table = np.zeros((self.count, COLUMNS))
        self.table[:, 0] = self._cores
        self.table[:, 1:4] = self._arms
        for row, core in zip(self.table, self._cores, strict=True):
            row[4:7] = layout.start_position(core)

    def strike(self, core: int, linear: Array, angular: Array, q: Array) -> tuple[Array, Array]:
        """
        Make an impulse about the pivot of one at the centre of mass; the pivot takes the rest.

            linear, angular : (3,) [N s], [N m s], world axes
            q               : (4,) attitude of the principal axes of the body
        """
        if core not in self._cores:
            return linear, angular
        arm = so3.rotate(q, self._arms[self._cores.index(core)])
        return np.zeros(3), angular + np.cross(arm, linear)

    def accelerate(self, linear: Array, angular: Array, q: Array, omega: Array) -> None:
        """
        Write the accelerations of the centres of mass: a' = w' x a + w x (w x a).

        linear, angular, q, omega : (n, 3), (n, 3), (n, 4), (n, 3) core order, world axes
        """
        of = self._cores
        arm = so3.rotate(q[of], self._arms)
        spin = np.cross(omega[of], arm)
        linear[of] = np.cross(angular[of], arm) + np.cross(omega[of], spin)
