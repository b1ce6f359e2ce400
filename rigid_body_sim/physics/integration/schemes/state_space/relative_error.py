# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The error of a substep relative to the tolerances of step size control:

    e = |err| / (atol + rtol max(|y|, |y_new|))        |.| the length of a vector

An error that is no number is the largest.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline


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
