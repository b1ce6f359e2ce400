# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box as a record of `hull_records`, written on the fly where a box meets a polyhedron.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    HALF,
    PLANES,
    RADIUS,
    VERTICES,
    packed,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import SHAPE

UNIT = packed(hulls.box((1.0, 1.0, 1.0)))
LENGTH = len(UNIT)
CORNERS = 8
PLANE_LIST = int(UNIT[PLANES])


@kernel
def write_box(numbers, a: int, work) -> int:
    """Write the record of the box of half edges numbers[a : a + 3]; return where it begins."""
    x, y, z = numbers[a], numbers[a + 1], numbers[a + 2]
    for i in range(LENGTH):
        work[SHAPE + i] = UNIT[i]
    for i in range(CORNERS):
        k = SHAPE + VERTICES + 3 * i
        work[k] *= x
        work[k + 1] *= y
        work[k + 2] *= z
    for i in range(6):
        work[SHAPE + PLANE_LIST + 4 * i + 3] = x if i < 2 else y if i < 4 else z
    work[SHAPE + RADIUS] = math.sqrt(x * x + y * y + z * z)
    work[SHAPE + HALF] = min(x, y, z)
    return SHAPE + 0 * a  # a number known when compiling would make numba compile its users again
