# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball and a cylinder: the ball's centre and the nearest point of the cylinder.

Centre at the distance rho from the axis and the height z, in cylinder axes; separation
    outside : |(max(rho - R, 0), z - clamp(z, -l, l))| - r
    inside  : max(rho - R, |z| - l) - r, through the side or through the nearer end
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    TINY,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, divide, dot, load, negate, scale, subtract

Array = NDArray[np.float64]

OFF_AXIS = 1e-8  # [-] squared distance from the axis / height: above, u leans by less than 1e-12


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find the point between a ball and a cylinder."""
    center = load(poses, pose_a)
    offset = subtract(center, load(poses, pose_b))
    axis = pose.axis(poses, pose_b, 2)
    height = dot(offset, axis)
    across = subtract(offset, scale(height, axis))
    squared = dot(across, across)
    rho = math.sqrt(squared)
    outward = pose.axis(poses, pose_b, 0)  # u: away from the axis
    if squared > TINY + OFF_AXIS * (height * height):
        outward = divide(across, rho)
    elif squared > TINY:  # what is across has lost digits: once more across the axis
        across = subtract(across, scale(dot(across, axis), axis))
        rho = math.sqrt(dot(across, across))
        if rho * rho > 0.5 * squared:  # else it was round-off along the axis
            outward = divide(across, rho)
    half_length = parameters[shape_b + HALF_LENGTH]
    out = rho - parameters[shape_b + RADIUS]
    above = height - clamp(height, half_length)
    beside = out if out > 0.0 else 0.0
    squared = beside * beside + above * above
    distance = math.sqrt(squared)
    if squared > TINY:
        beside /= distance
        above /= distance
    else:
        distance, beside, above = out, 1.0, 0.0
        if abs(height) - half_length > out:
            distance, beside = abs(height) - half_length, 0.0
            above = -1.0 if height < 0.0 else 1.0
    radius = parameters[shape_a + RADIUS]
    separation = distance - radius
    if not separation <= margin:
        return 0
    normal = negate(add_scaled(scale(beside, outward), above, axis))
    arm = radius + 0.5 * separation
    write_normal(found, normal)
    write_point(found, 0, add_scaled(center, arm, normal), separation, 0.0)
    return 1
