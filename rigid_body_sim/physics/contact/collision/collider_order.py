# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The order of the colliders of a scene.

Contacts are solved one after the other, so their order shows in the result far above rounding. It
must not depend on how a scene lists its bodies: colliders are ordered once by their height against
gravity, then place, at the start; planes first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.collision.collider import PLANE, Colliders
from rigid_body_sim.physics.model.plain_products import dot
from rigid_body_sim.physics.model.scene import Scene

Indices = NDArray[np.int64]


@np.errstate(all='ignore')
def order(scene: Scene, colliders: Colliders) -> Indices:
    """Order of the colliders that does not depend on how the scene lists them."""
    indices = colliders.table[collider_record.SCENE_INDEX :: collider_record.SIZE]
    if not len(indices):
        return np.zeros(0, dtype=np.int64)
    starts = np.array([scene.bodies[i].initial.position for i in indices])
    velocities = np.array([scene.bodies[i].initial.velocity for i in indices])
    down = np.asarray(scene.gravity)
    height = -dot(starts, down)
    planes = colliders.types != PLANE
    moves = colliders.bodies >= 0
    keys = [
        *velocities.T,
        colliders.radius,
        colliders.types,
        starts[:, 1],
        starts[:, 0],
        starts[:, 2],
    ]
    return np.lexsort((*keys, height, moves, planes))
