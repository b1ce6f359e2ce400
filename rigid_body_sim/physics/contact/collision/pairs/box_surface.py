# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A box, as a polyhedron, and ground of triangles, see `geometry.surfaces`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.aabb import extent
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.box_record import write_box
from rigid_body_sim.physics.contact.collision.geometry.surfaces.on_surface import surface_collider
from rigid_body_sim.physics.contact.collision.geometry.surfaces.polyhedron_on_triangle import (
    axis_to_triangle,
    polyhedron_on_triangle,
)
from rigid_body_sim.physics.contact.collision.pairs import box_plane
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_EDGES
from rigid_body_sim.physics.vectors import load

Array = NDArray[np.float64]


@kernel
def find_reach(parameters: Array, shape: int, poses: Array, place: int) -> Any:
    """Return the middle and the half edges of the AABB of a box [m]."""
    half = load(parameters, shape + HALF_EDGES)
    return load(poses, place), (
        extent(half, load(poses, place + pose.ROW_X)),
        extent(half, load(poses, place + pose.ROW_Y)),
        extent(half, load(poses, place + pose.ROW_Z)),
    )


@kernel
def collide_triangle(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int, plane: int,
    number: float, margin: float, along: Any, found: Array,
) -> None:  # fmt: skip
    """Add the contacts of a box with a triangle."""
    box = write_box(parameters, shape, found)
    polyhedron_on_triangle(
        found, box, parameters, surface, row, plane, number, poses, place, margin, along, found
    )


@kernel
def find_axis(
    parameters: Array, shape: int, poses: Array, place: int, surface: int, row: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Write the normal from a box to a triangle."""
    box = write_box(parameters, shape, found)
    return axis_to_triangle(found, box, parameters, surface, row, poses, place, margin, found)


collide = surface_collider(
    'box', find_reach=find_reach, collide_plane=box_plane.collide,
    collide_triangle=collide_triangle, find_axis=find_axis,
)  # fmt: skip
