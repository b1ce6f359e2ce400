# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The axis along which two convex polyhedra overlap least.

    s(n) = min_B n . x - max_A n . x        separation along n; negative: overlap
    s    = max over n of s(n)               among the normals of the faces of A and B, and the
    cross
                                            products of those edges of A and B whose arcs on the
                                            Gauss sphere cross

No search and no limit on the number of faces: what cannot win is dismissed by a few known points w
of M = B - A: the corners of the last simplex of `gjk`, which enclose the origin, then corners of M
around the best face. For each of them

    s(n) <= n . w

so a face whose n . w is below the best s found so far costs a few products, and so does an edge
when that holds at both ends of its arc for the same w (every normal between is a sum of both with
weights whose sum is at least one; valid for s <= 0). The axis of a pair of edges counts only after
its separation has been computed from all vertices, so a degenerate edge cannot invent one.

Source of the arc test: Gregorius, The separating axis test between convex polyhedra, GDC 2013.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import TINY
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    COUNT,
    EDGE_LIST,
    EDGES,
    FACES,
    LOOP,
    LOOPS,
    PLANES,
    VERTICES,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    AXIS,
    KNOWN,
    POINTS,
    ROW,
    SIMPLEX,
    TURNED,
    farthest,
    from_b,
    near_of,
    point_of_b,
    to_b,
)

NONE, OF_A, OF_B = 0, 1, 2
CHUNK = 256  # [-] edges of B that are tried together
PARALLEL = 1e-12  # [-] squared sine between edges below which their cross product is round-off


@inline
def _may_beat(work, at: int, known: int, x: float, y: float, z: float, most: float):
    """Tell whether n . w > most for all known points w."""
    for c in range(known):
        k = at + 3 * c
        if not x * work[k] + y * work[k + 1] + z * work[k + 2] > most:
            return False
    return True


@kernel
def know_simplex(work, corners: int) -> None:
    """Make the corners of the simplex the known points."""
    for c in range(corners):
        row, to, turned = SIMPLEX + ROW * c, KNOWN + 3 * c, TURNED + 3 * c
        x, y, z = work[row], work[row + 1], work[row + 2]
        work[to], work[to + 1], work[to + 2] = x, y, z
        work[turned], work[turned + 1], work[turned + 2] = to_b(work, x, y, z)


@kernel
def separation(
    of_a, a: int, of_b, b: int, work, x: float, y: float, z: float, i: int, j: int
) -> tuple[float, int, int]:
    """
    Return s(n) and the vertices of A and B that it lies between; axes of A.

    i, j : where to begin to look
    """
    i = farthest(of_a, a + VERTICES, int(of_a[a + COUNT]), near_of(of_a, a), x, y, z, i)
    bx, by, bz = to_b(work, -x, -y, -z)
    j = farthest(of_b, b + VERTICES, int(of_b[b + COUNT]), near_of(of_b, b), bx, by, bz, j)
    bx, by, bz = point_of_b(work, of_b, b + VERTICES + 3 * j)
    k = a + VERTICES + 3 * i
    return x * (bx - of_a[k]) + y * (by - of_a[k + 1]) + z * (bz - of_a[k + 2]), i, j


@kernel
def best_face_of(
    side: int, of_a, a: int, of_b, b: int, work, known: int, floor: float
) -> tuple[int, float, int, int]:
    """
    Find the face of A (or B) along whose normal the bodies are separated most.

    floor : [m]  only what is larger counts
    Returns its number, or -1, and s, and the vertices of A and B along its normal.
    """
    best, most, vertex_a, vertex_b = -1, floor, 0, 0
    of, at = (of_a, a) if side == OF_A else (of_b, b)
    planes = at + int(of[at + PLANES])
    faces = int(of[at + FACES])
    points, sign = (KNOWN, 1.0) if side == OF_A else (TURNED, -1.0)
    first, top = 0, -math.inf
    for f in range(faces):  # the likeliest first: it dismisses most of the others
        k = planes + 4 * f
        x, y, z = sign * of[k], sign * of[k + 1], sign * of[k + 2]
        least = math.inf
        for c in range(known):
            m = points + 3 * c
            least = min(least, x * work[m] + y * work[m + 1] + z * work[m + 2])
        if least > top:
            first, top = f, least
    i = j = 0
    for c in range(faces + 1):
        f = first if c == 0 else c - 1
        k = planes + 4 * f
        x, y, z = sign * of[k], sign * of[k + 1], sign * of[k + 2]
        if not _may_beat(work, points, known, x, y, z, most):
            continue
        if side == OF_B:
            x, y, z = from_b(work, x, y, z)
        s, i, j = separation(of_a, a, of_b, b, work, x, y, z, i, j)
        if s > most:
            best, most, vertex_a, vertex_b = f, s, i, j
    return best, most, vertex_a, vertex_b


@kernel
def best_face(
    of_a, a: int, of_b, b: int, work, corners: int, handicap: float
) -> tuple[int, int, float, int]:
    """
    Find the face of either body along whose normal they are separated most.

    corners  : of SIMPLEX
    handicap : [m]  by so much a face of B must beat the best of A
    Returns OF_A or OF_B, the number of the face, s, and the number of known points: around the
    best face four corners of M have joined them, so that little else can win.
    """
    know_simplex(work, corners)
    floor = -math.inf
    winner, face, most = NONE, -1, floor
    i = j = 0
    for side in range(OF_A, OF_B + 1):
        other, s, k, m = best_face_of(side, of_a, a, of_b, b, work, corners, floor)
        if other >= 0:
            winner, face, most = side, other, s
            floor = s + handicap
            i, j = k, m
    if winner == NONE:
        return winner, face, most, corners
    of, at = (of_a, a) if winner == OF_A else (of_b, b)
    loop = at + int(of[at + LOOPS]) + int(of[at + LOOP]) * face
    for c in range(4):
        k = int(of[loop + 1 + c * int(of[loop]) // 4])
        if winner == OF_A:
            i = k
        else:
            j = k
        x, y, z = point_of_b(work, of_b, b + VERTICES + 3 * j)
        m = a + VERTICES + 3 * i
        x, y, z = x - of_a[m], y - of_a[m + 1], z - of_a[m + 2]
        to, turned = KNOWN + 3 * (corners + c), TURNED + 3 * (corners + c)
        work[to], work[to + 1], work[to + 2] = x, y, z
        work[turned], work[turned + 1], work[turned + 2] = to_b(work, x, y, z)
    return winner, face, most, corners + 4


@inline
def _out(work, at: int, known: int, k: int, m: int, of, sign: float, floor: float):
    """Tell whether no normal on the arc between two faces can be better than the floor."""
    for c in range(known - 1, -1, -1):  # the corners around the best face dismiss most
        p = at + 3 * c
        x, y, z = work[p], work[p + 1], work[p + 2]
        if (
            sign * (x * of[k] + y * of[k + 1] + z * of[k + 2]) <= floor
            and sign * (x * of[m] + y * of[m + 1] + z * of[m + 2]) <= floor
        ):
            return True
    return False


@kernel
def best_edges(
    of_a, a: int, of_b, b: int, work, known: int, floor: float
) -> tuple[int, int, float]:
    """
    Find the edges of A and B along whose cross product the bodies are separated most.

    floor : [m]  only what is larger counts
    Returns their numbers, or -1, and s; AXIS holds the normal, axes of A. After `best_face`.
    """
    edge_a, edge_b, most = -1, -1, floor
    planes_a, planes_b = a + int(of_a[a + PLANES]), b + int(of_b[b + PLANES])
    list_a, list_b = a + int(of_a[a + EDGE_LIST]), b + int(of_b[b + EDGE_LIST])
    count_a, count_b = int(of_a[a + EDGES]), int(of_b[b + EDGES])
    done = 0
    i = j = 0
    while done < count_b:
        listed = 0
        low = min(most, 0.0)
        while done < count_b and listed < CHUNK:
            e = list_b + 4 * done
            k, m = planes_b + 4 * int(of_b[e + 2]), planes_b + 4 * int(of_b[e + 3])
            if not _out(work, TURNED, known, k, m, of_b, -1.0, low):
                work[POINTS + listed] = done
                listed += 1
            done += 1
        for f in range(count_a if listed > 0 else 0):
            e = list_a + 4 * f
            k, m = planes_a + 4 * int(of_a[e + 2]), planes_a + 4 * int(of_a[e + 3])
            if _out(work, KNOWN, known, k, m, of_a, 1.0, min(most, 0.0)):
                continue
            p, q = a + VERTICES + 3 * int(of_a[e]), a + VERTICES + 3 * int(of_a[e + 1])
            ux, uy, uz = to_b(
                work, of_a[q] - of_a[p], of_a[q + 1] - of_a[p + 1], of_a[q + 2] - of_a[p + 2]
            )
            lx, ly, lz = to_b(work, of_a[k], of_a[k + 1], of_a[k + 2])
            rx, ry, rz = to_b(work, of_a[m], of_a[m + 1], of_a[m + 2])
            cx, cy, cz = of_a[p], of_a[p + 1], of_a[p + 2]
            for h in range(listed):
                g = int(work[POINTS + h])
                e = list_b + 4 * g
                k, m = planes_b + 4 * int(of_b[e + 2]), planes_b + 4 * int(of_b[e + 3])
                left = ux * of_b[k] + uy * of_b[k + 1] + uz * of_b[k + 2]
                right = ux * of_b[m] + uy * of_b[m + 1] + uz * of_b[m + 2]
                if not left * right < 0.0:
                    continue
                p, q = b + VERTICES + 3 * int(of_b[e]), b + VERTICES + 3 * int(of_b[e + 1])
                vx, vy = of_b[q] - of_b[p], of_b[q + 1] - of_b[p + 1]
                vz = of_b[q + 2] - of_b[p + 2]
                over = rx * vx + ry * vy + rz * vz
                if not ((lx * vx + ly * vy + lz * vz) * over < 0.0 and left * over < 0.0):
                    continue
                x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
                xx = x * x + y * y + z * z
                uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
                if not xx > max(PARALLEL * uu * vv, TINY):
                    continue
                size = math.sqrt(xx)
                if x * (lx + rx) + y * (ly + ry) + z * (lz + rz) < 0.0:
                    size = -size
                x, y, z = from_b(work, x / size, y / size, z / size)
                bx, by, bz = point_of_b(work, of_b, p)
                if not x * (bx - cx) + y * (by - cy) + z * (bz - cz) > most:
                    continue
                s, i, j = separation(of_a, a, of_b, b, work, x, y, z, i, j)
                if s > most:
                    edge_a, edge_b, most = f, g, s
                    work[AXIS], work[AXIS + 1], work[AXIS + 2] = x, y, z
    return edge_a, edge_b, most


@kernel
def nearest_on_edges(of_a, a: int, of_b, b: int, work, edge_a: int, edge_b: int) -> None:
    """Write behind AXIS the points of two crossing edges that lie nearest to each other's line."""
    e, g = a + int(of_a[a + EDGE_LIST]) + 4 * edge_a, b + int(of_b[b + EDGE_LIST]) + 4 * edge_b
    p, q = a + VERTICES + 3 * int(of_a[e]), a + VERTICES + 3 * int(of_a[e + 1])
    px, py, pz = of_a[p], of_a[p + 1], of_a[p + 2]
    ux, uy, uz = of_a[q] - px, of_a[q + 1] - py, of_a[q + 2] - pz
    rx, ry, rz = point_of_b(work, of_b, b + VERTICES + 3 * int(of_b[g]))
    vx, vy, vz = point_of_b(work, of_b, b + VERTICES + 3 * int(of_b[g + 1]))
    vx, vy, vz = vx - rx, vy - ry, vz - rz
    dx, dy, dz = rx - px, ry - py, rz - pz
    uu, vv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    ud, vd = ux * dx + uy * dy + uz * dz, vx * dx + vy * dy + vz * dz
    det = uu * vv - uv * uv
    s = t = 0.5
    if det > PARALLEL * uu * vv:
        s = min(max((ud * vv - vd * uv) / det, 0.0), 1.0)
        t = min(max((ud * uv - vd * uu) / det, 0.0), 1.0)
    work[AXIS + 3], work[AXIS + 4], work[AXIS + 5] = px + s * ux, py + s * uy, pz + s * uz
    work[AXIS + 6], work[AXIS + 7], work[AXIS + 8] = rx + t * vx, ry + t * vy, rz + t * vz
