# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Ground of triangles as a record of numbers, for the kernels; built once, in world axes.

Behind the head stand four lists. Where one begins is counted from the start of the record.

    triangles : TRIANGLE each, in the order of a space-filling curve
    planes    : FACET each, one for each facet, all triangles that lie in one plane, up to
                FLAT_FACET of the extent, joined or not: see `facet`
    rings     : around each vertex, how many neighbours it has and where they are
    nodes     : NODE each, a bounding volume hierarchy: a complete binary tree of AABBs, node 1 the
                root, 2 n and 2 n + 1 the children of n, and LEAF triangles in each node of the
                last level

The order of the triangles is that of the Morton codes of their middles, so that what follows each
other lies together, and the tree needs no more than the order (Lauterbach and others, Fast BVH
construction on GPUs, 2009).

A facet has the mean plane of its triangles, weighted by area: what single precision has left of a
flat face is one face again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.errors import InvalidModel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

surface = Record()
COUNT = surface.number('-', 'triangles')
LEAVES = surface.number('-', 'nodes of the last level, a power of two')
TRIANGLES = surface.number('-', 'where the triangles begin')
PLANES = surface.number('-', 'where the planes begin')
NODES = surface.number('-', 'where the nodes begin: that of node 0, which does not exist')
IS_GRAPH = surface.number('-', '1: a height over some plane, so nothing lies behind it; 0: not')
FLATNESS = surface.number('m', 'what lies so near to a plane lies in it')
ASKED = surface.number('-', 'written: where the one triangle begins that is asked; 0: all are')
HEAD = surface.padding(8)

triangle = Record()
CORNERS = triangle.numbers(9, 'm', 'its corners, counter-clockwise seen from outside, world')
BEYOND = triangle.numbers(9, 'm', 'for each edge, the third corner of the neighbour there, world')
EDGE_KIND = triangle.numbers(3, '-', 'of the edge from this corner to the next one: see below')
OWNS_EDGE = triangle.numbers(3, '-', '1: of the two triangles at the edge this is the first')
OWNS_VERTEX = triangle.numbers(3, '-', '1: of the triangles at the corner this is the first')
RING = triangle.numbers(3, '-', 'where the ring of the corner begins')
NORMAL = triangle.vector('-', 'unit normal to the outside, world')
FACET_OF = triangle.number('-', 'number of its facet')
TRIANGLE = triangle.size

# kinds of an edge
CONCAVE, EVEN, CONVEX, BORDER = -1, 0, 1, 2

facet = Record()
FACET_NORMAL = facet.vector('-', 'unit normal of the plane, as `shape_parameters` have it')
FACET_OFFSET = facet.number('m', 'distance of the plane from the origin, along the normal')
FACET_LOW = facet.vector('m', 'low corner of the AABB of its triangles')
FACET_HIGH = facet.vector('m', 'high corner')
FACET = facet.size

node = Record()
LOW = node.vector('m', 'low corner of the AABB')
HIGH = node.vector('m', 'high corner')
NODE = node.size

LEAF = 4  # [-] triangles of a leaf: fewer, and the tree is deeper; more, and each visit is longer
FLAT_FACET = 2e-7  # [-] of the extent: single precision leaves 6e-8 of a coordinate
BITS = 20  # of a Morton code along each axis
ALIKE = 0.5  # [-] cosine: triangles that turn farther from each other are two sides of a fold
PLANE_ROUND_OFF = 1e-9  # [-] to which planes of triangles that share no edge are compared
LARGEST = 1e75  # [m] extent of ground: the square of an area is a number still


def record(vertices: Array, faces: Indices, *, name: str) -> Array:
    """
    Return the record of a surface.

    vertices : (n, 3) [m]  world
    faces    : (m, 3)      counter-clockwise seen from outside
    InvalidModel if no triangle has an area, or one that is no number.
    """
    vertices, index = _welded(vertices)
    faces = index[faces]
    extent = float(np.max(np.max(vertices, axis=0) - np.min(vertices, axis=0)))
    if not extent < LARGEST:
        raise InvalidModel(
            f'{name!r} is ground of {extent:g} m, of which no area can be told; check its units'
        )
    faces = _with_area(vertices, faces, extent, name=name)
    faces = faces[_along_curve(vertices[faces].mean(axis=1), extent)]
    corners = vertices[faces]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.sqrt(np.sum(areas * areas, axis=1))
    normals = areas / sizes[:, None]
    tolerance = FLAT_FACET * extent
    neighbours, beyond = _neighbours(faces, len(vertices))
    kinds = _kinds(vertices, corners, normals, neighbours, beyond, tolerance)
    facets, planes = _facets(corners, normals, sizes, neighbours, kinds, tolerance)
    planes = np.column_stack((planes, _boxes(facets, corners)))
    nodes, leaves = _nodes(corners)
    rings, ring_of = _rings(vertices, faces)
    count = len(faces)
    rows = np.zeros((count, TRIANGLE))
    rows[:, triangle.span(CORNERS)] = corners.reshape(count, 9)
    rows[:, triangle.span(BEYOND)] = vertices[beyond].reshape(count, 9)
    rows[:, triangle.span(EDGE_KIND)] = kinds
    rows[:, triangle.span(OWNS_EDGE)] = (neighbours < 0) | (np.arange(count)[:, None] < neighbours)
    first = np.full(len(vertices), count)
    np.minimum.at(first, faces.ravel(), np.repeat(np.arange(count), 3))
    rows[:, triangle.span(OWNS_VERTEX)] = first[faces] == np.arange(count)[:, None]
    rows[:, triangle.span(NORMAL)] = normals
    rows[:, FACET_OF] = facets
    of_triangles, of_planes, of_rings, of_nodes = HEAD + np.cumsum(
        [0, rows.size, planes.size, rings.size]
    )
    rows[:, triangle.span(RING)] = ring_of[faces] + of_rings
    head = np.zeros(HEAD)
    head[[COUNT, LEAVES, FLATNESS]] = count, leaves, tolerance
    head[IS_GRAPH] = np.all(normals @ areas.sum(axis=0) > 0.0)
    head[[TRIANGLES, PLANES, NODES]] = of_triangles, of_planes, of_nodes
    return np.concatenate((head, rows.ravel(), planes.ravel(), rings, nodes.ravel()))


def _welded(vertices: Array) -> tuple[Array, Indices]:
    """Make one of vertices at the same place; return them, and which each has become."""
    order = np.lexsort(vertices.T)
    ordered = vertices[order]
    fresh = np.ones(len(vertices), dtype=bool)
    fresh[1:] = np.any(ordered[1:] != ordered[:-1], axis=1)
    index = np.empty(len(vertices), dtype=np.int64)
    index[order] = np.cumsum(fresh) - 1
    return ordered[fresh], index


def _with_area(vertices: Array, faces: Indices, extent: float, *, name: str) -> Indices:
    """Leave out triangles that are only a line or a point."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    first, second, third = b - a, c - b, a - c
    areas = np.cross(first, second)
    longest = np.max([np.sum(side * side, axis=1) for side in (first, second, third)], axis=0)
    height = np.sqrt(np.sum(areas * areas, axis=1) / np.where(longest > 0.0, longest, 1.0))
    faces = faces[height > 1e-12 * extent]  # [m] of the triangle: lower is round-off
    if not len(faces):
        raise InvalidModel(f'{name!r} has no triangle with an area; ground needs one')
    return faces


def _along_curve(points: Array, extent: float) -> Indices:
    """Order points (n, 3) along a space-filling curve: by their Morton codes."""
    cells = (points - points.min(axis=0)) / (extent if extent > 0.0 else 1.0)
    cells = np.minimum((cells * (1 << BITS)).astype(np.uint64), np.uint64((1 << BITS) - 1))
    code = np.zeros(len(points), dtype=np.uint64)
    for axis in range(3):
        x = cells[:, axis]
        for shift, mask in (
            (32, 0x1F00000000FFFF),
            (16, 0x1F0000FF0000FF),
            (8, 0x100F00F00F00F00F),
            (4, 0x10C30C30C30C30C3),
            (2, 0x1249249249249249),
        ):  # two zeros between any two bits
            x = (x | (x << np.uint64(shift))) & np.uint64(mask)
        code |= x << np.uint64(axis)
    return np.argsort(code, kind='stable')


def _neighbours(faces: Indices, n_vertices: int) -> tuple[Indices, Indices]:
    """
    Find the triangle behind each edge (m, 3), -1: none; and its third corner.

    An edge from the corner of its number to the next one has a neighbour where exactly one other
    triangle goes the other way along it.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    key = np.minimum(start, end) * n_vertices + np.maximum(start, end)
    order = np.argsort(key, kind='stable')
    ordered = key[order]
    same = ordered[1:] == ordered[:-1]
    alone = ~np.concatenate(([False], same[:-1])) & ~np.concatenate((same[1:], [False]))
    pairs = np.flatnonzero(same & alone)
    first, second = order[pairs], order[pairs + 1]
    opposed = start[first] == end[second]
    first, second = first[opposed], second[opposed]
    other = np.full(len(key), -1)
    other[first], other[second] = second, first
    third = np.roll(faces, -2, axis=1).ravel()
    beyond = np.where(other >= 0, third[other], third)
    triangles = np.where(other >= 0, other // 3, -1)
    return triangles.reshape(-1, 3), beyond.reshape(-1, 3)


def _kinds(
    vertices: Array, corners: Array, normals: Array, neighbours: Indices, beyond: Indices,
    tolerance: float,
) -> Indices:  # fmt: skip
    """Tell what each edge is: by how high the neighbour's third corner lies over the plane."""
    heights = np.einsum('mek,mk->me', vertices[beyond] - corners[:, :1], normals)
    turned = np.einsum('mek,mk->me', normals[neighbours], normals)
    kinds = np.where(heights > tolerance, CONCAVE, np.where(heights < -tolerance, CONVEX, EVEN))
    kinds = np.where((kinds == EVEN) & (turned < 0.0), CONVEX, kinds)  # a thin sheet, folded
    return np.where(neighbours < 0, BORDER, kinds)


def _facets(
    corners: Array, normals: Array, sizes: Array, neighbours: Indices, kinds: Indices,
    tolerance: float,
) -> tuple[Indices, Array]:  # fmt: skip
    """Number the facets: one number for each triangle (m,), and their planes (f, FACET)."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = len(corners)
    triangle, edge = np.nonzero(kinds == EVEN)
    other = neighbours[triangle, edge]
    alike = np.sum(normals[triangle] * normals[other], axis=1) > ALIKE
    triangle, other = triangle[alike], other[alike]
    graph = coo_array((np.ones(len(triangle)), (triangle, other)), shape=(count, count))
    _, facets = connected_components(graph, directed=False)
    facets = _flat(facets, corners, normals, sizes, tolerance)
    planes = _planes(facets, corners, normals, sizes)
    # flush pieces that share no edge: equal planes
    scale = float(np.max(np.abs(corners)))
    rounded = np.round(planes / [*3 * [PLANE_ROUND_OFF], PLANE_ROUND_OFF * scale or 1.0])
    order = np.lexsort(rounded.T)
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = np.any(rounded[order][1:] != rounded[order][:-1], axis=1)
    joined = np.empty(len(order), dtype=np.int64)
    joined[order] = np.cumsum(fresh) - 1
    facets = joined[facets]
    return facets, _planes(facets, corners, normals, sizes)


def _planes(facets: Indices, corners: Array, normals: Array, sizes: Array) -> Array:
    """Give the mean plane of each facet: unit normal and offset."""
    count = int(facets.max()) + 1
    weights = np.bincount(facets, sizes, count)
    mean = np.stack(
        [np.bincount(facets, sizes * normals[:, axis], count) for axis in range(3)], axis=1
    )
    mean /= np.sqrt(np.sum(mean * mean, axis=1))[:, None]
    alone = np.bincount(facets, minlength=count)[facets] == 1
    mean[facets[alone]] = normals[alone]
    heights = np.einsum('mck,mk->m', corners, mean[facets]) / 3.0
    return np.column_stack((mean, np.bincount(facets, sizes * heights, count) / weights))


def _boxes(facets: Indices, corners: Array) -> Array:
    """Give the AABB of each facet (f, 6): low corner, high corner."""
    order = np.argsort(facets, kind='stable')
    starts = np.flatnonzero(np.diff(facets[order], prepend=-1))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts)
    return np.column_stack((low, np.maximum.reduceat(corners.max(axis=1)[order], starts)))


def _flat(
    facets: Indices, corners: Array, normals: Array, sizes: Array, tolerance: float
) -> Indices:
    """Take apart what bends from triangle to triangle, each by less than the tolerance."""
    planes = _planes(facets, corners, normals, sizes)
    own = planes[facets]
    off = np.abs(np.einsum('mck,mk->mc', corners, own[:, :-1]) - own[:, -1:]).max(axis=1)
    bent = np.zeros(len(planes), dtype=bool)
    bent[facets[off > tolerance]] = True
    singles = bent[facets]
    facets = np.where(singles, len(planes) + np.arange(len(facets)), facets)
    return np.unique(facets, return_inverse=True)[1].ravel()


def _nodes(corners: Array) -> tuple[Array, int]:
    """Give the AABBs of the tree (2 leaves, NODE), from node 0 on, and how many leaves it has."""
    leaves = 1
    while leaves * LEAF < len(corners):
        leaves *= 2
    nodes = np.empty((2 * leaves, NODE))
    low, high = node.span(LOW), node.span(HIGH)
    nodes[:, low], nodes[:, high] = np.inf, -np.inf
    starts = np.arange(0, len(corners), LEAF)
    last = nodes[leaves : leaves + len(starts)]
    last[:, low] = np.minimum.reduceat(corners.min(axis=1), starts)
    last[:, high] = np.maximum.reduceat(corners.max(axis=1), starts)
    level = leaves
    while level > 1:
        below = nodes[level : 2 * level].reshape(-1, 2, NODE)
        level //= 2
        nodes[level : 2 * level, low] = below[:, :, low].min(axis=1)
        nodes[level : 2 * level, high] = below[:, :, high].max(axis=1)
    return nodes, leaves


def _rings(vertices: Array, faces: Indices) -> tuple[Array, Indices]:
    """Give for each vertex the number and the places of its neighbours; and where that begins."""
    start = np.concatenate((faces.ravel(), np.roll(faces, -1, axis=1).ravel()))
    end = np.concatenate((np.roll(faces, -1, axis=1).ravel(), faces.ravel()))
    key = np.unique(start * len(vertices) + end)
    start, end = key // len(vertices), key % len(vertices)
    counts = np.bincount(start, minlength=len(vertices))
    sizes = 1 + 3 * counts
    begins = np.cumsum(sizes) - sizes
    rings = np.zeros(int(np.sum(sizes)))
    rings[begins] = counts
    rank = np.arange(len(start)) - np.repeat(np.cumsum(counts) - counts, counts)
    places = begins[start] + 1 + 3 * rank
    for axis in range(3):
        rings[places + axis] = vertices[end, axis]
    return rings, begins
