# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the inertia of a body over time: `inertia_over_time: {table: [[time, ixx, iyy, izz], …]}`.

Moments about the centre of mass in body axes, which are principal axes; in place of `inertia`.
`interpolation` is `smooth` (default: each moment comes to rest at every row) or `linear`.
"""

from __future__ import annotations

from rigid_body_sim.physics.model.inertia_over_time import INTERPOLATIONS, check_law
from rigid_body_sim.physics.model.scene import InertiaOverTime
from rigid_body_sim.scene.grammar import INERTIA_OVER_TIME
from rigid_body_sim.scene.values import Value


def read_inertia_over_time(value: Value) -> InertiaOverTime:
    """Return the checked law of a body."""
    what = 'a list of [time [s], ixx, iyy, izz [kg m^2]]'
    value.need_mapping(f'a mapping {{table: {what}}}')
    value.need_known(INERTIA_OVER_TIME.keys)
    rows = []
    for item in value.at('table', what=what).items(what):
        numbers = item.items(what)
        if len(numbers) != 4:
            raise item.error(f'got {len(numbers)} numbers; a row is [time, ixx, iyy, izz]')
        t, x, y, z = (
            number.number(unit=unit)
            for number, unit in zip(numbers, ('s', *['kg m^2'] * 3), strict=True)
        )
        rows.append((t, x, y, z))
    given = value.find('interpolation')
    how = 'smooth' if given is None else given.choice(INTERPOLATIONS, what='interpolation')
    law = InertiaOverTime(tuple(rows), how)
    with value.blamed():
        check_law(law)
    return law
