# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a normal is that of a flat face of a collider that moves: a side of a box or of a hull, an
end of a cylinder. Such a normal turns with the body (`solver.approach`). And the face of a
polyhedron on which something lies that leans a little.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import collider_record, pose
from rigid_body_sim.physics.contact.collision.collider import BOX, CYLINDER, HULL, ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    FACES,
    PLANE,
    Hull,
    planes_of,
)
from rigid_body_sim.physics.vectors import dot, load, scale

ALIGNED = 1e-9  # [-] 1 - |cosine| of normals that count as one: 4e-5 rad
LIES = 5e-9  # [-] the same of what leans on a face by 1e-4 rad at most


@kernel
def along_face(collider: int, normal: Any, colliders: ColliderArrays) -> float:
    """
    Return the greatest |cosine| of a unit normal and those of the faces of a collider, 0 where it
    has none: the sides of a box or hull, the ends of a cylinder.
    """
    row = collider * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    if kind != BOX and kind != CYLINDER and kind != HULL:
        return 0.0
    local = pose.to_shape(colliders.poses, collider * pose.SIZE, normal)
    most = abs(local[2])
    if kind == BOX:
        most = max(most, abs(local[0]), abs(local[1]))
    elif kind == HULL:
        most = 0.0
        begin = colliders.table[row + collider_record.PARAMETERS]
        hull = Hull(colliders.parameters, begin)
        planes = planes_of(hull)
        for face in range(int(colliders.parameters[begin + FACES])):
            along = dot(load(colliders.parameters, planes + PLANE * face), local)
            most = max(most, abs(along))
    return most


@kernel
def is_face_normal(collider: int, normal: Any, colliders: ColliderArrays) -> bool:
    """Tell whether a normal lies along that of a face of a collider, if it moves."""
    if colliders.table[collider * collider_record.SIZE + collider_record.BODY] < 0:
        return False
    return along_face(collider, normal, colliders) > 1.0 - ALIGNED


@kernel
def face_beneath(collider: int, normal: Any, colliders: ColliderArrays) -> Any:
    """
    Return the outward normal of the face of a box or hull along which a unit normal lies, up to
    what leans on it; the normal itself, where there is no such face.
    """
    row, place = collider * collider_record.SIZE, collider * pose.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    local = pose.to_shape(colliders.poses, place, normal)
    if kind == BOX:
        for index in range(3):
            if abs(local[index]) > 1.0 - LIES:
                sign = 1.0 if local[index] > 0.0 else -1.0
                return scale(sign, pose.axis(colliders.poses, place, index))
    if kind == HULL:
        begin = colliders.table[row + collider_record.PARAMETERS]
        planes = planes_of(Hull(colliders.parameters, begin))
        for face in range(int(colliders.parameters[begin + FACES])):
            of_face = load(colliders.parameters, planes + PLANE * face)
            if dot(of_face, local) > 1.0 - LIES:
                return pose.to_world(colliders.poses, place, of_face)
    return normal
