# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where two faces of polyhedra touch: the points of one that lie over the other.

The reference face spans a prism along the contact normal n; the incident face of the other body is
clipped by its sides (Sutherland and Hodgman). Each corner x that is left lies over a point of the
reference face, at the gap

    g = (m . x - c) / (m . n)        m, c: plane of the reference face

For bodies that are separated by s along n no g is smaller than s.
A corner is named by the edges it lies between, edges of the incident face or sides of the prism:
while the same edges meet, the name stays.

Source: Sutherland, Hodgman, Reentrant polygon clipping, Comm. ACM 17 (1974) 32.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CLIP,
    FACES,
    HALF,
    LOOP,
    LOOPS,
    PLANES,
    VERTICES,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    FRAME,
    POINTS,
    from_b,
    point_of_b,
)

CORNER = 4  # numbers of a corner: x, y, z, the edge that begins there
MOST = 2 * CLIP  # [-] corners: each side of the prism adds one
SECOND = POINTS + CORNER * MOST  # where the second list of corners begins
END = SECOND + CORNER * MOST  # what lies behind is untouched
STEEP = 0.05  # [-] cosine between a face and the normal below which it carries no patch
SLACK = 1e-6  # [-] of the half width: sides stand off, so that flush faces keep their corners
FACE_NAMES = 65536.0  # [-] most faces that have names of their own


@kernel
def facing(of, at: int, x: float, y: float, z: float) -> int:
    """Return the face whose normal comes nearest to a direction, axes of the polyhedron."""
    planes = at + int(of[at + PLANES])
    best, most = 0, -math.inf
    for f in range(int(of[at + FACES])):
        k = planes + 4 * f
        height = x * of[k] + y * of[k + 1] + z * of[k + 2]
        if height > most:
            best, most = f, height
    return best


@inline
def _corner(of, at: int, loop: int, k: int, is_b: bool, work):
    p = at + VERTICES + 3 * int(of[loop + 1 + k])
    if is_b:
        return point_of_b(work, of, p)
    return of[p], of[p + 1], of[p + 2]


@inline
def side_of(
    of, at: int, loop: int, sides: int, k: int, is_b: bool, x: float, y: float, z: float, work
):
    """Return the side of the prism over the edge that ends at corner k: s . x <= c."""
    px, py, pz = _corner(of, at, loop, k - 1 if k > 0 else sides - 1, is_b, work)
    qx, qy, qz = _corner(of, at, loop, k, is_b, work)
    px, py, pz = qx - px, qy - py, qz - pz
    sx, sy, sz = py * z - pz * y, pz * x - px * z, px * y - py * x
    slack = SLACK * of[at + HALF] * math.sqrt(sx * sx + sy * sy + sz * sz)
    return sx, sy, sz, sx * qx + sy * qy + sz * qz + slack


@kernel
def is_over(
    of,
    at: int,
    face: int,
    is_b: bool,
    x: float,
    y: float,
    z: float,
    px: float,
    py: float,
    pz: float,
    work,
) -> bool:
    """Tell whether a point p lies within the prism over a face along n = (x, y, z); axes of A."""
    loop = at + int(of[at + LOOPS]) + int(of[at + LOOP]) * face
    sides = int(of[loop])
    for k in range(sides):
        sx, sy, sz, out = side_of(of, at, loop, sides, k, is_b, x, y, z, work)
        if sx * px + sy * py + sz * pz > out:
            return False
    return True


@inline
def across(of, at: int, face: int, is_b: bool, work):
    """Return the way from a corner of a face to the opposite one, axes of A."""
    loop = at + int(of[at + LOOPS]) + int(of[at + LOOP]) * face
    px, py, pz = _corner(of, at, loop, 0, is_b, work)
    qx, qy, qz = _corner(of, at, loop, int(of[loop]) // 2, is_b, work)
    return px - qx, py - qy, pz - qz


@inline
def _put(work, at: int, x: float, y: float, z: float, edge: float) -> None:
    work[at], work[at + 1], work[at + 2], work[at + 3] = x, y, z, edge


@kernel
def clip_by_side(
    work, source: int, to: int, count: int, sx: float, sy: float, sz: float, c: float, name: float
) -> int:
    """Keep of a polygon what has s . x <= c; return the number of corners."""
    kept = 0
    if count == 0:
        return 0
    last = source + CORNER * (count - 1)
    height = sx * work[last] + sy * work[last + 1] + sz * work[last + 2] - c
    for i in range(count):
        here = source + CORNER * i
        before, height_before = last, height
        height = sx * work[here] + sy * work[here + 1] + sz * work[here + 2] - c
        if (height > 0.0) != (height_before > 0.0) and kept < MOST:
            t = height_before / (height_before - height)
            _put(
                work,
                to + CORNER * kept,
                work[before] + t * (work[here] - work[before]),
                work[before + 1] + t * (work[here + 1] - work[before + 1]),
                work[before + 2] + t * (work[here + 2] - work[before + 2]),
                name if height > 0.0 else work[before + 3],
            )
            kept += 1
        if not height > 0.0 and kept < MOST:
            _put(
                work,
                to + CORNER * kept,
                work[here],
                work[here + 1],
                work[here + 2],
                work[here + 3],
            )
            kept += 1
        last = here
    return kept


@kernel
def patch(
    of_r,
    r: int,
    face: int,
    of_i,
    i: int,
    incident: int,
    ref_is_b: bool,
    x: float,
    y: float,
    z: float,
    s: float,
    margin: float,
    work,
) -> tuple[int, float]:
    """
    Write the points of the incident face over the reference face at POINTS, as `keep_four` wants.

    of_r, r, face     : record of the reference body, and its face
    of_i, i, incident : record of the incident body, and its face
    ref_is_b          : whether the reference body is B of FRAME, the other one A; else reversed
    x, y, z           : n, out of the reference body; axes of A
    s                 : [m]  separation along n
    Returns the number of points with g <= margin, and the least g.
    """
    k = r + int(of_r[r + PLANES]) + 4 * face
    mx, my, mz, c = of_r[k], of_r[k + 1], of_r[k + 2], of_r[k + 3]
    k = i + int(of_i[i + PLANES]) + 4 * incident
    ix, iy, iz = of_i[k], of_i[k + 1], of_i[k + 2]
    if ref_is_b:
        mx, my, mz = from_b(work, mx, my, mz)
        c += mx * work[FRAME] + my * work[FRAME + 1] + mz * work[FRAME + 2]
    else:
        ix, iy, iz = from_b(work, ix, iy, iz)
    steep = mx * x + my * y + mz * z
    if not (steep > STEEP and ix * x + iy * y + iz * z < -STEEP):
        return 0, math.inf
    loop_r = r + int(of_r[r + LOOPS]) + int(of_r[r + LOOP]) * face
    loop_i = i + int(of_i[i + LOOPS]) + int(of_i[i + LOOP]) * incident
    sides = int(of_r[loop_r])
    count = int(of_i[loop_i])
    here, there = (SECOND, POINTS) if sides % 2 == 0 else (POINTS, SECOND)
    for k in range(count):
        px, py, pz = _corner(of_i, i, loop_i, k, not ref_is_b, work)
        _put(work, here + CORNER * k, px, py, pz, float(k))
    for k in range(sides):
        sx, sy, sz, out = side_of(of_r, r, loop_r, sides, k, ref_is_b, x, y, z, work)
        count = clip_by_side(work, here, there, count, sx, sy, sz, out, float(CLIP + k))
        here, there = there, here
    name = (float(face) * FACE_NAMES + float(incident)) * 2.0 + (1.0 if ref_is_b else 0.0)
    kept, least = 0, math.inf
    edge = work[SECOND + CORNER * (count - 1) + 3] if count > 0 else 0.0
    for k in range(count):  # reads SECOND, writes from POINTS on, and stays behind
        at = SECOND + CORNER * k
        px, py, pz, before = work[at], work[at + 1], work[at + 2], edge
        edge = work[at + 3]
        gap = max((mx * px + my * py + mz * pz - c) / steep, s)  # SLACK reaches over the rim
        if gap <= margin:
            to = POINTS + POINT * kept
            work[to] = px - 0.5 * gap * x
            work[to + 1] = py - 0.5 * gap * y
            work[to + 2] = pz - 0.5 * gap * z
            work[to + 3] = gap
            work[to + 4] = (name * MOST + before) * MOST + edge
            kept += 1
            least = min(least, gap)
    return kept, least
