# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rim of a cylinder near an edge or a corner of a polyhedron: the nearest points of both, exact.

Which edge or corner is nearest is that of the prism (GJK). Along it, x = p + t (q - p) in the axes
of the cylinder, the distance from the cylinder

    d = |(max(rho - r, 0), max(|z| - l, 0))|        rho distance from the axis

is convex: its least value is where its slope changes sign. A point of the rim is nearest where
both terms are positive; then the normal lies in the plane of axis and point, so that spin about
the axis does not move it.

An end that leans by a little over a tile is nearest where its rim crosses the edge of that, along
a normal of that edge alone. So, as between polyhedra (`two_polyhedra`), rim and edge must beat the
end, and the face of the polyhedron, by EDGE_LEAD of a half width.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.cylinders.mantle import UNDECIDED
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    EDGE_LEAD,
    NEITHER,
    NORMAL_OWNER,
    OF_NEAREST,
    TINY,
    TURNED,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import facing
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    HALF,
    PLANE,
    PRISM,
    RADIUS,
    Hull,
    loop_of,
    planes_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    from_b,
    point_of_b,
    relate,
    to_b,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.scratch import (
    OF_VERTEX_B,
    SIMPLEX,
    SIMPLEX_CORNER,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.support_points import (
    support,
    vertices_of,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import HALF_LENGTH
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS as RADIUS_OF_SIDE
from rigid_body_sim.physics.vectors import add, add_scaled, dot, load, negate, scale, subtract

Array = NDArray[np.float64]

INSIDE = 5e-3  # [-] of the radius: how deep the prism may lie inside the cylinder
HALVINGS = 50  # of an edge: to round-off
SHALLOW = 1e-9  # [-] of the radius: nearer to mantle or end the point is none of the rim
ON_RIM = 200.0  # feature
NEAREST = 1e-6  # [-] of the sizes: what another corner may be nearer
NONE = -1  # in place of a vertex


@inline
def way_from_rim(point: Any, radius: float, half: float) -> Any:
    """Return how far a point is beyond the mantle and beyond the end, and its way out of both."""
    across = math.sqrt(point[0] * point[0] + point[1] * point[1])
    beyond = across - radius if across > radius else 0.0
    above = abs(point[2]) - half if abs(point[2]) > half else 0.0
    share = beyond / across if across > 0.0 else 0.0
    rise = above if point[2] > 0.0 else -above
    return beyond, above, (share * point[0], share * point[1], rise)


@kernel
def least_way_from_rim(start: Any, edge: Any, radius: float, half: float) -> float:
    """Return where along an edge, 0 to 1, the distance from a cylinder is least; its axes."""
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        _, _, way = way_from_rim(add_scaled(start, middle, edge), radius, half)
        if dot(way, edge) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def _along_faces(hull: Hull, normal: Any, radius: float, half: float, found: Array) -> float:
    """
    Return the larger one of the separations along the end of the cylinder and along the face of
    the polyhedron that look along a normal most [m]; axes of the cylinder.
    """
    out = (0.0, 0.0, 1.0 if normal[2] > 0.0 else -1.0)
    lowest = vertex(hull, support(vertices_of(hull), to_b(found, negate(out)), 0))
    along_end = dot(out, point_of_b(found, lowest)) - half
    face = facing(hull, to_b(found, negate(normal)))
    inwards = from_b(found, negate(load(hull.numbers, planes_of(hull) + PLANE * face)))
    corner = vertex(hull, int(hull.numbers[loop_of(hull, face) + 1]))
    across = math.sqrt(inwards[0] * inwards[0] + inwards[1] * inwards[1])
    along_face = dot(inwards, point_of_b(found, corner))
    along_face -= radius * across + half * abs(inwards[2])
    return max(along_end, along_face)


@kernel
def rim_on_edge(
    parameters: Array, cylinder: int, numbers: Array, begin: int, poses: Array,
    pose_cylinder: int, pose_hull: int, margin: float, found: Array,
) -> int:  # fmt: skip
    """
    Find the point between a rim and an edge or corner of a record of `hull_records`, or return
    UNDECIDED; normal from the cylinder to the polyhedron, else see `manifold`.
    """
    prism, hull = Hull(parameters, cylinder + PRISM), Hull(numbers, begin)
    radius, half = parameters[cylinder + RADIUS_OF_SIDE], parameters[cylinder + HALF_LENGTH]
    size = parameters[cylinder + PRISM + RADIUS] + numbers[begin + RADIUS]
    relate((0.0, 0.0, 0.0), load(numbers, begin + CENTER), poses, pose_cylinder, pose_hull, found)
    reach = margin + INSIDE * radius
    state, corners = closest(vertices_of(prism), vertices_of(hull), reach, size, found)
    if state == FAR:
        return 0
    if state != GAP:
        return UNDECIDED
    first = int(found[SIMPLEX + OF_VERTEX_B])
    second = NONE
    for corner in range(1, corners):
        index = int(found[SIMPLEX + SIMPLEX_CORNER * corner + OF_VERTEX_B])
        if index != first and index != second:
            if second != NONE:
                return UNDECIDED
            second = index
    point = point_of_b(found, vertex(hull, first))
    if second != NONE:
        edge = subtract(point_of_b(found, vertex(hull, second)), point)
        share = least_way_from_rim(point, edge, radius, half)
        point = add_scaled(point, share, edge)
    beyond, above, way = way_from_rim(point, radius, half)
    if not (beyond > SHALLOW * radius and above > SHALLOW * radius):
        return UNDECIDED
    square = dot(way, way)
    if not square > TINY:
        return UNDECIDED
    gap = math.sqrt(square)
    normal = scale(1.0 / gap, way)
    nearest = point_of_b(
        found, vertex(hull, support(vertices_of(hull), to_b(found, negate(normal)), first))
    )
    if dot(normal, subtract(point, nearest)) > NEAREST * size:  # another part is nearer
        return UNDECIDED
    lead = EDGE_LEAD * min(parameters[cylinder + PRISM + HALF], numbers[begin + HALF])
    if _along_faces(hull, normal, radius, half, found) > gap - lead:
        return UNDECIDED
    if not gap <= margin:
        return 0
    write_normal(found, pose.to_world(poses, pose_cylinder, normal))
    found[NORMAL_OWNER], found[TURNED] = OF_NEAREST, NEITHER
    middle_point = add_scaled(point, -0.5, way)
    position = add(load(poses, pose_cylinder), pose.to_world(poses, pose_cylinder, middle_point))
    write_point(found, 0, position, gap, ON_RIM + (1.0 if point[2] > 0.0 else 0.0))
    return 1
