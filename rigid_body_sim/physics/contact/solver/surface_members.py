# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which manifolds are one surface: those of a body that moves with one other body, along one normal.
All that cannot move is one body, and all that is moved as one is one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    face_spring,
    impulse_cache,
    surface_chain,
)
from rigid_body_sim.physics.vectors import dot, load, scale

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

ALIKE = 1e-9  # [-] 1 - cos of an angle of 4e-5: normals of one surface
DONE = -2.0  # `manifold_record.STATE` of what belongs to a surface that was looked at
NONE = -1.0  # in place of a manifold


@inline
def owner_of(record: int, table: Indices, manifolds: Array) -> Any:
    """Body of a manifold that moves, and on which side it is (0: A)."""
    collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    shape = impulse_cache.moving_shape(collider_a, collider_b, table)
    body = table[shape * collider_record.SIZE + collider_record.BODY]
    return body, 0 if shape == collider_a else 1


@inline
def other_body_of(record: int, side: int, manifolds: Array, rows: Array) -> float:
    """
    Where the other body begins: all that cannot move is one, and all that is moved as one is one.
    """
    lane = int(manifolds[record + manifold_record.LANE])
    return rows[lane + (constraint.BODY_B if side == 0 else constraint.BODY_A)]


@inline
def is_line(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold has two points."""
    return manifolds[record + manifold_record.POINT_COUNT] == 2.0


@inline
def rolls_on_line(record: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a manifold is a line on which something round rolls."""
    lane = int(manifolds[record + manifold_record.LANE])
    is_round = rows[lane + constraint.ROUNDNESS] != constraint.NOT_ROUND
    return bool(is_round and is_line(record, manifolds))


@inline
def all_roll(count: int, members: Indices, manifolds: Array, rows: Array) -> bool:
    """Tell whether all manifolds of a surface are such lines."""
    roll = True
    for place in range(count):
        roll = roll and rolls_on_line(members[place], manifolds, rows)
    return roll


@inline
def all_lines(count: int, members: Indices, manifolds: Array) -> bool:
    """Tell whether all manifolds of a surface have two points."""
    lines = True
    for place in range(count):
        lines = lines and is_line(members[place], manifolds)
    return lines


@inline
def has_line(count: int, members: Indices, manifolds: Array) -> bool:
    """Tell whether some manifold of a surface has two points."""
    found = False
    for place in range(count):
        found = found or is_line(members[place], manifolds)
    return found


@inline
def has_one_spring(
    count: int, members: Indices, width: int, manifolds: Array, rows: Array, bodies: Array
) -> bool:  # fmt: skip
    """
    Tell whether a surface gives way as a whole (`face_spring`), as it lies alone or is struck
    flat: where one of its manifolds is a face; but not where all are lines, or points of which one
    may roll.
    """
    first = int(manifolds[members[0] + manifold_record.LANE])
    if not surface_chain.is_alone(count, first, rows) and not (
        is_new(count, members, width, manifolds, rows)
        and face_spring.meets_flat(first, rows, rows[constraint.SIZE :], bodies)
    ):
        return False
    face, rolls = False, False
    for place in range(count):
        points = manifolds[members[place] + manifold_record.POINT_COUNT]
        lane = int(manifolds[members[place] + manifold_record.LANE])
        face = face or points > 2.0
        rolls = rolls or rows[lane + constraint.ROUNDNESS] < constraint.NOT_ROUND
    return bool(face or not (rolls or all_lines(count, members, manifolds)))


@inline
def is_measured(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold has a face that was measured."""
    return (
        manifolds[record + manifold_record.POINT_COUNT] > 2.0
        and manifolds[record + manifold_record.FACE_AREA] > 0.0
    )


@inline
def has_lost_line(record: int, table: Indices, manifolds: Array, bodies: Array) -> bool:
    """Tell whether the body of a manifold has lost a line."""
    body, _ = owner_of(record, table, manifolds)
    return bool(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_LOST] >= cache_record.HEAD)


@kernel
def link_manifolds(
    lost: bool, order: Indices, table: Indices, manifolds: Array, rows: Array, bodies: Array
) -> Any:
    """
    Make the list of the manifolds of each body, but for those of balls: the first one, and behind
    each the next (`ghosts` had its own there). Tell whether there may be a surface of several, or
    statics leave something to choose.
    """
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        body, _ = owner_of(record, table, manifolds)
        bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD] = NONE
    found = False
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        if is_of_layers(record, manifolds, rows):
            continue
        body, _ = owner_of(record, table, manifolds)
        head = body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD
        first = bodies[head]
        found = found or first >= 0.0 or is_measured(record, manifolds)
        if lost and is_line(record, manifolds):
            found = found or has_lost_line(record, table, manifolds, bodies)
        manifolds[record + manifold_record.NEXT_OF_A] = first
        manifolds[record + manifold_record.STATE] = 0.0
        bodies[head] = float(record)
    return found


@inline
def is_of_layers(record: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a manifold is of a ball, or of layers about cores that meet at one point."""
    lane = int(manifolds[record + manifold_record.LANE])
    one_point = manifolds[record + manifold_record.POINT_COUNT] == 1.0
    return bool(one_point and rows[lane + constraint.ROUNDNESS] > constraint.NOT_ROUND)


@kernel
def list_surface(
    record: int, table: Indices, manifolds: Array, rows: Array, bodies: Array, members: Indices
) -> int:  # fmt: skip
    """
    List where the manifolds begin that are of one surface with one of them; return how many. None
    is of two, also where normals are alike one by one, and the first and the last are not.
    """
    body, side = owner_of(record, table, manifolds)
    other = other_body_of(record, side, manifolds, rows)
    normal = scale(1.0 - 2.0 * side, load(manifolds, record + manifold_record.NORMAL))
    count = 0
    place = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD])
    while place >= 0:
        _, its_side = owner_of(place, table, manifolds)
        its_normal = scale(1.0 - 2.0 * its_side, load(manifolds, place + manifold_record.NORMAL))
        if (
            manifolds[place + manifold_record.STATE] != DONE
            and other_body_of(place, its_side, manifolds, rows) == other
            and 1.0 - dot(normal, its_normal) < ALIKE
        ):
            members[count] = place
            manifolds[place + manifold_record.STATE] = DONE
            count += 1
        place = int(manifolds[place + manifold_record.NEXT_OF_A])
    return count


@inline
def keep_faces(count: int, members: Indices, manifolds: Array) -> int:
    """Leave in a list what has several points; return how many."""
    kept = 0
    for place in range(count):
        if manifolds[members[place] + manifold_record.POINT_COUNT] > 1.0:
            members[kept] = members[place]
            kept += 1
    return kept


@kernel
def are_of_several(count: int, members: Indices, table: Indices, manifolds: Array) -> bool:
    """
    Tell whether the faces on which a body lies are of several colliders: parts of a body that lie
    on one press as they may.
    """
    first = -1
    for place in range(count):
        _, side = owner_of(members[place], table, manifolds)
        other = int(manifolds[members[place] + manifold_record.COLLIDER_A + 1 - side])
        if first >= 0 and other != first:
            return True
        first = other
    return False


@kernel
def is_new(
    count: int, members: Indices, width: int, manifolds: Array, rows: Array
) -> bool:  # fmt: skip
    """Tell whether no point of a surface recalls an impulse."""
    for place in range(count):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        for index in range(int(manifolds[members[place] + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            if rows[row + contact_point.NORMAL_IMPULSE] > 0.0:
                return False
    return True
