# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the forces of a scene give and take at one instant: the power of all that has no potential.

    P = F . v + torque . omega        [W]  F, v: at the centre of mass

in three sums: commands (what is held on the bodies from outside the scene), drives (what the scene
itself brings energy in with: forces over time, constant ones without a potential, flows of mass)
and dissipation (what dampers and drag take, counted positive). What has a potential, as springs,
bumpers and gravity do, is part of `Simulation.energy()` and gives none. Each element says in its
own file, beside its force, what its power is: the kernel `power`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import argument, inline, kernel
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import (
    LANES,
    ROTATION,
    TRANSLATION,
    angular_velocity,
    at,
    to_world,
    velocity,
)
from rigid_body_sim.physics.vectors import dot, load, load_strided

Array = NDArray[np.float64]
PowerKernel = Callable[..., None]

power_sums = Record()
COMMANDS = power_sums.number('W', 'of what is held on the bodies')
DRIVES = power_sums.number('W', 'of what the scene brings energy in with; may be negative')
DISSIPATION = power_sums.number('W', 'taken by dampers and drag, positive')
SUMS = power_sums.size

held = Record()
BODY = held.number('-', 'core index')
RIGID = held.number('-', 'index among the rigid bodies; -1: a point mass')
FORCE = held.vector('N', 'at the centre of mass, world axes, or principal axes')
TORQUE = held.vector('N m', 'the same axes')
TURNS_WITH_BODY = held.number('-', '1: both are in principal axes')
HELD = held.size


@inline
def wrench_power(translation, rotation, body, rigid, force, torque):
    """Power [W] of a force at the centre of mass and a torque, world axes."""
    given = dot(force, velocity(translation, body))
    if rigid >= 0:
        given += dot(torque, angular_velocity(rotation, rigid))
    return given


@kernel
def _power_of_commands(table, count, translation, rotation, out):
    """Add the power of all that is held."""
    for number in range(count):
        row = HELD * number
        rigid = int(table[row + RIGID])
        force = load(table, row + FORCE)
        torque = load(table, row + TORQUE)
        if table[row + TURNS_WITH_BODY] != 0.0:
            force = to_world(rotation, rigid, force)
            torque = to_world(rotation, rigid, torque)
        body = int(table[row + BODY])
        out[COMMANDS] += wrench_power(translation, rotation, body, rigid, force, torque)


@kernel
def _power_of_all(n_moving, n_rigid, translation, rotation, out):
    """Add the power of the sums of forces and torques."""
    for body in range(n_moving):
        force = load_strided(translation, at(body, TRANSLATION) + blocks.FORCE, LANES)
        torque = (0.0, 0.0, 0.0)
        if body < n_rigid:
            torque = load_strided(rotation, at(body, ROTATION) + blocks.TORQUE, LANES)
        rigid = body if body < n_rigid else -1
        out[DRIVES] += wrench_power(translation, rotation, body, rigid, force, torque)


def of_wrenches(accumulate: Callable[..., Any], n_moving: int, n_rigid: int) -> PowerKernel:
    """
    Give the power of an element that does not say it: that of all its wrenches, as of a drive.

    Right for an element that stores nothing; slower, because its wrenches are summed for it.
    """

    def power(
        elements: Any,
        start: int,
        count: int,
        time: float,
        translation: Any,
        rotation: Any,
        out: Any,
    ) -> None:
        sums = [
            blocks.rows(np.asarray(array), size, offset, 3)
            for array, size, offset in (
                (translation, TRANSLATION, blocks.FORCE),
                (rotation, ROTATION, blocks.TORQUE),
            )
        ]
        before = [view.copy() for view in sums]
        for view in sums:
            view[:] = 0.0
        accumulate(elements, start, count, time, translation, rotation)
        _power_of_all(n_moving, n_rigid, translation, rotation, out)
        for view, values in zip(sums, before, strict=True):
            view[:] = values

    return power


class Pivots(Protocol):
    """Bodies that turn about a pivot: `elements.pivot.Pivots`."""

    count: int

    def show(self, translation: Array, rotation: Array) -> None:
        """Let the blocks hold position and momentum of the centres of mass."""
        ...

    def hide(self, translation: Array, rotation: Array) -> None:
        """Let the blocks hold what a tick begins with again."""
        ...


class Acting(Protocol):
    """What acts in a scene: `acting_elements.ActingElements`."""

    arguments: tuple[Any, Any]
    kinks: Array

    @property
    def pivots(self) -> Pivots:
        """Give the bodies that turn about a pivot."""
        ...

    def working(self) -> list[tuple[PowerKernel, int, int]]:
        """Give the elements that bring or take energy: kernel, first place, number."""
        ...


class Powers:
    """
    The power of all that acts in one scene.

    idle          : whether nothing acts that gives or takes: every power is zero
    was_commanded : whether anything was held so far
    kinks         : instants [s] at which a derivative of a power jumps
    """

    def __init__(self, acting: Acting) -> None:
        self._acting = acting
        self.kinks = acting.kinks
        self._held = np.zeros((0, HELD))
        self.was_commanded = False
        self.renew()

    def renew(self) -> None:
        """Look again where the elements stand: after `ActingElements.set_turning`."""
        self._working = self._acting.working()
        self.idle = not (self._working or len(self._held))

    def holds(self, table: Array) -> bool:
        """Whether what is held is the same as that of a table, rows of `held`."""
        return np.array_equal(table, self._held)

    def hold(self, table: Array) -> None:
        """Take over what is held: rows of `held`."""
        self._held = table
        self._commands = (argument(table.reshape(-1)), len(table))
        self.was_commanded |= len(table) > 0
        self.renew()

    def prepare(self, translation: Array, rotation: Array) -> None:
        """Compile what `measure` will need, commands too."""
        out = argument(np.zeros(SUMS))
        _power_of_commands(argument(np.zeros(HELD)), 0, translation, rotation, out)
        self.measure(0.0, translation, rotation, out)

    def measure(self, time: float, translation: Array, rotation: Array, out: Array) -> None:
        """
        Evaluate at a time [s] of the scene.

        out : (SUMS,) [W]
        """
        for place in range(SUMS):
            out[place] = 0.0
        pivots = self._acting.pivots
        if pivots.count:
            pivots.show(translation, rotation)
        numbers = self._acting.arguments[0]
        for power, start, count in self._working:  # in this order: the first may write moments
            power(numbers, start, count, time, translation, rotation, out)
        if len(self._held):
            _power_of_commands(*self._commands, translation, rotation, out)
        if pivots.count:
            pivots.hide(translation, rotation)
