# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies whose inertia changes over time while their mass stays: skaters, folding masts, tethers.

    L' = torque,   omega = R I(t)^-1 R^T L,   I(t) = diag(ixx, iyy, izz) in body axes

What moves inside the body (the arms of the skater) moves along lines that carry no angular
momentum relative to the body, and its mass is spread so that centre of mass and principal axes
stay. Then L is that of a rigid body with the inertia of the instant; without torque it keeps its
last bit, and omega follows. The drive that moves the arms does work: from T = L . I^-1 L / 2

    P = -omega . I'(t) omega / 2    [W]

(pulled in: I' < 0, P > 0). The kinetic energy of the arms along their lines is not part of it.

Between the rows of a table each moment goes along a straight line, or along 3 u^2 - 2 u^3
(`smooth`: at rest at every row); both stay between the rows, so that what a rigid body may have at
the rows it may have at every instant. Before the first and after the last row it stays. Ticks are
cut at the rows (`forces.schedule`), so that an integrator keeps its order.

Only methods that integrate L itself and ask for the inertia at each of their stages follow it:
lie_rk4, and Runge–Kutta methods with `orientation: matrix`.

Source: Goldstein, Classical Mechanics, section 4.9 (rate of a vector in a turning frame).
"""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.inertia_tensor import check_inertia
from rigid_body_sim.physics.model.numbers import numbers
from rigid_body_sim.physics.model.scene import Body, InertiaOverTime, Scene
from rigid_body_sim.physics.model.variable_mass import mass_at

Array = NDArray[np.float64]

INTERPOLATIONS = ('linear', 'smooth')
SAME = 1e-12  # [-] of the largest moment: how near `inertia` of a record must be to the law at 0


def check_law(law: InertiaOverTime) -> None:
    """Refuse a table that no body can follow."""
    if not isinstance(law.table, tuple | list):
        raise InvalidModel('the table of inertia_over_time is no tuple of rows')
    if law.interpolation not in INTERPOLATIONS:
        raise InvalidModel(
            f'interpolation {law.interpolation!r} is unknown; allowed: {", ".join(INTERPOLATIONS)}'
        )
    if len(law.table) < 2:
        raise InvalidModel('inertia_over_time needs at least two rows [time, ixx, iyy, izz]')
    for number, row in enumerate(law.table):
        try:
            numbers(row, 4, unit='s, kg m^2')
            check_inertia(np.diag(row[1:]))
        except InvalidModel as error:
            raise InvalidModel(f'row {number} of inertia_over_time: {error}') from error
    for number, (one, other) in enumerate(pairwise(law.table)):
        if not other[0] > one[0]:
            raise InvalidModel(
                f'row {number + 1} of inertia_over_time, at {other[0]:g} s, is not later than the '
                'one before; times must ascend'
            )


def check_inertia_over_time(body: Body) -> None:
    """Refuse a law that the body cannot have."""
    law = body.inertia_over_time
    if law is None:
        return
    name = repr(body.name)
    if body.fixed or body.inertia is None:
        raise InvalidModel(
            f'{name} does not turn, so that inertia_over_time says nothing; remove it'
        )
    for held, key in ((body.pivot, 'pivot'), (body.mass_flow, 'mass_rate')):
        if held is not None:
            raise InvalidModel(
                f'{name} has inertia_over_time, for which {key} is not modelled; remove one'
            )
    check_law(law)
    apart = np.max(np.abs(body.inertia - np.diag(moments_at(law, 0.0))))
    if not apart <= SAME * np.max(np.abs(body.inertia)):
        raise InvalidModel(
            f'{name}: its inertia is not that of inertia_over_time at 0 s; leave inertia out'
        )


def inertia_at_start(body: Body) -> Array | None:
    """Inertia (3, 3) [kg m^2] at the start of the scene; that of the body where it stays."""
    law = body.inertia_over_time
    return body.inertia if law is None else np.diag(moments_at(law, 0.0))


def inertia_at(body: Body, time: float) -> Array | None:
    """
    Inertia about the centre of mass (3, 3) [kg m^2], body axes, at a time [s] since the start of
    the scene; None for a body without.
    """
    if body.inertia is None:
        return None
    if body.inertia_over_time is not None:
        return np.diag(moments_at(body.inertia_over_time, time))
    return body.inertia * (mass_at(body, time) / body.mass) if body.mass_flow else body.inertia


def moments_at(law: InertiaOverTime, time: float) -> Array:
    """Moments (3,) [kg m^2] at a time [s] since the start of the scene."""
    begin, end, share = _place(law, time)
    if law.interpolation == 'smooth':
        share = share * share * (3.0 - 2.0 * share)
    start, stop = np.array(begin[1:]), np.array(end[1:])
    return start + share * (stop - start)


def rates_at(law: InertiaOverTime, time: float, *, toward: float | None = None) -> Array:
    """
    Rates of the moments (3,) [kg m^2/s] from a time [s] on.

        toward : [s] of two rates that meet at a row, the one on the side of this instant
    """
    begin, end = _rows_about(law, time if toward is None else toward)
    if end[0] == begin[0]:
        return np.zeros(3)
    lasts = end[0] - begin[0]
    slope = (np.array(end[1:]) - np.array(begin[1:])) / lasts
    share = (time - begin[0]) / lasts
    return slope * (6.0 * share * (1.0 - share) if law.interpolation == 'smooth' else 1.0)


def _rows_about(law: InertiaOverTime, time: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Give the rows about a time, from a row on the next two; the same twice outside."""
    after = bisect_right(law.table, time, key=lambda row: row[0])
    if after in (0, len(law.table)):
        row = law.table[min(after, len(law.table) - 1)]
        return row, row
    return law.table[after - 1], law.table[after]


def _place(
    law: InertiaOverTime, time: float
) -> tuple[tuple[float, ...], tuple[float, ...], float]:
    """Give the rows about a time and its share of the way between them."""
    begin, end = _rows_about(law, time)
    if end[0] == begin[0]:
        return begin, end, 0.0
    return begin, end, (time - begin[0]) / (end[0] - begin[0])


def along(body: Body, times: Array) -> tuple[Array, Array] | None:
    """Moments and their rates, (n, 3) each, at times (n,) [s]; None where the inertia stays."""
    law = body.inertia_over_time
    if law is None:
        return None
    seconds = times.tolist()
    moments = np.array([moments_at(law, t) for t in seconds]).reshape(-1, 3)
    return moments, np.array([rates_at(law, t) for t in seconds]).reshape(-1, 3)


def changing(scene: Scene) -> list[Body]:
    """Give the bodies of a scene whose inertia changes over time."""
    return [body for body in scene.bodies if body.inertia_over_time is not None]
