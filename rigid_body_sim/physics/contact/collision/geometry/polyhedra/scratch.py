# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the kernels of two polyhedra keep in the scratch behind the manifold (`manifold`).

All of it is in the axes of A about its centre, unless it says otherwise. Kernels call the array
`work`: it is the `found` of the pair.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT
from rigid_body_sim.physics.contact.collision.geometry.manifold import SCRATCH as BEGIN
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import CLIP, size_of

simplex_corner = Record()
DIFFERENCE = simplex_corner.vector('m', 'w = b - a, a corner of the Minkowski difference')
OF_VERTEX_A = simplex_corner.number('-', 'vertex a of A')
OF_VERTEX_B = simplex_corner.number('-', 'vertex b of B')
WEIGHT = simplex_corner.number('-', 'of w in the point nearest to the origin')
SIMPLEX_CORNER = simplex_corner.size

corner = Record()
POSITION = corner.vector('m', 'corner of a polygon')
EDGE_NAME = corner.number('-', 'edge that begins there')
CORNER = corner.size

MOST_CORNERS = 2 * CLIP  # [-] of a clipped face: each side of the prism adds one
MOST_KNOWN = 8  # [-] known points: four of the simplex, four around the best face
CHUNK = 256  # [-] edges of B that are tried together

two_polyhedra = Record(begin=BEGIN)
OFFSET = two_polyhedra.vector('m', 't, centre of B')
ROTATION = two_polyhedra.matrix('-', 'Q, row by row: from the axes of B to those of A')
SIMPLEX = two_polyhedra.numbers(4 * SIMPLEX_CORNER, 'm', 'corners of the simplex of GJK')
NEAREST = two_polyhedra.vector('m', 'v, from the nearest point of A to that of B')
NEAREST_A = two_polyhedra.vector('m', 'nearest point of A')
NEAREST_B = two_polyhedra.vector('m', 'nearest point of B')
KNOWN = two_polyhedra.numbers(3 * MOST_KNOWN, 'm', 'known points w of the Minkowski difference')
KNOWN_IN_B = two_polyhedra.numbers(3 * MOST_KNOWN, 'm', 'the same, axes of B')
AXIS = two_polyhedra.vector('-', 'unit normal from A to B that is not of a face')
AXIS_A = two_polyhedra.vector('m', 'point of A that is nearest along it')
AXIS_B = two_polyhedra.vector('m', 'point of B that is nearest along it')
CORE_IN_B = two_polyhedra.numbers(2 * 3, 'm', 'ends of a core, its own axes')
CORE_START = two_polyhedra.vector('m', 'one end of a core')
CORE_END = two_polyhedra.vector('m', 'the other end')
EDGES_LEFT = two_polyhedra.numbers(CHUNK, '-', 'edges of B that are not dismissed')
POLYGON = two_polyhedra.numbers(MOST_CORNERS * CORNER, 'm', 'corners of the incident face')
CLIPPED = two_polyhedra.numbers(MOST_CORNERS * CORNER, 'm', 'the same, clipped by one more side')
CANDIDATES = two_polyhedra.numbers((MOST_CORNERS + 1) * POINT, 'm', 'points to choose from')
BOX = two_polyhedra.numbers(size_of(8, 6, 4, 12), 'm', 'record of a box: `hull_records`')
SIZE = two_polyhedra.size
