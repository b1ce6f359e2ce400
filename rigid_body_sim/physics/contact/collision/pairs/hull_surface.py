# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A convex hull and ground of triangles, see `geometry.surfaces`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import CENTER, RADIUS
from rigid_body_sim.physics.contact.collision.geometry.surfaces.on_surface import surface_collider
from rigid_body_sim.physics.contact.collision.geometry.surfaces.polyhedron_on_triangle import (
    axis_to_triangle,
    polyhedron_on_triangle,
)
from rigid_body_sim.physics.contact.collision.pairs import hull_plane
from rigid_body_sim.physics.vectors import add, load

Array = NDArray[np.float64]


@kernel
def find_reach(parameters: Array, shape: int, poses: Array, place: int) -> Any:
    """Return the middle and the half edges of a box about the ball around a hull [m]."""
    center = pose.to_world(poses, place, load(parameters, shape + CENTER))
    radius = parameters[shape + RADIUS]
    return add(load(poses, place), center), (radius, radius, radius)


@kernel
def collide_triangle(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int, plane: int,
    number: float, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """Add the contacts of a hull with a triangle."""
    polyhedron_on_triangle(
        parameters, shape, parameters, surface, row, plane, number, poses, place, margin, along,
        found,
    )  # fmt: skip


@kernel
def find_axis(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Write the normal from a hull to a triangle."""
    return axis_to_triangle(
        parameters, shape, parameters, surface, row, poses, place, margin, found
    )


collide = surface_collider(
    'hull', find_reach=find_reach, collide_plane=hull_plane.collide,
    collide_triangle=collide_triangle, find_axis=find_axis,
)  # fmt: skip
