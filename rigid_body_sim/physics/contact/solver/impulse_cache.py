# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the contacts of a tick leave to the next one; the list is described in `assembly`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.collider import POSE
from rigid_body_sim.physics.contact.collision.geometry.manifold import FEATURE
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT as FOUND_POINT
from rigid_body_sim.physics.contact.collision.narrow_phase import (
    BODY_A,
    COUNT,
    KEY,
    LANE,
    RECORD,
    RECORD_POINTS,
)
from rigid_body_sim.physics.contact.solver.assembly import (
    ANCHOR,
    FEAT,
    MEMORY,
    NORM,
    REMEMBERED,
    SLIP,
    TWIST,
    anchor_of,
)
from rigid_body_sim.physics.contact.solver.constraint import (
    APPROACH,
    BOUNCE,
    JN,
    JO,
    JQ,
    JR,
    JS,
    JT,
    MANIFOLD,
    T2,
    N,
    T,
)
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
    to = MEMORY
    for m in range(manifolds):
        o = m * RECORD
        count = int(records[o + COUNT])
        memory[to] = records[o + KEY]
        memory[to + 1] = float(count)
        to += 2
        place = int(records[o + LANE])
        pose = int(records[o + BODY_A]) * POSE
        for point in range(count):
            at_point = o + RECORD_POINTS + point * FOUND_POINT
            p = place + MANIFOLD + point * width
            # a point that bounced leaves: its friction would pull the body back for a substep
            left = rows[place + BOUNCE] > 0.0 and rows[p + APPROACH] < 0.0
            keep = 0.0 if left else lasting(rows, p)
            t, s = keep * rows[p + JT], keep * rows[p + JO]
            memory[to + FEAT] = records[at_point + FEATURE]
            memory[to + NORM] = keep * rows[p + JN]
            for axis in range(3):
                row = place + 8 * axis
                memory[to + SLIP + axis] = t * rows[row + T] + s * rows[row + T2]
                memory[to + TWIST + axis] = (
                    keep
                    * (
                        rows[p + JR] * rows[row + T]
                        + rows[p + JQ] * rows[row + T2]
                        + rows[p + JS] * rows[row + N]
                    )
                    if angular
                    else 0.0
                )
            x, y, z = anchor_of(
                poses, pose, records[at_point], records[at_point + 1], records[at_point + 2]
            )
            memory[to + ANCHOR] = x
            memory[to + ANCHOR + 1] = y
            memory[to + ANCHOR + 2] = z
            to += REMEMBERED


def end_of_memory(memory: Array) -> int:
    """Count the numbers of the memory that are in use."""
    end = MEMORY
    for _ in range(int(memory[1])):
        end += 2 + int(memory[end + 1]) * REMEMBERED
    return end
