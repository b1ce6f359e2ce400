# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What several faces carry together: the pressure of one surface.

A body that lies on four tiles presses on sixteen points, and statics determine three sums of what
they carry. Passes over the constraints leave the rest as it comes: a tile of which a sliver is
covered carries as much as one under half of the body. Friction feels it: a body that drills on
tiles is braked by where it presses. So where statics leave a choice, the impulses that are
recalled are chosen anew, with the same force and the same torque: those of a pressure that is
linear over all faces of one body on one other with one normal, and nowhere pulls,

    N_i = w_i max(alpha + beta . (r_i - c), 0)
    sum N_i and sum N_i r_i as recalled,   w_i = A u_i: `pressure_of_face`

A : [m^2] area of the face; a manifold of two points, which is a line, has none, but where all
    are lines: there A is the length [m]
c : mean of the points by w

What is one surface: see `surface_members`; alpha and beta: `linear_pressure`; how it gives way:
`surface_springs`. Where all are lines, of what rolls, force and torque are not those of the
impulses where they are recalled, but those of the last tick as the body has felt them: from tick
to tick the line goes over to other tiles by a good part of its length, its ends on each of them
have moved, and a tile may be left behind with all that it bore (`surface_loads`). What is put down
on a surface that cannot move starts from what pulls at its centre of mass.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    lane_scratch,
    pressure_of_face,
    surface_chain,
    surface_friction,
    surface_springs,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.linear_pressure import (
    carrier_of,
    find_pressure,
    share_of_all,
    size_of,
    takes_part,
)
from rigid_body_sim.physics.contact.solver.softness import Softness
from rigid_body_sim.physics.contact.solver.surface_loads import first_load, left_behind
from rigid_body_sim.physics.contact.solver.surface_members import (
    DONE,
    all_lines,
    all_roll,
    are_of_several,
    has_lost_line,
    has_one_spring,
    is_measured,
    is_new,
    is_of_layers,
    keep_faces,
    link_manifolds,
    list_surface,
    owner_of,
    rolls_on_line,
)
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

EXACT = 1e-9  # [-] of the torque that may be lost by the choice
OF_LINES = 0.1  # [-] the same of a line that turns meanwhile: what is lost is across it

# where impulses come from: they were found where their points are; they are recalled from the last
# tick; and some body has lost a line since
AS_FOUND, RECALLED, WITH_LOST = 0, 1, 2


@kernel
def _most(count: int, members: Indices, width: int, manifolds: Array, rows: Array) -> int:
    """Return where the manifold begins that carries most."""
    best, most = members[0], -1.0
    for place in range(count):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        press = 0.0
        for index in range(int(manifolds[members[place] + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            press += rows[row + contact_point.NORMAL_IMPULSE]
        if press > most:
            best, most = members[place], press
    return best


@kernel
def _press_as_one(
    count: int, members: Indices, width: int, h: float, recalls: int, colliders: ColliderArrays,
    constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """Choose the impulses of one surface; h: substep [s]."""
    table, scratch = colliders.table, constraints.scratch
    manifolds, rows = constraints.manifolds, constraints.rows
    if count > 1 and not are_of_several(count, members, table, manifolds):
        return
    lane = int(manifolds[members[0] + manifold_record.LANE])
    _, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    origin = load(manifolds, members[0] + manifold_record.POINTS)
    frame = origin, (tangent_1, tangent_2)
    carrier, first, exact = -1, (0.0, 0.0, 0.0), EXACT
    if count > 1:
        carrier = carrier_of(count, members, width, table, manifolds, rows)
        if is_new(count, members, width, manifolds, rows):
            first = first_load(members[0], h, frame, table, manifolds, bodies)
    if recalls != AS_FOUND and first[0] == 0.0 and all_roll(count, members, manifolds, rows):
        first = left_behind(
            count, members, width, h, recalls == WITH_LOST, frame, colliders, constraints, bodies
        )
        exact = OF_LINES
    pressure = find_pressure(count, members, carrier, width, frame, first, exact, manifolds, rows)
    if carrier >= 0 and not pressure[3]:
        carrier = -1
        pressure = find_pressure(
            count, members, carrier, width, frame, first, exact, manifolds, rows
        )
    if not pressure[3]:
        return
    alpha, beta_1, beta_2, _ = pressure
    lines = all_lines(count, members, manifolds)
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = size_of(record, lines, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        shares = pressure_of_face.weights(record, frame[1], manifolds)
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            if takes_part(row, rows):
                x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
                impulse = size * shares[index] * (alpha + beta_1 * x + beta_2 * y)
                rows[row + contact_point.NORMAL_IMPULSE] = max(impulse, 0.0)
    if count > 1:
        for place in range(count):
            lane = int(manifolds[members[place] + manifold_record.LANE])
            _, side = owner_of(members[place], table, manifolds)
            surface_friction.name_mover(lane, side, width, rows)
        surface_friction.join(
            count, members, _most(count, members, width, manifolds, rows),
            share_of_all(count, members, carrier, frame, manifolds), width, manifolds, rows,
            scratch,
        )  # fmt: skip


@inline
def _leaves_a_choice(record: int, width: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a face was measured, and carries something at more than one point."""
    if not is_measured(record, manifolds):
        return False
    lane = int(manifolds[record + manifold_record.LANE])
    taking_part, total = 0, 0.0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        row = lane + constraint.SIZE + index * width
        taking_part += 1 if takes_part(row, rows) else 0
        total += rows[row + contact_point.NORMAL_IMPULSE]
    return taking_part > 1 and total > 0.0


@kernel
def share_pressure(
    width: int, softness: Softness, recalls: int, colliders: ColliderArrays,
    constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """
    Choose the recalled impulses of all surfaces of a group that several faces are, and let them
    give way as one.

    width   : numbers of a point
    recalls : AS_FOUND, RECALLED or WITH_LOST
    """
    table = colliders.table
    manifolds, rows, order = constraints.manifolds, constraints.rows, constraints.order
    members, scratch = constraints.members, constraints.scratch
    scratch[lane_scratch.SHARED] = scratch[lane_scratch.SURFACES] = 0.0
    scratch[lane_scratch.WHOLE_SURFACES] = 0.0
    if not link_manifolds(recalls == WITH_LOST, order, table, manifolds, rows, bodies):
        return
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        if (
            is_of_layers(record, manifolds, rows)
            or manifolds[record + manifold_record.STATE] == DONE
        ):
            continue
        count = list_surface(record, table, manifolds, rows, bodies, members)
        one_spring = False
        if count > 1:
            one_spring = has_one_spring(count, members, width, manifolds, rows, bodies)
            surface_chain.chain(count, members, one_spring, softness.h, manifolds, rows, bodies)
        count = keep_faces(count, members, manifolds)
        if count > 1 and not one_spring:
            surface_springs.share_springs(
                count, members, width, softness.h, table, manifolds, rows, bodies
            )
        if count == 0:
            continue
        record = members[0]
        if (
            count > 1
            and all_lines(count, members, manifolds)
            and are_of_several(count, members, table, manifolds)
        ):
            surface_springs.give_way_as_one_line(
                count, members, width, softness, table, manifolds, rows, scratch
            )
        has_lost = recalls == WITH_LOST and rolls_on_line(record, manifolds, rows)
        has_lost = has_lost and has_lost_line(record, table, manifolds, bodies)
        if count > 1 or has_lost or _leaves_a_choice(record, width, manifolds, rows):
            _press_as_one(
                count, members, width, softness.h, recalls, colliders, constraints, bodies
            )
    surface_chain.link(order, manifolds, rows, scratch)
