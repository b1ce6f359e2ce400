# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The mantle of a cylinder: that of the capsule about the same axis, which holds the cylinder.

So where the capsule of the axis (-l, l) touches along a normal n across the axis a, the cylinder
touches at the same points. Where n leans by a little, eps = n . a, the surface of the cylinder
along n is that of its mantle or its rim, at u = (n - eps a) / |n - eps a| from the axis,

    r (1 - sqrt(1 - eps^2)) below that of the capsule

A manifold of the capsule is changed so. It is not one of the mantle where n leans by more than
LEAN, nor where the two overlap by less along the axis: there an end is in between.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    Hull,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    support,
    vertices_of,
)
from rigid_body_sim.physics.vectors import add_scaled, dot, load, negate, scale, store, subtract

Array = NDArray[np.float64]

UNDECIDED = -1  # count that says: another kernel must find the points
LEAN = 0.02  # [-] largest eps; beyond, the points of the capsule lie too far from those of the rim

SHALLOW, ACROSS = 0.01, 1e-6  # [-] of the radius, of eps: what is deeper and leans is not decided


@kernel
def onto_mantle(
    found: Array, count: int, axis: Any, radius: float, is_a: bool, beyond: float
) -> int:
    """
    Change the manifold of a capsule into that of the cylinder about its axis.

        axis   : unit vector, world axes
        is_a   : whether it is A of the pair: the normal leaves it
        beyond : separation of the other shape from the ends, along the axis [m]
    Returns the number of points, or UNDECIDED where it is not a contact of the mantle.
    """
    outwards = load(found, NORMAL)
    if not is_a:
        outwards = negate(outwards)
    lean = dot(outwards, axis)
    if not abs(lean) <= LEAN:
        return UNDECIDED
    across = math.sqrt(1.0 - lean * lean)
    below = radius * lean * lean / (1.0 + across)
    direction = scale(1.0 / across, add_scaled(outwards, -lean, axis))
    shift = scale(radius, subtract(direction, outwards))
    shift = add_scaled(shift, 0.5 * below, outwards)
    for place in range(POINTS, POINTS + POINT * count, POINT):
        store(found, place, add_scaled(load(found, place), 1.0, shift))
        found[place + SEPARATION] += below
        gap = found[place + SEPARATION]
        if gap < min(beyond, 0.0) or (gap < -SHALLOW * radius and abs(lean) > ACROSS):
            return UNDECIDED
    return count


@kernel
def hull_beyond_ends(
    numbers: Array, begin: int, half: float, poses: Array, pose_cylinder: int, pose_hull: int
) -> float:
    """Separation of a record of `hull_records` from the ends of a cylinder, along its axis [m]."""
    hull = Hull(numbers, begin)
    axis = pose.axis(poses, pose_cylinder, 2)
    local = pose.to_shape(poses, pose_hull, axis)
    offset = dot(axis, subtract(load(poses, pose_hull), load(poses, pose_cylinder)))
    offset += dot(local, load(numbers, begin + CENTER))
    vertices = vertices_of(hull)
    highest = offset + dot(local, vertex(hull, support(vertices, local, 0)))
    lowest = offset + dot(local, vertex(hull, support(vertices, negate(local), 0)))
    return max(lowest, -highest) - half


@kernel
def round_beyond_ends(
    half: float, half_other: float, radius_other: float, is_capsule: bool, poses: Array,
    pose_cylinder: int, pose_other: int,
) -> float:  # fmt: skip
    """Do the same for another cylinder, or for a capsule [m]."""
    axis = pose.axis(poses, pose_cylinder, 2)
    cosine = dot(axis, pose.axis(poses, pose_other, 2))
    offset = dot(axis, subtract(load(poses, pose_other), load(poses, pose_cylinder)))
    across = 1.0 if is_capsule else math.sqrt(max(1.0 - cosine * cosine, 0.0))
    return abs(offset) - half - half_other * abs(cosine) - radius_other * across
