# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Quotients with a limit at zero, which closed forms need where drag, flow or time is small.

    decay_once(x)  = (1 - e^-x)/x                 1 at 0
    decay_twice(x) = (e^-x - 1 + x)/x^2         1/2 at 0
    sine(x)        = sin x/x                      1 at 0
    tangent(x)     = tan x/x                      1 at 0
    logarithm(x)   = ln(1 + x)/x                  1 at 0
    burnt(x)       = 1 - (1 - x) ln(1/(1 - x))/x  0 at 0, sum of x^k/(k (k + 1))
    less_sine(x)   = x - sin x                    x^3/6 near 0

Written out they are differences of nearly equal numbers over a small one, and 0/0 at zero. Here
each is right to a few units of the last digit at every x, zero included.
Source: Taylor series; the first two are phi_1(-x) and phi_2(-x) of exponential integrators.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial

import numpy as np

from rigid_body_sim.exact.motion import Array

BY_SERIES = 1.0  # [-] below it the sums of powers are used: 1^20/22! is below round-off
BURNT_BY_SERIES = 0.25  # [-] likewise: 0.25^27/700 is
DECAY_TWICE = [(-1.0) ** k / factorial(k + 2) for k in range(20)]
LESS_SINE = [(-1.0) ** k / factorial(2 * k + 3) for k in range(10)]
BURNT = [0.0, *(1.0 / (k * (k + 1)) for k in range(1, 28))]


def decay_once(x: Array) -> Array:
    """Return (1 - e^-x)/x."""
    return _over(-np.expm1(-x), x, 1.0)


def decay_twice(x: Array) -> Array:
    """Return (e^-x - 1 + x)/x^2."""
    near = np.abs(x) < BY_SERIES
    far = np.where(near, BY_SERIES, x)
    direct = (1.0 + np.expm1(-far) / far) / far
    return np.where(near, _powers(DECAY_TWICE, np.where(near, x, 0.0)), direct)


def sine(x: Array) -> Array:
    """Return sin x/x."""
    return _over(np.sin(x), x, 1.0)


def tangent(x: Array) -> Array:
    """Return tan x/x."""
    return _over(np.tan(x), x, 1.0)


def logarithm(x: Array) -> Array:
    """Return ln(1 + x)/x."""
    return _over(np.log1p(x), x, 1.0)


def burnt(x: Array) -> Array:
    """Return 1 - (1 - x) ln(1/(1 - x))/x, for x < 1."""
    near = np.abs(x) < BURNT_BY_SERIES
    far = np.where(near, BURNT_BY_SERIES, x)
    direct = 1.0 + (1.0 - far) * np.log1p(-far) / far
    return np.where(near, _powers(BURNT, np.where(near, x, 0.0)), direct)


def less_sine(x: Array) -> Array:
    """Return x - sin x."""
    near = np.abs(x) < BY_SERIES
    small = np.where(near, x, 0.0)
    return np.where(near, small**3 * _powers(LESS_SINE, small**2), x - np.sin(x))


def _over(above: Array, x: Array, limit: float) -> Array:
    """Divide by x; the limit where x is zero."""
    return np.where(x == 0.0, limit, above / np.where(x == 0.0, 1.0, x))


def _powers(coefficients: Sequence[float], x: Array) -> Array:
    """Sum of coefficients times powers of x (Horner)."""
    value = np.zeros_like(x)
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
