# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A contact manifold as the narrow phase hands it to the solver: the pair, its normal, up to four
points.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST, POINT

manifold = Record()
PAIR_ID = manifold.number(
    '-',
    'key of the pair of colliders, and a share of 1 where it has several; they are in its order',
)
COLLIDER_A = manifold.number('-', 'number of collider A; type of A <= type of B')
COLLIDER_B = manifold.number('-', 'number of collider B')
POINT_COUNT = manifold.number('-', 'points, at most four')
NORMAL = manifold.vector('-', 'unit normal from A to B, world axes')
PIECES = manifold.number(
    '-', 'into so many its motion wants the tick cut, if the pair hits; COVERED: see there'
)
RECYCLED = manifold.number('-', 'where its record begins in those of `recycling`, or -1')
FACE_AREA = manifold.number('m^2', 'of the face that touches: see `geometry.manifold`')
FACE_RADIUS = manifold.number('m', 'mean distance of the face from its middle')
FACE_SQUARE = manifold.number('m^2', 'mean square of that distance')
FACE_MIDDLE = manifold.vector('m', 'middle of the face, world axes')
RIM = manifold.number('-', 'of which cylinder its points are the lowest: `geometry.manifold`')
POINTS = manifold.numbers(
    MOST * POINT, 'm', 'the points as the pair kernels give them: `geometry.manifold`'
)
# of its place in the list, not of the manifold:
LANE = manifold.number('-', 'where its lane begins in the rows of the solver')
STATE = manifold.number('-', 'what is known of it while ghosts are looked for: `ghosts`')
NEXT_OF_A = manifold.number('-', 'where the next manifold of the body of A begins, or -1')
NEXT_OF_B = manifold.number('-', 'the same of B')
SIZE = manifold.padding(40)  # five cache lines

# of a manifold that others cover, while impacts are looked for: in place of its pieces, and of all
# points but the first; `ghosts`
COVERED = 0.0
COVER_COUNT = POINTS + POINT
COVERS = COVER_COUNT + 1  # the pairs of those
MOST_COVERS = (MOST - 1) * POINT - 1
