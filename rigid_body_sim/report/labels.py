# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the names of curves go, so that none covers another or a mark.

Each name tries the places about the points of its own curve, fine end first, and takes the one
that covers least: other names count most, then the border, marks, and lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GAP = 7.0  # [pixel] between a mark and a name
SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1))
COVERED_NAME, BEYOND, COVERED_MARK, COVERED_LINE, LATER = 1000.0, 1000.0, 8.0, 3.0, 0.4


@dataclass(frozen=True)
class Label:
    """Centre of a name [pixel], and whether it covers nothing that must be seen."""

    x: float
    y: float
    is_free: bool


def place(
    curves: Sequence[Array],
    sizes: Sequence[tuple[float, float]],
    named: Sequence[int],
    bounds: tuple[float, float, float, float],
) -> list[Label]:
    """
    Place names, the most important first.

    curves  : (k, 2) [pixel] points of every curve, those without a name too
    sizes   : width and height of each name [pixel]
    named   : for each name, its curve
    bounds  : left, lower, right, upper [pixel] of the field
    returns : one place for each name
    """
    marks = np.concatenate([np.zeros((0, 2)), *curves])
    lines = np.concatenate([np.zeros((0, 2)), *(_along(curve) for curve in curves)])
    boxes: list[tuple[float, float, float, float]] = []
    placed = []
    for (width, height), index in zip(sizes, named, strict=True):
        best: tuple[float, float, float] | None = None
        for later, point in enumerate(curves[index][::-1]):
            for right, up in SIDES:
                x = point[0] + right * (0.5 * width + GAP)
                y = point[1] + up * (0.5 * height + GAP)
                box = (x - 0.5 * width, y - 0.5 * height, x + 0.5 * width, y + 0.5 * height)
                cost = LATER * later + _cost(box, boxes, marks, lines, bounds)
                if best is None or cost < best[0]:
                    best = (cost, x, y)
        assert best is not None, 'a curve without points has no name'
        cost, x, y = best
        boxes.append((x - 0.5 * width, y - 0.5 * height, x + 0.5 * width, y + 0.5 * height))
        placed.append(Label(x, y, cost < COVERED_NAME))
    return placed


def _along(curve: Array) -> Array:
    """Points every few pixels along a curve."""
    pieces = []
    for start, end in pairwise(curve):
        count = max(2, int(np.hypot(*(end - start)) / 6.0))
        pieces.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
    return np.concatenate([np.zeros((0, 2)), *pieces])


def _inside(points: Array, box: tuple[float, float, float, float]) -> int:
    left, lower, right, upper = box
    x, y = points[:, 0], points[:, 1]
    return int(np.count_nonzero((x > left) & (x < right) & (y > lower) & (y < upper)))


def _cost(
    box: tuple[float, float, float, float],
    boxes: Sequence[tuple[float, float, float, float]],
    marks: Array,
    lines: Array,
    bounds: tuple[float, float, float, float],
) -> float:
    left, lower, right, upper = box
    covered = sum(
        left < other[2] and other[0] < right and lower < other[3] and other[1] < upper
        for other in boxes
    )
    beyond = left < bounds[0] or lower < bounds[1] or right > bounds[2] or upper > bounds[3]
    return (
        COVERED_NAME * covered
        + BEYOND * beyond
        + COVERED_MARK * _inside(marks, box)
        + COVERED_LINE * _inside(lines, box)
    )
