# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A kernel that uses each kind of argument, and stops if told to: called as an image and as plain
Python, it must come to the same. See `images.Images.is_trusted`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from rigid_body_sim.physics.compile.image import KernelStopped, kinds_of, with_last

_PLACES = 5
_STOP = -1.0


def probe(n, begin, step, numbers, counts, more, fixed, flag, ratio):
    """Write into two arrays what only the right arguments come to."""
    if step < 0.0:
        raise ValueError
    for i in range(begin, n):
        numbers[i] = ratio * fixed[i] + step * i + more + len(numbers)
        counts[i] += i * more + len(counts) + 10 * len(fixed)
    part = numbers[begin:n]
    part[0] = 2.0 * len(part)
    if flag:
        counts[begin] = -more
    return numbers[n - 1] / 3.0


def probe_arguments(step: float = 0.7) -> tuple[Any, ...]:
    """Give arguments of a call: each length and number another."""
    numbers, counts = np.full(_PLACES + 3, 0.1), np.arange(_PLACES, dtype=np.int64)
    fixed = np.sqrt(np.arange(2.0, _PLACES + 8))
    fixed.flags.writeable = False
    return _PLACES, 1, step, numbers, counts, 11, fixed, True, 1.0 / 7.0


PROBED = kinds_of(probe_arguments()) or ()


def agrees(image: Callable[..., Any]) -> bool:
    """Tell whether an image of the probe comes to what its source does."""
    given, expected = probe_arguments(), probe_arguments()
    if image(*given) != probe(*expected) or image(*given[:-1]) is not NotImplemented:
        return False
    for i, one in enumerate(given):  # of another kind than was taken
        if image(*given[:i], str(one), *given[i + 1 :]) is not NotImplemented:
            return False
    for count in range(len(given)):
        for brief in (False, True):
            ready = with_last(image, given[count:], brief=brief)
            if ready(*given[:count]) != probe(*expected) or ready(*given) is not NotImplemented:
                return False
    if not all(np.array_equal(a, b) for a, b in zip(given, expected, strict=True)):
        return False
    try:
        image(*probe_arguments(_STOP))
    except KernelStopped:
        return True
    return False
