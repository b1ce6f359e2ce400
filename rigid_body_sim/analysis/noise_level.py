# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How much white noise samples carry, found from the samples alone.

    c_i = sum_j w_ij y_j,   w_ij ~ 1 / prod_k (t_j - t_k),   sum_j w_ij^2 = 1
        the divided difference of d + 1 neighbours, scaled: zero for a polynomial of degree d - 1,
        of the variance of the noise for white noise, whatever d

A smooth motion vanishes from c as d grows and the noise does not: the smallest mean square over d
is taken. Differences do not reach over breaks. A motion that the samples do not resolve counts as
noise, and so it should: nothing can be told of its derivatives. Where few differences are much
larger than most (jumps that are not known), these few are no noise: the median tells (`typical`),
and what they come from is told by what the spline cannot follow.

Samples written with few digits change in steps of one size. Their noise is that of rounding to
these, g / sqrt(12), however slow the motion (`quantum`).

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
LEVELS = 5  # different multiples of a step
STEPPING = 0.02  # [-] of the samples: fewer steps than this are a motion that starts and stops
OFF_STEP = 1e-6  # [step] of which samples may be beside multiples, by rounding
VANISHING = 30.0  # [-] by which differences of half the order are larger where motion is smooth
FEWEST = 4  # differences that make a mean
MEDIAN = 0.4549  # of the square of a normal number of variance one
NEAR_LOWEST = 1.3  # [-] of the mean square: lower orders average over more samples


def noise_level(
    time: Array, samples: Array, edges: Sequence[int], *, typical: bool = False
) -> Array:
    """
    Standard deviation of the noise of each column.

        time, samples : (n,), (n, d)
        edges         : first sample of each stretch without breaks, and n
        typical       : of most differences, whatever the others are: by their median
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
            squares = np.square(np.concatenate(parts))
            middle = np.median(squares, axis=0) / MEDIAN
            found.append(middle if typical else np.mean(squares, axis=0))
    if not found:
        return np.zeros(samples.shape[1])
    squares = np.array(found)
    near = squares <= NEAR_LOWEST * np.min(squares, axis=0)
    first = np.argmax(near, axis=0)
    return np.sqrt(squares[first, np.arange(samples.shape[1])])


def local_level(time: Array, samples: Array, edges: Sequence[int]) -> Array:
    """
    Noise about each sample (n,) of all columns together, as if what is there were noise.

    The largest difference that a sample is part of, of the order in which that is least. A jump or
    an outlier shows in it at its size. Zero where differences still vanish as the order grows: a
    smooth motion, beside a gap in the samples.
    """
    found = np.zeros(len(time))
    for begin, end in pairwise(edges):
        least, halfway = np.full(end - begin, np.inf), np.full(end - begin, np.inf)
        for order in range(2, min(HIGHEST, end - begin - 1) + 1):
            c = _differences(time[begin:end], samples[begin:end], order)
            square = np.pad(np.sum(np.square(c), axis=1), order)
            windows = np.lib.stride_tricks.sliding_window_view(square, order + 1)
            np.minimum(least, np.max(windows, axis=1), out=least)
            if order <= HIGHEST // 2:
                halfway = least.copy()
        stays = np.isfinite(least) & (halfway <= VANISHING**2 * least)
        found[begin:end] = np.where(stays, least, 0.0)
    return np.sqrt(found)


def quantum(samples: Array, level: Array) -> Array:
    """
    Step of which the samples of each column are multiples, (d,); zero where they are of none.

    level : (d,) noise by differences: a motion whose differences vanish has no steps
    """
    found = np.zeros(samples.shape[1])
    for i, column in enumerate(samples.T):
        levels = np.unique(column)
        if len(levels) < LEVELS:
            continue
        gaps = np.diff(levels)
        # what differs by rounding alone is one level
        gaps = gaps[gaps > 8.0 * np.finfo(float).eps * np.max(np.abs(levels))]
        step = float(np.min(gaps, initial=np.inf))
        if not np.isfinite(step) or level[i] < STEPPING * step:
            continue
        multiples = (column - column[0]) / step
        if np.max(np.abs(multiples - np.round(multiples))) > OFF_STEP:
            continue
        if np.mean(np.round(np.diff(multiples, 2)) != 0.0) > STEPPING:
            found[i] = step
    return found


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
