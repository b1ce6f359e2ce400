# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Points and weights inside a shape: integral f dV = sum of w f(x), for a smooth f.

Tetrahedra from the middle of a hull or mesh to each triangle, signed like their volumes (a conical
product of n Gauss points along each of three directions, exact to degree 2 n - 1); a box, ball,
cylinder or capsule in its own coordinates, with the same degree: Gauss points along lengths and
radii, equal steps around.

On a mesh that is not convex the tetrahedra reach beyond the solid and cancel there: f has to be
smooth in its convex hull, not in the solid alone.

Source: Stroud, Approximate Calculation of Multiple Integrals (1971), chapter 2 (conical products)
and 7.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.plain_products import dot, product
from rigid_body_sim.physics.model.shapes import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Mesh,
    Shape,
    Sphere,
)
from rigid_body_sim.physics.model.volume_integrals import hull_faces, need_closed

Array = NDArray[np.float64]
Nodes = tuple[Array, Array]

MOST_AT_ONCE = 1 << 18  # points evaluated together: 10 MB of coordinates


def nodes(shape: Shape, n: int) -> Iterator[Nodes]:
    """
    Yield points (k, 3) [m] in shape coordinates and weights (k,) [m^3], part by part.

    n : points along each direction
    """
    match shape:
        case Box(size=(a, b, c)):
            x, wx = _line(n)
            grid = _grid(x, x, x)
            yield grid * np.array([a, b, c]), a * b * c * _grid_weight(wx, wx, wx)
        case Sphere(radius=r):
            yield _ball(r, n, -1.0, 1.0)
        case Cylinder(radius=r, length=h):
            yield _tube(r, h, n)
        case Capsule(radius=r, length=h):
            yield _tube(r, h, n)
            for low, high, shift in ((0.0, 1.0, 0.5 * h), (-1.0, 0.0, -0.5 * h)):
                points, weights = _ball(r, n, low, high)
                yield points + np.array([0.0, 0.0, shift]), weights
        case ConvexHull(vertices=vertices):
            yield from _fan(vertices, hull_faces(vertices), n)
        case Mesh(vertices=vertices, faces=faces, name=name):
            need_closed(faces, name=name)
            yield from _fan(vertices, faces, n)
        case _:
            raise InvalidModel(
                f'a {type(shape).__name__.lower()} has no volume for a density; give its mass'
            )


def count(shape: Shape, n: int) -> int:
    """Count the points that `nodes` yields: what an integral costs."""
    if isinstance(shape, Mesh):
        return len(shape.faces) * n**3
    if isinstance(shape, ConvexHull):
        return 2 * len(shape.vertices) * n**3  # a hull of v points has at most 2 v - 4 triangles
    return 6 * n**3


def _jacobi(n: int, alpha: int, beta: int) -> Nodes:
    """Gauss points on (0, 1) for the weight (1 - u)^alpha u^beta."""
    from scipy.special import roots_jacobi  # a tenth of a second that few scenes need

    x, w = roots_jacobi(n, alpha, beta)
    return 0.5 * (x + 1.0), w * 0.5 ** (alpha + beta + 1)


def _line(n: int) -> Nodes:
    """Gauss points on (-1/2, 1/2)."""
    x, w = _jacobi(n, 0, 0)
    return x - 0.5, w


def _around(n: int) -> Nodes:
    """Equal steps around a circle [rad]: exact to degree 2 n - 1."""
    return 2.0 * math.pi * np.arange(2 * n) / (2 * n), np.full(2 * n, math.pi / n)


def _grid(x: Array, y: Array, z: Array) -> Array:
    return np.stack(np.meshgrid(x, y, z, indexing='ij'), axis=-1).reshape(-1, 3)


def _grid_weight(x: Array, y: Array, z: Array) -> Array:
    return (x[:, None, None] * y[None, :, None] * z[None, None, :]).reshape(-1)


def _tube(radius: float, length: float, n: int) -> Nodes:
    """Cylinder about z: dV = r dr dphi dz."""
    (r, wr), (phi, wp), (z, wz) = _jacobi(n, 0, 1), _around(n), _line(n)
    grid = _grid(radius * r, phi, length * z)
    points = np.stack(
        (grid[:, 0] * np.cos(grid[:, 1]), grid[:, 0] * np.sin(grid[:, 1]), grid[:, 2]), axis=1
    )
    return points, radius**2 * length * _grid_weight(wr, wp, wz)


def _ball(radius: float, n: int, low: float, high: float) -> Nodes:
    """
    Ball, or the part of it with cos theta between low and high: dV = r^2 dr dphi d(cos theta).
    """
    (r, wr), (phi, wp), (u, wu) = _jacobi(n, 0, 2), _around(n), _jacobi(n, 0, 0)
    u, wu = low + (high - low) * u, (high - low) * wu
    grid = _grid(r, phi, u)
    across = grid[:, 0] * np.sqrt(1.0 - grid[:, 2] ** 2)
    points = np.stack(
        (across * np.cos(grid[:, 1]), across * np.sin(grid[:, 1]), grid[:, 0] * grid[:, 2]), axis=1
    )
    return radius * points, radius**3 * _grid_weight(wr, wp, wu)


def _fan(vertices: Array, faces: NDArray[np.int64], n: int) -> Iterator[Nodes]:
    """Tetrahedra from the mean of the vertices to each triangle (a, b, c)."""
    (u, wu), (v, wv), (w, ww) = _jacobi(n, 0, 2), _jacobi(n, 0, 1), _jacobi(n, 0, 0)
    grid, weights = _grid(u, v, w), _grid_weight(wu, wv, ww)
    # u from the middle to the triangle; in the triangle v from a to the side b c, w along that
    # side
    first = grid[:, 0] * (1.0 - grid[:, 1])
    third = grid[:, 0] * grid[:, 1] * grid[:, 2]
    shares = np.stack((first, grid[:, 0] - first - third, third), axis=1)
    middle = np.mean(vertices, axis=0)
    corners = (vertices - middle)[faces]
    six_volumes = dot(corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    if np.sum(six_volumes) < 0.0:  # all triangles face inwards
        six_volumes = -six_volumes
    step = max(1, MOST_AT_ONCE // len(weights))
    for begin in range(0, len(faces), step):
        part = slice(begin, begin + step)
        points = middle + product(shares, corners[part]).reshape(-1, 3)
        yield points, (six_volumes[part, None] * weights).reshape(-1)
