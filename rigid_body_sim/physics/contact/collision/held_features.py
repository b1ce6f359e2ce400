# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a pair has held: the features of its points in the last tick, and by which impulses they
pressed, a row for each pair.

Faces of many corners touch in up to four of them (`geometry.manifold_reduction`), and round ends
in four of their rim (`geometry.cylinders.rim`); which, depends on those of the last tick, so that
they stay the same while a body trembles. The impulse cache keeps them from tick to tick, so they
are part of the state.

Of ground of triangles a pair has a manifold for each facet; known is the one that bore most, and
whose it was: the body stands on that.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CYLINDER,
    HULL,
    PLANE,
    SURFACE,
)
from rigid_body_sim.physics.contact.collision.geometry import manifold

held = Record()
COUNT = held.number('-', 'points of the last tick; 0: the pair was not near')
FEATURES = held.numbers(manifold.MOST, '-', 'which parts of the shapes touched')
IMPULSES = held.numbers(manifold.MOST, 'N s', 'by which they pressed, of the last substep')
KEY = held.number('-', 'of several manifolds of a pair which one that is: `surface_scratch.KEY`')
SIZE = held.size

# types of pairs of which some of many points are kept
OF_FACES = {(BOX, BOX), (BOX, HULL), (HULL, HULL), (HULL, PLANE), (HULL, SURFACE)}
OF_RIMS = {
    (BOX, CYLINDER),
    (CYLINDER, CYLINDER),
    (CYLINDER, HULL),
    (CYLINDER, PLANE),
    (CYLINDER, SURFACE),
}
KINDS = frozenset(OF_FACES | OF_RIMS)


@inline
def _keeps(type_a: int, type_b: int) -> bool:
    """Tell whether a pair is of KINDS: others choose anew, whatever else a scene holds."""
    of_faces = (type_a == BOX or type_a == HULL) and (type_b == BOX or type_b == HULL)
    of_rims = type_a == CYLINDER and (type_b == HULL or type_b == CYLINDER)
    of_rims = of_rims or (type_a == BOX and type_b == CYLINDER)
    on_ground = type_b == PLANE or type_b == SURFACE
    return of_faces or of_rims or (on_ground and (type_a == HULL or type_a == CYLINDER))


@inline
def tell(index: int, type_a: int, type_b: int, rows: Array, found: Array) -> None:
    """Tell a pair kernel what the pair of an index has held; no rows: nothing is known."""
    known = len(rows) > 0 and _keeps(type_a, type_b)
    count = int(rows[index * SIZE + COUNT]) if known else 0
    found[manifold.HELD_COUNT] = float(count)
    if count > 0:
        found[manifold.HELD_KEY] = rows[index * SIZE + KEY]
    for point in range(count):
        found[manifold.HELD + point] = rows[index * SIZE + FEATURES + point]
        found[manifold.HELD_IMPULSES + point] = rows[index * SIZE + IMPULSES + point]
