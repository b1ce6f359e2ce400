# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The first and the last word on a body that turns about a pivot: see `model.pivot`.

    first : r <- O + a,   p <- m omega x a               the centre of mass, for elements to read
    last  : torque <- torque + a x F,   F <- 0,   r <- O,   p <- 0

Not elements that a scene names: they stand about all others. Derivatives (`forces.derivatives`)
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

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import argument, inline, kernel
from rigid_body_sim.physics.forces.derivatives import (
    DAMPING_MATRIX,
    ROW,
    TORQUE_ROWS,
    TURN_COLUMNS,
    add_turning_arm,
    block_place,
    first_block,
    partner,
    place_of,
)
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.state.blocks import (
    FORCE,
    INVERSE_MASS,
    LANES,
    MOMENTUM,
    POSITION,
    TRANSLATION,
    add_torque,
    angular_velocity,
    at,
    to_world,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_strided,
    cross,
    load,
    load_strided,
    scale,
    store,
    store_strided,
)

if TYPE_CHECKING:
    from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]

NAME = 'pivot'

columns = Record()
BODY = columns.number('-', 'core index, also among the rigid bodies')
ARM = columns.vector('m', 'a: from the pivot to the centre of mass, principal axes')
PIVOT = columns.vector('m', 'O: world')
LAST_FORCE = columns.vector('N', 'sum of the forces at the last evaluation, world axes')
COLUMNS = columns.size

NO_VECTOR = (0.0, 0.0, 0.0)


@inline
def show_center(elements, start, count, time, translation, rotation):
    """Write position and momentum of the centres of mass."""
    for number in range(count):
        row = start + COLUMNS * number
        body = int(elements[row + BODY])
        arm = to_world(rotation, body, load(elements, row + ARM))
        k = at(body, TRANSLATION)
        mass = 1.0 / translation[k + INVERSE_MASS]
        momentum = scale(mass, cross(angular_velocity(rotation, body), arm))
        center = add(load(elements, row + PIVOT), arm)
        store_strided(translation, k + POSITION, LANES, center)
        store_strided(translation, k + MOMENTUM, LANES, momentum)


@inline
def _stand_still(elements, row, k, translation):
    """Put the row of a body back to the pivot."""
    store_strided(translation, k + POSITION, LANES, load(elements, row + PIVOT))
    store_strided(translation, k + MOMENTUM, LANES, NO_VECTOR)


@inline
def turn_about_pivot(elements, start, count, time, translation, rotation):
    """Make torques about the pivot of all that acts."""
    for number in range(count):
        row = start + COLUMNS * number
        body = int(elements[row + BODY])
        arm = to_world(rotation, body, load(elements, row + ARM))
        k = at(body, TRANSLATION)
        force = load_strided(translation, k + FORCE, LANES)
        store(elements, row + LAST_FORCE, force)
        store_strided(translation, k + FORCE, LANES, NO_VECTOR)
        _stand_still(elements, row, k, translation)
        add_torque(rotation, body, cross(arm, force))


@kernel
def hide_center(elements, count, translation):
    """Put the rows back to the pivots: the end of what `show_center` began."""
    for number in range(count):
        row = COLUMNS * number
        _stand_still(elements, row, at(int(elements[row + BODY]), TRANSLATION), translation)


@kernel
def show_center_for_derivatives(
    elements, start, count, time, translation, rotation, table, definite
):
    """Write position and momentum of the centres of mass."""
    show_center(elements, start, count, time, translation, rotation)


@kernel
def _turn_columns(table, place, arm, omega, definite):
    """Let a body move with its turns alone, in one block: columns 3 to 5 from columns 0 to 2."""
    for row in range(ROW):
        of_stiffness = place + ROW * row
        of_damping = of_stiffness + DAMPING_MATRIX
        k, c = load(table, of_stiffness), load(table, of_damping)
        add_strided(table, of_damping + TURN_COLUMNS, 1, cross(arm, c))
        if definite == 0:  # c . (omega x (theta x a)) = (a x (c x omega)) . theta
            k = add(k, cross(c, omega))
        add_strided(table, of_stiffness + TURN_COLUMNS, 1, cross(arm, k))
        store(table, of_stiffness, NO_VECTOR)
        store(table, of_damping, NO_VECTOR)


@kernel
def _turn_rows(table, place, arm):
    """Make torques about the pivot of forces, in one matrix: rows 3 to 5 from rows 0 to 2."""
    for column in range(place, place + ROW):
        force = load_strided(table, column, ROW)
        add_strided(table, column + TORQUE_ROWS, ROW, cross(arm, force))
        store_strided(table, column, ROW, NO_VECTOR)


@kernel
def turn_derivatives(elements, start, count, time, translation, rotation, table, definite):
    """Make derivatives of torques about the pivot with turns of all derivatives."""
    for number in range(count):
        row = start + COLUMNS * number
        body = int(elements[row + BODY])
        arm = to_world(rotation, body, load(elements, row + ARM))
        omega = angular_velocity(rotation, body)
        for block in range(first_block(table, body), first_block(table, body + 1)):
            place = block_place(table, block)
            _turn_rows(table, place, arm)
            _turn_rows(table, place + DAMPING_MATRIX, arm)
            place = place_of(table, partner(table, block), body)
            _turn_columns(table, place, arm, omega, definite)
        if definite == 0:
            add_turning_arm(table, body, arm, load(elements, row + LAST_FORCE))
        _stand_still(elements, row, at(body, TRANSLATION), translation)


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
        self.table[:, BODY] = self._cores
        self.table[:, ARM:PIVOT] = self._arms
        for row, core in zip(self.table, self._cores, strict=True):
            row[PIVOT:LAST_FORCE] = layout.start_position(core)
        self._numbers = argument(self.table.reshape(-1))

    def about_pivot(
        self, core: int, linear: Array, angular: Array, q: Array
    ) -> tuple[Array, Array]:
        """
        Make an impulse about the pivot of one at the centre of mass; the pivot takes the rest.

            linear, angular : (3,) [N s], [N m s], world axes
            q               : (4,) attitude of the principal axes of the body
        """
        if core not in self._cores:
            return linear, angular
        arm = so3.rotate(q, self._arms[self._cores.index(core)])
        return np.zeros(3), angular + np.cross(arm, linear)

    def show(self, translation: Array, rotation: Array) -> None:
        """Let the blocks hold position and momentum of the centres of mass."""
        show_center(self._numbers, 0, self.count, 0.0, translation, rotation)

    def hide(self, translation: Array, rotation: Array) -> None:
        """Let the blocks hold what a tick begins with again."""
        hide_center(self._numbers, self.count, translation)

    def accelerate(self, linear: Array, angular: Array, q: Array, omega: Array) -> None:
        """
        Write the accelerations of the centres of mass: a' = w' x a + w x (w x a).

        linear, angular, q, omega : (n, 3), (n, 3), (n, 4), (n, 3) core order, world axes
        """
        of = self._cores
        arm = so3.rotate(q[of], self._arms)
        spin = np.cross(omega[of], arm)
        linear[of] = np.cross(angular[of], arm) + np.cross(omega[of], spin)
