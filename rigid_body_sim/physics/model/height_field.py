# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A height field: ground whose height is given over the points of a grid.

    point (i, j) lies at  x = x0 + j dx,  y = y0 + i dy,  z = z0 + h_ij

Row i follows y and column j follows x, both upward. Each cell is cut into two triangles along its
shorter diagonal, the one whose ends differ less in height; their outside is up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel, blaming
from rigid_body_sim.physics.model.numbers import array_of_numbers, is_number, numbers, shown
from rigid_body_sim.physics.model.shapes import Surface

Array = NDArray[np.float64]


def height_field(
    heights: ArrayLike,
    *,
    spacing: Any,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    name: str = 'height field',
) -> Surface:
    """
    Return the surface of a height field.

    heights : (rows, columns) [m], at least 2 x 2
    spacing : [m] of the grid, one number or (dx, dy)
    origin  : (3,) [m] where the height 0 of point (0, 0) lies, shape coordinates
    """
    grid = _grid(heights)
    with blaming('spacing'):
        dx, dy = (spacing, spacing) if is_number(spacing) else numbers(spacing, 2, unit='m')
        if not (dx > 0.0 and dy > 0.0 and np.isfinite([dx, dy]).all()):
            raise InvalidModel(f'got {shown(spacing)} m; distances of points are positive')
    with blaming('origin'):
        start = np.array(numbers(origin, 3, unit='m'))
    rows, columns = grid.shape
    x, y = np.meshgrid(dx * np.arange(columns), dy * np.arange(rows))
    vertices = start + np.stack((x, y, grid), axis=-1).reshape(-1, 3)
    corner = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    a, b, c, d = corner, corner + 1, corner + columns + 1, corner + columns
    flat = grid.ravel()
    along_ac = (np.abs(flat[a] - flat[c]) <= np.abs(flat[b] - flat[d]))[:, None]
    first = np.where(along_ac, np.stack((a, b, c), axis=1), np.stack((a, b, d), axis=1))
    second = np.where(along_ac, np.stack((a, c, d), axis=1), np.stack((b, c, d), axis=1))
    return Surface(vertices, np.stack((first, second), axis=1).reshape(-1, 3), name)


def _grid(heights: ArrayLike) -> Array:
    """Check the heights."""
    with blaming('heights'):
        grid = array_of_numbers(heights)
        if grid is None:
            raise InvalidModel(
                f'got {shown(heights)}; a matrix of heights [m] is needed: rows of as many numbers'
            )
        if grid.ndim != 2 or min(grid.shape) < 2:
            raise InvalidModel(
                f'got the shape {grid.shape}; at least two rows of two heights [m] are needed'
            )
        if not np.all(np.isfinite(grid)):
            raise InvalidModel('hold NaN or infinity; every height must be finite [m]')
    return grid
