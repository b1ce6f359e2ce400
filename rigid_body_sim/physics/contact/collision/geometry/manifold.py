# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a pair kernel finds: the contact manifold, one normal and up to four points.

    collide(parameters, a, b, poses, pose_a, pose_b, margin, found) -> count
        parameters, poses : see `collider`
        a, b              : where the parameters of the shapes begin; type of A <= type of B
        pose_a, pose_b    : where their poses begin in `poses`
        margin            : [m]  largest separation of a point that is reported
        found             : FOUND numbers: the manifold (NORMAL, POINTS) is written; SHIFT, TURN
                            and HELD are read
        count             : int  points, at most MOST; 0: farther apart than the margin

The array `found` is a manifold and, behind it, room of the pair kernel's own. That scratch begins
at SCRATCH; whoever uses it declares its fields as `Record(begin=SCRATCH)`: `boxes.two_boxes`,
`cylinders.on_face`, `polyhedra.scratch`, `surfaces.surface_scratch` and pairs. Only one pair is
under way at a time, and nothing in it outlives the call.

A feature is a number that stays the same from tick to tick while the same parts touch.

Lengths are squared here. Nearer than SHORTEST two parts count as coincident, because the square
has lost digits there; two shapes larger than 1e154 m never meet, because it overflows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.vectors import store

Array = NDArray[np.float64]

point = Record()
POSITION = point.vector('m', 'midway between the surfaces, world axes')
SEPARATION = point.number('m', 'gap of the surfaces there; negative: penetration')
FEATURE = point.number('-', 'which parts of the shapes touch')
POINT = point.size

MOST = 4  # [-] points of a manifold

manifold = Record()
NORMAL = manifold.vector('-', 'unit normal from A to B, world axes')
POINTS = manifold.numbers(MOST * POINT, 'm', 'its points, one after the other')
FACE_AREA = manifold.number(
    'm^2', 'of the face that touches (`touching_face`); 0: the points are its corners'
)
FACE_RADIUS = manifold.number('m', 'mean distance of the face from its middle')
FACE_SQUARE = manifold.number('m^2', 'mean square of that distance')
FACE_MIDDLE = manifold.vector('m', 'middle of the face, world axes')
NORMAL_OWNER = manifold.number('-', 'whose the normal is: NOBODYS ... OF_EDGES')
TURNED = manifold.number(
    '-', 'which of the two does not feel its spin about its axis z: NEITHER ...'
)
EDGE_A = manifold.vector('m', 'where it is OF_EDGES: along the edge of A, axes of A')
EDGE_B = manifold.vector('m', 'along the edge of B, axes of A; n is along EDGE_A x EDGE_B')
RIM = manifold.number(
    '-', 'which of the two is a cylinder over a flat side, its points the lowest of its rims'
)
SHIFT = manifold.vector('m', 'asked with: how far a hull moves in the tick beside what is fixed')
TURN = manifold.vector('rad', 'asked with: how far it turns, world axes; zeros: nothing is known')
HELD_COUNT = manifold.number('-', 'asked with: how many points the pair had in the last tick')
HELD = manifold.numbers(MOST, '-', 'asked with: their features')
HELD_IMPULSES = manifold.numbers(MOST, 'N s', 'asked with: by which they pressed')
HELD_KEY = manifold.number('-', 'asked with: on which facet of ground of triangles that was')
SCRATCH = manifold.size  # where a kernel may keep what it likes
FOUND = 4096  # numbers in `found`: the largest scratch is that of ground (`surfaces`)
# whose the normal is: what it stays fixed to while the bodies move by little
NOBODYS = 0.0  # nothing is known of it
FACE_OF_A, FACE_OF_B = 1.0, 2.0  # that of a face
OF_EDGES = 3.0  # across an edge of each
OF_NEAREST = 4.0  # along the way between two nearest points
OF_MANTLE = 5.0  # of a cylinder, where the rim of another meets it
NEITHER, SHAPE_A, SHAPE_B, BOTH = 0.0, 1.0, 2.0, 3.0
SHORTEST = 1e-140  # [m] of a shorter way the direction is no direction
TINY = SHORTEST * SHORTEST  # [m^2] a component of 1e-13 of it still has a square with all digits
# Of points as good as another up to these shares the first counts: without them a resting body
# changes its points, and loses their impulses, with every tremble.
TIE = 1e-5  # [-] of the extent: depths
LEAD = 1e-3  # [-] distances squared and areas
# A normal is that of a side of A, unless a side of B, or an edge, separates by so much more.
FACE_LEAD = 1e-4  # [-] of the smallest half width; 0: stacked boxes change their reference side
EDGE_LEAD = 1e-3  # [-] of the same; 0: sides that touch get one point for four, capsules for two
EDGE_SHARE = 0.05  # [-] of the distance of the sides, or of their overlap, beside EDGE_LEAD


@inline
def write_normal(found: Array, normal: Any) -> None:
    """Write the unit normal of the manifold, from A to B, world axes."""
    store(found, NORMAL, normal)


@inline
def write_point(
    found: Array, index: int, position: Any, separation: float, feature: float
) -> None:
    """Write one of the points of the manifold, 0 to 3."""
    write_point_at(found, POINTS + index * POINT, position, separation, feature)


@inline
def write_point_at(
    found: Array, at: int, position: Any, separation: float, feature: float
) -> None:
    """Write a point that begins at a place of `found`, also in the scratch."""
    store(found, at, position)
    found[at + SEPARATION] = separation
    found[at + FEATURE] = feature


@inline
def copy_point(found: Array, to: int, source: int) -> None:
    """Copy the point that begins at a place of `found` to another place."""
    for number in range(POINT):
        found[to + number] = found[source + number]
