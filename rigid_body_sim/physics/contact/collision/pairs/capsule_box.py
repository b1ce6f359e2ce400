# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A capsule and a box: the capsule's axis against the box.

In box axes the axis is p + t d, |t| <= l. Apart, the distance to the box is a convex function of t
whose square has a derivative that is linear between the points where the axis crosses the planes
of the sides: its zero is exact. Where the axis enters the box, the separating axis of largest
separation counts: three sides and three edges (cross products with d), an edge only where it wins
by EDGE_LEAD of the smallest half edge + EDGE_SHARE |s|.

Besides the nearest point, the ends of the stretch that lies over the same side or edge are points,
with their own true separations, so that a capsule can lie on a box.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.clamp import clamp
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    EDGE_SHARE,
    SCRATCH,
    SHORTEST,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_EDGES,
    HALF_LENGTH,
    RADIUS,
)
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, negate, subtract

Array = NDArray[np.float64]

ENTERED = 1e-9  # [-] of all sizes: nearer than this the axis counts as in the box
OVERHANG = 0.1  # [-] of the radius: how far beyond an edge the stretch reaches that lies on it
EQUAL_SEPARATION = 1e-6  # [-] of the radius: separations nearer than this are equal
ALONG_EDGE = 1e-3  # [-] sine of the angle below which the axis and an edge span no normal

NO_EDGE = -1  # a side separates most
NEAREST, LOW_END, HIGH_END = 0.0, 1.0, 2.0  # features

# scratch, box axes
scratch = Record(begin=SCRATCH)
MIDDLE = scratch.vector('m', 'p: middle of the capsule')
ALONG = scratch.vector('-', 'd: axis of the capsule')
HALF = scratch.vector('m', 'h: half edges of the box')
NORMAL = scratch.vector('-', 'n: normal out of the box')


@inline
def _slope(found: Array, along: float) -> Any:
    """Half the derivative of the squared distance to the box at p + t d."""
    total = 0.0
    for k in range(3):
        place = found[MIDDLE + k] + along * found[ALONG + k]
        total += found[ALONG + k] * (place - clamp(place, found[HALF + k]))
    return total


@inline
def _distance(found: Array, along: float) -> Any:
    """Distance of p + t d from the box."""
    total = 0.0
    for k in range(3):
        outside = found[MIDDLE + k] + along * found[ALONG + k]
        outside -= clamp(outside, found[HALF + k])
        total += outside * outside
    return math.sqrt(total)


@kernel
def _nearest(found: Array, half_length: float) -> Any:
    """Return t of the point of the axis that is nearest to the box."""
    low, high = -half_length, half_length
    at_low, at_high = _slope(found, low), _slope(found, high)
    if at_low >= 0.0:
        return low
    if at_high <= 0.0:
        return high
    for k in range(3):
        component = found[ALONG + k]
        if component == 0.0:
            continue
        for side in range(2):
            level = found[HALF + k] if side else -found[HALF + k]
            along = (level - found[MIDDLE + k]) / component
            if low < along < high:
                slope = _slope(found, along)
                if slope > 0.0:
                    high, at_high = along, slope
                elif slope < 0.0:
                    low, at_low = along, slope
                else:
                    return along
    return low - at_low / (at_high - at_low) * (high - low)  # a product of lengths might overflow


@kernel
def _entered(found: Array, half_length: float) -> Any:
    """
    Write the normal out of the box of the axis of largest separation.

    Returns the separation and t of the nearest point of an edge; for a side, t = infinity.
    """
    best, side = -math.inf, 0
    smallest = found[HALF]
    for k in range(3):
        smallest = min(smallest, found[HALF + k])
        separation = abs(found[MIDDLE + k]) - found[HALF + k] - half_length * abs(found[ALONG + k])
        if separation > best:
            best, side = separation, k
    largest, edge = best + EDGE_LEAD * smallest + EDGE_SHARE * abs(best), NO_EDGE
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        across_i, across_j = -found[ALONG + j], found[ALONG + i]
        length = math.sqrt(across_i * across_i + across_j * across_j)
        if length < ALONG_EDGE:
            continue
        separation = abs(found[MIDDLE + i] * across_i + found[MIDDLE + j] * across_j)
        separation -= found[HALF + i] * abs(across_i)
        separation = (separation - found[HALF + j] * abs(across_j)) / length
        if separation > largest:
            largest, edge = separation, k
    for k in range(3):
        found[NORMAL + k] = 0.0
    if edge == NO_EDGE:
        found[NORMAL + side] = -1.0 if found[MIDDLE + side] < 0.0 else 1.0
        return best, math.inf
    return largest, _at_edge(found, half_length, edge)


@inline
def _at_edge(found: Array, half_length: float, edge: int) -> Any:
    """Write the normal across the axis and an edge; return t where the two are nearest."""
    i, j = (edge + 1) % 3, (edge + 2) % 3
    across_i, across_j = -found[ALONG + j], found[ALONG + i]
    squared = across_i * across_i + across_j * across_j
    length = math.sqrt(squared)
    if found[MIDDLE + i] * across_i + found[MIDDLE + j] * across_j < 0.0:
        length = -length
    normal_i, normal_j = across_i / length, across_j / length
    found[NORMAL + i], found[NORMAL + j] = normal_i, normal_j
    # along the edge the two are as near as they look when seen along it
    edge_i = found[HALF + i] if normal_i > 0.0 else -found[HALF + i]
    edge_j = found[HALF + j] if normal_j > 0.0 else -found[HALF + j]
    along = found[ALONG + i] * (edge_i - found[MIDDLE + i]) + found[ALONG + j] * (
        edge_j - found[MIDDLE + j]
    )
    return clamp(along / squared, half_length)


@kernel
def _append(
    poses: Array, pose_b: int, found: Array, count: int, along: float, separation: float,
    radius: float, margin: float, feature: float,
) -> int:  # fmt: skip
    """Append the point between the axis at t and the box; return the new count."""
    if not separation <= margin:
        return count
    arm = radius + 0.5 * separation
    local = add_scaled(load(found, MIDDLE), along, load(found, ALONG))
    local = add_scaled(local, -arm, load(found, NORMAL))
    position = add(load(poses, pose_b), pose.to_world(poses, pose_b, local))
    write_point(found, count, position, separation, feature)
    return count + 1


@kernel
def _stretch(found: Array, half_length: float, facing: int, beyond: float) -> Any:
    """
    Return t of the two ends of the stretch of the axis that lies over the side or edge.

        facing : axis of the box along which the normal is longest
        beyond : how far beyond an edge the stretch may reach, per component of the normal [m]
    """
    low, high = -half_length, half_length
    for k in range(3):
        component = found[ALONG + k]
        if k == facing or component == 0.0:
            continue
        limit = found[HALF + k] + abs(found[NORMAL + k]) * beyond
        one = (-limit - found[MIDDLE + k]) / component
        two = (limit - found[MIDDLE + k]) / component
        low = max(low, min(one, two))
        high = min(high, max(one, two))
    return low, high


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find up to three points between capsule and box; feature: which it is."""
    offset = subtract(load(poses, pose_a), load(poses, pose_b))
    axis = pose.axis(poses, pose_a, 2)
    radius, half_length = parameters[shape_a + RADIUS], parameters[shape_a + HALF_LENGTH]
    size = half_length
    for k in range(3):
        axis_of_box = pose.axis(poses, pose_b, k)
        found[MIDDLE + k] = dot(offset, axis_of_box)
        found[ALONG + k] = dot(axis, axis_of_box)
        found[HALF + k] = parameters[shape_b + HALF_EDGES + k]
        size += parameters[shape_b + HALF_EDGES + k]
    nearest = _nearest(found, half_length)
    distance = _distance(found, nearest)
    if not distance - radius <= margin:
        return 0
    apart, at_edge = distance > max(ENTERED * size, SHORTEST), math.inf
    if apart:
        for k in range(3):
            outside = found[MIDDLE + k] + nearest * found[ALONG + k]
            found[NORMAL + k] = (outside - clamp(outside, found[HALF + k])) / distance
    else:
        distance, at_edge = _entered(found, half_length)
        if at_edge < math.inf:
            nearest = at_edge
    facing = 0
    for k in range(1, 3):
        if abs(found[NORMAL + k]) > abs(found[NORMAL + facing]):
            facing = k
    beyond = OVERHANG * radius + (distance if apart else 0.0)
    low, high = _stretch(found, half_length, facing, beyond)
    write_normal(found, negate(pose.to_world(poses, pose_b, load(found, NORMAL))))
    separation = distance - radius
    if at_edge < math.inf or not high - low > EQUAL_SEPARATION * size:
        return _append(poses, pose_b, found, 0, nearest, separation, radius, margin, NEAREST)
    if apart:
        at_low, at_high = _distance(found, low) - radius, _distance(found, high) - radius
    else:
        out = found[NORMAL + facing]
        level = out * found[MIDDLE + facing] - found[HALF + facing] - radius
        at_low = level + low * out * found[ALONG + facing]
        at_high = level + high * out * found[ALONG + facing]
    count = 0
    if apart and separation < min(at_low, at_high) - EQUAL_SEPARATION * radius:
        count = _append(poses, pose_b, found, count, nearest, separation, radius, margin, NEAREST)
    count = _append(poses, pose_b, found, count, low, at_low, radius, margin, LOW_END)
    return _append(poses, pose_b, found, count, high, at_high, radius, margin, HIGH_END)
