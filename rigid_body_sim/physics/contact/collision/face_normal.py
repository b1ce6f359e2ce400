# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a normal is that of a flat face of a collider that moves: a side of a box or of a hull, an
end of a cylinder. Such a normal turns with the body (`solver.approach`).
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
from rigid_body_sim.physics.vectors import dot, load

ALIGNED = 1e-9  # [-] 1 - |cosine| of normals that count as one: 4e-5 rad


@kernel
def is_face_normal(collider: int, normal: Any, colliders: ColliderArrays) -> bool:
    """Tell whether a normal lies along that of a face of a collider, if it moves."""
    row = collider * collider_record.SIZE
    if colliders.table[row + collider_record.BODY] < 0:
        return False
    kind = colliders.table[row + collider_record.TYPE]
    if kind != BOX and kind != CYLINDER and kind != HULL:
        return False
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
    return most > 1.0 - ALIGNED
