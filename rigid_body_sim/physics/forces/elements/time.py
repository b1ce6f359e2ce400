# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A force and torque on one body given over time by a table, in world axes or in those of the body.

    F(t) = c0 + c1 s + c2 s^2 + c3 s^3,   s = t - t_i,   t_i <= t < t_i+1; likewise the torque
    F acts at a point of the body: torque about the centre of mass = arm x F + torque

linear : straight from row to row
cubic  : the twice continuously differentiable spline through the rows (not-a-knot; scipy's
         CubicSpline)

Time counts from the start of the scene. Before the first and after the last row the wrench is
zero, or with `outside: hold` that of the nearest row. At a row the wrench has a kink, or its third
derivative jumps: a tick is cut at the rows inside it (`forces.schedule`), so that a method keeps
its order. Rows much denser than ticks cost as many steps. It takes and gives energy from outside:
none is conserved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.forces import body_point
from rigid_body_sim.physics.forces.body_point import point_field
from rigid_body_sim.physics.forces.element import BodyState, Places, key, pushed
from rigid_body_sim.physics.forces.power import DRIVES, wrench_power
from rigid_body_sim.physics.model.locked_arrays import locked
from rigid_body_sim.physics.model.numbers import is_list, is_number, shown
from rigid_body_sim.physics.model.plain_products import product
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.state.blocks import add_force, add_torque, to_world
from rigid_body_sim.physics.vectors import add, cross, load

head = Record()
WIDTH = head.number('-', 'numbers of the row, which differs from row to row')
POINT = point_field(head, 'where the force acts')
TURNS_WITH_BODY = head.number('-', '1: the wrench is in principal axes')
ACTS = head.number('-', '1 while it acts, else 0: the switch')
INTERVALS = head.number('-', 'intervals that follow; behind the last one, its end [s]')
SIZE_HEAD = head.size

COMPONENTS = 3  # of a vector
CUBIC = 4  # c0 to c3

interval = Record()
BEGIN = interval.number('s', 'when it begins')
FORCE = interval.numbers(COMPONENTS * CUBIC, 'N s^-n', 'coefficients of Fx, then of Fy, of Fz')
TORQUE = interval.numbers(COMPONENTS * CUBIC, 'N m s^-n', 'coefficients of the torque, likewise')
SIZE = interval.size


@inline
def _value(elements, c, s):
    """Cubic at s [s] after the start of its interval."""
    return elements[c] + s * (
        elements[c + 1] + s * (elements[c + 2] + s * elements[c + CUBIC - 1])
    )


@inline
def _vector(elements, c, s):
    """Three cubics at s [s] after the start of their interval."""
    return (
        _value(elements, c, s),
        _value(elements, c + CUBIC, s),
        _value(elements, c + 2 * CUBIC, s),
    )


@inline
def _interval_at(elements, row, time):
    """Where the interval stands in which a time lies: the first or the last, where in none."""
    low, high = 0, int(elements[row + INTERVALS])
    while high - low > 1:
        middle = (low + high) // 2
        if elements[row + SIZE_HEAD + SIZE * middle + BEGIN] <= time:
            low = middle
        else:
            high = middle
    return row + SIZE_HEAD + SIZE * low


@inline
def _wrench(elements, row, time, rotation):
    """Force at the centre of mass and torque about it of one table, world axes."""
    rigid = int(elements[row + POINT + body_point.RIGID])
    place = _interval_at(elements, row, time)
    last = elements[row + SIZE_HEAD + SIZE * int(elements[row + INTERVALS])]
    s = max(min(time, last) - elements[place + BEGIN], 0.0)
    force = _vector(elements, place + FORCE, s)
    torque = (0.0, 0.0, 0.0)
    if rigid >= 0:
        torque = _vector(elements, place + TORQUE, s)
        arm = to_world(rotation, rigid, load(elements, row + POINT + body_point.OFFSET))
        if elements[row + TURNS_WITH_BODY] != 0.0:
            force = to_world(rotation, rigid, force)
            torque = to_world(rotation, rigid, torque)
        torque = add(torque, cross(arm, force))
    return force, torque


@inline
def accumulate(elements, start, count, time, translation, rotation):
    """Add the wrenches of all tables."""
    row = start
    for _number in range(count):
        if elements[row + ACTS] != 0.0:
            rigid = int(elements[row + POINT + body_point.RIGID])
            force, torque = _wrench(elements, row, time, rotation)
            if rigid >= 0:
                add_torque(rotation, rigid, torque)
            add_force(translation, int(elements[row + POINT + body_point.BODY]), force)
        row += int(elements[row + WIDTH])


@kernel
def power(elements, start, count, time, translation, rotation, out):
    """Add what the wrenches of all tables give."""
    row = start
    for _number in range(count):
        if elements[row + ACTS] != 0.0:
            body = int(elements[row + POINT + body_point.BODY])
            rigid = int(elements[row + POINT + body_point.RIGID])
            force, torque = _wrench(elements, row, time, rotation)
            out[DRIVES] += wrench_power(translation, rotation, body, rigid, force, torque)
        row += int(elements[row + WIDTH])


@dataclass(frozen=True)
class TimeTable:
    """
    A wrench over time; rows of `table` are (t, fx, fy, fz) or (t, fx, fy, fz, tx, ty, tz) [s, N, N
    m].
    """

    body: str = key('body')
    table: tuple[tuple[float, ...], ...] = key('table', unit='s, N, N m')
    interpolation: str = key('choice', choices=('linear', 'cubic'), default='linear')
    outside: str = key('choice', choices=('zero', 'hold'), default='zero')
    frame: str = key('choice', choices=('world', 'body'), default='world')
    point: Vector | None = key('point', unit='m', default=None)

    TYPE = 'time'
    COLUMNS = None
    SWITCH = ACTS
    accumulate = staticmethod(accumulate)
    power = staticmethod(power)

    def __post_init__(self) -> None:
        with blaming('table'):
            self._check_table()
        object.__setattr__(self, 'table', locked(self.table))

    def _check_table(self) -> None:
        if not is_list(self.table) or not all(map(_is_row, self.table)):
            raise InvalidModel(f'got {shown(self.table)}; a list of rows of numbers is needed')
        widths = {len(row) for row in self.table}
        if (
            len(self.table) < 2
            or len(widths) != 1
            or not widths <= {1 + COMPONENTS, 1 + 2 * COMPONENTS}
        ):
            raise InvalidModel(
                f'a table of {len(self.table)} rows of {sorted(widths)} numbers; '
                'at least two rows are needed, '
                'all of (t, fx, fy, fz) or all of (t, fx, fy, fz, tx, ty, tz)'
            )
        numbers = np.array(self.table, dtype=np.float64)
        if not np.all(np.isfinite(numbers)):
            raise InvalidModel('the table holds NaN or infinity; every number must be finite')
        late = np.flatnonzero(np.diff(numbers[:, 0]) <= 0.0)
        if late.size:
            t = numbers[late[0] + 1, 0]
            raise InvalidModel(
                f'row {late[0] + 1} of the table, at {t:g} s, is not later than the one before; '
                'times must ascend (for a jump give two forces, one that ends and one that begins)'
            )

    def _coefficients(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times (n,) and coefficients (n - 1, 6, 4), c0 first."""
        numbers = np.zeros((len(self.table), 1 + 2 * COMPONENTS))
        numbers[:, : len(self.table[0])] = self.table
        t, values = numbers[:, 0], numbers[:, 1:]
        found = np.zeros((len(t) - 1, 2 * COMPONENTS, CUBIC))
        with np.errstate(all='ignore'):
            if self.interpolation == 'linear':
                found[:, :, 0] = values[:-1]
                found[:, :, 1] = np.diff(values, axis=0) / np.diff(t)[:, None]
            else:
                found[:] = np.moveaxis(_spline(t, values), 0, -1)
        if not np.all(np.isfinite(found)):
            raise InvalidModel(
                'between the rows of the table the wrench changes faster than numbers can tell; '
                'check its times and units',
                at=('table',),
            )
        return t, found

    def row(self, places: Places) -> tuple[float, ...]:
        """
        Width, place, frame, switch, then start and coefficients of each interval, and the last
        time.
        """
        place = pushed(places, self.body, self.point)
        t, coefficients = self._coefficients()
        if place.turns < 0 and np.any(coefficients[:, COMPONENTS:]):
            raise InvalidModel(
                f'a torque over time on the point mass {self.body!r}, which has no orientation'
            )
        if self.frame == 'body':
            axes = np.array([places.principal_axes(self.body, _unit(i)) for i in range(3)])
            turned = [product(axes.T, part) for part in np.split(coefficients, 2, axis=1)]
            coefficients = np.concatenate(turned, axis=1)
        intervals = np.concatenate((t[:-1, None], coefficients.reshape(-1, SIZE - 1)), axis=1)
        in_body = 1.0 if self.frame == 'body' else 0.0
        row = (
            *place.numbers(),
            in_body,
            1.0,
            float(len(intervals)),
            *intervals.ravel().tolist(),
            float(t[-1]),
        )
        return (float(len(row) + 1), *row)

    def acts(self) -> tuple[float, float]:
        """From the first row to the last, or always where the nearest row holds."""
        if self.outside == 'hold':
            return (-math.inf, math.inf)
        return (self.table[0][0], self.table[-1][0])

    def kinks(self) -> tuple[float, ...]:
        """The times of its rows [s]."""
        return tuple(row[0] for row in self.table)

    def bodies(self) -> tuple[str, ...]:
        """The one body; whatever pushes it is not in the scene."""
        return (self.body,)

    def turns(self, body: str) -> bool:
        """With torques, or away from the centre of mass."""
        torques = (number for row in self.table for number in row[1 + COMPONENTS :])
        return self.point is not None or any(torques)

    def depends_on_velocity(self) -> bool:
        """Never."""
        return False

    def conserves_energy(self) -> bool:
        """Never: it works on the body from outside."""
        return False

    def brings_energy(self) -> bool:
        """Always."""
        return True

    def potential_energy(self, state: BodyState) -> float:
        """A force over time stores nothing."""
        return 0.0


def _spline(t: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients (4, n - 1, 6) of the cubic spline, c0 first; NaN where there is none."""
    from scipy.interpolate import CubicSpline  # slow to import: only for those who ask

    try:
        return CubicSpline(t, values, axis=0).c[::-1]
    except (ValueError, np.linalg.LinAlgError):  # numbers too far apart
        return np.full((CUBIC, len(t) - 1, values.shape[1]), np.nan)


def _is_row(row: object) -> bool:
    """Tell whether something is a row of numbers, perhaps not finite."""
    return is_list(row) and all(isinstance(x, float) or is_number(x) for x in row)


def _unit(axis: int) -> Vector:
    return (float(axis == 0), float(axis == 1), float(axis == 2))


ELEMENT = TimeTable
