# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the kernels of ground keep in the scratch behind that of two polyhedra (`polyhedra.scratch`).

The narrow phase writes MOTION and REST before it asks; it reads the manifolds from RESULTS.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST, POINT
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import scratch
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import size_of

slot = Record()  # a facet under the body, and what the body would touch of its whole plane
SLOT_FACET = slot.number('-', 'number of the facet')
SLOT_COUNT = slot.number('-', 'points on the plane')
SLOT_OVER = slot.number('-', 'bit k: point k lies over the facet')
SLOT_FROM = slot.number(
    '-', 'of two points, the part of the way between them over the facet: begin'
)
SLOT_TO = slot.number('-', 'its end; no more than the begin: none')
SLOT_AREA = slot.number('m^2', 'of the face on the plane: `geometry.manifold`')
SLOT_RADIUS = slot.number('m', 'mean distance of that face from its middle')
SLOT_SQUARE = slot.number('m^2', 'mean square of that distance')
SLOT_MIDDLE = slot.vector('m', 'its middle')
SLOT_NORMAL = slot.vector('-', 'unit normal to the outside')
SLOT_POINTS = slot.numbers(MOST * POINT, 'm', 'the points: `geometry.manifold`')
SLOT = slot.size

result = Record()  # a manifold
KEY = result.number('-', 'facet, or FREE + triangle')
COUNT = result.number('-', 'points')
NORMAL = result.vector('-', 'unit normal from the body to the ground')
MOST_POINTS = 16  # [-] of a manifold before it is reduced
RESULT_POINTS = result.numbers(MOST_POINTS * POINT, 'm', 'the points: `geometry.manifold`')
RESULT = result.size

MOST_LISTED = 128  # [-] triangles that are listed at a time
MOST_SLOTS = 47  # [-] facets that are asked as planes; others are asked triangle by triangle
MOST_RESULTS = 16  # [-] manifolds of a body on one surface; of more, the deepest are kept

on_surface = Record(begin=scratch.SIZE)
MOTION = on_surface.vector('m', 'of the body in this tick')
QUERY_LOW = on_surface.vector('m', 'low corner of the box that is asked for')
QUERY_HIGH = on_surface.vector('m', 'high corner')
REST = on_surface.number('m', 'what counts as near at rest, a part of the margin')
NEAR = on_surface.number('m', 'separation that counts as near but for MOTION')
BY_FACES = on_surface.number('-', '1: triangles that are asked alone may be met along their faces')
HELD_ON_FACET = on_surface.number('-', 'points that were held on the facet `manifold.HELD_KEY`')
SLOTS_USED = on_surface.number('-', 'facets that have a slot: some point lies over them')
RESULTS_USED = on_surface.number('-', 'manifolds that were found')
OVERLAP = on_surface.number('m', 'the least overlap that no manifold holds, below 0; or -inf')
OVERLAP_KEY = on_surface.number('-', 'key of its manifold')
OVERLAP_NORMAL = on_surface.vector('-', 'its normal, from the body to the ground')
OVERLAP_POINT = on_surface.numbers(POINT, 'm', 'its point: `geometry.manifold`')
TRIANGLE_HULL = on_surface.numbers(size_of(3, 2, 3, 3), 'm', 'a triangle: `hull_records`')
LISTED = on_surface.numbers(MOST_LISTED, '-', 'where triangles near the body begin')
SLOTS = on_surface.numbers(MOST_SLOTS * SLOT, 'm', 'facets near the body')
RESULTS = on_surface.numbers(MOST_RESULTS * RESULT, 'm', 'manifolds')
SIZE = on_surface.size

FREE = float(1 << 22)  # [-] keys of manifolds that are of no facet begin here
KEYS = float(1 << 23)  # [-] keys of a pair: a share of the distance of two pair ids


@inline
def key_of_pair_id(pair_id: float) -> float:
    """Return the key of a manifold of ground among those of its pair, by its pair id."""
    return (pair_id - math.floor(pair_id)) * KEYS
