# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Convex polyhedra: from points to vertices, polygons and edges.

The convex hull of points is found by Qhull, whose facets are triangles. Triangles in one plane are
joined into a polygon, because a false edge inside a flat side gives false contacts; then
V - E + F = 2 (Euler) holds for the polygons. Solids much thinner in one direction than in another
are stretched before (an affine map keeps the hull), so that Qhull sees a body of equal extents.

Where a rim of a cylinder meets something other than a face, an edge or a corner, it collides as a
prism of SIDES sides whose edges lie on the mantle, turned so that one of them is nearest
(`cylinders.turned_prism`); the middle of a side lies 0.48 % of the radius inside.

Source: Barber, Dobkin, Huhdanpaa, The quickhull algorithm, ACM Trans. Math. Softw. 22 (1996) 469.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.contact.collision.geometry.polyhedra.polygons import Topology, polygons
from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.plain_products import dot, length, product
from rigid_body_sim.physics.model.principal_axes import spread_axes
from rigid_body_sim.physics.model.shapes import Mesh
from rigid_body_sim.physics.model.volume_integrals import volume_integrals

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SIDES = 32  # [-] of the prism that stands for a cylinder
COPLANAR = 1e-9  # [-] of the extent: triangles this near to one plane are one polygon
FLATTEST = 1e-12  # [-] thickness / extent below which points span no solid
THIN = 1e-3  # [-] thickness / extent below which points are stretched before Qhull sees them
SAME_POINT = 1e-13  # [-] of the extent: points nearer than this are one
LEAST_AREA = 1e-300  # [-] of the square of its length: a smaller polygon has lost its normal


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """
    A convex polyhedron about the middle of its bounding box.

    center    : (3,) [m]     that middle, shape axes
    vertices  : (v, 3) [m]   from the centre
    planes    : (f, 4)       unit normal out of the solid [-], its distance from the centre [m]
    loops     : f arrays of vertex indices, counter-clockwise seen from outside
    edges     : (e, 4) int   from vertex, to vertex, face on the left, face on the right
    near      : v arrays of the vertices that share an edge or a triangle with a vertex
    """

    center: Array
    vertices: Array
    planes: Array
    loops: tuple[Indices, ...]
    edges: Indices
    near: tuple[Indices, ...]

    @property
    def radius(self) -> float:
        """Largest distance of a vertex from the centre [m]."""
        return float(np.max(length(self.vertices)))

    @property
    def half_width(self) -> float:
        """Half of the least distance between a face and what lies opposite [m]."""
        least = [np.min(dot(self.vertices, normal)) for normal in self.planes[:, :-1]]
        return 0.5 * float(np.min(self.planes[:, -1] - np.array(least)))

    @property
    def triangles(self) -> Indices:
        """The polygons as fans of triangles (m, 3), outward."""
        fans = [np.column_stack((np.full(len(o) - 2, o[0]), o[1:-1], o[2:])) for o in self.loops]
        return np.concatenate(fans)

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        corners = self.vertices[self.triangles]
        return float(np.sum(dot(corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))) / 6.0


_FOUND: WeakKeyDictionary[Mesh, Polyhedron] = WeakKeyDictionary()  # as long as the mesh is used


def hull(points: ArrayLike, *, name: str = 'convex hull') -> Polyhedron:
    """
    Return the convex hull of points.

    points : (n, 3) [m], finite, in any order; duplicates and points inside do not matter
    name   : for the message of InvalidModel, which is raised when the points span no solid: fewer
             than four, or all of them in one plane up to FLATTEST of their extent or up to the
             rounding of their coordinates
    """
    points = np.asarray(points, dtype=np.float64)
    with np.errstate(over='ignore', invalid='ignore'):
        low, high = np.min(points, axis=0), np.max(points, axis=0)
        extent = float(np.max(high - low))
    if not math.isfinite(extent) or not np.all(np.isfinite(points)):
        raise InvalidModel(f'{name}: coordinates reach beyond 1e308 m; use smaller ones')
    center = low + 0.5 * (high - low)
    unit = 2.0 ** math.floor(math.log2(extent)) if extent > 0.0 else 1.0  # exact to divide by
    scaled = _distinct((points - center) / unit, SAME_POINT * extent / unit)
    axes, spans = _spans(scaled)
    rounding = 4.0 * np.finfo(np.float64).eps * float(np.max(np.abs(points))) / unit
    if len(scaled) < 4 or not spans[2] > max(FLATTEST * spans[0], rounding):
        raise InvalidModel(
            f'{name}: {len(scaled)} distinct points span '
            f'{spans[0] * unit:.3g} x {spans[1] * unit:.3g} x {spans[2] * unit:.3g} m, no solid; '
            'a convex hull needs at least four points that do not lie in one plane'
        )
    tolerance = COPLANAR * min(spans[0], spans[2] * 1e6)
    topology = _topology(scaled, axes, spans, tolerance, name)
    return _polyhedron(center, scaled * unit, topology)


def hull_of_mesh(mesh: Mesh) -> Polyhedron:
    """Return the convex hull of a mesh; of one and the same mesh it is found once."""
    if mesh not in _FOUND:
        _FOUND[mesh] = hull(mesh.vertices, name=f'mesh {mesh.name!r}')
    return _FOUND[mesh]


def box(half_extents: ArrayLike) -> Polyhedron:
    """Return the cuboid of half extents (3,) [m] along the shape axes."""
    half = np.asarray(half_extents, dtype=np.float64)
    signs = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]) * 2.0 - 1.0
    loops = ((1, 3, 7, 5), (0, 4, 6, 2), (2, 6, 7, 3), (0, 1, 5, 4), (4, 5, 7, 6), (0, 2, 3, 1))
    return _polyhedron(np.zeros(3), signs * half, Topology.of_loops(loops, 8))


def prism(radius: float, half_length: float, *, sides: int = SIDES) -> Polyhedron:
    """Return the prism of equal sides about the z axis whose edges lie on the mantle."""
    turn = 2.0 * math.pi / sides
    angle = turn * (np.arange(sides) + 0.5)
    ring = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    top = np.column_stack((ring, np.full(sides, half_length)))
    bottom = np.column_stack((ring, np.full(sides, -half_length)))
    first = range(sides)
    around = [(sides + i, sides + (i + 1) % sides, (i + 1) % sides, i) for i in first]
    loops = (tuple(first), tuple(sides + i for i in reversed(first)), *around)
    topology = Topology.of_loops(loops, 2 * sides)
    return _polyhedron(np.zeros(3), np.concatenate((top, bottom)), topology)


def convexity_defect(mesh: Mesh) -> float:
    """
    Return the share of its convex hull that a mesh leaves empty [-].

    1 - V_mesh / V_hull: 0 for a convex mesh. The mesh collides as its hull, so a large value means
    that it touches where it has no surface.
    """
    solid = hull_of_mesh(mesh)
    volume, _, _ = volume_integrals(mesh.vertices, mesh.faces)
    return max(0.0, 1.0 - volume / solid.volume)


def _distinct(points: Array, distance: float) -> Array:
    """Keep one of the points that fall into the same cell of a fine grid, in their order."""
    cells = np.round(points / distance) if distance > 0.0 else points
    _, first = np.unique(cells, axis=0, return_index=True)
    return points[np.sort(first)]


def _spans(points: Array) -> tuple[Array, Array]:
    """
    Return the principal axes (columns) of a set of points and its extents along them, largest
    first.
    """
    axes = spread_axes(points - np.mean(points, axis=0))
    along = product(points, axes)
    spans = np.max(along, axis=0) - np.min(along, axis=0)
    order = np.argsort(-spans, kind='stable')
    return axes[:, order], spans[order]


def _topology(points: Array, axes: Array, spans: Array, tolerance: float, name: str) -> Topology:
    """Ask Qhull for the triangles, first as the points are, then stretched to equal extents."""
    # A quarter of a second to import: only for the scenes that have a hull.
    from scipy.spatial import ConvexHull, QhullError

    stretched = product(points, axes) / spans
    tries = [points, stretched] if spans[2] > THIN * spans[0] else [stretched]
    for coordinates in tries:
        try:
            found = ConvexHull(coordinates, qhull_options='Qt')
        except (QhullError, ValueError):
            continue
        triangles, neighbours = (np.array(x, np.int64) for x in (found.simplices, found.neighbors))
        topology = polygons(points, triangles, neighbours, tolerance)
        if topology is not None:
            return topology
    raise InvalidModel(
        f'{name}: no closed surface around {len(points)} points; they are too nearly in one plane '
        f'({spans[0]:.3g} : {spans[1]:.3g} : {spans[2]:.3g}): make the solid thicker'
    )


def _polyhedron(center: Array, points: Array, topology: Topology) -> Polyhedron:
    """Drop the points that no polygon uses, and compute the planes."""
    used = np.unique(np.concatenate(topology.loops))
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    vertices = points[used]
    loops = tuple(number[loop] for loop in topology.loops)
    edges = topology.edges.copy()
    edges[:, :2] = number[edges[:, :2]]
    near = tuple(number[topology.near[i]] for i in used)
    near = tuple(around[around >= 0] for around in near)
    normals = np.array([_normal(vertices[loop]) for loop in loops])
    offsets = np.array([np.max(dot(vertices, normal)) for normal in normals])
    return Polyhedron(center, vertices, np.column_stack((normals, offsets)), loops, edges, near)


def _normal(corners: Array) -> Array:
    """
    Return the unit normal of a polygon (Newell): its area vector, from its own middle.

    InvalidModel where it is narrower than 1e-300 of its length, and has no area in these numbers.
    """
    arms = corners - np.mean(corners, axis=0)
    arms = arms / np.max(np.abs(arms))
    area = np.sum(np.cross(arms, np.roll(arms, -1, axis=0)), axis=0)
    largest = float(np.max(np.abs(area)))
    if not largest > LEAST_AREA:
        raise InvalidModel(
            'polyhedron: a face narrower than 1e-300 of its length has no normal; make it wider'
        )
    area = np.ldexp(area, -math.frexp(largest)[1])  # exact, and now its square is no subnormal
    return area / length(area)
