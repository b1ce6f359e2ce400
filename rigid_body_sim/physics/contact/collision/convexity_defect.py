# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The convexity defect of meshes: they collide as their hull, so one that is not convex touches where
it has no surface.

    defect = 1 - V_mesh / V_hull [-], `geometry.polyhedra.hulls.convexity_defect`

Of an open surface nobody knows the volume; that is said too. A defect of at most TOLERATED is that
of a rounding that was cut into triangles, or of a nearly flat dent; nothing is said of it.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.contact.collision.solids import solids
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.shapes import Mesh
from rigid_body_sim.physics.model.volume_integrals import need_closed

TOLERATED = 0.01  # [-] of the hull; zero would name every scanned mesh


def convexity_warnings(scene: Scene) -> tuple[str, ...]:
    """Name the bodies whose mesh leaves more of its hull empty than is tolerated, a line each."""
    bodies: dict[int, list[str]] = {}
    meshes: dict[int, Mesh] = {}
    for body in scene.bodies:
        for shape in (solid.shape for solid in solids(body)):
            if isinstance(shape, Mesh):
                meshes[id(shape)] = shape
                of_mesh = bodies.setdefault(id(shape), [])
                if body.name not in of_mesh[-1:]:  # parts of one body are together
                    of_mesh.append(body.name)
    found = []
    for key, mesh in meshes.items():
        defect = convexity_defect_of(mesh)
        if not defect <= TOLERATED:
            first, *others = bodies[key]
            more = f' ({len(others)} bod{"y" if len(others) == 1 else "ies"} more)'
            empty = (
                'as its surface encloses no volume, nobody knows how much of this hull is empty'
                if math.isnan(defect)
                else f'{100.0 * defect:.2g} % of this hull is outside the mesh'
            )
            found.append(
                f'{first!r} collides as the convex hull of its mesh {mesh.name!r}, and {empty}: '
                'it will touch where it has no surface; set as: parts, make it a union of convex '
                'shapes, or '
                'accept it' + (more if others else '')
            )
    return tuple(dict.fromkeys(found))  # parts that read the same file: one line


def convexity_defect_of(mesh: Mesh) -> float:
    """Tell what share of its hull a mesh leaves empty [-]; NaN where nobody knows."""
    # Qhull takes a quarter of a second to import: only for the scenes that have a hull.
    from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hulls import convexity_defect

    try:
        need_closed(mesh.faces, name=mesh.name)
        return convexity_defect(mesh)
    except InvalidModel:  # its mass and inertia are stated, not those of its surface
        return math.nan
