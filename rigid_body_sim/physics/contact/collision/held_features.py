# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a pair has held: the features of its points in the last tick, a row for each pair.

Faces of many corners touch in up to four of them (`geometry.manifold_reduction`); which, depends
on those of the last tick, so that they stay the same while a body trembles. The impulse cache
keeps them from tick to tick, so they are part of the state.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.collider import BOX, HULL, PLANE
from rigid_body_sim.physics.contact.collision.geometry import manifold

held = Record()
COUNT = held.number('-', 'points of the last tick; 0: the pair was not near')
FEATURES = held.numbers(manifold.MOST, '-', 'which parts of the shapes touched')
SIZE = held.size

# types of pairs of which some of many points are kept
KINDS = frozenset({(BOX, BOX), (BOX, HULL), (HULL, HULL), (HULL, PLANE)})


@inline
def _keeps(type_a: int, type_b: int) -> bool:
    """Tell whether a pair is of KINDS: others choose anew, whatever else a scene holds."""
    of_faces = (type_a == BOX or type_a == HULL) and (type_b == BOX or type_b == HULL)
    return of_faces or (type_a == HULL and type_b == PLANE)


@inline
def tell(index: int, type_a: int, type_b: int, rows: Array, found: Array) -> None:
    """Tell a pair kernel what the pair of an index has held; no rows: nothing is known."""
    known = len(rows) > 0 and _keeps(type_a, type_b)
    count = int(rows[index * SIZE + COUNT]) if known else 0
    found[manifold.HELD_COUNT] = float(count)
    for point in range(count):
        found[manifold.HELD + point] = rows[index * SIZE + FEATURES + point]
