# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A box as a record of `hull_records`, written on the fly where a box meets a polyhedron.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.polyhedra import hulls
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    HALF,
    PLANE,
    PLANE_OFFSET,
    PLANES,
    RADIUS,
    VERTEX,
    VERTICES,
    packed,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import BOX
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES
from rigid_body_sim.physics.vectors import dot, load

Array = NDArray[np.float64]

UNIT = packed(hulls.box((1.0, 1.0, 1.0)))
LENGTH = len(UNIT)
CORNERS, FACES = 8, 6
FIRST_OFFSET = int(UNIT[PLANES]) + PLANE_OFFSET


@kernel
def write_box(parameters: Array, box: int, work: Array) -> int:
    """Write the record of a box whose parameters begin at `box`; return where it begins."""
    half = load(parameters, box + HALF_EDGES)
    for number in range(LENGTH):
        work[BOX + number] = UNIT[number]
    for corner in range(CORNERS):
        place = BOX + VERTICES + VERTEX * corner
        work[place] *= half[0]
        work[place + 1] *= half[1]
        work[place + 2] *= half[2]
    for face in range(FACES):
        distance = half[0] if face < 2 else half[1] if face < 4 else half[2]
        work[BOX + FIRST_OFFSET + PLANE * face] = distance
    work[BOX + RADIUS] = math.sqrt(dot(half, half))
    work[BOX + HALF] = min(half[0], half[1], half[2])
    return BOX
