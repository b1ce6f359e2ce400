# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the steps of a method take from an oscillation that no force damps.

    x'' = -omega^2 x:   a step multiplies the amplitude by |R(i h omega)|

        R : stability function of the method (its scheme's `stability_function`)

So the energy falls by 1 - |R|^2 a step, by 1 - |R|^(4 pi / (h omega)) a period. Kicks and drifts
(`dmv6` and the like) have none to give: within their limit both eigenvalues of a step lie on the
unit circle, and the energy swings and stays. A method that chooses its steps damps by what its
tolerances allow, and tells none either.

omega is that of `step_limits`: exact for one spring between centres, elsewhere up to sqrt 3 too
high.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.integration.integrator import Integrator

Array = NDArray[np.float64]

NOTICED = 1e-3  # [-] of the energy of a swing, a period; rk4 takes that at h omega = 0.41
BESIDE_DAMPERS = 0.1  # [-] of what dampers take: less changes no motion that they brake
SHORTEST = 1e-9  # [-] h omega


@dataclass(frozen=True)
class NumericalDamping:
    """
    An oscillation that a method damps.

    body       : that swings so
    rate       : [rad/s] omega
    product    : [rad] h omega
    per_period : [-] share of its energy that the steps take in a period
    per_second : [-] in a second
    unnoticed  : [rad] h omega at which they take NOTICED in a period
    cure       : what would take less
    """

    integrator: str
    rate: float
    product: float
    per_period: float
    per_second: float
    unnoticed: float
    body: str = ''
    cure: str = ''

    @property
    def text(self) -> str:
        """One line: method, body, product, what is lost, cure."""
        return (
            f'{self.integrator} damps: {self.body!r} may swing at {self.rate:.3g} rad/s, and '
            f'steps of h omega = {self.product:.3g} take {_percent(self.per_period)} of the '
            f'energy of such a swing in a period, {_percent(self.per_second)} in a second; '
            f'{self.cure}'
        )


def stability_function(integrator: Integrator) -> Callable[[complex], complex] | None:
    """Give R(z) of a method with fixed steps; None where it has none, see the module."""
    if integrator.controls_its_error:
        return None
    return getattr(integrator.scheme, 'stability_function', None)


def damps_no_spring(integrator: Integrator) -> bool:
    """Whether the energy of a linear spring stays, within the limit of the method."""
    return stability_function(integrator) is None and not integrator.is_reference


def lost_in_a_period(of: Callable[[complex], complex], product: float) -> float:
    """Give the share of the energy that steps of h omega take in a period; negative: a gain."""
    return -math.expm1(4.0 * math.pi / product * _log_growth(of, product))


def _log_growth(of: Callable[[complex], complex], product: float) -> float:
    """ln |R(i h omega)|; -40 where nothing is left."""
    return math.log(max(abs(of(1j * product)), 1e-17))


def worst_damping(
    integrator: Integrator, h: float, rates: Array, *, dampers: Array
) -> tuple[int, NumericalDamping] | None:
    """
    Find who is damped most, and how; None where nobody is worth a word.

    rates   : (n,) [rad/s] omega
    dampers : (n,) [1/s] at which the velocity of a body is braked
    """
    of = stability_function(integrator)
    if of is None:
        return None
    worst, found = 0.0, None
    for rate in np.unique(rates):
        product = h * float(rate)
        if not SHORTEST < product < math.inf:
            continue
        lost = lost_in_a_period(of, product)
        per_second = -2.0 * _log_growth(of, product) / h
        if not lost > max(NOTICED, worst):
            continue
        free = np.flatnonzero((rates == rate) & (per_second > BESIDE_DAMPERS * dampers))
        if len(free):
            worst = lost
            found = int(free[0]), float(rate), product, lost, -math.expm1(-per_second)
    if found is None:
        return None
    core, rate, product, lost, in_a_second = found
    return core, NumericalDamping(
        integrator=integrator.name,
        rate=rate,
        product=product,
        per_period=lost,
        per_second=in_a_second,
        unnoticed=_unnoticed(of, product),
    )


def _unnoticed(of: Callable[[complex], complex], product: float) -> float:
    """h omega below which a period takes less than NOTICED, by halving."""
    low, high = 0.0, product
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle > SHORTEST and lost_in_a_period(of, middle) > NOTICED:
            high = middle
        else:
            low = middle
    return max(low, SHORTEST)


def _percent(share: float) -> str:
    """Write a share of one; what rounds to all is `all but all`."""
    return f'{100.0 * share:.2g} %' if share < 0.995 else 'nearly all'
