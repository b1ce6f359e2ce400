# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A convex polyhedron as a row of numbers, for the kernels.

    0  COUNT       of vertices                  8..10  CENTER   (3,) [m]  shape axes
    1  FACES       their number                11      RADIUS   [m] of the vertices about the
    centre
    2  EDGES       their number                12      HALF     [m] half of the least width
    3  PLANES      where they begin            13      SIZE     [-] length of the record
    4  LOOPS       where they begin            14, 15  free
    5  EDGE_LIST   where they begin            16      VERTICES: x, y, z [m] from the centre, each
    6  NEAR        where they begin, or 0
    7  LOOP        [-] numbers of a loop

Where something begins is counted from the start of the record.
    planes    : 4 each       unit normal [-], distance from the centre [m]
    loops     : LOOP each    number of corners, then indices of vertices, counter-clockwise seen
                from outside; a face of more than CLIP corners keeps CLIP of them, evenly chosen:
                a patch a little smaller than the face
    edges     : 4 each       from vertex, to vertex, face on the left, face on the right
    near      : COUNT + 1 starts (from the start of NEAR), then indices of neighbours; only for
                more than SCAN vertices, whose farthest one is found by climbing
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import Polyhedron
from rigid_body_sim.physics.model.shapes import Box, ConvexHull, Cylinder, Mesh

Array = NDArray[np.float64]

COUNT, FACES, EDGES, PLANES, LOOPS, EDGE_LIST, NEAR, LOOP = range(8)
CENTER, RADIUS, HALF, SIZE, VERTICES = 8, 11, 12, 13, 16
PRISM = 2  # where the record of a cylinder begins, behind its radius and half length
CLIP = 16  # [-] most corners of a face in clipping; more cost time, fewer shrink the patch
SCAN = 64  # [-] most vertices that are looked at one by one; above, climbing is faster


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
    starts = np.cumsum([VERTICES, *(part.size for part in parts)])
    head = np.zeros(VERTICES)
    head[[COUNT, FACES, EDGES]] = len(solid.vertices), len(solid.loops), len(solid.edges)
    head[[PLANES, LOOPS, EDGE_LIST]] = starts[1:4]
    head[[NEAR, LOOP]] = starts[4] if near.size else 0.0, loops.shape[1]
    head[CENTER : CENTER + 3] = solid.center
    head[[RADIUS, HALF, SIZE]] = solid.radius, solid.half_width, starts[-1]
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
