# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A pressure that is linear over the faces of a surface and nowhere pulls, with given sums:

    N_i = w_i max(alpha + beta . (r_i - c), 0),   w_i = A u_i: `pressure_of_face`
        A : [m^2] area of the face; where all are lines, the length [m]
        c : mean of the points by w

A plane carries the whole face of a body, also beside a box that is flush with it: it has all the
weight. A point takes part that was pressed, or touches.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.collision.collider import PLANE
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    patch_friction,
    pressure_of_face,
)
from rigid_body_sim.physics.contact.solver.surface_members import all_lines, is_line, is_measured
from rigid_body_sim.physics.vectors import cross, dot, load, subtract

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TOUCHES = 3e-7  # [m] apart: so far what rests may tremble
ROUNDS = 8  # [-] in which points that would pull are left out, at most
THIN = 1e-9  # [-] of the second moment: points are as good as in a line


@kernel
def size_of(record: int, lines: bool, manifolds: Array) -> float:
    """
    Return the area of the face of a manifold [m^2]; a line has none.

        lines : where all are lines: the length of each [m]
    """
    normal = load(manifolds, record + manifold_record.NORMAL)
    if is_measured(record, manifolds):
        return manifolds[record + manifold_record.FACE_AREA]
    points = record + manifold_record.POINTS
    origin = load(manifolds, points)
    first = subtract(load(manifolds, points + manifold.POINT), origin)
    if is_line(record, manifolds):
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
def takes_part(row: int, rows: Array) -> bool:
    """Tell whether a point was pressed, or touches."""
    return (
        rows[row + contact_point.NORMAL_IMPULSE] > 0.0
        or rows[row + contact_point.INITIAL_SEPARATION] <= TOUCHES
    )


@kernel
def carrier_of(
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
            taking_part += 1 if takes_part(row, rows) else 0
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
    lines = all_lines(count, members, manifolds)
    alpha, beta_1, beta_2, known = pressure
    total, total_1, total_2 = 0.0, 0.0, 0.0
    w, w_1, w_2, w_11, w_12, w_22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for place in range(count):
        record = members[place]
        lane = int(manifolds[record + manifold_record.LANE])
        size = size_of(record, lines, manifolds)
        size = 0.0 if carrier >= 0 and place != carrier else size
        shares = pressure_of_face.weights(record, frame[1], manifolds)
        for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
            row = lane + constraint.SIZE + index * width
            if not takes_part(row, rows):
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
            if not takes_part(lane + constraint.SIZE + index * width, rows):
                continue
            x, y = pressure_of_face.place(record, index, frame[0], frame[1], manifolds)
            pressed = not is_known or alpha + slope_1 * x + slope_2 * y > 0.0
            if (now[0] + now[1] * x + now[2] * y > 0.0) != pressed:
                return False
    return True


@kernel
def share_of_all(
    count: int, members: Indices, carrier: int, frame: Any, manifolds: Array
) -> Any:  # fmt: skip
    """Return k_face of all faces of a surface: see `surface_friction`."""
    if carrier >= 0:
        shares = pressure_of_face.weights(members[carrier], frame[1], manifolds)
        return pressure_of_face.uniform_share(members[carrier], shares, frame[1], manifolds)
    lines = all_lines(count, members, manifolds)
    of_points = uniform = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for place in range(count):
        record = members[place]
        size = size_of(record, lines, manifolds)
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
def find_pressure(
    count: int, members: Indices, carrier: int, width: int, frame: Any, first: Any, exact: float,
    manifolds: Array, rows: Array,
) -> Any:  # fmt: skip
    """
    Return alpha and beta of the pressure of a surface, and whether there is one.

    first : load beside what is recalled, and its moments: see `first_load`, `left_behind`
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
