# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The manifold of two convex polyhedra.

Apart, the nearest points (`gjk`) give gap and normal; overlapping, the axis of least overlap
(`separating_axes`) does. The face of each body that looks along the normal is clipped against the
other (`face_clipping`); where no face lies there, the nearest points themselves are the contact.

So that the normal does not jump to and fro between two equal choices, a face of B must beat the
faces of A by FACE_GAIN of a half width, and edges, corners or nearest points must beat the faces
by
EDGE_GAIN of it, plus EDGE_SHARE of the overlap: so much, at most, is a gap smaller, and a
depth larger, than the exact one. A corner of a round face that the patch lacks joins it when it is
deeper by DEEPER of a half width.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import (
    DEEPER,
    keep_extremes,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import (
    FACE_NAMES,
    MOST,
    across,
    facing,
    is_over,
    patch,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    COUNT,
    HALF,
    PLANES,
    RADIUS,
    VERTICES,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    AXIS,
    FRAME,
    NEAREST,
    POINTS,
    farthest,
    from_b,
    near_of,
    place,
    point_of_b,
    to_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.separating_axes import (
    NONE,
    OF_A,
    OF_B,
    best_edges,
    best_face,
    nearest_on_edges,
    separation,
)

FACE_GAIN = 1e-4  # [-] of the half width; 0: the reference face flickers between equal faces
EDGE_GAIN = 1e-3  # [-] of the half width; 0: a box on a box stands on an edge for a tick
EDGE_SHARE = 0.05  # [-] of the overlap
EXACT = 1e-9  # [-] of the half width: a patch this near to the gap holds the nearest points
LARGEST = 1e40  # [m] beyond, products of lengths overflow; such bodies never meet


@kernel
def collide_records(
    of_a, a: int, of_b, b: int, poses, pa: int, pb: int, margin: float, found
) -> int:
    """Find the manifold of two records of `hull_records`; see `manifold` for the arguments."""
    size = of_a[a + RADIUS] + of_b[b + RADIUS]
    k, m = a + CENTER, b + CENTER
    place(
        of_a[k], of_a[k + 1], of_a[k + 2], of_b[m], of_b[m + 1], of_b[m + 2], poses, pa, pb, found
    )
    x, y, z = found[FRAME], found[FRAME + 1], found[FRAME + 2]
    reach = size + margin
    if not (x * x + y * y + z * z <= reach * reach and size < LARGEST):
        return 0
    state, corners = closest(
        of_a,
        a + VERTICES,
        int(of_a[a + COUNT]),
        near_of(of_a, a),
        of_b,
        b + VERTICES,
        int(of_b[b + COUNT]),
        near_of(of_b, b),
        margin,
        size,
        found,
    )
    if state == FAR:
        return 0
    half = min(of_a[a + HALF], of_b[b + HALF])
    side, face, s = _axis(of_a, a, of_b, b, state, corners, half, found)
    if not s <= margin:
        return 0
    count = _patch(of_a, a, of_b, b, side, face, s, state, margin, half, found)
    to_world(of_a[k], of_a[k + 1], of_a[k + 2], poses, pa, found, count)
    return count


@kernel
def _axis(
    of_a, a: int, of_b, b: int, state: int, corners: int, half: float, work
) -> tuple[int, int, float]:
    """Choose the normal: of a face of A or B, or (NONE) the one at AXIS; return also s."""
    if state == GAP:
        return _axis_apart(of_a, a, of_b, b, half, work)
    side, face, s, known = best_face(of_a, a, of_b, b, work, corners, FACE_GAIN * half)
    floor = s + EDGE_GAIN * half + EDGE_SHARE * abs(s)
    edge_a, edge_b, s_edge = best_edges(of_a, a, of_b, b, work, known, floor)
    if edge_a >= 0:
        nearest_on_edges(of_a, a, of_b, b, work, edge_a, edge_b)
        return NONE, 0, s_edge
    return side, face, s


@kernel
def _axis_apart(of_a, a: int, of_b, b: int, half: float, work) -> tuple[int, int, float]:
    """Take the normal of the face that looks along v best, if it separates as well as v."""
    d = nearest_to_axis(work)
    x, y, z = work[AXIS], work[AXIS + 1], work[AXIS + 2]
    winner, best, s, floor = NONE, 0, d, d - EDGE_GAIN * half
    for side in range(OF_A, OF_B + 1):
        is_b = side == OF_B
        of, at = (of_b, b) if is_b else (of_a, a)
        tx, ty, tz = x, y, z
        if is_b:
            tx, ty, tz = to_b(work, -x, -y, -z)
        face = facing(of, at, tx, ty, tz)
        k = at + int(of[at + PLANES]) + 4 * face
        tx, ty, tz = of[k], of[k + 1], of[k + 2]
        if is_b:
            tx, ty, tz = from_b(work, -tx, -ty, -tz)
        along, _, _ = separation(of_a, a, of_b, b, work, tx, ty, tz, 0 * face, 0 * face)
        if along > floor:
            winner, best, s, floor = side, face, along, along + FACE_GAIN * half
    return winner, best, s


@inline
def nearest_to_axis(work) -> float:
    """Copy normal and points of NEAREST to AXIS; return the distance."""
    x, y, z = work[NEAREST], work[NEAREST + 1], work[NEAREST + 2]
    d = math.sqrt(x * x + y * y + z * z)
    work[AXIS], work[AXIS + 1], work[AXIS + 2] = x / d, y / d, z / d
    for c in range(3, 9):
        work[AXIS + c] = work[NEAREST + c]
    return d


@kernel
def _patch(
    of_a,
    a: int,
    of_b,
    b: int,
    side: int,
    face: int,
    s: float,
    state: int,
    margin: float,
    half: float,
    work,
) -> int:
    """
    Write the normal and the points of the manifold, axes of A; return their number.

    The point of least gap is among them. Where the patch lacks it, the nearest points are added,
    or for the overlap along a face its deepest corner, unless that hangs over the rim and the
    patch is as deep but for the gains.
    """
    is_b = side == OF_B
    of_r, r, of_i, i = (of_b, b, of_a, a) if is_b else (of_a, a, of_b, b)
    x, y, z = work[AXIS], work[AXIS + 1], work[AXIS + 2]
    if side == NONE:
        face = facing(of_a, a, x, y, z)
    else:
        k = r + int(of_r[r + PLANES]) + 4 * face
        x, y, z = of_r[k], of_r[k + 1], of_r[k + 2]
        if is_b:
            x, y, z = from_b(work, x, y, z)
    sign = -1.0 if is_b else 1.0
    work[0], work[1], work[2] = sign * x, sign * y, sign * z
    tx, ty, tz = -x, -y, -z
    if not is_b:
        tx, ty, tz = to_b(work, tx, ty, tz)
    other = facing(of_i, i, tx, ty, tz)
    count, least = patch(of_r, r, face, of_i, i, other, is_b, x, y, z, s, margin, work)
    gap = s
    px = py = pz = 0.0
    if side == NONE or state == GAP:
        gap = nearest_to_axis(work) if state == GAP else s
        px = 0.5 * (work[AXIS + 3] + work[AXIS + 6])
        py = 0.5 * (work[AXIS + 4] + work[AXIS + 7])
        pz = 0.5 * (work[AXIS + 5] + work[AXIS + 8])
        missing = True
    else:
        k = (
            i
            + VERTICES
            + 3
            * farthest(
                of_i, i + VERTICES, int(of_i[i + COUNT]), near_of(of_i, i), tx, ty, tz, 0 * face
            )
        )
        px, py, pz = of_i[k], of_i[k + 1], of_i[k + 2]
        if not is_b:
            px, py, pz = point_of_b(work, of_i, k)
        missing = least > s + EDGE_GAIN * half + EDGE_SHARE * abs(s) or is_over(
            of_r, r, face, is_b, x, y, z, px, py, pz, work
        )
        px, py, pz = px - 0.5 * s * x, py - 0.5 * s * y, pz - 0.5 * s * z
    enough = gap + (EXACT if side == NONE else DEEPER) * half
    if missing and gap <= margin and not least <= enough:
        to = POINTS + POINT * count
        work[to], work[to + 1], work[to + 2], work[to + 3] = px, py, pz, gap
        work[to + 4] = -1.0 - (float(face) * FACE_NAMES + float(other)) * (2.0 * MOST * MOST)
        count += 1
    x, y, z = across(of_r, r, face, is_b, work)
    return keep_extremes(work, POINTS + 0 * face, count, x, y, z)


@kernel
def to_world(cx: float, cy: float, cz: float, poses, pa: int, found, count: int) -> None:
    """Turn normal and points from the axes of A about its centre (cx, cy, cz) to the world."""
    for c in range(count + 1):
        at = 0 if c == 0 else 3 + POINT * (c - 1)
        x, y, z = found[at], found[at + 1], found[at + 2]
        if c > 0:
            x, y, z = x + cx, y + cy, z + cz
        for i in range(3):
            p = pa + 3 + 3 * i
            turned = poses[p] * x + poses[p + 1] * y + poses[p + 2] * z
            found[at + i] = poses[pa + i] + turned if c > 0 else turned
