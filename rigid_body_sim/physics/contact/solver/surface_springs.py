# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How a surface of several faces gives way that is not struck flat: evenly, where it is pressed
evenly.

Tiles share a face as they happen to lie, in halves and slivers. Were the springs at their points
alike, a sliver would hold up as much as a half, and a load that changes would tilt the body. So
each point has a spring as stiff as the part of all faces for which it stands (`face_spring`),

    m_i = M A u_i / sum A        M = 1/(1/m_A + 1/m_B), A: area of its face, u_i: its part of that

together as stiff as the one spring of a flat blow. And all have one load, and so one sink
(`static_sink`): the mean by area.

Lines, of what rolls over several tiles, give way as one line would: each is as stiff as its share
of the length (`softness`). Else a tile onto which a disc has just come would bear as much as the
one it leaves, and lift it there.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    face_spring,
    lane_scratch,
    static_sink,
)
from rigid_body_sim.physics.contact.solver.linear_pressure import carrier_of, size_of
from rigid_body_sim.physics.contact.solver.softness import DEEP, Softness, soften
from rigid_body_sim.physics.contact.solver.surface_members import has_line, owner_of

LEAST = 1e-3  # [-] share of a line in the softness of a surface
LEAST_PART = 1e-5  # [-] of the mean part of a point: without one it has no spring


@kernel
def give_way_as_one_line(
    count: int, members: Indices, width: int, softness: Softness, table: Indices, manifolds: Array,
    rows: Array, scratch: Array,
) -> None:  # fmt: skip
    """Share the softness of one line, and its sink, among those of a surface."""
    carrier = carrier_of(count, members, width, table, manifolds, rows)
    total, most, load_of_all = 0.0, 0.0, 0.0
    for place in range(count):
        if carrier >= 0 and place != carrier:
            continue
        size = size_of(members[place], True, manifolds)
        lane = int(manifolds[members[place] + manifold_record.LANE])
        total += size
        load_of_all += size * rows[lane + constraint.LOAD]
        most = max(most, manifolds[members[place] + manifold_record.POINT_COUNT])
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = size_of(record, True, manifolds)
        if not size > 0.0 or (carrier >= 0 and place != carrier):
            continue
        share = size / total * most / manifolds[record + manifold_record.POINT_COUNT]
        _, side = owner_of(record, table, manifolds)
        other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
        fixed = table[other * collider_record.SIZE + collider_record.BODY] < 0
        soften(lane, softness, fixed, max(share, LEAST), rows)
        radius = rows[lane + constraint.DEEP] / DEEP
        static_sink.recall(lane, softness.h, radius, load_of_all / total, rows)
        scratch[lane_scratch.SHARED] = 1.0


@kernel
def share_springs(
    count: int, members: Indices, width: int, h: float, table: Indices, manifolds: Array,
    rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Let the springs of a surface be as stiff as the parts of its faces for which their points
    stand, with one sink; not on a pivot, nor where one is a line, which has no area.

    h : [s] substep
    """
    first = int(manifolds[members[0] + manifold_record.LANE])
    mass = face_spring.mass_of(
        bodies[int(rows[first + constraint.BODY_A]) + solver_bodies.INVERSE_MASS]
        + bodies[int(rows[first + constraint.BODY_B]) + solver_bodies.INVERSE_MASS]
    )
    if not mass > 0.0 or has_line(count, members, manifolds):
        return
    carrier = carrier_of(count, members, width, table, manifolds, rows)
    area, load_of_all, points_of_all = 0.0, 0.0, 0.0
    for place in range(count):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        size = size_of(members[place], False, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        area += size
        load_of_all += size * rows[lane + constraint.LOAD]
        points_of_all += manifolds[members[place] + manifold_record.POINT_COUNT]
    if not area > 0.0:
        return
    for place in range(count):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        size = size_of(members[place], False, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        points = int(manifolds[members[place] + manifold_record.POINT_COUNT])
        rows[lane + constraint.MEAN_SPRING_MASS] = mass / points_of_all
        share = size / area * points_of_all / points
        for index in range(points):
            row = lane + constraint.SIZE + index * width
            own = rows[row + contact_point.SPRING_SHARE]
            rows[row + contact_point.SPRING_SHARE] = max(share * own, LEAST_PART)
        radius = rows[lane + constraint.DEEP] / DEEP
        static_sink.recall(lane, h, radius, load_of_all / area, rows)
