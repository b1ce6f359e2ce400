# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Meshes that are not convex: they collide as their hull, so they touch where they have no surface.

    defect = 1 - V_mesh / V_hull [-], `geometry.hulls.convexity_defect`

A defect of at most TOLERATED is that of a rounding that was cut into triangles, or of a nearly
flat dent; nothing is said of it.
"""

from __future__ import annotations

from rigid_body_sim.physics.contact.compound import solids
from rigid_body_sim.physics.model import Scene
from rigid_body_sim.physics.shapes import Mesh

TOLERATED = 0.01  # [-] of the hull; zero would name every scanned mesh


def hollow_meshes(scene: Scene) -> tuple[str, ...]:
    """Name the bodies whose mesh leaves more of its hull empty than is tolerated, a line each."""
    bodies: dict[int, list[str]] = {}
    meshes: dict[int, Mesh] = {}
    for body in scene.bodies:
        for shape in (solid.shape for solid in solids(body)):
            if isinstance(shape, Mesh):
                meshes[id(shape)] = shape
                bodies.setdefault(id(shape), []).append(body.name)
    if not meshes:
        return ()
    # Qhull takes a quarter of a second to import: only for the scenes that have a hull.
    from rigid_body_sim.physics.contact.geometry.hulls import convexity_defect

    found = []
    for key, mesh in meshes.items():
        defect = convexity_defect(mesh)
        if defect > TOLERATED:
            first, *others = bodies[key]
            more = f' ({len(others)} bod{"y" if len(others) == 1 else "ies"} more)'
            found.append(
                f'{first!r} collides as the convex hull of its mesh {mesh.name!r}, and '
                f'{100.0 * defect:.2g} % of this hull is outside the mesh: it will touch where it '
                'has no surface; make it a union of convex shapes, or accept it'
                + (more if others else '')
            )
    return tuple(found)
