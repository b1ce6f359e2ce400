# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Step size control of an embedded pair: the relative error of a substep, and how long the next one
shall be.

    error of a vector     e = |err| / (atol + rtol max(|y|, |y_new|))
    after acceptance      factor 0.9 e^(-1/8) e_before^(1/16), within [1/5, 5]
    after refusal         factor 0.9 e^(-1/4), at least 1/5

The controller is that of Gustafsson, see `adaptive`. An error that is no number is the largest.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline

SAFETY = 0.9  # [-] of the substep that would just be accepted; nearer to 1 more are refused
LEAST, LARGEST = 0.2, 5.0  # [-] change of the substep at once
SMALLEST_ERROR = 1e-10  # [-] a smaller one counts as this


@inline
def after_acceptance(error, before, refused):
    """Factor of the substep after one with this error: 0.9 e^(-1/8) e_before^(1/16)."""
    counted = max(error, SMALLEST_ERROR)
    factor = SAFETY * math.sqrt(math.sqrt(math.sqrt(math.sqrt(before) / counted)))
    factor = min(max(factor, LEAST), LARGEST)
    return min(factor, 1.0) if refused else factor


@inline
def after_refusal(error):
    """
    Factor of the substep after one refused with this error, which may be no number: 0.9 e^(-1/4).
    """
    if error < math.inf:
        return max(LEAST, SAFETY / math.sqrt(math.sqrt(error)))
    return LEAST


@inline
def _length(v):
    x, y, z = v
    return math.sqrt(x * x + y * y + z * z)


@inline
def relative_error(h, slope, before, after, tolerances):
    """Error h |K| of a vector relative to the tolerances (rtol, atol)."""
    rtol, atol = tolerances
    size = max(_length(before), _length(after))
    return h * _length(slope) / (atol + rtol * size)


@inline
def larger(error, other):
    """Give the larger error; one that is no number is larger."""
    return other if other > error or other != other else error
