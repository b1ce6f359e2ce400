# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What samples of a motion must be for a spline through them to tell its derivatives.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.analysis.piecewise_spline import DEGREE
from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.model.numbers import array_of_numbers

Array = NDArray[np.float64]

FEWEST = DEGREE + 1  # samples
FARTHEST = 1e100  # [m] squares of what is farther are no numbers


def need_motion(time: Array, position: Array, *, unit: float = 1.0) -> None:
    """
    Refuse times (k,) that do not ascend and positions (k, 3) [m] that are no numbers.

    unit : [s] of the times
    """
    if len(time) < FEWEST:
        raise UserError(
            f'{len(time)} samples; a spline of degree {DEGREE} needs at least {FEWEST}'
        )
    if not (np.all(np.isfinite(time)) and np.all(np.isfinite(position))):
        raise UserError('times or positions hold NaN or infinity; every number must be finite')
    if np.max(np.abs(position)) > FARTHEST:
        raise UserError(f'positions up to {np.max(np.abs(position)):g} m; allowed: 1e100 m')
    need_ascending(time, unit=unit)


def need_ascending(time: NDArray[Any], *, unit: float = 1.0) -> None:
    """Refuse times (k,) [unit s] of which one is not later than the one before."""
    late = np.flatnonzero(time[1:] <= time[:-1])
    if late.size:
        before, at = (float(time[late[0] + k] * unit) for k in (0, 1))
        raise UserError(
            f'sample {late[0] + 1}, at {at:.15g} s, is not later than the one before, at '
            f'{before:.15g} s; times must ascend'
        )


def need_bandwidth(bandwidth: float | None) -> None:
    """Refuse a bandwidth [Hz] that is not positive."""
    if bandwidth is not None and not (np.isfinite(bandwidth) and bandwidth > 0.0):
        raise UserError(f'bandwidth {bandwidth:g} Hz; allowed: a positive number')


def vector_of(what: str, values: ArrayLike) -> Array:
    """Return three finite numbers; UserError for anything else."""
    found = array_of_numbers(values)
    if found is None or found.shape != (3,) or not np.all(np.isfinite(found)):
        raise UserError(f'{what} {values!r}; allowed: three finite numbers')
    return found
