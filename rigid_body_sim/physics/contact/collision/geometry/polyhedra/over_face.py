# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A body over the middle of a face of a polyhedron: there the polyhedron is a half space.

It is where the ball about the body, seen along the normal of the face, lies within the face, and
its centre on the outside. So what rolls, tips and tumbles on a block of any shape does so as on a
plane, with all that the kernels of planes know (true rims, corners that come down).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    FACES,
    PLANE,
    PLANE_OFFSET,
    RADIUS,
    Hull,
    loop_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.vectors import add, cross, dot, load, subtract

Array = NDArray[np.float64]

NO_FACE = -1
LARGER = 2.0  # [-] times the ball a polyhedron must be, or none of its faces is larger


@kernel
def face_below(hull: Hull, poses: Array, place: int, center: Any, radius: float) -> int:
    """
    Return the face over whose middle a ball is, or NO_FACE.

    hull          : the polyhedron;   place : where its pose begins
    center, radius: of the ball, world axes [m]
    """
    numbers, begin = hull.numbers, hull.begin
    if not numbers[begin + RADIUS] > LARGER * radius:
        return NO_FACE
    local = pose.to_shape(poses, place, subtract(center, load(poses, place)))
    local = subtract(local, load(numbers, begin + CENTER))
    planes, best, face = planes_of(hull), 0.0, NO_FACE
    for number in range(int(numbers[begin + FACES])):
        plane = planes + PLANE * number
        height = dot(load(numbers, plane), local) - numbers[plane + PLANE_OFFSET]
        if height > best:
            best, face = height, number
    if face == NO_FACE:
        return NO_FACE
    normal, loop = load(numbers, planes + PLANE * face), loop_of(hull, face)
    corners = int(numbers[loop])
    last = vertex(hull, int(numbers[loop + corners]))
    for index in range(corners):
        corner = vertex(hull, int(numbers[loop + 1 + index]))
        edge = subtract(corner, last)
        inwards = dot(cross(normal, edge), subtract(local, last))
        if not inwards >= radius * math.sqrt(dot(edge, edge)):
            return NO_FACE
        last = corner
    return face


@inline
def plane_of(hull: Hull, face: int, poses: Array, place: int) -> Any:
    """Return unit normal and offset of the plane of a face, out . x = offset in world axes."""
    plane = planes_of(hull) + PLANE * face
    normal = load(hull.numbers, plane)
    out = pose.to_world(poses, place, normal)
    center = pose.to_world(poses, place, load(hull.numbers, hull.begin + CENTER))
    origin = add(load(poses, place), center)
    return out, hull.numbers[plane + PLANE_OFFSET] + dot(out, origin)
