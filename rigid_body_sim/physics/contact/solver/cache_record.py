# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulse cache: what contacts leave to the next tick, for its warm start.

One list in the order of the pairs: substep [s] and number of manifolds; then for each manifold its
pair id, its number of points, and for each point the fields here; then, for pairs whose manifolds
follow their bodies (`collision.recycling`), the record of that. Impulses are vectors of the world.
"""

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST

head = Record()
SUBSTEP = head.number('s', 'length of the substep whose impulses these are')
MANIFOLDS = head.number('-', 'how many follow')
HEAD = head.size

manifold = Record()
PAIR_ID = manifold.number('-', 'see `manifold_record`')
POINTS = manifold.number('-', 'how many follow')
LOAD = manifold.number('m/s^2', 'see `static_sink`')
MIDDLE = manifold.vector(
    'm', 'of what one or two points bore, from the origin of what moves: `surface_loads`'
)
NEXT_LOST = manifold.number(
    '-', 'of the next one that its body has lost: `impulse_cache.link_lost`'
)
RECYCLED = manifold.number('-', 'numbers behind the points: a `recycled_record`, or none')
MANIFOLD_HEAD = manifold.size

point = Record()
FEATURE = point.number('-', 'stays the same while the same parts touch')
NORMAL_IMPULSE = point.number('N s', 'of the last substep')
FRICTION_IMPULSE = point.vector('N s', 'of the last substep, world axes')
ANCHOR = point.vector('m', 'place of the point in the axes of shape A')
SINK_SHARE = point.number('-', 'its own static sink over that of its manifold: `static_sink`')
ANGULAR_IMPULSE = point.vector('N m s', 'rolling and twisting, of the last substep, world axes')
POINT_SIZE = point.size

MOST_OF_MANIFOLD = MANIFOLD_HEAD + MOST * POINT_SIZE  # numbers, but for the record behind


@inline
def behind_points(entry: int, cache: Array) -> int:
    """Where the points of a manifold end that begins at a place of a cache."""
    return entry + MANIFOLD_HEAD + int(cache[entry + POINTS]) * POINT_SIZE


@inline
def next_entry(entry: int, cache: Array) -> int:
    """Where the next manifold of a cache begins."""
    return behind_points(entry, cache) + int(cache[entry + RECYCLED])
