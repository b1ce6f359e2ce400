# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A capsule and ground of triangles, see `geometry.surfaces`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.surfaces.core_on_triangle import (
    axis_to_core,
    core_on_triangle,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.on_surface import (
    DEEP,
    surface_collider,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    FACET_OF,
    IS_GRAPH,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import FREE
from rigid_body_sim.physics.contact.collision.pairs import capsule_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH, RADIUS
from rigid_body_sim.physics.vectors import add_scaled, load

Array = NDArray[np.float64]


@kernel
def find_reach(parameters: Array, shape: int, poses: Array, place: int) -> Any:
    """Return the middle and the half edges of the AABB of a capsule [m]."""
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    axis = pose.axis(poses, place, 2)
    return load(poses, place), (
        radius + half * abs(axis[0]),
        radius + half * abs(axis[1]),
        radius + half * abs(axis[2]),
    )


@kernel
def collide_triangle(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int, plane: int,
    number: float, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """Add the contacts of a capsule with a triangle."""
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    least = -math.inf if parameters[surface + IS_GRAPH] != 0.0 else -DEEP * radius
    center, axis = load(poses, place), pose.axis(poses, place, 2)
    core_on_triangle(
        add_scaled(center, -half, axis), add_scaled(center, half, axis), radius, parameters,
        surface, row, plane, parameters[row + FACET_OF], FREE + number, least, found,
    )  # fmt: skip


@kernel
def find_axis(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Write the normal from a capsule to a triangle."""
    radius, half = parameters[shape + RADIUS], parameters[shape + HALF_LENGTH]
    center, axis = load(poses, place), pose.axis(poses, place, 2)
    return axis_to_core(
        add_scaled(center, -half, axis), add_scaled(center, half, axis), radius, parameters, row,
        margin, found,
    )  # fmt: skip


collide = surface_collider(
    'capsule', find_reach=find_reach, collide_plane=capsule_plane.collide,
    collide_triangle=collide_triangle, find_axis=find_axis,
)  # fmt: skip
