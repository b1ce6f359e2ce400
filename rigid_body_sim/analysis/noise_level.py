# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How much white noise samples carry, found from the samples alone.

    c_i = sum_j w_ij y_j,   w_ij ~ 1 / prod_k (t_j - t_k),   sum_j w_ij^2 = 1
        the divided difference of d + 1 neighbours, scaled: zero for a polynomial of degree d - 1,
        of the variance of the noise for white noise, whatever d

A smooth motion vanishes from c as d grows and the noise does not: the smallest mean square over d
is taken. Differences do not reach over breaks. A motion that the samples do not resolve counts as
noise, and so it should: nothing can be told of its derivatives.

Source: de Boor, A Practical Guide to Splines, chapter I; differences of high order as an estimate
of noise: Hall, Kay and Titterington, Biometrika 77 (1990) 521.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

HIGHEST = 12  # order of a difference: a motion of 0.4 rad per sample has left 1e-8 of itself
FEWEST = 4  # differences that make a mean
NEAR_LOWEST = 1.3  # [-] of the mean square: lower orders average over more samples


def noise_level(time: Array, samples: Array, edges: Sequence[int]) -> Array:
    """
    Standard deviation of the noise of each column.

        time, samples : (n,), (n, d)
        edges         : first sample of each stretch without breaks, and n
        returns       : (d,) in the unit of the samples
    """
    found = []
    for order in range(2, HIGHEST + 1):
        parts = [
            _differences(time[begin:end], samples[begin:end], order)
            for begin, end in pairwise(edges)
            if end - begin > order
        ]
        if parts and sum(map(len, parts)) >= FEWEST:
            found.append(np.mean(np.square(np.concatenate(parts)), axis=0))
    if not found:
        return np.zeros(samples.shape[1])
    squares = np.array(found)
    near = squares <= NEAR_LOWEST * np.min(squares, axis=0)
    first = np.argmax(near, axis=0)
    return np.sqrt(squares[first, np.arange(samples.shape[1])])


def _differences(time: Array, samples: Array, order: int) -> Array:
    """Scaled divided differences (n - order, d)."""
    count = len(time) - order
    t = np.lib.stride_tricks.sliding_window_view(time, order + 1)
    t = (t - t[:, :1]) / (t[:, -1:] - t[:, :1])
    gaps = t[:, :, None] - t[:, None, :]
    gaps[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
    weights = 1.0 / np.prod(gaps, axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    middle = samples[order // 2 : order // 2 + count]  # near values: their difference is exact
    found = np.zeros_like(middle)
    for j in range(order + 1):
        found += weights[:, j, None] * (samples[j : j + count] - middle)
    return found
