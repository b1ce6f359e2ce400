# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Edges and corners of two boxes that are nearest to each other: one point.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.boxes.two_boxes import (
    FREE,
    HALF_A,
    HALF_B,
    MIDDLE,
    TURN,
    crossed,
)
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINTS,
    TINY,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

PARALLEL = 1e-6  # [-] sin^2 of the angle between edges below which they have no common normal
EDGES, CORNERS_A, CORNERS_B = 10000.0, 20000.0, 30000.0  # features: edge pairs, corners
BEST_A, BEST_B = FREE, FREE + 3  # nearest points of A and B from the middle of A, axes of A


@inline
def _put(
    poses: Array, pa: int, found: Array, nx: float, ny: float, nz: float, feature: float
) -> Any:
    """Write normal and point from axes of A into the world; return the gap, measured along n."""
    x = found[BEST_A] + found[BEST_B]
    y = found[BEST_A + 1] + found[BEST_B + 1]
    z = found[BEST_A + 2] + found[BEST_B + 2]
    gap = (
        nx * (found[BEST_B] - found[BEST_A])
        + ny * (found[BEST_B + 1] - found[BEST_A + 1])
        + nz * (found[BEST_B + 2] - found[BEST_A + 2])
    )
    rx, ry, rz = pa + 3, pa + 6, pa + 9
    put_normal(
        found,
        poses[rx] * nx + poses[rx + 1] * ny + poses[rx + 2] * nz,
        poses[ry] * nx + poses[ry + 1] * ny + poses[ry + 2] * nz,
        poses[rz] * nx + poses[rz + 1] * ny + poses[rz + 2] * nz,
    )
    put_point(
        found,
        POINTS,
        poses[pa] + 0.5 * (poses[rx] * x + poses[rx + 1] * y + poses[rx + 2] * z),
        poses[pa + 1] + 0.5 * (poses[ry] * x + poses[ry + 1] * y + poses[ry + 2] * z),
        poses[pa + 2] + 0.5 * (poses[rz] * x + poses[rz + 1] * y + poses[rz + 2] * z),
        gap,
        feature,
    )
    return gap


@kernel
def _nearest_on_lines(found: Array, i: int, j: int, to: int) -> Any:
    """
    Find the nearest points of the two edges along a_i and b_j that face each other most.

    Written at `to`: point of A (3), point of B (3), axes of A, unit normal from A to B (3).
    Returns the feature, negative if the nearest points of the lines lie beyond the edges' ends
    (then the points are those of the edges).
    """
    i1, i2 = (i + 1) % 3, (i + 2) % 3
    n1, n2 = -found[TURN + 3 * i2 + j], found[TURN + 3 * i1 + j]
    length = math.sqrt(n1 * n1 + n2 * n2)
    if n1 * found[MIDDLE + i1] + n2 * found[MIDDLE + i2] < 0.0:
        length = -length
    n1 /= length
    n2 /= length
    found[to + 6 + i] = 0.0
    found[to + 6 + i1] = n1
    found[to + 6 + i2] = n2
    up1, up2 = n1 > 0.0, n2 > 0.0
    found[to + i] = 0.0
    found[to + i1] = found[HALF_A + i1] if up1 else -found[HALF_A + i1]
    found[to + i2] = found[HALF_A + i2] if up2 else -found[HALF_A + i2]
    for k in range(3):
        found[to + 3 + k] = found[MIDDLE + k]
    number = 4.0 * i + 2.0 * up1 + up2
    for k in range(1, 3):
        m = (j + k) % 3
        up = n1 * found[TURN + 3 * i1 + m] + n2 * found[TURN + 3 * i2 + m] < 0.0
        h = found[HALF_B + m] if up else -found[HALF_B + m]
        for row in range(3):
            found[to + 3 + row] += h * found[TURN + 3 * row + m]
        number = 2.0 * number + up
    # nearest points x_A + alpha a_i, x_B + beta b_j
    rx, ry, rz = (
        found[to + 3] - found[to],
        found[to + 4] - found[to + 1],
        found[to + 5] - found[to + 2],
    )
    along_a = found[to + 3 + i] - found[to + i]
    along_b = rx * found[TURN + j] + ry * found[TURN + 3 + j] + rz * found[TURN + 6 + j]
    c = found[TURN + 3 * i + j]
    half_a, half_b = found[HALF_A + i], found[HALF_B + j]
    alpha = (along_a - c * along_b) / (length * length)
    beta = alpha * c - along_b
    if not (abs(alpha) <= half_a and abs(beta) <= half_b):
        number = -1.0 - number
        beta = clamp(clamp(alpha, half_a) * c - along_b, half_b)
        alpha = clamp(along_a + beta * c, half_a)
    found[to + i] += alpha
    for row in range(3):
        found[to + 3 + row] += beta * found[TURN + 3 * row + j]
    return 3.0 * number + j if number >= 0.0 else 3.0 * (number + 1.0) - j - 1.0


@kernel
def edge_contact(
    poses: Array, pa: int, margin: float, found: Array, i: int, j: int, across: bool
) -> int:
    """
    Find the point between the edges along a_i and b_j, which span the separating axis.

    across : report only edges that cross each other, seen along the normal
    """
    number = _nearest_on_lines(found, i, j, BEST_A)
    if number < 0.0:
        if across:
            return 0
        number = -1.0 - number
    normal = BEST_A + 6
    nx, ny, nz = found[normal], found[normal + 1], found[normal + 2]
    return 1 if _put(poses, pa, found, nx, ny, nz, EDGES + number) <= margin else 0


@inline
def _corner(found: Array, k: int, half: int) -> Any:
    """Corner k of the box whose half edges begin at `half`, its own axes."""
    return (
        found[half] if k & 1 else -found[half],
        found[half + 1] if k & 2 else -found[half + 1],
        found[half + 2] if k & 4 else -found[half + 2],
    )


@inline
def _keep(found: Array, ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> None:
    found[BEST_A] = ax
    found[BEST_A + 1] = ay
    found[BEST_A + 2] = az
    found[BEST_B] = bx
    found[BEST_B + 1] = by
    found[BEST_B + 2] = bz


@kernel
def nearest_points(poses: Array, pa: int, margin: float, found: Array) -> int:
    """
    Find the nearest points of two boxes that do not overlap; 0: farther apart than the margin.

    They are a corner and a box, or two edges that cross. Two edges span their own separating
    axis, so that of each pair of directions only one pair of edges can be nearest.
    """
    a, b = HALF_A, HALF_B
    least, feature = math.inf, 0.0
    for k in range(8):
        x, y, z = _corner(found, k, HALF_B)
        px = found[MIDDLE] + (found[TURN] * x + found[TURN + 1] * y + found[TURN + 2] * z)
        py = found[MIDDLE + 1] + (found[TURN + 3] * x + found[TURN + 4] * y + found[TURN + 5] * z)
        pz = found[MIDDLE + 2] + (found[TURN + 6] * x + found[TURN + 7] * y + found[TURN + 8] * z)
        qx, qy, qz = clamp(px, found[a]), clamp(py, found[a + 1]), clamp(pz, found[a + 2])
        dx, dy, dz = px - qx, py - qy, pz - qz
        squared = dx * dx + dy * dy + dz * dz
        if squared < least:
            least, feature = squared, CORNERS_B + k
            _keep(found, qx, qy, qz, px, py, pz)
    for k in range(8):
        x, y, z = _corner(found, k, HALF_A)
        ux, uy, uz = x - found[MIDDLE], y - found[MIDDLE + 1], z - found[MIDDLE + 2]
        px = found[TURN] * ux + found[TURN + 3] * uy + found[TURN + 6] * uz
        py = found[TURN + 1] * ux + found[TURN + 4] * uy + found[TURN + 7] * uz
        pz = found[TURN + 2] * ux + found[TURN + 5] * uy + found[TURN + 8] * uz
        dx = clamp(px, found[b]) - px
        dy = clamp(py, found[b + 1]) - py
        dz = clamp(pz, found[b + 2]) - pz
        squared = dx * dx + dy * dy + dz * dz
        if squared < least:
            least, feature = squared, CORNERS_A + k
            _keep(
                found,
                x,
                y,
                z,
                x + (found[TURN] * dx + found[TURN + 1] * dy + found[TURN + 2] * dz),
                y + (found[TURN + 3] * dx + found[TURN + 4] * dy + found[TURN + 5] * dz),
                z + (found[TURN + 6] * dx + found[TURN + 7] * dy + found[TURN + 8] * dz),
            )
    for i in range(3):
        for j in range(3):
            c = found[TURN + 3 * i + j]
            sine = 1.0 - c * c
            s = crossed(found, i, j)
            if sine < PARALLEL or not (s > 0.0 and s * s < least * sine):
                continue
            number = _nearest_on_lines(found, i, j, BEST_B + 3)
            if number >= 0.0:
                least, feature = s * s / sine, EDGES + number
                for k in range(6):
                    found[BEST_A + k] = found[BEST_B + 3 + k]
    nx = found[BEST_B] - found[BEST_A]
    ny = found[BEST_B + 1] - found[BEST_A + 1]
    nz = found[BEST_B + 2] - found[BEST_A + 2]
    squared = nx * nx + ny * ny + nz * nz
    distance = math.sqrt(squared)
    if squared < TINY or not distance <= margin:
        return 0
    nx, ny, nz = nx / distance, ny / distance, nz / distance
    return 1 if _put(poses, pa, found, nx, ny, nz, feature) <= margin else 0
