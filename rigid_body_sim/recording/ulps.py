# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Distance between doubles in units in the last place, from their bit patterns.

The 2^64 patterns are put in one line: -NaN ... -inf ... -0, +0 ... +inf ... NaN. Neighbours have
distance 1, so the distance is 0 exactly when the bits are equal: -0 and +0 differ by 1, two NaNs
by their payloads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_SIGN = np.uint64(1 << 63)


def ulp_distance(a: ArrayLike, b: ArrayLike) -> NDArray[np.uint64]:
    """
    Count the doubles between a and b, elementwise (shapes broadcast).

    A distance across the sign counts both sides; the largest possible one is 2^64 - 1.
    """
    place_a, place_b = _place(a), _place(b)
    return np.where(place_a > place_b, place_a - place_b, place_b - place_a)


def _place(values: ArrayLike) -> NDArray[np.uint64]:
    """Return the place of each bit pattern in the line; a bijection of uint64."""
    bits = np.asarray(values, dtype=np.float64).view(np.uint64)
    return np.where(bits & _SIGN != 0, ~bits, bits | _SIGN)
