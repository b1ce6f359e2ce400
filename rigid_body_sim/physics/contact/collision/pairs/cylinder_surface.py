# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A cylinder and ground of triangles, see `geometry.surfaces`.

On a flat part it has its true rim; where it lies over the edge of a facet, that of its prism,
which bumps at its edges when it rolls.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import PRISM
from rigid_body_sim.physics.contact.collision.geometry.surfaces.on_surface import surface_collider
from rigid_body_sim.physics.contact.collision.geometry.surfaces.polyhedron_on_triangle import (
    axis_to_triangle,
    polyhedron_on_triangle,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    BY_FACES,
    MOST_SLOTS,
    SLOTS_USED,
)
from rigid_body_sim.physics.contact.collision.pairs import cylinder_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import (
    HALF_LENGTH,
    NORMAL,
    RADIUS,
)
from rigid_body_sim.physics.vectors import dot, load

Array = NDArray[np.float64]

LIES = (
    0.7  # [-] cosine between the axis and the normal of a face, below which a cylinder lies on it
)


@kernel
def find_reach(parameters: Array, shape: int, poses: Array, place: int) -> Any:
    """Return the middle and the half edges of the AABB of a cylinder [m]."""
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    axis = pose.axis(poses, place, 2)
    return load(poses, place), (
        half * abs(axis[0]) + radius * math.sqrt(max(1.0 - axis[0] * axis[0], 0.0)),
        half * abs(axis[1]) + radius * math.sqrt(max(1.0 - axis[1] * axis[1], 0.0)),
        half * abs(axis[2]) + radius * math.sqrt(max(1.0 - axis[2] * axis[2], 0.0)),
    )


@kernel
def collide_triangle(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int, plane: int,
    number: float, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """
    Add the contacts of the prism of a cylinder with a triangle; along its face only of one that
    stands: of one that lies the line on the plane of the face is known, and the prism is lower.
    """
    cosine = dot(pose.axis(poses, place, 2), load(parameters, plane + NORMAL))
    all_asked = found[SLOTS_USED] < MOST_SLOTS
    found[BY_FACES] = 0.0 if abs(cosine) < LIES and all_asked else 1.0
    polyhedron_on_triangle(
        parameters, shape + PRISM, parameters, surface, row, plane, number, poses, place, margin,
        along, found,
    )  # fmt: skip


@kernel
def find_axis(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Write the normal from a cylinder, by its prism, to a triangle."""
    return axis_to_triangle(
        parameters, shape + PRISM, parameters, surface, row, poses, place, margin, found
    )


collide = surface_collider(
    'cylinder', find_reach=find_reach, collide_plane=cylinder_plane.collide,
    collide_triangle=collide_triangle, find_axis=find_axis, lines=True,
)  # fmt: skip
