# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The mid phase: which triangles of a surface are near a body.

The tree is walked in its order without a stack: behind the last node of a branch comes the
neighbour of the nearest ancestor that is a left child. A list that is full is handed over, and the
walk goes on from where it stopped.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    ASKED,
    BEYOND,
    BORDER,
    CONCAVE,
    CORNERS,
    COUNT,
    EDGE_KIND,
    EVEN,
    HIGH,
    LEAF,
    LEAVES,
    LOW,
    NODE,
    NODES,
    TRIANGLE,
    TRIANGLES,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    LISTED,
    MOST_LISTED,
    QUERY_HIGH,
    QUERY_LOW,
)
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]

ROOT, END = 1, 0  # nodes with which a walk begins and ends


@inline
def _meets_node(parameters: Array, box: int, found: Array) -> bool:
    """Tell whether the AABB of a node overlaps the box that is asked for."""
    return (
        (parameters[box + LOW] <= found[QUERY_HIGH])
        & (parameters[box + HIGH] >= found[QUERY_LOW])
        & (parameters[box + LOW + 1] <= found[QUERY_HIGH + 1])
        & (parameters[box + HIGH + 1] >= found[QUERY_LOW + 1])
        & (parameters[box + LOW + 2] <= found[QUERY_HIGH + 2])
        & (parameters[box + HIGH + 2] >= found[QUERY_LOW + 2])
    )


@inline
def _meets_triangle(parameters: Array, row: int, found: Array) -> bool:
    """Tell whether the AABB of a triangle does."""
    meets = True
    for axis in range(3):
        a = parameters[row + CORNERS + axis]
        b = parameters[row + CORNERS + 3 + axis]
        c = parameters[row + CORNERS + 6 + axis]
        meets &= (min(a, b, c) <= found[QUERY_HIGH + axis]) & (
            max(a, b, c) >= found[QUERY_LOW + axis]
        )
    return meets


@kernel
def list_near(parameters: Array, surface: int, node: int, found: Array) -> tuple[int, int]:
    """
    List triangles that overlap the box that is asked for, from a node of the tree on.

    node : ROOT at first, then what the last call returned
    Returns how many are listed, and the node from which to go on, or END.
    """
    nodes = surface + int(parameters[surface + NODES])
    triangles = surface + int(parameters[surface + TRIANGLES])
    leaves = int(parameters[surface + LEAVES])
    count = int(parameters[surface + COUNT])
    listed = 0
    while node != END and listed <= MOST_LISTED - LEAF:
        meets = _meets_node(parameters, nodes + NODE * node, found)
        if meets and node < leaves:
            node *= 2
            continue
        if meets:
            first = LEAF * (node - leaves)
            for index in range(first, min(first + LEAF, count)):
                row = triangles + TRIANGLE * index
                if _meets_triangle(parameters, row, found):
                    found[LISTED + listed] = row
                    listed += 1
        while node & 1:
            node >>= 1
        if node != END:
            node += 1
    return listed, node


@inline
def corner_of(parameters: Array, row: int, index: int) -> Any:
    """Return a corner of a triangle, 0 to 2."""
    return load(parameters, row + CORNERS + 3 * index)


@inline
def triangle_reach(parameters: Array, surface: int, direction: Any) -> float:
    """Return how far the triangle that is asked reaches along a direction [m]; none: no bound."""
    row = int(parameters[surface + ASKED])
    if row == 0:
        return math.inf
    return max(
        dot(direction, corner_of(parameters, row, 0)),
        dot(direction, corner_of(parameters, row, 1)),
        dot(direction, corner_of(parameters, row, 2)),
    )


@kernel
def farthest_corner(parameters: Array, surface: int, direction: Any) -> Any:
    """Return the corner of the triangle that is asked which is farthest along a direction [m]."""
    row = int(parameters[surface + ASKED])
    best = corner_of(parameters, row, 0)
    for corner in range(1, 3):
        other = corner_of(parameters, row, corner)
        if dot(direction, other) > dot(direction, best):
            best = other
    return best


@inline
def edge_side(parameters: Array, row: int, edge: int, normal: Any) -> Any:
    """Return what points out of a triangle across an edge, in its plane, as long as the edge."""
    start = corner_of(parameters, row, edge)
    stop = corner_of(parameters, row, edge + 1 if edge < 2 else 0)
    return cross(subtract(stop, start), normal)


@inline
def _half_tangent(parameters: Array, row: int, edge: int, side: Any, normal: Any) -> float:
    """
    Return tan(phi/2) of the angle between a triangle and its neighbour behind a convex edge; of a
    border, that of a right angle.
    """
    if parameters[row + EDGE_KIND + edge] == BORDER:
        return 1.0
    way = subtract(load(parameters, row + BEYOND + 3 * edge), corner_of(parameters, row, edge))
    size = math.sqrt(dot(side, side))
    drop, out = -dot(normal, way), dot(side, way) / size
    return drop / (math.sqrt(drop * drop + out * out) + out) if drop > 0.0 else 0.0


@kernel
def lies_over(
    parameters: Array, row: int, normal: Any, point: Any, depth: float, seam: float, reach: float
) -> bool:
    """
    Tell whether a point lies over a triangle, or beyond a concave edge of it.

    normal : of the plane along which is looked
    depth  : [m] of the point below the plane: beside a convex edge it is of that face to which it
             is nearer, so that what has sunk into one is not pushed along the other
    seam   : [m] how far a point may lie beyond any edge: no crack between triangles
    reach  : [m] how far beyond a concave edge: there the plane goes on below the neighbour, so
             that it is a bound for what stands on that, and comes up to this face
    """
    for edge in range(3):
        side = edge_side(parameters, row, edge, normal)
        beyond = dot(side, subtract(point, corner_of(parameters, row, edge)))
        kind, free = parameters[row + EDGE_KIND + edge], seam
        if kind == CONCAVE:
            free = reach
        elif depth > 0.0 and kind != EVEN:
            free -= depth * _half_tangent(parameters, row, edge, side, normal)
        if beyond > free * math.sqrt(dot(side, side)):
            return False
    return True
