# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A convex polyhedron as a record of numbers, for the kernels.

Behind the head stand five lists. Where one begins is counted from the start of the record.

    vertices : VERTEX each  x, y, z [m] from the centre
    planes   : PLANE each   one for each face, see `plane`
    loops    : LOOP each    one for each face: number of corners, then indices of vertices,
               counter-clockwise seen from outside; a face of more than CLIP corners keeps CLIP of
               them, evenly chosen: a patch a little smaller than the face
    edges    : EDGE each    see `edge`
    near     : COUNT + 1 starts (from the start of NEAR), then indices of neighbours; only for
               more than SCAN vertices, whose farthest one is found by climbing
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import Polyhedron
from rigid_body_sim.physics.model.shapes import Box, ConvexHull, Cylinder, Mesh
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]

hull = Record()
COUNT = hull.number('-', 'vertices')
FACES = hull.number('-', 'faces')
EDGES = hull.number('-', 'edges')
PLANES = hull.number('-', 'where the planes begin')
LOOPS = hull.number('-', 'where the loops begin')
EDGE_LIST = hull.number('-', 'where the edges begin')
NEAR = hull.number('-', 'where the neighbours begin, or 0')
LOOP = hull.number('-', 'numbers of a loop')
CENTER = hull.vector('m', 'centre, shape axes')
RADIUS = hull.number('m', 'of the vertices about the centre')
HALF = hull.number('m', 'half of the least width')
SIZE = hull.number('-', 'numbers of the record')
VERTICES = hull.padding(16)

plane = Record()
PLANE_NORMAL = plane.vector('-', 'unit normal out of the solid')
PLANE_OFFSET = plane.number('m', 'distance from the centre, along the normal')
PLANE = plane.size

edge = Record()
START = edge.number('-', 'vertex at which it starts')
END = edge.number('-', 'vertex at which it ends')
LEFT = edge.number('-', 'face on the left, seen from outside, going along')
RIGHT = edge.number('-', 'face on the right')
EDGE = edge.size

VERTEX = 3  # numbers of a vertex
PRISM = 2  # where the record of a cylinder begins, behind its radius and half length
CLIP = 16  # [-] most corners of a face in clipping; more cost time, fewer shrink the patch
SCAN = 64  # [-] most vertices that are looked at one by one; above, climbing is faster


class Hull(NamedTuple):
    """
    A record, for kernels.

    numbers : the array in which it lies
    begin   : where it begins
    """

    numbers: Array
    begin: int


@inline
def vertex(hull: Hull, index: int) -> Any:
    """Return a vertex, from the centre."""
    return load(hull.numbers, hull.begin + VERTICES + VERTEX * index)


@inline
def planes_of(hull: Hull) -> Any:
    """Return where the planes begin in the array."""
    return hull.begin + int(hull.numbers[hull.begin + PLANES])


@inline
def edges_of(hull: Hull) -> Any:
    """Return where the edges begin in the array."""
    return hull.begin + int(hull.numbers[hull.begin + EDGE_LIST])


@inline
def loop_of(hull: Hull, face: int) -> Any:
    """Return where the loop of a face begins in the array."""
    numbers, begin = hull.numbers, hull.begin
    return begin + int(numbers[begin + LOOPS]) + int(numbers[begin + LOOP]) * face


def size_of(vertices: int, faces: int, corners: int, edges: int) -> int:
    """Return the numbers of a record of few vertices; corners: of the face that has most."""
    return VERTICES + VERTEX * vertices + (PLANE + 1 + corners) * faces + EDGE * edges


def record(shape: ConvexHull | Mesh | Cylinder | Box) -> Array:
    """Return the record of a shape; InvalidModel when its points span no solid."""
    match shape:
        case ConvexHull(vertices=vertices):
            return packed(hulls.hull(vertices))
        case Mesh():
            return packed(hulls.hull_of_mesh(shape))
        case Cylinder(radius=radius, length=length):
            return packed(hulls.prism(radius, 0.5 * length))
        case Box(size=size):
            return packed(hulls.box(0.5 * np.array(size)))


def packed(solid: Polyhedron) -> Array:
    """Return the record of a polyhedron."""
    near = _near(solid) if len(solid.vertices) > SCAN else np.zeros(0)
    loops = _clip_loops(solid)
    parts = [solid.vertices, solid.planes, loops, solid.edges, near]
    ends = np.cumsum([VERTICES, *(part.size for part in parts)])
    _, planes_at, loops_at, edges_at, near_at, size = ends
    head = np.zeros(VERTICES)
    head[[COUNT, FACES, EDGES]] = len(solid.vertices), len(solid.loops), len(solid.edges)
    head[[PLANES, LOOPS, EDGE_LIST]] = planes_at, loops_at, edges_at
    head[[NEAR, LOOP]] = near_at if near.size else 0.0, loops.shape[1]
    head[hull.span(CENTER)] = solid.center
    head[[RADIUS, HALF, SIZE]] = solid.radius, solid.half_width, size
    return np.concatenate((head, *(np.asarray(part, dtype=float).ravel() for part in parts)))


def _clip_loops(solid: Polyhedron) -> Array:
    most = min(CLIP, max(len(loop) for loop in solid.loops))
    table = np.zeros((len(solid.loops), 1 + most))
    for row, loop in zip(table, solid.loops):
        kept = min(len(loop), CLIP)
        row[0] = kept
        row[1 : 1 + kept] = loop[np.arange(kept) * len(loop) // kept]
    return table


def _near(solid: Polyhedron) -> Array:
    lengths = [len(around) for around in solid.near]
    starts = len(lengths) + 1 + np.concatenate(([0], np.cumsum(lengths)))
    return np.concatenate((starts, *solid.near)).astype(float)
