# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A side of one box against the other box: the patch in which they face each other.

The reference side is that of the separating axis; the incident side is the one of the other box
that faces it most, a parallelogram c + alpha p + beta q, |alpha|, |beta| <= 1, seen along the axes
u, v of the reference side. The patch is what the two have in common: corners of the incident side
over the reference side, points where its edges cross the edges of the reference side (Liang and
Barsky, ACM Trans. Graph. 3 (1984) 1), and corners of the reference side under it. What lies within
the margin of the reference side is the manifold.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import between, component
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    SCRATCH,
    keep_four_flat,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

CORNER = 4  # numbers of a corner of the patch: u, v, gap [m], feature [-]
INCIDENT = SCRATCH  # the four corners of the incident side
PATCH = INCIDENT + 4 * CORNER  # up to 12 of the patch, some of them twice
CUTS, UNDER, NAMES = 4.0, 20.0, 24.0  # features: edge 0 … 3 cut by side 0 … 3, corners under it
DEEPEST = 40000.0  # features of corners that lie deepest
ROUNDING = 1e-12  # [-] of a half edge: a corner beyond an edge by less is over the side


@inline
def _put(found: Array, at: int, u: float, v: float, gap: float, feature: float) -> None:
    found[at] = u
    found[at + 1] = v
    found[at + 2] = gap
    found[at + 3] = feature


@kernel
def _cut_edges(found: Array, half_u: float, half_v: float, margin: float) -> int:
    """Append the corners and cut points of the edges of the incident side; return their number."""
    count = 0
    limit_u, limit_v = half_u * (1.0 + ROUNDING), half_v * (1.0 + ROUNDING)
    for k in range(4):
        at = INCIDENT + k * CORNER
        to = INCIDENT + ((k + 1) & 3) * CORNER
        u, v, gap = found[at], found[at + 1], found[at + 2]
        du, dv, climb = found[to] - u, found[to + 1] - v, found[to + 2] - gap
        first, last, enter, leave = 0.0, 1.0, -1.0, -1.0
        if du != 0.0:
            one, two = (-limit_u - u) / du, (limit_u - u) / du
            low, high = 0.0, 1.0
            if one > two:
                one, two, low, high = two, one, 1.0, 0.0
            if one > first:
                first, enter = one, low
            if two < last:
                last, leave = two, high
        elif abs(u) > limit_u:
            continue
        if dv != 0.0:
            one, two = (-limit_v - v) / dv, (limit_v - v) / dv
            low, high = 2.0, 3.0
            if one > two:
                one, two, low, high = two, one, 3.0, 2.0
            if one > first:
                first, enter = one, low
            if two < last:
                last, leave = two, high
        elif abs(v) > limit_v:
            continue
        if first > last:
            continue
        cut = gap + first * climb
        if cut <= margin:
            feature = 1.0 * k if enter < 0.0 else CUTS + 4.0 * k + enter
            _put(found, PATCH + count * CORNER, u + first * du, v + first * dv, cut, feature)
            count += 1
        if leave < 0.0 or last == first:
            continue  # the next edge begins there, or this one only touches a corner
        cut = gap + last * climb
        if cut <= margin:
            feature = CUTS + 4.0 * k + leave
            _put(found, PATCH + count * CORNER, u + last * du, v + last * dv, cut, feature)
            count += 1
    return count


@kernel
def face_contact(
    numbers: Array,
    reference: int,
    incident: int,
    poses: Array,
    pr: int,
    pi: int,
    margin: float,
    found: Array,
    of_b: bool,
    axis: int,
) -> int:
    """
    Find the manifold of a side of the reference box and the incident box; 0: none in the margin.

        of_b : the reference box is B
        axis : of the reference side
    """
    i, j = (axis + 1) % 3, (axis + 2) % 3
    ru, rv, rw = pr + 3 + i, pr + 3 + j, pr + 3 + axis
    half_u, half_v = numbers[reference + i], numbers[reference + j]
    half = numbers[reference + axis]
    dx, dy, dz = between(poses, pr, pi)
    cu, cv = component(poses, ru, dx, dy, dz), component(poses, rv, dx, dy, dz)
    cw = component(poses, rw, dx, dy, dz)
    side = -1.0 if cw < 0.0 else 1.0
    mx, my, mz = side * poses[rw], side * poses[rw + 3], side * poses[rw + 6]
    m = 0
    most = component(poses, pi + 3, mx, my, mz)
    for k in range(1, 3):
        along = component(poses, pi + 3 + k, mx, my, mz)
        if abs(along) > abs(most):
            m, most = k, along
    facing = most < 0.0
    h = numbers[incident + m] if facing else -numbers[incident + m]
    p, q = (m + 1) % 3, (m + 2) % 3
    x, y, z = poses[pi + 3 + m], poses[pi + 6 + m], poses[pi + 9 + m]
    cu += h * component(poses, ru, x, y, z)
    cv += h * component(poses, rv, x, y, z)
    cw = side * cw + h * most - half
    h = numbers[incident + p]
    x, y, z = h * poses[pi + 3 + p], h * poses[pi + 6 + p], h * poses[pi + 9 + p]
    pu, pv, pw = (
        component(poses, ru, x, y, z),
        component(poses, rv, x, y, z),
        mx * x + my * y + mz * z,
    )
    h = numbers[incident + q]
    x, y, z = h * poses[pi + 3 + q], h * poses[pi + 6 + q], h * poses[pi + 9 + q]
    qu, qv, qw = (
        component(poses, ru, x, y, z),
        component(poses, rv, x, y, z),
        mx * x + my * y + mz * z,
    )
    put_normal(found, -mx if of_b else mx, -my if of_b else my, -mz if of_b else mz)
    at = INCIDENT
    _put(found, at, cu + pu + qu, cv + pv + qv, cw + pw + qw, 0.0)
    _put(found, at + CORNER, cu - pu + qu, cv - pv + qv, cw - pw + qw, 1.0)
    _put(found, at + 2 * CORNER, cu - pu - qu, cv - pv - qv, cw - pw - qw, 2.0)
    _put(found, at + 3 * CORNER, cu + pu - qu, cv + pv - qv, cw + pw - qw, 3.0)
    count, first = 4, INCIDENT
    inside = abs(cu) + abs(pu) + abs(qu) <= half_u and abs(cv) + abs(pv) + abs(qv) <= half_v
    if not (inside and cw + abs(pw) + abs(qw) <= margin):
        count, first = _cut_edges(found, half_u, half_v, margin), PATCH
        det = pu * qv - pv * qu
        if not inside and det != 0.0:
            for k in range(4):
                u, v = half_u if k & 1 else -half_u, half_v if k & 2 else -half_v
                alpha, beta = (u - cu) * qv - (v - cv) * qu, (v - cv) * pu - (u - cu) * pv
                if abs(alpha) < abs(det) and abs(beta) < abs(det):
                    gap = cw + (alpha / det * pw + beta / det * qw)
                    if gap <= margin:
                        _put(found, PATCH + count * CORNER, u, v, gap, UNDER + k)
                        count += 1
        if count > 4:
            count, first = keep_four_flat(found, PATCH, count, INCIDENT), INCIDENT
    number = (((3.0 if of_b else 0.0) + axis) * 2.0 + (side > 0.0)) * 6.0 + 2.0 * m + facing
    for k in range(count):
        at = first + k * CORNER
        u, v, gap = found[at], found[at + 1], found[at + 2]
        w, feature = half + 0.5 * gap, number * NAMES + found[at + 3]
        put_point(
            found,
            POINTS + k * POINT,
            poses[pr] + (poses[ru] * u + poses[rv] * v + mx * w),
            poses[pr + 1] + (poses[ru + 3] * u + poses[rv + 3] * v + my * w),
            poses[pr + 2] + (poses[ru + 6] * u + poses[rv + 6] * v + mz * w),
            gap,
            feature,
        )
    return count


@kernel
def deepest_corner(
    numbers: Array,
    incident: int,
    poses: Array,
    pr: int,
    pi: int,
    found: Array,
    of_b: bool,
    axis: int,
    separation: float,
) -> int:
    """
    Report the corner of the incident box that lies deepest behind a side of the reference box.

        separation : [m]  along the axis of that side; the gap of the point
    """
    mx, my, mz = poses[pr + 3 + axis], poses[pr + 6 + axis], poses[pr + 9 + axis]
    dx, dy, dz = between(poses, pr, pi)
    if mx * dx + my * dy + mz * dz < 0.0:
        mx, my, mz = -mx, -my, -mz
    x, y, z = -0.5 * separation * mx, -0.5 * separation * my, -0.5 * separation * mz
    number = 0.0
    for k in range(3):
        ax, ay, az = poses[pi + 3 + k], poses[pi + 6 + k], poses[pi + 9 + k]
        down = mx * ax + my * ay + mz * az > 0.0
        h = -numbers[incident + k] if down else numbers[incident + k]
        x += h * ax
        y += h * ay
        z += h * az
        number = 2.0 * number + down
    put_normal(found, -mx if of_b else mx, -my if of_b else my, -mz if of_b else mz)
    x, y, z = poses[pi] + x, poses[pi + 1] + y, poses[pi + 2] + z
    put_point(found, POINTS, x, y, z, separation, DEEPEST + 8.0 * of_b + number)
    return 1
