# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where body B stands as seen from body A, and the scratch the kernels of a pair share.

    x_A = t + Q x_B,   t = R_A^T (c_B - c_A),   Q = R_A^T R_B
        c : centre of a polyhedron, world; differences are taken first, so that a far origin costs
            no more digits than the poses have lost
        R : shape axes to world

Everything between two polyhedra is computed in the axes of A about its centre. The scratch is the
`found` array of the pair, beyond its results:

     24..35  FRAME    t, then Q row by row
     36..59  SIMPLEX  4 rows of 6: w (3), vertex of A, vertex of B, weight
             KNOWN    later up to 8 points w (3)
     60..68  NEAREST  v (3) from the nearest point of A to that of B; then both points
     69..77  AXIS     a normal that is not of a face, then the nearest points along it
     78..101 TURNED   KNOWN in the axes of B
    102..357 POINTS   polygons, lists, cores, points to choose from
    358..    SHAPE    the record of a box
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import NEAR

FRAME, SIMPLEX, NEAREST, AXIS, TURNED, POINTS, SHAPE = 24, 36, 60, 69, 78, 102, 358
KNOWN = SIMPLEX
ROW = 6  # [-] numbers of a row of the simplex


@kernel
def place(
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
    poses,
    pa: int,
    pb: int,
    work,
) -> None:
    """Write FRAME; (ax, ay, az), (bx, by, bz) [m]: the centres in the axes of their shapes."""
    dx = poses[pb] - poses[pa]
    dy = poses[pb + 1] - poses[pa + 1]
    dz = poses[pb + 2] - poses[pa + 2]
    dx += poses[pb + 3] * bx + poses[pb + 4] * by + poses[pb + 5] * bz
    dy += poses[pb + 6] * bx + poses[pb + 7] * by + poses[pb + 8] * bz
    dz += poses[pb + 9] * bx + poses[pb + 10] * by + poses[pb + 11] * bz
    dx -= poses[pa + 3] * ax + poses[pa + 4] * ay + poses[pa + 5] * az
    dy -= poses[pa + 6] * ax + poses[pa + 7] * ay + poses[pa + 8] * az
    dz -= poses[pa + 9] * ax + poses[pa + 10] * ay + poses[pa + 11] * az
    for i in range(3):
        m, n, o = poses[pa + 3 + i], poses[pa + 6 + i], poses[pa + 9 + i]
        work[FRAME + i] = m * dx + n * dy + o * dz
        for j in range(3):
            work[FRAME + 3 + 3 * i + j] = (
                m * poses[pb + 3 + j] + n * poses[pb + 6 + j] + o * poses[pb + 9 + j]
            )


@inline
def to_b(work, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Turn a direction from the axes of A into those of B."""
    return (
        work[FRAME + 3] * x + work[FRAME + 6] * y + work[FRAME + 9] * z,
        work[FRAME + 4] * x + work[FRAME + 7] * y + work[FRAME + 10] * z,
        work[FRAME + 5] * x + work[FRAME + 8] * y + work[FRAME + 11] * z,
    )


@inline
def from_b(work, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Turn a direction from the axes of B into those of A."""
    return (
        work[FRAME + 3] * x + work[FRAME + 4] * y + work[FRAME + 5] * z,
        work[FRAME + 6] * x + work[FRAME + 7] * y + work[FRAME + 8] * z,
        work[FRAME + 9] * x + work[FRAME + 10] * y + work[FRAME + 11] * z,
    )


@inline
def point_of_b(work, points, at: int) -> tuple[float, float, float]:
    """Return the point of B at points[at : at + 3] as seen from A."""
    x, y, z = points[at], points[at + 1], points[at + 2]
    return (
        work[FRAME] + (work[FRAME + 3] * x + work[FRAME + 4] * y + work[FRAME + 5] * z),
        work[FRAME + 1] + (work[FRAME + 6] * x + work[FRAME + 7] * y + work[FRAME + 8] * z),
        work[FRAME + 2] + (work[FRAME + 9] * x + work[FRAME + 10] * y + work[FRAME + 11] * z),
    )


@inline
def near_of(of, at: int) -> int:
    """Return where the neighbours of the vertices of a record are listed, or 0."""
    near = int(of[at + NEAR])
    return at + near if near > 0 else 0


@inline
def farthest(
    points, at: int, count: int, near: int, x: float, y: float, z: float, guess: int
) -> int:
    """
    Return the vertex that lies farthest along a direction.

    points[at : at + 3 count] : the vertices
    near                      : where their neighbours are listed; 0: look at each vertex
    guess                     : where to begin to climb
    """
    if near == 0:
        best = 0
        top = x * points[at] + y * points[at + 1] + z * points[at + 2]
        for i in range(1, count):
            k = at + 3 * i
            height = x * points[k] + y * points[k + 1] + z * points[k + 2]
            if height > top:
                top = height
                best = i
        return best
    best = guess
    k = at + 3 * best
    top = x * points[k] + y * points[k + 1] + z * points[k + 2]
    for _ in range(count):  # each step is higher: no vertex is met twice
        here = best
        for j in range(int(points[near + here]), int(points[near + here + 1])):
            i = int(points[near + j])
            k = at + 3 * i
            height = x * points[k] + y * points[k + 1] + z * points[k + 2]
            if height > top:
                top = height
                best = i
        if best == here:
            break
    return best
