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
And where all are lines, of what rolls, they give way as one line would: each is as stiff as its
share of the length, and all have one sink (`softness`, `static_sink`). Else a tile onto which a
disc has just come would bear as much as the one it leaves, and lift it there. And force and torque
are not those of the impulses where they are recalled, but those of the last tick as the body has
felt them: from tick to tick the line goes over to other tiles by a good part of its length, its
ends on each of them have moved, and a tile may be left behind with all that it bore.

What is put down on a surface that cannot move starts from what pulls at its centre of mass.

What cannot move is one body. A plane carries the whole face of a body, also beside a box that is
flush with it: it has all the weight. A point takes part that was pressed, or touches.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record, pose
from rigid_body_sim.physics.contact.collision.collider import PLANE, ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    constraint,
    contact_point,
    face_spring,
    impulse_cache,
    lane_scratch,
    patch_friction,
    pressure_of_face,
    static_sink,
    surface_chain,
    surface_friction,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.softness import DEEP, Softness, soften
from rigid_body_sim.physics.vectors import add, cross, dot, load, scale, subtract

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOUCHES = 3e-7  # [m] apart: so far what rests may tremble
ALIKE = 1e-9  # [-] 1 - cos of an angle of 4e-5: normals of one surface
ROUNDS = 8  # [-] in which points that would pull are left out, at most
THIN = 1e-9  # [-] of the second moment: points are as good as in a line
EXACT = 1e-9  # [-] of the torque that may be lost by the choice
FLUSH_DISTANCE = 1e-5  # [m] from a surface: what a body has lost there was a part of it
OF_LINES = 0.1  # [-] the same of a line that turns meanwhile: what is lost is across it
LEAST = 1e-3  # [-] share of a face in the softness of a surface
DONE = -2.0  # `manifold_record.STATE` of what belongs to a surface that was looked at
NONE = -1.0  # in place of a manifold

# where impulses come from: they were found where their points are; they are recalled from the last
# tick; and some body has lost a line since
AS_FOUND, RECALLED, WITH_LOST = 0, 1, 2


@inline
def _owner(record: int, table: Indices, manifolds: Array) -> Any:
    """Body of a manifold that moves, and on which side it is (0: A)."""
    collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    shape = impulse_cache.moving_shape(collider_a, collider_b, table)
    body = table[shape * collider_record.SIZE + collider_record.BODY]
    return body, 0 if shape == collider_a else 1


@inline
def _other(record: int, side: int, manifolds: Array, rows: Array) -> float:
    """
    Where the other body begins: all that cannot move is one, and all that is moved as one is one.
    """
    lane = int(manifolds[record + manifold_record.LANE])
    return rows[lane + (constraint.BODY_B if side == 0 else constraint.BODY_A)]


@inline
def _is_line(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold has two points."""
    return manifolds[record + manifold_record.POINT_COUNT] == 2.0


@inline
def _rolls(record: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a manifold is a line on which something round rolls."""
    lane = int(manifolds[record + manifold_record.LANE])
    is_round = rows[lane + constraint.ROUNDNESS] != constraint.NOT_ROUND
    return bool(is_round and _is_line(record, manifolds))


@inline
def _all_roll(count: int, members: Indices, manifolds: Array, rows: Array) -> bool:
    """Tell whether all manifolds of a surface are such lines."""
    roll = True
    for place in range(count):
        roll = roll and _rolls(members[place], manifolds, rows)
    return roll


@inline
def _all_lines(count: int, members: Indices, manifolds: Array) -> bool:
    """Tell whether all manifolds of a surface have two points."""
    lines = True
    for place in range(count):
        lines = lines and _is_line(members[place], manifolds)
    return lines


@inline
def _has_one_spring(
    count: int, members: Indices, width: int, manifolds: Array, rows: Array, bodies: Array
) -> bool:  # fmt: skip
    """
    Tell whether a surface gives way as a whole (`face_spring`), as it lies alone or is struck
    flat: where one of its manifolds is a face; but not where all are lines, or points of which one
    may roll.
    """
    first = int(manifolds[members[0] + manifold_record.LANE])
    if not surface_chain.is_alone(count, first, rows) and not (
        _is_new(count, members, width, manifolds, rows)
        and face_spring.meets_flat(first, rows, rows[constraint.SIZE :], bodies)
    ):
        return False
    face, rolls = False, False
    for place in range(count):
        points = manifolds[members[place] + manifold_record.POINT_COUNT]
        lane = int(manifolds[members[place] + manifold_record.LANE])
        face = face or points > 2.0
        rolls = rolls or rows[lane + constraint.ROUNDNESS] < constraint.NOT_ROUND
    return bool(face or not (rolls or _all_lines(count, members, manifolds)))


@inline
def _is_measured(record: int, manifolds: Array) -> bool:
    """Tell whether a manifold has a face that was measured."""
    return (
        manifolds[record + manifold_record.POINT_COUNT] > 2.0
        and manifolds[record + manifold_record.FACE_AREA] > 0.0
    )


@inline
def _has_lost(record: int, table: Indices, manifolds: Array, bodies: Array) -> bool:
    """Tell whether the body of a manifold has lost a line."""
    body, _ = _owner(record, table, manifolds)
    return bool(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_LOST] >= cache_record.HEAD)


@kernel
def _link(
    lost: bool, order: Indices, table: Indices, manifolds: Array, rows: Array, bodies: Array
) -> Any:
    """
    Make the list of the manifolds of each body, but for those of balls: the first one, and behind
    each the next (`ghosts` had its own there). Tell whether there may be a surface of several, or
    statics leave something to choose.
    """
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        body, _ = _owner(record, table, manifolds)
        bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD] = NONE
    found = False
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        if _is_round(record, manifolds, rows):
            continue
        body, _ = _owner(record, table, manifolds)
        head = body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD
        first = bodies[head]
        found = found or first >= 0.0 or _is_measured(record, manifolds)
        if lost and _is_line(record, manifolds):
            found = found or _has_lost(record, table, manifolds, bodies)
        manifolds[record + manifold_record.NEXT_OF_A] = first
        manifolds[record + manifold_record.STATE] = 0.0
        bodies[head] = float(record)
    return found


@inline
def _is_round(record: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a manifold is of a ball, or of layers about cores that meet at one point."""
    lane = int(manifolds[record + manifold_record.LANE])
    one_point = manifolds[record + manifold_record.POINT_COUNT] == 1.0
    return bool(one_point and rows[lane + constraint.ROUNDNESS] > constraint.NOT_ROUND)


@kernel
def _list_surface(
    record: int, table: Indices, manifolds: Array, rows: Array, bodies: Array, members: Indices
) -> int:  # fmt: skip
    """
    List where the manifolds begin that are of one surface with one of them; return how many. None
    is of two, also where normals are alike one by one, and the first and the last are not.
    """
    body, side = _owner(record, table, manifolds)
    other = _other(record, side, manifolds, rows)
    normal = scale(1.0 - 2.0 * side, load(manifolds, record + manifold_record.NORMAL))
    count = 0
    place = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD])
    while place >= 0:
        _, its_side = _owner(place, table, manifolds)
        its_normal = scale(1.0 - 2.0 * its_side, load(manifolds, place + manifold_record.NORMAL))
        if (
            manifolds[place + manifold_record.STATE] != DONE
            and _other(place, its_side, manifolds, rows) == other
            and 1.0 - dot(normal, its_normal) < ALIKE
        ):
            members[count] = place
            manifolds[place + manifold_record.STATE] = DONE
            count += 1
        place = int(manifolds[place + manifold_record.NEXT_OF_A])
    return count


@inline
def _keep_faces(count: int, members: Indices, manifolds: Array) -> int:
    """Leave in a list what has several points; return how many."""
    kept = 0
    for place in range(count):
        if manifolds[members[place] + manifold_record.POINT_COUNT] > 1.0:
            members[kept] = members[place]
            kept += 1
    return kept


@kernel
def _size_of(record: int, lines: bool, manifolds: Array) -> float:
    """
    Return the area of the face of a manifold [m^2]; a line has none.

        lines : where all are lines: the length of each [m]
    """
    normal = load(manifolds, record + manifold_record.NORMAL)
    if _is_measured(record, manifolds):
        return manifolds[record + manifold_record.FACE_AREA]
    points = record + manifold_record.POINTS
    origin = load(manifolds, points)
    first = subtract(load(manifolds, points + manifold.POINT), origin)
    if _is_line(record, manifolds):
        return math.sqrt(dot(first, first)) if lines else 0.0
    count = int(manifolds[record + manifold_record.POINT_COUNT])
    second = subtract(load(manifolds, points + 2 * manifold.POINT), origin)
    if count == 3:
        return 0.5 * abs(dot(normal, cross(first, second)))
    # of four corners in any order, the diagonals are those that span most
    third = subtract(load(manifolds, points + 3 * manifold.POINT), origin)
    twice = abs(dot(normal, cross(first, subtract(third, second))))
    twice = max(twice, abs(dot(normal, cross(second, subtract(third, first)))))
    return 0.5 * max(twice, abs(dot(normal, cross(third, subtract(second, first)))))


@inline
def _takes_part(row: int, rows: Array) -> bool:
    """Tell whether a point was pressed, or touches."""
    return (
        rows[row + contact_point.NORMAL_IMPULSE] > 0.0
        or rows[row + contact_point.INITIAL_SEPARATION] <= TOUCHES
    )


@kernel
def _carrier(
    count: int, members: Indices, width: int, table: Indices, manifolds: Array, rows: Array
) -> int:  # fmt: skip
    """Return the place in the list of a plane on which a face lies, or -1."""
    for place in range(count):
        record = members[place]
        collider = int(manifolds[record + manifold_record.COLLIDER_B])
        if table[collider * collider_record.SIZE + collider_record.TYPE] != PLANE:
            continue
        lane = int(manifolds[record + manifold_record.LANE])
        points, taking_part = int(manifolds[record + manifold_record.POINT_COUNT]), 0
        for index in range(points):
            row = lane + constraint.SIZE + index * width
            taking_part += 1 if _takes_part(row, rows) else 0
        if taking_part > 2 or taking_part == points:
            return place
    return -1


@kernel
def _sum_up(
    count: int, members: Indices, carrier: int, width: int, frame: Any, pressure: Any,
    manifolds: Array, rows: Array,
) -> Any:  # fmt: skip
    """
    Sum up over the points of a surface: impulses and their moments; of those on which a pressure
    (alpha, beta) presses, weights and their moments; and how many it would change.

        pressure : with a third number, whether to look at it: else it presses on all
    """
    lines = _all_lines(count, members, manifolds)
    alpha, beta_1, beta_2, known = pressure
    total, total_1, total_2 = 0.0, 0.0, 0.0
    w, w_1, w_2, w_11, w_12, w_22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = _size_of(record, lines, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        shares = pressure_of_face.weights(record, frame[1], manifolds)
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            if not _takes_part(row, rows):
                continue
            x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
            weight = size * shares[index]
            impulse = rows[row + contact_point.NORMAL_IMPULSE]
            total += impulse
            total_1 += impulse * x
            total_2 += impulse * y
            if known and not alpha + beta_1 * x + beta_2 * y > 0.0:
                continue
            w += weight
            w_1 += weight * x
            w_2 += weight * y
            w_11 += weight * x * x
            w_12 += weight * x * y
            w_22 += weight * y * y
    return total, total_1, total_2, w, w_1, w_2, w_11, w_12, w_22


@inline
def _pressure(sums: Any, exact: float) -> Any:
    """
    Return alpha and beta of sums, and whether there are such.

    exact : [-] of the torque that may be lost
    """
    total, total_1, total_2, w, w_1, w_2, w_11, w_12, w_22 = sums
    if not (w > 0.0 and total > 0.0):
        return 0.0, 0.0, 0.0, False
    c_1, c_2 = w_1 / w, w_2 / w
    s_11, s_12, s_22 = w_11 - w_1 * c_1, w_12 - w_1 * c_2, w_22 - w_2 * c_2
    m_1, m_2 = total_1 - total * c_1, total_2 - total * c_2
    trace = s_11 + s_22
    if not trace > 0.0:
        return 0.0, 0.0, 0.0, False
    if s_11 * s_22 - s_12 * s_12 > THIN * trace * trace:
        determinant = s_11 * s_22 - s_12 * s_12
        beta_1 = (s_22 * m_1 - s_12 * m_2) / determinant
        beta_2 = (s_11 * m_2 - s_12 * m_1) / determinant
    else:  # of a line: along its points
        along = (s_11 * m_1 + s_12 * m_2, s_12 * m_1 + s_22 * m_2)
        beta_1, beta_2 = along[0] / (trace * trace), along[1] / (trace * trace)
    lost_1 = m_1 - (s_11 * beta_1 + s_12 * beta_2)
    lost_2 = m_2 - (s_12 * beta_1 + s_22 * beta_2)
    lost, size = lost_1 * lost_1 + lost_2 * lost_2, total * total * trace / w
    return total / w - beta_1 * c_1 - beta_2 * c_2, beta_1, beta_2, lost <= exact * exact * size


@kernel
def _is_consistent(
    count: int, members: Indices, width: int, frame: Any, before: Any, now: Any, manifolds: Array,
    rows: Array,
) -> bool:  # fmt: skip
    """Tell whether two pressures press on the same points."""
    alpha, slope_1, slope_2, is_known = before
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            if not _takes_part(lane + constraint.SIZE + index * width, rows):
                continue
            x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
            pressed = not is_known or alpha + slope_1 * x + slope_2 * y > 0.0
            if (now[0] + now[1] * x + now[2] * y > 0.0) != pressed:
                return False
    return True


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
def _share_of_all(
    count: int, members: Indices, carrier: int, frame: Any, manifolds: Array
) -> Any:  # fmt: skip
    """Return k_face of all faces of a surface: see `surface_friction`."""
    if carrier >= 0:
        return pressure_of_face.uniform_share(members[carrier], frame[1], manifolds)
    lines = _all_lines(count, members, manifolds)
    of_points = uniform = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for place in range(count):
        record = members[place]
        size = _size_of(record, lines, manifolds)
        shares = pressure_of_face.weights(record, frame[1], manifolds)
        own = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if not size > 0.0:
            continue
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
            own = _with(own, size * shares[index], x, y)
        of_points = _sum(of_points, own, 0.0)
        s_11, s_12, s_22 = _second_moment(own)
        trace = s_11 + s_22
        square = pressure_of_face.mean_square(record, trace, manifolds)
        uniform = _sum(uniform, own, own[0] * (square / trace - 1.0) if trace > 0.0 else 0.0)
    s_11, s_12, s_22 = _second_moment(of_points)
    trace = s_11 + s_22
    q = patch_friction.flatness(trace, s_11 * s_22 - s_12 * s_12)
    s_11, s_12, s_22 = _second_moment(uniform)
    k = (s_11 + s_22) / trace
    of_uniform = patch_friction.flatness(s_11 + s_22, s_11 * s_22 - s_12 * s_12)
    k *= patch_friction.shape_factor(of_uniform) / patch_friction.shape_factor(q)
    return pressure_of_face.of_face(k, q)


@inline
def _sum(sums: Any, own: Any, more: float) -> Any:
    """Add two sums, and so much more of the second moment Sigma of the second."""
    s_11, s_12, s_22 = _second_moment(own)
    n, x, y, xx, xy, yy = sums
    n_2, x_2, y_2, xx_2, xy_2, yy_2 = own
    return (
        n + n_2, x + x_2, y + y_2, xx + xx_2 + more * s_11, xy + xy_2 + more * s_12,
        yy + yy_2 + more * s_22,
    )  # fmt: skip


@inline
def _with(sums: Any, weight: float, x: float, y: float) -> Any:
    """Add a weight at a place to sums: 1, x, y, xx, xy, yy."""
    n, sum_x, sum_y, xx, xy, yy = sums
    return (
        n + weight, sum_x + weight * x, sum_y + weight * y, xx + weight * x * x,
        xy + weight * x * y, yy + weight * y * y,
    )  # fmt: skip


@inline
def _second_moment(sums: Any) -> Any:
    """Return Sigma of such sums: 11, 12, 22."""
    n, sum_x, sum_y, xx, xy, yy = sums
    x, y = sum_x / n, sum_y / n
    return xx / n - x * x, xy / n - x * y, yy / n - y * y


@kernel
def _find_pressure(
    count: int, members: Indices, carrier: int, width: int, frame: Any, first: Any, exact: float,
    manifolds: Array, rows: Array,
) -> Any:  # fmt: skip
    """
    Return alpha and beta of the pressure of a surface, and whether there is one.

    first : load beside what is recalled, and its moments: see `_first_load`, `_left_behind`
    exact : see `_pressure`
    """
    pressure = 0.0, 0.0, 0.0, False
    for _ in range(ROUNDS):
        before = pressure
        sums = _sum_up(count, members, carrier, width, frame, before, manifolds, rows)
        loads = sums[0] + first[0], sums[1] + first[1], sums[2] + first[2]
        pressure = _pressure((*loads, *sums[3:]), exact)
        if not pressure[3]:
            return pressure
        if _is_consistent(count, members, width, frame, before, pressure, manifolds, rows):
            return pressure
    return 0.0, 0.0, 0.0, False


@kernel
def _are_of_several(count: int, members: Indices, table: Indices, manifolds: Array) -> bool:
    """
    Tell whether the faces on which a body lies are of several colliders: parts of a body that lie
    on one press as they may.
    """
    first = -1
    for place in range(count):
        _, side = _owner(members[place], table, manifolds)
        other = int(manifolds[members[place] + manifold_record.COLLIDER_A + 1 - side])
        if first >= 0 and other != first:
            return True
        first = other
    return False


@kernel
def _is_new(
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


@kernel
def _first_load(
    record: int, h: float, frame: Any, table: Indices, manifolds: Array, rows: Array,
    bodies: Array,
) -> Any:  # fmt: skip
    """
    Return what a body that is put down on a surface that cannot move presses in a substep, by what
    pulls at its centre of mass: N, N x, N y; none, if it comes down faster than it is pulled.
    """
    body, side = _owner(record, table, manifolds)
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    if table[other * collider_record.SIZE + collider_record.BODY] >= 0:
        return 0.0, 0.0, 0.0
    row = body * solver_bodies.SIZE
    normal = scale(2.0 * side - 1.0, load(manifolds, record + manifold_record.NORMAL))
    inverse_mass = bodies[row + solver_bodies.INVERSE_MASS]
    pull = -h * dot(normal, load(bodies, row + solver_bodies.FREE_ACCELERATION))
    speed = inverse_mass * dot(normal, load(bodies, row + solver_bodies.MOMENTUM))
    if not (abs(speed) < pull and inverse_mass > solver_bodies.HELD):
        return 0.0, 0.0, 0.0
    way = subtract(load(bodies, row + solver_bodies.START_POSITION), frame[0])
    total = pull / inverse_mass
    return total, total * dot(way, frame[1][0]), total * dot(way, frame[1][1])


@inline
def _with_carried(
    sums: Any, entry: int, factor: float, origin: Any, frame: Any, cache: Array
) -> Any:
    """Add what an entry of the cache has carried; origin: of the shape that moves."""
    total, total_1, total_2 = sums
    way = subtract(add(origin, load(cache, entry + cache_record.MIDDLE)), frame[0])
    own = factor * impulse_cache.load_of(entry, cache)
    return (
        total + own, total_1 + own * dot(way, frame[1][0]), total_2 + own * dot(way, frame[1][1])
    )  # fmt: skip


@kernel
def _with_lost(
    sums: Any, factor: float, record: int, frame: Any, colliders: ColliderArrays, manifolds: Array,
    cache: Array, bodies: Array,
) -> Any:  # fmt: skip
    """
    Add what the body of a manifold has lost of its surface to N, N x, N y: what lies in its plane
    and is of the same other body.
    """
    table = colliders.table
    shapes = len(table) // collider_record.SIZE
    body, side = _owner(record, table, manifolds)
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    other_body = table[other * collider_record.SIZE + collider_record.BODY]
    normal = cross(frame[1][0], frame[1][1])
    entry = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_LOST])
    while entry >= cache_record.HEAD:
        pair = int(cache[entry + cache_record.PAIR_ID])
        first, second = pair // shapes, pair % shapes
        shape = impulse_cache.moving_shape(first, second, table)
        second = second if shape == first else first
        origin = load(colliders.poses, shape * pose.SIZE + pose.POSITION)
        way = subtract(add(origin, load(cache, entry + cache_record.MIDDLE)), frame[0])
        lies_in_plane = abs(dot(normal, way)) < FLUSH_DISTANCE
        if (
            lies_in_plane
            and table[second * collider_record.SIZE + collider_record.BODY] == other_body
        ):
            sums = _with_carried(sums, entry, factor, origin, frame, cache)
        entry = int(cache[entry + cache_record.NEXT_LOST])
    return sums


@kernel
def _left_behind(
    count: int, members: Indices, width: int, h: float, lost: bool, frame: Any,
    colliders: ColliderArrays, constraints: Constraints, bodies: Array,
) -> Any:  # fmt: skip
    """
    Return what a surface carried in the last tick beyond what is recalled of it, seen from the
    body: N, N x, N y; h: substep [s]. Nothing, where it was more than lines.

    lost : whether some body has lost a line: see `impulse_cache.link_lost`
    """
    manifolds, rows, cache = constraints.manifolds, constraints.rows, constraints.impulse_cache
    factor = impulse_cache.share_recalled(h, cache)
    _, side = _owner(members[0], colliders.table, manifolds)
    sums = 0.0, 0.0, 0.0
    for place in range(count):
        record = members[place]
        entry = constraints.places[record // manifold_record.SIZE]
        if entry != impulse_cache.NEW:
            if cache[entry + cache_record.POINTS] > 2.0:
                return 0.0, 0.0, 0.0
            shape = int(manifolds[record + manifold_record.COLLIDER_A + side])
            origin = load(colliders.poses, shape * pose.SIZE + pose.POSITION)
            sums = _with_carried(sums, entry, factor, origin, frame, cache)
        lane = int(manifolds[record + manifold_record.LANE])
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            impulse = rows[row + contact_point.NORMAL_IMPULSE]
            if impulse > 0.0:
                x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
                sums = sums[0] - impulse, sums[1] - impulse * x, sums[2] - impulse * y
    if not lost:
        return sums
    return _with_lost(sums, factor, members[0], frame, colliders, manifolds, cache, bodies)


@kernel
def _press_as_one(
    count: int, members: Indices, width: int, h: float, recalls: int, colliders: ColliderArrays,
    constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """Choose the impulses of one surface; h: substep [s]."""
    table, scratch = colliders.table, constraints.scratch
    manifolds, rows = constraints.manifolds, constraints.rows
    if count > 1 and not _are_of_several(count, members, table, manifolds):
        return
    lane = int(manifolds[members[0] + manifold_record.LANE])
    _, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    origin = load(manifolds, members[0] + manifold_record.POINTS)
    frame = origin, (tangent_1, tangent_2)
    carrier, first, exact = -1, (0.0, 0.0, 0.0), EXACT
    if count > 1:
        carrier = _carrier(count, members, width, table, manifolds, rows)
        if _is_new(count, members, width, manifolds, rows):
            first = _first_load(members[0], h, frame, table, manifolds, rows, bodies)
    if recalls != AS_FOUND and first[0] == 0.0 and _all_roll(count, members, manifolds, rows):
        first = _left_behind(
            count, members, width, h, recalls == WITH_LOST, frame, colliders, constraints, bodies
        )
        exact = OF_LINES
    pressure = _find_pressure(count, members, carrier, width, frame, first, exact, manifolds, rows)
    if carrier >= 0 and not pressure[3]:
        carrier = -1
        pressure = _find_pressure(
            count, members, carrier, width, frame, first, exact, manifolds, rows
        )
    if not pressure[3]:
        return
    alpha, beta_1, beta_2, _ = pressure
    lines = _all_lines(count, members, manifolds)
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = _size_of(record, lines, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        shares = pressure_of_face.weights(record, frame[1], manifolds)
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            if _takes_part(row, rows):
                x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
                impulse = size * shares[index] * (alpha + beta_1 * x + beta_2 * y)
                rows[row + contact_point.NORMAL_IMPULSE] = max(impulse, 0.0)
    if count > 1:
        for place in range(count):
            lane = int(manifolds[members[place] + manifold_record.LANE])
            _, side = _owner(members[place], table, manifolds)
            surface_friction.name_mover(lane, side, width, rows)
        surface_friction.join(
            count, members, _most(count, members, width, manifolds, rows),
            _share_of_all(count, members, carrier, frame, manifolds), width, manifolds, rows,
            scratch,
        )  # fmt: skip


@inline
def _leaves_a_choice(record: int, width: int, manifolds: Array, rows: Array) -> bool:
    """Tell whether a face was measured, and carries something at more than one point."""
    if not _is_measured(record, manifolds):
        return False
    lane = int(manifolds[record + manifold_record.LANE])
    taking_part, total = 0, 0.0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        row = lane + constraint.SIZE + index * width
        taking_part += 1 if _takes_part(row, rows) else 0
        total += rows[row + contact_point.NORMAL_IMPULSE]
    return taking_part > 1 and total > 0.0


@kernel
def _give_way_as_one(
    count: int, members: Indices, width: int, softness: Softness, table: Indices, manifolds: Array,
    rows: Array, scratch: Array,
) -> None:  # fmt: skip
    """Share the softness of one line, and its sink, among those of a surface."""
    carrier = _carrier(count, members, width, table, manifolds, rows)
    lines = _all_lines(count, members, manifolds)
    total, most, load_of_all = 0.0, 0.0, 0.0
    for place in range(count):
        if carrier >= 0 and place != carrier:
            continue
        size = _size_of(members[place], lines, manifolds)
        lane = int(manifolds[members[place] + manifold_record.LANE])
        total += size
        load_of_all += size * rows[lane + constraint.LOAD]
        most = max(most, manifolds[members[place] + manifold_record.POINT_COUNT])
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = _size_of(record, lines, manifolds)
        if not size > 0.0 or (carrier >= 0 and place != carrier):
            continue
        share = size / total * most / manifolds[record + manifold_record.POINT_COUNT]
        _, side = _owner(record, table, manifolds)
        other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
        fixed = table[other * collider_record.SIZE + collider_record.BODY] < 0
        soften(lane, softness, fixed, max(share, LEAST), rows)
        radius = rows[lane + constraint.DEEP] / DEEP
        static_sink.recall(lane, softness.h, radius, load_of_all / total, rows)
        scratch[lane_scratch.SHARED] = 1.0


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
    if not _link(recalls == WITH_LOST, order, table, manifolds, rows, bodies):
        return
    for index in range(len(order)):
        record = order[index] * manifold_record.SIZE
        if _is_round(record, manifolds, rows) or manifolds[record + manifold_record.STATE] == DONE:
            continue
        count = _list_surface(record, table, manifolds, rows, bodies, members)
        if count > 1:
            one_spring = _has_one_spring(count, members, width, manifolds, rows, bodies)
            surface_chain.chain(count, members, one_spring, softness.h, manifolds, rows, bodies)
        count = _keep_faces(count, members, manifolds)
        if count == 0:
            continue
        record = members[0]
        if (
            count > 1
            and _all_lines(count, members, manifolds)
            and _are_of_several(count, members, table, manifolds)
        ):
            _give_way_as_one(count, members, width, softness, table, manifolds, rows, scratch)
        has_lost = recalls == WITH_LOST and _rolls(record, manifolds, rows)
        has_lost = has_lost and _has_lost(record, table, manifolds, bodies)
        if count > 1 or has_lost or _leaves_a_choice(record, width, manifolds, rows):
            _press_as_one(
                count, members, width, softness.h, recalls, colliders, constraints, bodies
            )
    surface_chain.link(order, manifolds, rows, scratch)
