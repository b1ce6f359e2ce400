# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A side of one box against the other box: the patch in which they face each other.

The reference side is that of the separating axis; the incident side is the one of the other box
that faces it most. The incident side is cut by the four planes around the reference side
(Sutherland and Hodgman, Comm. ACM 17 (1974) 32); what remains within the margin of the reference
side is the manifold. A corner of the patch is named by the two edges that meet in it: 0 to 3 of
the incident side, 4 to 7 of the reference side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.manifold import (
    POINT,
    POINTS,
    keep_four,
    put_normal,
    put_point,
)
from rigid_body_sim.physics.contact.two_boxes import FREE, HALF_A, HALF_B, MIDDLE, TURN
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]

CORNER = 4  # numbers of a corner: u, v along the side, gap [m], edge that follows [-]
POLYGON = 9 * CORNER
FIRST, SECOND = FREE, FREE + POLYGON  # the polygon before and after a cut
PATCH = SECOND + POLYGON  # the points before the choice of four
DEEPEST = 40000.0  # features of corners that lie deepest
ROUNDING = 1e-12  # [-] a corner beyond a cutting plane by less is inside


@kernel
def _cut(found: Array, source: int, target: int, count: int, axis: int, limit: float) -> int:
    """
    Keep the part of a polygon where a coordinate stays below a limit.

    axis  : 0: u <= limit, 1: -u <= limit, 2: v <= limit, 3: -v <= limit
    Returns how many corners remain; the new edge gets the number 4 + axis.
    """
    coordinate = axis >> 1
    sign = -1.0 if axis & 1 else 1.0
    bound = limit * (1.0 + ROUNDING)
    kept = 0
    here = source + (count - 1) * CORNER
    depth = sign * found[here + coordinate] - bound
    for k in range(count):
        there = source + k * CORNER
        after = sign * found[there + coordinate] - bound
        if (depth > 0.0) != (after > 0.0):
            share = depth / (depth - after)
            to = target + kept * CORNER
            for i in range(3):
                found[to + i] = found[here + i] + share * (found[there + i] - found[here + i])
            found[to + coordinate] = sign * limit
            found[to + 3] = found[here + 3] if depth > 0.0 else 4.0 + axis
            kept += 1
        if not after > 0.0:
            to = target + kept * CORNER
            for i in range(CORNER):
                found[to + i] = found[there + i]
            kept += 1
        here, depth = there, after
    return kept


@inline
def _corner(found: Array, k: int, u: float, v: float, gap: float) -> None:
    at = FIRST + k * CORNER
    found[at] = u
    found[at + 1] = v
    found[at + 2] = gap
    found[at + 3] = float(k)


@kernel
def face_contact(
    poses: Array, pa: int, pb: int, margin: float, found: Array, of_b: bool, axis: int
) -> int:
    """
    Find the manifold of a side of A (or of B) and the other box; 0: nothing within the margin.

        of_b : the reference side belongs to B
        axis : of the reference side
    """
    down, across = (1, 3) if of_b else (3, 1)  # C_ij is at TURN + down i + across j
    reference, incident = (HALF_B, HALF_A) if of_b else (HALF_A, HALF_B)
    pose = pb if of_b else pa
    u, v = (axis + 1) % 3, (axis + 2) % 3
    tu, tv, tw = found[MIDDLE + u], found[MIDDLE + v], found[MIDDLE + axis]
    if of_b:
        tu = tv = tw = 0.0
        for i in range(3):
            t = found[MIDDLE + i]
            tu -= t * found[TURN + 3 * i + u]
            tv -= t * found[TURN + 3 * i + v]
            tw -= t * found[TURN + 3 * i + axis]
    side = -1.0 if tw < 0.0 else 1.0
    row = TURN + down * axis
    j = 0
    if abs(found[row + across]) > abs(found[row]):
        j = 1
    if abs(found[row + 2 * across]) > abs(found[row + j * across]):
        j = 2
    facing = side * found[row + j * across] < 0.0
    h = found[incident + j] if facing else -found[incident + j]
    p, q = (j + 1) % 3, (j + 2) % 3
    hp, hq = found[incident + p], found[incident + q]
    row_u, row_v = TURN + down * u, TURN + down * v
    cu = tu + h * found[row_u + j * across]
    cv = tv + h * found[row_v + j * across]
    half = found[reference + axis]
    cw = side * (tw + h * found[row + j * across]) - half
    pu, pv, pw = (
        hp * found[row_u + p * across],
        hp * found[row_v + p * across],
        side * hp * found[row + p * across],
    )
    qu, qv, qw = (
        hq * found[row_u + q * across],
        hq * found[row_v + q * across],
        side * hq * found[row + q * across],
    )
    _corner(found, 0, cu + pu + qu, cv + pv + qv, cw + pw + qw)
    _corner(found, 1, cu - pu + qu, cv - pv + qv, cw - pw + qw)
    _corner(found, 2, cu - pu - qu, cv - pv - qv, cw - pw - qw)
    _corner(found, 3, cu + pu - qu, cv + pv - qv, cw + pw - qw)
    half_u, half_v = found[reference + u], found[reference + v]
    count, source, target = 4, FIRST, SECOND
    reach_u, reach_v = abs(pu) + abs(qu), abs(pv) + abs(qv)
    for cut in range(4):
        center, reach, limit = (cu, reach_u, half_u) if cut < 2 else (cv, reach_v, half_v)
        if (-center if cut & 1 else center) + reach > limit:
            count = _cut(found, source, target, count, cut, limit)
            source, target = target, source
    number = (((3.0 if of_b else 0.0) + axis) * 2.0 + (side > 0.0)) * 6.0 + 2.0 * j + facing
    near = 0
    before = found[source + (count - 1) * CORNER + 3]
    for k in range(count):
        at = source + k * CORNER
        after = found[at + 3]
        gap = found[at + 2]
        if gap <= margin:
            # (x, y, z): from the middle of the reference box along its axes u, v and `axis`
            x, y, z = found[at], found[at + 1], side * (half + 0.5 * gap)
            wx = poses[pose + 3 + u] * x + poses[pose + 3 + v] * y + poses[pose + 3 + axis] * z
            wy = poses[pose + 6 + u] * x + poses[pose + 6 + v] * y + poses[pose + 6 + axis] * z
            wz = poses[pose + 9 + u] * x + poses[pose + 9 + v] * y + poses[pose + 9 + axis] * z
            put_point(
                found,
                PATCH + near * POINT,
                poses[pose] + wx,
                poses[pose + 1] + wy,
                poses[pose + 2] + wz,
                gap,
                (number * 8.0 + before) * 8.0 + after,
            )
            near += 1
        before = after
    if of_b:
        side = -side
    put_normal(
        found,
        side * poses[pose + 3 + axis],
        side * poses[pose + 6 + axis],
        side * poses[pose + 9 + axis],
    )
    if near > 4:
        return keep_four(found, PATCH, near)
    for i in range(near * POINT):
        found[POINTS + i] = found[PATCH + i]
    return near


@kernel
def deepest_corner(
    poses: Array, pa: int, pb: int, found: Array, of_b: bool, axis: int, separation: float
) -> int:
    """
    Report the corner of the other box that lies deepest behind the side of a separating axis.

        separation : [m]  along that axis; the gap of the point
    """
    pose = pb if of_b else pa
    other = pa if of_b else pb
    half = HALF_A if of_b else HALF_B
    mx, my, mz = poses[pose + 3 + axis], poses[pose + 6 + axis], poses[pose + 9 + axis]
    dx = poses[other] - poses[pose]
    dy = poses[other + 1] - poses[pose + 1]
    dz = poses[other + 2] - poses[pose + 2]
    if mx * dx + my * dy + mz * dz < 0.0:
        mx, my, mz = -mx, -my, -mz
    x, y, z = -0.5 * separation * mx, -0.5 * separation * my, -0.5 * separation * mz
    number = 0.0
    for k in range(3):
        ax, ay, az = poses[other + 3 + k], poses[other + 6 + k], poses[other + 9 + k]
        down = mx * ax + my * ay + mz * az > 0.0
        h = -found[half + k] if down else found[half + k]
        x += h * ax
        y += h * ay
        z += h * az
        number = 2.0 * number + down
    put_point(
        found,
        POINTS,
        poses[other] + x,
        poses[other + 1] + y,
        poses[other + 2] + z,
        separation,
        DEEPEST + 8.0 * of_b + number,
    )
    if of_b:
        mx, my, mz = -mx, -my, -mz
    put_normal(found, mx, my, mz)
    return 1
