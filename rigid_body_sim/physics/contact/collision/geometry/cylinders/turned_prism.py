# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The prism that stands for a cylinder where its rim meets something other than a face, turned about
the axis so that one of its edges looks along the normal.

The edges of the prism lie on the mantle, so its nearest point is then that of the cylinder, and it
rolls without bumps; where nothing looks along the normal the prism lies inside the cylinder and
holds nothing up that the cylinder would not. The normal is first found with the prism as it is;
what overlaps by more than DEEP stays so.

A normal on a rim lies in the plane of axis and point: else what has no friction would brake
or throw what spins. Where chords of prisms meet edges and corners it lies there up to their angle
with the rim, 11 degrees, and is turned into it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    BOTH,
    FACE_OF_A,
    FACE_OF_B,
    NEITHER,
    NORMAL,
    NORMAL_OWNER,
    OF_MANTLE,
    OF_NEAREST,
    POINT,
    POINTS,
    SEPARATION,
    SHAPE_A,
    SHAPE_B,
    TINY,
    TURNED,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import scratch
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import VERTICES
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    collide_records,
)
from rigid_body_sim.physics.vectors import (
    add_scaled,
    cross,
    dot,
    load,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]

ON_END = 0.05  # [-] sine of the angle between normal and axis: below, an end touches as it is
OFF = 1e-6  # [rad] beside the normal: so the two neighbours of that edge are never alike
# [m] beyond, its square loses digits or is infinite: the prism touches as it is
LEAST_RADIUS, MOST_RADIUS = 1e-150, 1e150
DEEP = 0.1  # [-] of the radius
ACROSS = 1e-3  # [-] sine of the angle between normal and mantle, below which that touches
MOST_TURNED = 0.9  # [-] cosine: more than chords are off the rim no normal is turned
SKEW = 0.01  # [-] squared sine of the angle between two axes, above which they make frames

turned = Record(begin=scratch.SIZE)
POSE_A = turned.numbers(pose.SIZE, '-', 'pose of A, turned')
POSE_B = turned.numbers(pose.SIZE, '-', 'pose of B, turned')


@inline
def copy_pose(poses: Array, source: int, found: Array, target: int) -> None:
    """Copy a pose into the scratch."""
    for entry in range(pose.SIZE):
        found[target + entry] = poses[source + entry]


@kernel
def turn_towards_normal(numbers: Array, begin: int, found: Array, place: int) -> bool:
    """
    Turn a prism about its axis until its first edge looks along the normal in `found`, or against
    it; tell whether it was turned.

        begin : where its record begins;  place : of its pose in `found`
    """
    normal = load(found, NORMAL)
    axis_x, axis_y = pose.axis(found, place, 0), pose.axis(found, place, 1)
    along_x, along_y = dot(normal, axis_x), dot(normal, axis_y)
    across = math.sqrt(along_x * along_x + along_y * along_y)
    if not across > ON_END:
        return False
    first_x, first_y, _ = load(numbers, begin + VERTICES)
    radius = math.sqrt(first_x * first_x + first_y * first_y)
    size = radius * across
    if not (LEAST_RADIUS < radius < MOST_RADIUS and found[POINTS + SEPARATION] > -DEEP * radius):
        return False
    along_x, along_y = along_x - OFF * along_y, along_y + OFF * along_x
    cosine = (along_x * first_x + along_y * first_y) / size
    sine = (along_y * first_x - along_x * first_y) / size
    stride = pose.ROW_Y - pose.ROW_X
    turned_x = add_scaled(scale(cosine, axis_x), sine, axis_y)
    turned_y = add_scaled(scale(cosine, axis_y), -sine, axis_x)
    store_strided(found, place + pose.ROW_X, stride, turned_x)
    store_strided(found, place + pose.ROW_X + 1, stride, turned_y)
    return True


@kernel
def collide_prisms(
    numbers_a: Array, hull_a: int, numbers_b: Array, hull_b: int, prism_a: bool, prism_b: bool,
    poses: Array, pose_a: int, pose_b: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the manifold of two records of which one, or both, stand for a cylinder.

        prism_a, prism_b : which; else see `two_polyhedra.collide_records`
    """
    count = collide_records(
        numbers_a, hull_a, numbers_b, hull_b, poses, pose_a, pose_b, margin, found
    )
    if count == 0:
        return 0
    copy_pose(poses, pose_a, found, POSE_A)
    copy_pose(poses, pose_b, found, POSE_B)
    turns_a = prism_a and turn_towards_normal(numbers_a, hull_a, found, POSE_A)
    turns_b = prism_b and turn_towards_normal(numbers_b, hull_b, found, POSE_B)
    if not (turns_a or turns_b):
        return count
    count = collide_records(
        numbers_a, hull_a, numbers_b, hull_b, found, POSE_A, POSE_B, margin, found
    )
    found[NORMAL_OWNER], found[TURNED] = _owner(turns_a, turns_b, found)
    if count > 0 and found[NORMAL_OWNER] == OF_NEAREST:
        _turn_into_axial_planes(turns_a, turns_b, count, found)
    return count


@inline
def _along_rim(place: int, point: Any, found: Array) -> Any:
    """Return the direction of the rim through a point [m]; place : of a pose in `found`."""
    return cross(pose.axis(found, place, 2), subtract(point, load(found, place)))


@inline
def _without(normal: Any, along: Any) -> Any:
    """Return a normal without its part along a rim."""
    square = dot(along, along)
    share = dot(normal, along) / square if square > TINY else 0.0
    return add_scaled(normal, -share, along)


@kernel
def _turn_into_axial_planes(turns_a: bool, turns_b: bool, count: int, found: Array) -> None:
    """Turn the normal into the planes of axis and deepest point of the prisms that were turned."""
    deepest = POINTS
    for place in range(POINTS, POINTS + POINT * count, POINT):
        if found[place + SEPARATION] < found[deepest + SEPARATION]:
            deepest = place
    normal, point = load(found, NORMAL), load(found, deepest)
    rim_a, rim_b = _along_rim(POSE_A, point, found), _along_rim(POSE_B, point, found)
    both, turned_normal = cross(rim_a, rim_b), normal
    if turns_a and turns_b and dot(both, both) > SKEW * dot(rim_a, rim_a) * dot(rim_b, rim_b):
        turned_normal = scale(1.0 if dot(both, normal) > 0.0 else -1.0, both)
    else:
        turned_normal = _without(turned_normal, rim_a) if turns_a else turned_normal
        turned_normal = _without(turned_normal, rim_b) if turns_b else turned_normal
    length = math.sqrt(dot(turned_normal, turned_normal))
    if length > 0.0 and dot(turned_normal, normal) > MOST_TURNED * length:
        store(found, NORMAL, scale(1.0 / length, turned_normal))


@inline
def _owner(turns_a: bool, turns_b: bool, found: Array) -> Any:
    """Tell whose the normal is, and who turns with it: none of the faces of a turned prism."""
    owner = found[NORMAL_OWNER]
    if turns_a and turns_b:
        axis_a, axis_b = pose.axis(found, POSE_A, 2), pose.axis(found, POSE_B, 2)
        normal, both = load(found, NORMAL), cross(axis_a, axis_b)
        lean = min(abs(dot(normal, axis_a)), abs(dot(normal, axis_b)))
        if lean < ACROSS and dot(both, both) > SKEW:
            return OF_MANTLE, BOTH
    elif turns_a and owner == FACE_OF_B:
        return FACE_OF_B, SHAPE_A
    elif turns_b and owner == FACE_OF_A:
        return FACE_OF_A, SHAPE_B
    return OF_NEAREST, NEITHER
