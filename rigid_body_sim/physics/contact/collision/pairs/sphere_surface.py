# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A ball and ground of triangles, see `geometry.surfaces`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
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
from rigid_body_sim.physics.contact.collision.pairs import sphere_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]


@kernel
def find_reach(parameters: Array, shape: int, poses: Array, place: int) -> Any:
    """Return the middle and the half edges of the AABB of a ball [m]."""
    radius = parameters[shape + RADIUS]
    return load(poses, place), (radius, radius, radius)


@kernel
def collide_triangle(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int, plane: int,
    number: float, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """Add the contacts of a ball with a triangle."""
    radius = parameters[shape + RADIUS]
    least = -math.inf if parameters[surface + IS_GRAPH] != 0.0 else -DEEP * radius
    center = load(poses, place)
    core_on_triangle(
        center, center, radius, parameters, surface, row, plane, parameters[row + FACET_OF],
        FREE + number, least, found,
    )  # fmt: skip


@kernel
def find_axis(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Write the normal from a ball to a triangle."""
    center = load(poses, place)
    return axis_to_core(center, center, parameters[shape + RADIUS], parameters, row, margin, found)


collide = surface_collider(
    'sphere', find_reach=find_reach, collide_plane=sphere_plane.collide,
    collide_triangle=collide_triangle, find_axis=find_axis,
)  # fmt: skip
