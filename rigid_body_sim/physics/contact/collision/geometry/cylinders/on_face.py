# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder on a side of a box, with its true round rim: it rolls, spins and stands as on a plane.

The separating axes that are exact for both are tried: the sides of the box, the ends of the
cylinder, and the cross products of its axis with the edges of the box. Where a side separates them
most, the points are those of a cylinder on a plane as far as they lie over the side, and the ends
of what hangs over: the lowest line of a lying cylinder, cut at the edges of the side; where the
circle of a standing one crosses the edges; the corners of the side under it. Where an edge of the
box touches the mantle, the point is the one between edge and axis. All other cases (rim on edge,
corner on mantle, corner on end, deep overlap) are left to another kernel.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import (
    lowest_direction,
    rim_feature,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FOUND,
    POINT,
    POINTS,
    SCRATCH,
    keep_four,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

UNDECIDED = -1  # count that says: another kernel must find the points
LEAD = 1e-3  # [-] of the smallest size by which an end or an edge must beat the sides …
SHARE = 0.05  # [-] … plus this share of |s|
HANGING = 0.01  # [-] of the radius: how much higher than the lowest point what is over the side is
SHALLOW = 0.2  # [-] of the smallest size: deeper, the rim may leave sooner over an edge
PARALLEL = 1e-6  # [-] sin^2 of the angle between axis and edge without a common normal
ROUNDING = 1e-12  # [-] a point beyond an edge by less is over the side

TURN = FOUND - 60  # (3, 3) axes of the cylinder (columns) in those of the box
MIDDLE = TURN + 9  # (3,) [m] middle of the cylinder from that of the box, box axes
CUTS, CORNERS, EDGES = 30.0, 40.0, 50.0  # features: where edges cut, corners of the side, edges


@kernel
def _add(
    poses: Array,
    pa: int,
    found: Array,
    count: int,
    axis: int,
    u: float,
    v: float,
    level: float,
    gap: float,
    margin: float,
    feature: float,
) -> int:
    """
    Append a point of the cylinder, if it is within the margin; return the new count.

    u, v  : [m]  along the two axes behind `axis` of the box
    level : [m]  of the side along `axis`, with its sign
    """
    if not gap <= margin:
        return count
    w = level + (0.5 * gap if level > 0.0 else -0.5 * gap)
    i, j = pa + 3 + (axis + 1) % 3, pa + 3 + (axis + 2) % 3
    k = pa + 3 + axis
    put_point(
        found,
        SCRATCH + count * POINT,
        poses[pa] + (u * poses[i] + v * poses[j] + w * poses[k]),
        poses[pa + 1] + (u * poses[i + 3] + v * poses[j + 3] + w * poses[k + 3]),
        poses[pa + 2] + (u * poses[i + 6] + v * poses[j + 6] + w * poses[k + 6]),
        gap,
        feature,
    )
    return count + 1


@inline
def _row(found: Array, axis: int) -> Any:
    """Axis of the box in the axes of the cylinder."""
    at = TURN + 3 * axis
    return found[at], found[at + 1], found[at + 2]


@kernel
def _load(numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, found: Array) -> None:
    dx = poses[pb] - poses[pa]
    dy = poses[pb + 1] - poses[pa + 1]
    dz = poses[pb + 2] - poses[pa + 2]
    for i in range(3):
        x, y, z = poses[pa + 3 + i], poses[pa + 6 + i], poses[pa + 9 + i]
        found[MIDDLE + i] = x * dx + y * dy + z * dz
        for j in range(3):
            found[TURN + 3 * i + j] = (
                x * poses[pb + 3 + j] + y * poses[pb + 6 + j] + z * poses[pb + 9 + j]
            )


@kernel
def on_face(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the manifold of a box and a cylinder, or return UNDECIDED; else see `manifold`."""
    _load(numbers, a, b, poses, pa, pb, found)
    radius, half = numbers[b], numbers[b + 1]
    best, axis = -math.inf, 0
    smallest = min(radius, half)
    along, spread = 0.0, half
    for k in range(3):
        tx, ty, rise = _row(found, k)
        h = numbers[a + k]
        s = abs(found[MIDDLE + k]) - (h + half * abs(rise) + radius * math.sqrt(tx * tx + ty * ty))
        if not s <= margin:
            return 0
        if s > best:
            best, axis = s, k
        smallest = min(smallest, h)
        along += found[MIDDLE + k] * rise
        spread += h * abs(rise)
    to_beat = best + LEAD * smallest + SHARE * abs(best)
    s = abs(along) - spread
    if s > margin:
        return 0
    by_end = s > to_beat
    edge = -1
    for k in range(3):
        _, _, c = _row(found, k)
        i, j = (k + 1) % 3, (k + 2) % 3
        ni, nj = -found[TURN + 3 * j + 2], found[TURN + 3 * i + 2]  # e_k x a
        squared = ni * ni + nj * nj
        if squared < PARALLEL:
            continue
        s = abs(ni * found[MIDDLE + i] + nj * found[MIDDLE + j])
        s = (s - numbers[a + i] * abs(ni) - numbers[a + j] * abs(nj)) / math.sqrt(squared) - radius
        if s > margin:
            return 0
        if s > to_beat:
            to_beat, edge = s, k
    if (to_beat if edge >= 0 else best) < -SHALLOW * smallest:
        return UNDECIDED
    if edge >= 0:
        return _mantle(numbers, a, b, poses, pa, found, edge, to_beat)
    if by_end:
        return UNDECIDED
    count = _points(numbers, a, b, poses, pa, margin, found, axis)
    least = math.inf
    for k in range(count):
        least = min(least, found[SCRATCH + k * POINT + 3])
    if not least <= best + HANGING * radius:
        return UNDECIDED
    return keep_four(found, SCRATCH, count)


@kernel
def _mantle(
    numbers: Array,
    a: int,
    b: int,
    poses: Array,
    pa: int,
    found: Array,
    edge: int,
    gap: float,
) -> int:
    """Find the point between an edge of the box and the mantle; UNDECIDED beyond their ends."""
    i, j = (edge + 1) % 3, (edge + 2) % 3
    ni, nj = -found[TURN + 3 * j + 2], found[TURN + 3 * i + 2]
    squared = ni * ni + nj * nj
    length = math.sqrt(squared)
    if ni * found[MIDDLE + i] + nj * found[MIDDLE + j] < 0.0:
        length = -length
    ni, nj = ni / length, nj / length
    hi = numbers[a + i] if ni > 0.0 else -numbers[a + i]
    hj = numbers[a + j] if nj > 0.0 else -numbers[a + j]
    di, dj = found[TURN + 3 * i + 2], found[TURN + 3 * j + 2]
    # along the edge the axis is as near to it as it looks: t of the nearest point of the axis
    t = (di * (hi - found[MIDDLE + i]) + dj * (hj - found[MIDDLE + j])) / squared
    w = found[MIDDLE + edge] + t * found[TURN + 3 * edge + 2]
    if not (abs(t) <= numbers[b + 1] and abs(w) <= numbers[a + edge]):
        return UNDECIDED
    ri, rj, rk = pa + 3 + i, pa + 3 + j, pa + 3 + edge
    nx = poses[ri] * ni + poses[rj] * nj
    ny = poses[ri + 3] * ni + poses[rj + 3] * nj
    nz = poses[ri + 6] * ni + poses[rj + 6] * nj
    hi, hj = hi + 0.5 * gap * ni, hj + 0.5 * gap * nj
    put_normal(found, nx, ny, nz)
    put_point(
        found,
        POINTS,
        poses[pa] + (poses[ri] * hi + poses[rj] * hj + poses[rk] * w),
        poses[pa + 1] + (poses[ri + 3] * hi + poses[rj + 3] * hj + poses[rk + 3] * w),
        poses[pa + 2] + (poses[ri + 6] * hi + poses[rj + 6] * hj + poses[rk + 6] * w),
        gap,
        EDGES + 4.0 * edge + 2.0 * (ni > 0.0) + (nj > 0.0),
    )
    return 1


@kernel
def _points(
    numbers: Array,
    a: int,
    b: int,
    poses: Array,
    pa: int,
    margin: float,
    found: Array,
    axis: int,
) -> int:
    """Collect the points over a side of the box, from SCRATCH on; write the normal."""
    radius, half = numbers[b], numbers[b + 1]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    limit_u, limit_v = numbers[a + i] * (1.0 + ROUNDING), numbers[a + j] * (1.0 + ROUNDING)
    side = -1.0 if found[MIDDLE + axis] < 0.0 else 1.0
    level = side * numbers[a + axis]
    tx, ty, rise = _row(found, axis)
    tx, ty, rise = side * tx, side * ty, side * rise
    xu, yu, au = _row(found, i)
    xv, yv, av = _row(found, j)
    put_normal(
        found,
        side * poses[pa + 3 + axis],
        side * poses[pa + 6 + axis],
        side * poses[pa + 9 + axis],
    )
    ux, uy, slot = lowest_direction(tx, ty)
    upper_end = rise < 0.0  # the end at +z is the lower one
    end = half if upper_end else -half
    cu, cv = found[MIDDLE + i] + end * au, found[MIDDLE + j] + end * av
    lower = side * found[MIDDLE + axis] - numbers[a + axis] - half * abs(rise)
    lies = half * abs(rise) < radius * (tx * ux + ty * uy)
    count = 0
    for k in range(3 if lies else 4):
        qx, qy = -radius * ux, -radius * uy
        if k == 1:
            qx, qy = -qy, qx
        elif k == 2:
            qx, qy = qy, -qx
        elif k == 3:
            qx, qy = -qx, -qy
        u, v, gap = cu + qx * xu + qy * yu, cv + qx * xv + qy * yv, lower + qx * tx + qy * ty
        feature = rim_feature(k, slot, upper_end)
        if k == 0 and lies:
            count = _line(
                poses,
                pa,
                found,
                count,
                axis,
                u,
                v,
                gap,
                -2.0 * end * au,
                -2.0 * end * av,
                2.0 * half * abs(rise),
                limit_u,
                limit_v,
                level,
                margin,
                feature,
            )
        elif abs(u) <= limit_u and abs(v) <= limit_v:
            count = _add(poses, pa, found, count, axis, u, v, level, gap, margin, feature)
    if lies:
        return count
    # The circle and the edges of the side: D = p cos + q sin along one of them.
    for cut in range(4):
        p, q, middle, limit = (xu, yu, cu, limit_u) if cut < 2 else (xv, yv, cv, limit_v)
        d = ((limit if cut & 1 else -limit) - middle) / radius
        m = p * p + q * q
        if not d * d < m:
            continue
        root = math.sqrt(m - d * d)
        for turn in range(2):
            sign = -1.0 if turn else 1.0
            c, s = (p * d - sign * q * root) / m, (q * d + sign * p * root) / m
            qx, qy = radius * c, radius * s
            u, v = cu + qx * xu + qy * yu, cv + qx * xv + qy * yv
            if (abs(v) <= limit_v) if cut < 2 else (abs(u) <= limit_u):
                gap = lower + qx * tx + qy * ty
                feature = CUTS + 2.0 * cut + turn
                count = _add(poses, pa, found, count, axis, u, v, level, gap, margin, feature)
    # Corners of the side below the end: straight up to the plane of the end.
    det = xu * yv - yu * xv
    if det == 0.0:
        return count
    for corner in range(4):
        u = numbers[a + i] if corner & 1 else -numbers[a + i]
        v = numbers[a + j] if corner & 2 else -numbers[a + j]
        du, dv = u - cu, v - cv
        qx, qy = (du * yv - dv * yu) / det, (dv * xu - du * xv) / det
        if qx * qx + qy * qy <= radius * radius:
            gap = lower + qx * tx + qy * ty
            count = _add(poses, pa, found, count, axis, u, v, level, gap, margin, CORNERS + corner)
    return count


@kernel
def _line(
    poses: Array,
    pa: int,
    found: Array,
    count: int,
    axis: int,
    u: float,
    v: float,
    gap: float,
    du: float,
    dv: float,
    climb: float,
    limit_u: float,
    limit_v: float,
    level: float,
    margin: float,
    feature: float,
) -> int:
    """Append the ends of the lowest line of a lying cylinder, as far as it is over the side."""
    first, last = 0.0, 1.0
    start, stop = feature, 1.0 - feature if feature < 2.0 else feature + 100.0
    for direction in range(2):
        x, d, limit = (v, dv, limit_v) if direction else (u, du, limit_u)
        if d == 0.0:
            if abs(x) > limit:
                return count
            continue
        one, two = (-limit - x) / d, (limit - x) / d
        if one > two:
            one, two = two, one
        if one > first:
            first, start = one, CUTS + 2.0 * direction + (d > 0.0)
        if two < last:
            last, stop = two, CUTS + 2.0 * direction + (d < 0.0)
    if first > last:
        return count
    for share, name in ((first, start), (last, stop)):
        count = _add(
            poses,
            pa,
            found,
            count,
            axis,
            u + share * du,
            v + share * dv,
            level,
            gap + share * climb,
            margin,
            name,
        )
    return count
