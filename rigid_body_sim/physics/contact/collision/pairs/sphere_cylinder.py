# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a cylinder: the ball's centre and the nearest point of the cylinder.

Centre at the distance rho from the axis and the height z, in cylinder axes.
    outside : gap = |(max(rho - R, 0), z - clamp(z, -l, l))| - r
    inside  : gap = max(rho - R, |z| - l) - r, through the side or through the nearer end
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINTS,
    TINY,
    put_normal,
    put_point,
)

Array = NDArray[np.float64]

NEAR = 1e-8  # [-] squared distance from the axis / height: above, u leans by less than 1e-12


@kernel
def collide(
    numbers: Array, a: int, b: int, poses: Array, pa: int, pb: int, margin: float, found: Array
) -> int:
    """Find the point between a ball and a cylinder."""
    x, y, z = poses[pa], poses[pa + 1], poses[pa + 2]
    dx, dy, dz = x - poses[pb], y - poses[pb + 1], z - poses[pb + 2]
    bx, by, bz = poses[pb + 5], poses[pb + 8], poses[pb + 11]
    height = dx * bx + dy * by + dz * bz
    px, py, pz = dx - height * bx, dy - height * by, dz - height * bz
    squared = px * px + py * py + pz * pz
    rho = math.sqrt(squared)
    ux, uy, uz = poses[pb + 3], poses[pb + 6], poses[pb + 9]  # away from the axis
    if squared > TINY + NEAR * (height * height):
        ux, uy, uz = px / rho, py / rho, pz / rho
    elif squared > TINY:  # p has lost digits: once more across the axis
        along = px * bx + py * by + pz * bz
        px, py, pz = px - along * bx, py - along * by, pz - along * bz
        rho = math.sqrt(px * px + py * py + pz * pz)
        if rho * rho > 0.5 * squared:  # else it was round-off along the axis
            ux, uy, uz = px / rho, py / rho, pz / rho
    out = rho - numbers[b]
    above = height - clamp(height, numbers[b + 1])
    beside = out if out > 0.0 else 0.0
    squared = beside * beside + above * above
    distance = math.sqrt(squared)
    if squared > TINY:
        beside /= distance
        above /= distance
    else:
        distance, beside, above = out, 1.0, 0.0
        if abs(height) - numbers[b + 1] > out:
            distance, beside = abs(height) - numbers[b + 1], 0.0
            above = -1.0 if height < 0.0 else 1.0
    radius = numbers[a]
    gap = distance - radius
    if not gap <= margin:
        return 0
    nx = -(beside * ux + above * bx)
    ny = -(beside * uy + above * by)
    nz = -(beside * uz + above * bz)
    arm = radius + 0.5 * gap
    put_normal(found, nx, ny, nz)
    put_point(found, POINTS, x + arm * nx, y + arm * ny, z + arm * nz, gap, 0.0)
    return 1
