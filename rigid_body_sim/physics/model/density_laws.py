# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Laws of a density over the space that a shape fills, in shape coordinates.

    linear     : rho = at_origin + gradient . x
    polynomial : rho = sum of c x^i y^j z^k
    table      : rho between rows (s, rho) by straight lines; s is x, y or z of a box, z of a
                 cylinder, or the distance from the middle of a sphere

Mass, centre and inertia are integrals by quadrature (`mass_properties.of_density`); those of a
table have closed forms between its rows: slices of a box or cylinder, shells of a sphere, for
which

    m = 4 pi integral rho s^2 ds,   I = (8 pi / 3) integral rho s^4 ds

Refused with InvalidModel: a density that falls below zero where it was looked at (of a polynomial:
at the points of the quadrature), a table that does not span the shape, powers that are no whole
numbers of at least zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model import quadrature
from rigid_body_sim.physics.model.mass_properties import (
    MassProperties,
    of_density,
    of_linear_density,
    union,
)
from rigid_body_sim.physics.model.plain_products import power
from rigid_body_sim.physics.model.shapes import Box, Cylinder, Mesh, Shape, Sphere

Array = NDArray[np.float64]

ALONG = ('x', 'y', 'z', 'radius')  # of a table
HIGHEST_POWER = 20  # [-] of all three together: what 24 points a direction integrate exactly
LOOKS = 12  # [-] points along each direction at which the sign of a density is looked at
SPANNED = 1e-9  # [-] of the extent: a table may end this near to the surface


@dataclass(frozen=True)
class LinearDensity:
    """
    A density that grows along one direction: rho = at_origin + gradient . x.

    at_origin : [kg/m^3]       at the origin of the shape
    gradient  : (3,) [kg/m^4]  shape axes
    """

    at_origin: float
    gradient: tuple[float, float, float]

    def of(self, shape: Shape) -> MassProperties:
        """Return mass, centre and inertia; InvalidModel where the density falls below zero."""
        return of_linear_density(shape, at_origin=self.at_origin, gradient=self.gradient)


@dataclass(frozen=True)
class PolynomialDensity:
    """
    A density that is a polynomial of the place: rho = sum of c x^i y^j z^k.

    terms : (c [kg/m^(3 + i + j + k)], (i, j, k)), one each
    """

    terms: Sequence[tuple[float, tuple[int, int, int]]]

    def __post_init__(self) -> None:
        for _, powers in self.terms:
            if min(powers) < 0 or sum(powers) > HIGHEST_POWER:
                raise InvalidModel(
                    f'powers {list(powers)}: whole numbers of at least 0 are needed, together at '
                    f'most {HIGHEST_POWER}'
                )

    def at(self, points: Array) -> Array:
        """Return the density [kg/m^3] at points (k, 3) [m]."""
        total = np.zeros(len(points))
        for coefficient, powers in self.terms:
            term = np.full(len(points), coefficient)
            for axis, exponent in enumerate(powers):
                if exponent:
                    term = term * power(points[:, axis], exponent)
            total = total + term
        return total

    def of(self, shape: Shape) -> MassProperties:
        """Return mass, centre and inertia; InvalidModel where the density falls below zero."""
        need_positive(shape, self.at)
        return of_density(shape, self.at)


@dataclass(frozen=True)
class TableDensity:
    """
    A density by straight lines between rows.

    along : 'x', 'y', 'z' or 'radius'
    rows  : (s [m], rho [kg/m^3]), s ascending
    """

    along: str
    rows: Sequence[tuple[float, float]]

    def __post_init__(self) -> None:
        if len(self.rows) < 2 or any(b[0] <= a[0] for a, b in pairwise(self.rows)):
            raise InvalidModel('a table needs at least two rows, and their places must ascend')
        for s, rho in self.rows:
            if not (math.isfinite(s) and math.isfinite(rho) and rho >= 0.0):
                raise InvalidModel(
                    f'row [{s:g}, {rho:g}]: finite numbers are needed, and a density of 0 or more'
                )

    def of(self, shape: Shape) -> MassProperties:
        """Return mass, centre and inertia of a box, cylinder or sphere."""
        match shape, self.along:
            case Box(size=size), ('x' | 'y' | 'z'):
                axis = 'xyz'.index(self.along)
                return self._slices(axis, size[axis], [edge * edge / 12.0 for edge in size])
            case Cylinder(radius=radius, length=length), 'z':
                across = 0.25 * radius * radius
                return self._slices(
                    2, length, [across, across, 0.0], area=math.pi * radius * radius
                )
            case Sphere(radius=radius), 'radius':
                return self._shells(radius)
        raise InvalidModel(
            f'a table along {self.along!r} is known of: x, y, z of a box, z of a cylinder, radius '
            f'of a sphere; not of a {type(shape).__name__.lower()}'
        )

    def _pieces(self, low: float, high: float) -> list[tuple[float, float, float, float]]:
        """Cut the rows to what the shape spans: begin, end [m], density at both [kg/m^3]."""
        reach = SPANNED * (high - low)
        if self.rows[0][0] > low + reach or self.rows[-1][0] < high - reach:
            raise InvalidModel(
                f'the table goes from {self.rows[0][0]:g} to {self.rows[-1][0]:g} m along '
                f'{self.along}, the shape from {low:g} to {high:g} m; it must span the shape'
            )
        found = []
        for (a, at_a), (b, at_b) in pairwise(self.rows):
            slope = (at_b - at_a) / (b - a)
            begin, end = max(a, low), min(b, high)
            if end > begin:
                found.append(
                    (
                        begin,
                        end,
                        max(0.0, at_a + slope * (begin - a)),
                        max(0.0, at_b + slope * (end - b)),
                    )
                )
        return found

    def _slices(
        self, axis: int, length: float, spread: list[float], *, area: float | None = None
    ) -> MassProperties:
        """
        Join slices across an axis, each of length h and with a density m + g s about its middle.

        M = m A h,   c = g h^2 / (12 m),   integral s^2 dm = M h^2/12 - M c^2 about the centre

        spread : (3,) [m^2]  mean square of the distance across, along each axis
        area   : [m^2]       of a slice; None: of a box
        """
        if area is None:
            i, j = (axis + 1) % 3, (axis + 2) % 3
            area = 12.0 * math.sqrt(spread[i]) * math.sqrt(spread[j])
        parts = []
        for begin, end, at_begin, at_end in self._pieces(-0.5 * length, 0.5 * length):
            mean, h = 0.5 * (at_begin + at_end), end - begin
            if mean == 0.0:
                continue
            shift = (at_end - at_begin) * h / (12.0 * mean)
            mass = mean * area * h
            squares = [mass * square for square in spread]
            squares[axis] = mass * (h * h / 12.0 - shift * shift)
            x, y, z = squares
            center = np.zeros(3)
            center[axis] = 0.5 * (begin + end) + shift
            parts.append(MassProperties(mass, center, np.diag((y + z, x + z, x + y))))
        if not parts:
            raise InvalidModel('the density is zero everywhere; a body needs a mass')
        return union(parts)

    def _shells(self, radius: float) -> MassProperties:
        mass = moment = 0.0
        for begin, end, at_begin, at_end in self._pieces(0.0, radius):
            slope = (at_end - at_begin) / (end - begin)
            at_zero = at_begin - slope * begin
            for n in (2, 4):
                integral = at_zero * (power(end, n + 1) - power(begin, n + 1)) / (n + 1)
                integral += slope * (power(end, n + 2) - power(begin, n + 2)) / (n + 2)
                if n == 2:
                    mass += 4.0 * math.pi * integral
                else:
                    moment += 8.0 * math.pi / 3.0 * integral
        if not (mass > 0.0 and math.isfinite(mass)):
            raise InvalidModel(f'mass is {mass} kg; it must be positive and finite')
        return MassProperties(mass, np.zeros(3), moment * np.eye(3))


DensityLaw = LinearDensity | PolynomialDensity | TableDensity


def need_positive(shape: Shape, density: Callable[[Array], Array]) -> None:
    """Refuse a density that falls below zero at points inside a shape, or corners of a mesh."""
    if isinstance(shape, Mesh):  # points of its quadrature may lie outside
        looked = [shape.vertices]
    else:
        looked = [points for points, _ in quadrature.nodes(shape, LOOKS)]
    for points in looked:
        values = density(points)
        worst = int(np.argmin(values))
        if values[worst] < 0.0:
            place = ', '.join(f'{x:.6g}' for x in points[worst])
            raise InvalidModel(
                f'the density falls to {values[worst]:.6g} kg/m^3 at ({place}) m, within the '
                'shape; it must stay zero or positive'
            )
