# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder on a plane, with its true round rim (`geometry.cylinders.rim`).

The lowest points of both ends are the lowest line of a lying cylinder, which rolls without bumps.
The lower end also has points a quarter turn to either side and, if the cylinder stands rather than
lies (`rim.lies`), one opposite: it rests on four points.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.rim import (
    lies,
    rim_directions,
    rim_feature,
)
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import one_of
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    MOST,
    RIM,
    SHAPE_A,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.geometry.touching_face import write_disc
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_LENGTH,
    NORMAL,
    OFFSET,
    RADIUS,
)
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, negate, scale, subtract

Array = NDArray[np.float64]

OPPOSITE = 3  # the last of the points of the lower end


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find up to four points of the rims of a cylinder near a plane; feature: see `rim`."""
    out = load(parameters, shape_b + NORMAL)
    return on_plane(
        parameters, shape_a, poses, pose_a, out, parameters[shape_b + OFFSET], margin, found
    )


@kernel
def on_plane(
    parameters: Array, shape: int, poses: Array, place: int, out: Any, offset: float,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Do so on the plane out . x = offset, out its unit normal in world axes."""
    center = load(poses, place)
    axis_x, axis_y = pose.axis(poses, place, 0), pose.axis(poses, place, 1)
    axis = pose.axis(poses, place, 2)
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    rise = dot(out, axis)
    height = dot(out, center) - offset
    # tau in the axes of the end: its component along a is exactly zero there
    tilt_x, tilt_y = dot(out, axis_x), dot(out, axis_y)
    sine = math.sqrt(tilt_x * tilt_x + tilt_y * tilt_y)
    lower = height - half * abs(rise)
    if not lower - radius * sine <= margin:
        return 0
    lowest, right, left, opposite = rim_directions(tilt_x, tilt_y, found)
    up_x, up_y, _ = lowest
    write_normal(found, negate(out))
    upper_end = rise < 0.0  # the end at +z is the lower one
    fall = radius * (tilt_x * up_x + tilt_y * up_y)
    other = lies(rise, sine, half, fall, lower, margin)
    count = 0
    for number in range(MOST):
        end = half if upper_end else -half
        x, y, fixed = one_of(number, lowest, right, left, opposite)
        to_x, to_y = -x, -y  # towards the point
        separation = lower + radius * (tilt_x * to_x + tilt_y * to_y)
        feature = rim_feature(number, fixed, upper_end)
        if number == OPPOSITE and other:
            end = -end
            to_x, to_y = -up_x, -up_y
            separation = lower + 2.0 * half * abs(rise) - fall
            feature = 1.0 - upper_end  # the lowest of the other end
        if not separation <= margin:
            continue
        on_rim = add_scaled(scale(end, axis), radius * to_x, axis_x)
        on_rim = add_scaled(on_rim, radius * to_y, axis_y)
        position = add(center, subtract(on_rim, scale(0.5 * separation, out)))
        write_point(found, count, position, separation, feature)
        count += 1
    if count == MOST and half * abs(rise) >= fall:  # what rolls on its rim has no face
        write_disc(found, radius, add_scaled(center, half if upper_end else -half, axis))
    found[RIM] = SHAPE_A
    return count
