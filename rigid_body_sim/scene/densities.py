# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read a density that varies over space, in shape coordinates.

    density: {type: linear, at_origin: 250, gradient: [0, 0, 100]}       type may be left out
    density: {type: polynomial, terms: [{coefficient: 900, powers: [0, 0, 0]},
                                        {coefficient: -4e3, powers: [2, 0, 0]}]}
    density: {type: table, along: z, rows: [[-0.5, 900], [0, 600], [0.5, 900]]}
"""

from __future__ import annotations

from collections.abc import Callable

from rigid_body_sim.physics.model.density_laws import (
    ALONG,
    DensityLaw,
    LinearDensity,
    PolynomialDensity,
    TableDensity,
)
from rigid_body_sim.scene.grammar import DENSITIES, TERM
from rigid_body_sim.scene.values import Value


def read_density(value: Value) -> DensityLaw:
    """Return the law that a mapping describes."""
    kind = value.find('type')
    law = 'linear' if kind is None else kind.choice(LAWS, what='density')
    value.need_known(('type', *DENSITIES[law].keys))
    with value.blamed():
        return LAWS[law](value)


def _linear(value: Value) -> LinearDensity:
    at_origin = value.at('at_origin', what='a density [kg/m^3]').number(unit='kg/m^3')
    gradient = value.at('gradient', what='a list of three numbers [kg/m^4]').vector(unit='kg/m^4')
    return LinearDensity(at_origin, gradient)


def _polynomial(value: Value) -> PolynomialDensity:
    what = 'a list of {coefficient: c, powers: [i, j, k]}'
    terms = []
    for item in value.at('terms', what=what).items(what):
        item.need_mapping('{coefficient: c, powers: [i, j, k]}')
        item.need_known(TERM.keys)
        coefficient = item.at('coefficient', what='a number').number(unit='kg/m^(3 + i + j + k)')
        given = item.at('powers', what='three whole numbers')
        x, y, z = given.vector(unit='-')
        if any(power != round(power) for power in (x, y, z)):
            raise given.error(f'got {[x, y, z]}; powers are whole numbers')
        terms.append((coefficient, (int(x), int(y), int(z))))
    return PolynomialDensity(tuple(terms))


def _table(value: Value) -> TableDensity:
    along = value.at('along', what=f'one of {", ".join(ALONG)}').choice(ALONG, what='along')
    what = 'a list of [place [m], density [kg/m^3]]'
    rows = []
    for item in value.at('rows', what=what).items(what):
        pair = item.items(what)
        if len(pair) != 2:
            raise item.error(f'got {len(pair)} numbers; a row is [place [m], density [kg/m^3]]')
        rows.append((pair[0].number(unit='m'), pair[1].number(unit='kg/m^3', minimum=0.0)))
    return TableDensity(along, tuple(rows))


LAWS: dict[str, Callable[[Value], DensityLaw]] = {
    'linear': _linear,
    'polynomial': _polynomial,
    'table': _table,
}
