# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Support points: the vertex of a polyhedron that lies farthest along a direction.

Each vertex is looked at, or, where neighbours are listed, the search climbs from one vertex to a
higher neighbour: on a convex polyhedron the vertex that has none is the highest of all.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    COUNT,
    NEAR,
    VERTEX,
    VERTICES,
    Hull,
)
from rigid_body_sim.physics.vectors import dot, load

Array = NDArray[np.float64]


class Vertices(NamedTuple):
    """
    A convex set of points.

    numbers    : the array in which they lie, three numbers each
    begin      : where they begin
    total      : how many there are
    neighbours : where their neighbours are listed, see `hull_records`; 0: look at each vertex
    """

    numbers: Array
    begin: int
    total: int
    neighbours: int


@inline
def vertices_of(hull: Hull) -> Any:
    """Return the vertices of a polyhedron."""
    numbers, begin = hull.numbers, hull.begin
    near = int(numbers[begin + NEAR])
    neighbours = begin + near if near > 0 else 0
    return Vertices(numbers, begin + VERTICES, int(numbers[begin + COUNT]), neighbours)


@inline
def support(vertices: Vertices, direction: Any, guess: int) -> Any:
    """Return the vertex that lies farthest along a direction; guess: where to begin to climb."""
    numbers, begin, neighbours = vertices.numbers, vertices.begin, vertices.neighbours
    if neighbours == 0:
        best = 0
        top = dot(direction, load(numbers, begin))
        for index in range(1, vertices.total):
            height = dot(direction, load(numbers, begin + VERTEX * index))
            if height > top:
                top = height
                best = index
        return best
    best = guess
    top = dot(direction, load(numbers, begin + VERTEX * best))
    for _ in range(vertices.total):  # each step is higher: no vertex is met twice
        here = best
        first, behind = int(numbers[neighbours + here]), int(numbers[neighbours + here + 1])
        for entry in range(first, behind):
            index = int(numbers[neighbours + entry])
            height = dot(direction, load(numbers, begin + VERTEX * index))
            if height > top:
                top = height
                best = index
        if best == here:
            break
    return best
