# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the contacts of a tick leave to the next one; the list is described in `assembly`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import collider, manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import cache_record, constraint, contact_point
from rigid_body_sim.physics.contact.solver.assembly import anchor_of
from rigid_body_sim.physics.contact.solver.warm_start import lasting

Array = NDArray[np.float64]


@kernel
def remember(
    manifolds: int, width: int, h: float, angular: bool, poses: Array, records: Array,
    rows: Array, memory: Array,
) -> None:  # fmt: skip
    """Write what the next tick starts from; poses are those at the start of this one."""
    memory[0] = h
    memory[1] = float(manifolds)
    to = cache_record.HEAD
    for m in range(manifolds):
        o = m * manifold_record.SIZE
        count = int(records[o + manifold_record.POINT_COUNT])
        memory[to] = records[o + manifold_record.PAIR_ID]
        memory[to + 1] = float(count)
        to += 2
        place = int(records[o + manifold_record.LANE])
        pose = int(records[o + manifold_record.COLLIDER_A]) * collider.POSE
        for point in range(count):
            at_point = o + manifold_record.POINTS + point * manifold.POINT
            p = place + constraint.SIZE + point * width
            # a point that bounced leaves: its friction would pull the body back for a substep
            left = (
                rows[place + constraint.RESTITUTION] > 0.0
                and rows[p + contact_point.APPROACH_VELOCITY] < 0.0
            )
            keep = 0.0 if left else lasting(rows, p)
            t, s = (
                keep * rows[p + contact_point.TANGENT_IMPULSE_1],
                keep * rows[p + contact_point.TANGENT_IMPULSE_2],
            )
            memory[to + cache_record.FEATURE] = records[at_point + manifold.FEATURE]
            memory[to + cache_record.NORMAL_IMPULSE] = (
                keep * rows[p + contact_point.NORMAL_IMPULSE]
            )
            for axis in range(3):
                row = place + 8 * axis
                memory[to + cache_record.FRICTION_IMPULSE + axis] = (
                    t * rows[row + constraint.TANGENT_1] + s * rows[row + constraint.TANGENT_2]
                )
                memory[to + cache_record.ANGULAR_IMPULSE + axis] = (
                    keep
                    * (
                        rows[p + contact_point.ROLLING_IMPULSE_1]
                        * rows[row + constraint.TANGENT_1]
                        + rows[p + contact_point.ROLLING_IMPULSE_2]
                        * rows[row + constraint.TANGENT_2]
                        + rows[p + contact_point.TWIST_IMPULSE] * rows[row + constraint.NORMAL]
                    )
                    if angular
                    else 0.0
                )
            x, y, z = anchor_of(
                poses, pose, records[at_point], records[at_point + 1], records[at_point + 2]
            )
            memory[to + cache_record.ANCHOR] = x
            memory[to + cache_record.ANCHOR + 1] = y
            memory[to + cache_record.ANCHOR + 2] = z
            to += cache_record.POINT_SIZE


def end_of_memory(memory: Array) -> int:
    """Count the numbers of the memory that are in use."""
    end = cache_record.HEAD
    for _ in range(int(memory[1])):
        end += 2 + int(memory[end + 1]) * cache_record.POINT_SIZE
    return end
