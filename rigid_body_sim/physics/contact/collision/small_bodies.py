# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bodies too small for the tick: free fall takes them too far in one.

    g dt^2 / 2 > FALLEN s    s: cube root of the volume of the box around the largest solid [m]

Ten cubes of two thirds of that size fall into disorder within seconds; larger ones stand, and so
do thin plates that are wide enough. What is alone rests as it should: of one body nothing is said.
"""

from __future__ import annotations

import math

import numpy as np

from rigid_body_sim.physics.contact.collision import bounds_record, collider_record
from rigid_body_sim.physics.contact.collision.collider import Colliders
from rigid_body_sim.physics.model.scene import Scene

FALLEN = 0.025  # [-] of the size. In 4 ms cubes of 2 mm fall by 0.039; of 3 mm, which stand, 0.026


def small_body_warnings(scene: Scene, colliders: Colliders) -> tuple[str, ...]:
    """Say that bodies are too small for the tick, if there are several."""
    gravity, dt = math.hypot(*scene.gravity), 1e-9 * scene.dt_ns
    least = 0.5 * gravity * dt * dt / FALLEN
    small = {index: size for index, size in _sizes(colliders).items() if 0.0 < size < least}
    if len(small) < 2 or math.isinf(least):
        return ()
    smallest = min(small, key=small.__getitem__)
    longest = math.sqrt(2.0 * FALLEN * small[smallest] / gravity)
    return (
        f'{scene.bodies[smallest].name!r} and {len(small) - 1} more are too small for ticks of '
        f'{dt:.3g} s: {small[smallest]:.2g} m large, they fall by more than {FALLEN:.1%} of that '
        f'in one, and stacks of them fall over; set dt to at most {0.95 * longest:.2g} s',
    )


def _sizes(colliders: Colliders) -> dict[int, float]:
    """Size of the largest solid of each body that moves, by its index in the scene [m]."""
    bounds = colliders.local_bounds.reshape(-1, bounds_record.SIZE)
    table = colliders.table.reshape(-1, collider_record.SIZE)
    edges = 2.0 * (
        bounds[:, bounds_record.bounds.span(bounds_record.HALF)]
        + bounds[:, [bounds_record.ROUNDING]]
    )
    found: dict[int, float] = {}
    for row, size in zip(table, np.cbrt(edges).prod(axis=1).tolist(), strict=True):
        if row[collider_record.BODY] >= 0:
            index = int(row[collider_record.SCENE_INDEX])
            found[index] = max(size, found.get(index, 0.0))
    return found
