# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is kept of the last full detection of a pair, so that its manifold may follow the bodies: see
`recycling`.

Lengths and directions are in the axes of the shapes A and B, from their origins; those of a shape
that is TURNED in z, its axis, and x, the part of the normal across it.
"""

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST

point = Record()
ON_A = point.vector('m', 'place on A, axes of A')
ON_B = point.vector('m', 'place on B, axes of B')
SEPARATION = point.number('m', 'gap at the full detection')
FEATURE = point.number('-', 'see `geometry.manifold`')
POINT = point.size

recycled = Record()
NORMAL_OWNER = recycled.number('-', 'whose the normal is: see `geometry.manifold`')
TURNED = recycled.number('-', 'whose frame turns with the normal: see there')
POINT_COUNT = recycled.number('-', 'points, at most four')
MARGIN = recycled.number('m', 'speculative margin of the full detection')
ROTATION = recycled.matrix('-', 'Q = R_A^T R_B, row by row, at the full detection')
DIRECTION_A = recycled.vector('-', 'the normal, or the edge that spans it, axes of A')
DIRECTION_B = recycled.vector('-', 'the same of B, axes of B')
FACE_AREA = recycled.number('m^2', 'of the face that touches: see `geometry.manifold`')
FACE_RADIUS = recycled.number('m', 'mean distance of the face from its middle')
FACE_SQUARE = recycled.number('m^2', 'mean square of that distance')
MIDDLE_ON_A = recycled.vector('m', 'middle of the face, axes of A')
MIDDLE_ON_B = recycled.vector('m', 'the same, axes of B')
POINTS = recycled.numbers(MOST * POINT, 'm', 'its points, one after the other')
SIZE = recycled.size


@inline
def size_in_use(record: int, records: Array) -> int:
    """Count the numbers of a record that are in use."""
    return POINTS + POINT * int(records[record + POINT_COUNT])
