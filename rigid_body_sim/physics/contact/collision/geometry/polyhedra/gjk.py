# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The distance of two convex sets of points: the algorithm of Gilbert, Johnson and Keerthi.

    d = min |b - a|,  a in A, b in B  =  distance of the origin from M = B - A

A simplex of up to four points w = b - a of M approaches the point v of M nearest to the origin:
the point of M farthest along -v joins it, and the corners v does not need leave.
v . w / |v| is a lower bound of d at each step, so bodies farther apart than the margin are
dismissed after one or two steps. For polyhedra the steps end at the exact features.

The nearest point of a triangle is computed from its plane, not from its corners: the direction of
v keeps its digits while d goes to zero.

Source: Gilbert, Johnson, Keerthi, IEEE J. Robotics and Automation 4 (1988) 193.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import TINY
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    FRAME,
    NEAREST,
    ROW,
    SIMPLEX,
    farthest,
    point_of_b,
    to_b,
)

FAR, GAP, TOUCH = 0, 1, 2
STEPS = 64  # [-] most steps; 5 to 12 are usual, and meshes of 5000 vertices need some 15
CLOSE = 1e-15  # [-] gain of |v|^2 that ends the search
TOUCHING = 1e-9  # [-] of the size of the bodies: nearer is for the separating axes to judge
COLLINEAR = 1e-26  # [-] squared sine below which a triangle is only its sides
FLAT = 1e-20  # [-] squared height / edge below which each face of a tetrahedron is looked at


@kernel
def closest(
    points_a,
    at_a: int,
    count_a: int,
    near_a: int,
    points_b,
    at_b: int,
    count_b: int,
    near_b: int,
    margin: float,
    size: float,
    work,
) -> tuple[int, int]:
    """
    Find the nearest points of two polyhedra.

    points[at : at + 3 count], near : vertices, see `farthest`; those of B in the axes of FRAME
    margin : [m]  farther apart is FAR
    size   : [m]  of both bodies
    Returns (FAR | GAP | TOUCH, corners of SIMPLEX); for GAP, NEAREST holds v and both points.
    """
    x, y, z = work[FRAME], work[FRAME + 1], work[FRAME + 2]
    vv = x * x + y * y + z * z
    if not vv > 0.0:
        x, y, z, vv = 1.0, 0.0, 0.0, 1.0
    corners = 0
    i = j = 0
    limit = margin * margin
    touching = max((TOUCHING * size) * (TOUCHING * size), TINY)
    stalled = False
    vw = vv
    for _ in range(STEPS):
        i = farthest(points_a, at_a, count_a, near_a, x, y, z, i)
        bx, by, bz = to_b(work, -x, -y, -z)
        j = farthest(points_b, at_b, count_b, near_b, bx, by, bz, j)
        k = at_a + 3 * i
        bx, by, bz = point_of_b(work, points_b, at_b + 3 * j)
        bx -= points_a[k]
        by -= points_a[k + 1]
        bz -= points_a[k + 2]
        vw = x * bx + y * by + z * bz
        if vw > 0.0 and vw * vw > limit * vv:
            return FAR, corners
        if stalled or (corners > 0 and vv - vw <= CLOSE * vv):
            break
        known = False
        for c in range(corners):
            row = SIMPLEX + ROW * c
            known = known or (work[row + 3] == i and work[row + 4] == j)
        if known:
            break
        row = SIMPLEX + ROW * corners
        work[row], work[row + 1], work[row + 2] = bx, by, bz
        work[row + 3], work[row + 4] = i, j
        before = vv if corners > 0 else math.inf
        corners = _reduce(work, corners + 1)
        if corners == 0:
            return TOUCH, 4
        x, y, z = work[NEAREST], work[NEAREST + 1], work[NEAREST + 2]
        vv = x * x + y * y + z * z
        if not vv > touching:
            return TOUCH, corners
        stalled = not vv < before
    if not vw > 0.25 * vv:  # round-off got the better of a degenerate simplex
        return TOUCH, corners
    for c in range(6):
        work[NEAREST + 3 + c] = 0.0
    for c in range(corners):
        row = SIMPLEX + ROW * c
        k = at_a + 3 * int(work[row + 3])
        bx, by, bz = point_of_b(work, points_b, at_b + 3 * int(work[row + 4]))
        share = work[row + 5]
        work[NEAREST + 3] += share * points_a[k]
        work[NEAREST + 4] += share * points_a[k + 1]
        work[NEAREST + 5] += share * points_a[k + 2]
        work[NEAREST + 6] += share * bx
        work[NEAREST + 7] += share * by
        work[NEAREST + 8] += share * bz
    return GAP, corners


@kernel
def _reduce(work, corners: int) -> int:
    """
    Find v on a simplex and keep the corners it needs, each with its weight.

    Returns their number; 0 for a tetrahedron around the origin.
    """
    if corners <= 2:
        p, q = SIMPLEX, SIMPLEX + ROW * (corners - 1)
        _, share, x, y, z = _segment(work, p, q)
        work[p + 5] = 1.0 - share
        if corners == 2:
            work[q + 5] = share
    else:
        least = math.inf
        best = 3
        share_p = share_q = share_r = 0.0
        x = y = z = 0.0
        for face in range(0 if corners == 4 else 3, 4):  # its number: the corner it leaves out
            p = SIMPLEX + ROW * (1 if face == 0 else 0)
            q = SIMPLEX + ROW * (2 if face <= 1 else 1)
            r = SIMPLEX + ROW * (3 if face <= 2 else 2)
            if corners == 4 and _looks_away(work, p, q, r, SIMPLEX + ROW * face):
                continue
            vv, sp, sq, sr, tx, ty, tz = _triangle(work, p, q, r)
            if vv < least:
                least, best = vv, face
                share_p, share_q, share_r = sp, sq, sr
                x, y, z = tx, ty, tz
        if least == math.inf:
            return 0
        if corners == 4:
            work[SIMPLEX + ROW * best + 5] = 0.0
        work[SIMPLEX + ROW * (1 if best == 0 else 0) + 5] = share_p
        work[SIMPLEX + ROW * (2 if best <= 1 else 1) + 5] = share_q
        work[SIMPLEX + ROW * (3 if best <= 2 else 2) + 5] = share_r
    work[NEAREST], work[NEAREST + 1], work[NEAREST + 2] = x, y, z
    to = SIMPLEX
    for c in range(corners):
        row = SIMPLEX + ROW * c
        if work[row + 5] > 0.0:
            for k in range(6):
                work[to + k] = work[row + k]
            to += ROW
    return (to - SIMPLEX) // ROW


@inline
def _looks_away(work, p: int, q: int, r: int, s: int) -> bool:
    """Tell whether the origin and the corner s lie on the same side of the face p q r."""
    ux, uy, uz = work[q] - work[p], work[q + 1] - work[p + 1], work[q + 2] - work[p + 2]
    wx, wy, wz = work[r] - work[p], work[r + 1] - work[p + 1], work[r + 2] - work[p + 2]
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    ux, uy, uz = work[s] - work[p], work[s + 1] - work[p + 1], work[s + 2] - work[p + 2]
    opposite = nx * ux + ny * uy + nz * uz
    origin = -(nx * work[p] + ny * work[p + 1] + nz * work[p + 2])
    edge = (nx * nx + ny * ny + nz * nz) * (ux * ux + uy * uy + uz * uz)
    return origin * opposite > 0.0 and opposite * opposite > FLAT * edge


@kernel
def _segment(work, p: int, q: int) -> tuple[float, float, float, float, float]:
    """Return |v|^2, the weight of q, and v, of the edge p q."""
    x, y, z = work[p], work[p + 1], work[p + 2]
    ux, uy, uz = work[q] - x, work[q + 1] - y, work[q + 2] - z
    uu = ux * ux + uy * uy + uz * uz
    share = -(x * ux + y * uy + z * uz)
    if not share > 0.0:
        share = 0.0
    elif share >= uu:
        share = 1.0
        x, y, z = work[q], work[q + 1], work[q + 2]
    else:
        share /= uu
        x, y, z = x + share * ux, y + share * uy, z + share * uz
    return x * x + y * y + z * z, share, x, y, z


@kernel
def _triangle(
    work, p: int, q: int, r: int
) -> tuple[float, float, float, float, float, float, float]:
    """Return |v|^2, the weights of p, q, r, and v, of the triangle p q r."""
    ax, ay, az = work[p], work[p + 1], work[p + 2]
    bx, by, bz = work[q], work[q + 1], work[q + 2]
    ux, uy, uz = bx - ax, by - ay, bz - az
    wx, wy, wz = work[r] - ax, work[r + 1] - ay, work[r + 2] - az
    tx, ty, tz = work[r] - bx, work[r + 1] - by, work[r + 2] - bz
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    nn = nx * nx + ny * ny + nz * nz
    size = (ux * ux + uy * uy + uz * uz) * (wx * wx + wy * wy + wz * wz)
    thin = not nn > max(COLLINEAR * size, TINY)  # [m^4] below, digits of nn are lost
    share_p = nx * (by * tz - bz * ty) + ny * (bz * tx - bx * tz) + nz * (bx * ty - by * tx)
    share_q = nx * (wy * az - wz * ay) + ny * (wz * ax - wx * az) + nz * (wx * ay - wy * ax)
    share_r = nx * (ay * uz - az * uy) + ny * (az * ux - ax * uz) + nz * (ax * uy - ay * ux)
    if share_p > 0.0 and share_q > 0.0 and share_r > 0.0 and not thin:
        total = share_p + share_q + share_r
        height = (nx * ax + ny * ay + nz * az) / nn
        x, y, z = nx * height, ny * height, nz * height
        return (
            x * x + y * y + z * z,
            share_p / total,
            share_q / total,
            share_r / total,
            x,
            y,
            z,
        )
    least = math.inf
    x = y = z = 0.0
    one = two = three = 0.0
    for side in range(3):  # its number: the corner it leaves out
        if not thin and (share_p if side == 0 else share_q if side == 1 else share_r) > 0.0:
            continue
        vv, share, sx, sy, sz = _segment(work, q if side == 0 else p, q if side == 2 else r)
        if vv < least:
            least, x, y, z = vv, sx, sy, sz
            one = 0.0 if side == 0 else 1.0 - share
            two = 0.0 if side == 1 else (share if side == 2 else 1.0 - share)
            three = 0.0 if side == 2 else share
    return least, one, two, three, x, y, z
