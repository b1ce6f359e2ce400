# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From the triangles of a convex surface to its polygons.

Neighbouring triangles whose corners lie in one plane, up to a tolerance, are joined, starting with
the largest: the plane of a sliver is round-off, the plane of its large neighbour is not.
The result is checked: each polygon is one simple loop, each edge has two faces, and
V - E + F = 2 (Euler).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model.plain_products import dot

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Topology:
    """
    How the points of a polyhedron are joined.

    loops : one array of point indices for each face, counter-clockwise seen from outside
    edges : (e, 4)  from point, to point, face on the left (outside, going along), face on the
            right
    near  : one array for each point: the points it is joined to
    """

    loops: tuple[Indices, ...]
    edges: Indices
    near: tuple[Indices, ...]

    @classmethod
    def of_loops(
        cls, loops: Sequence[Sequence[int]], n_points: int, *, also_near: Indices | None = None
    ) -> Topology:
        """
        Join points by the sides of faces.

        also_near : (k, 3) triangles whose sides, too, count for `near`
        ValueError if two faces disagree about a side.
        """
        left = {}
        for face, loop in enumerate(loops):
            for start, end in zip(loop, (*loop[1:], loop[0])):
                if (start, end) in left:
                    raise ValueError(f'two faces have the side {start}-{end} on the same hand')
                left[start, end] = face
        if any((end, start) not in left for start, end in left):
            raise ValueError('a side has only one face')
        edges = [
            (start, end, face, left[end, start])
            for (start, end), face in left.items()
            if start < end
        ]
        near: list[set[int]] = [set() for _ in range(n_points)]
        for start, end in left:
            near[start].add(end)
        for a, b, c in also_near.tolist() if also_near is not None else ():
            for start, end in ((a, b), (b, c), (c, a)):
                near[start].add(end)
                near[end].add(start)
        return cls(
            tuple(np.array(loop, dtype=np.int64) for loop in loops),
            np.array(edges, dtype=np.int64),
            tuple(np.array(sorted(around), dtype=np.int64) for around in near),
        )

    @property
    def is_sphere(self) -> bool:
        """Whether V - E + F = 2: a closed surface in one piece without a handle."""
        points = len(np.unique(np.concatenate(self.loops)))
        return points - len(self.edges) + len(self.loops) == 2


def polygons(
    points: Array, triangles: Indices, neighbours: Indices, tolerance: float
) -> Topology | None:
    """
    Join the triangles of a convex hull into polygons.

    points     : (n, 3) [m]
    triangles  : (m, 3)  in any orientation
    neighbours : (m, 3)  the triangle opposite each corner
    tolerance  : [m]     from the plane of a face
    Returns None if the triangles are no closed surface.
    """
    outward = _outward(points, triangles, neighbours)
    if outward is None:
        return None
    triangles = outward
    joined = _groups(points, triangles, neighbours, tolerance)
    for groups in (joined, np.arange(len(triangles))):  # if joining fails: as they are
        loops = _loops(triangles, groups)
        if loops is None:
            continue
        loops = _without_midpoints(points, loops, tolerance)
        try:
            topology = Topology.of_loops(loops, len(points), also_near=triangles)
        except ValueError:
            continue
        if topology.is_sphere:
            return topology
    return None


def _areas(points: Array, triangles: Indices) -> Array:
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def _outward(points: Array, triangles: Indices, neighbours: Indices) -> Indices | None:
    """Turn all triangles outward: the largest by its normal, each other by its neighbour."""
    areas = _areas(points, triangles)
    seed = int(np.argmax(np.sum(areas**2, axis=1)))
    middle = np.mean(points[np.unique(triangles)], axis=0)
    oriented = triangles.copy()
    if dot(points[triangles[seed, 0]] - middle, areas[seed]) < 0.0:
        oriented[seed] = oriented[seed, ::-1]
    done = {seed}
    waiting = [seed]
    while waiting:
        here = waiting.pop()
        a, b, c = oriented[here].tolist()
        sides = {(a, b), (b, c), (c, a)}
        for other in neighbours[here].tolist():
            if other in done:
                continue
            a, b, c = oriented[other].tolist()
            if sides & {(a, b), (b, c), (c, a)}:
                oriented[other] = oriented[other, ::-1]
            done.add(other)
            waiting.append(other)
    return oriented if len(done) == len(triangles) else None


def _groups(points: Array, triangles: Indices, neighbours: Indices, tolerance: float) -> Indices:
    """Number the planes: one number for each triangle."""
    areas = _areas(points, triangles)
    sizes = np.sqrt(np.sum(areas**2, axis=1))
    groups = np.full(len(triangles), -1)
    for seed in np.argsort(-sizes, kind='stable').tolist():
        if groups[seed] >= 0 or not sizes[seed] > 0.0:
            continue
        groups[seed] = seed
        normal = areas[seed] / sizes[seed]
        height = dot(points, normal)
        height = height - height[triangles[seed, 0]]
        waiting = [seed]
        while waiting:
            for other in neighbours[waiting.pop()].tolist():
                if groups[other] >= 0 or np.any(np.abs(height[triangles[other]]) > tolerance):
                    continue
                if dot(areas[other], normal) < -0.5 * sizes[other] and sizes[other] > tolerance:
                    continue  # the other side of a thin solid
                groups[other] = seed
                waiting.append(other)
    alone = groups < 0
    groups[alone] = np.flatnonzero(alone)
    return groups


def _loops(triangles: Indices, groups: Indices) -> list[list[int]] | None:
    """Return the rim of each group as one simple loop, or None if one is not."""
    owner = {}
    for triangle, (a, b, c) in enumerate(triangles.tolist()):
        for side in ((a, b), (b, c), (c, a)):
            if side in owner:
                return None
            owner[side] = int(groups[triangle])
    rims: dict[int, dict[int, int]] = {}
    for (start, end), group in owner.items():
        if (end, start) not in owner:
            return None
        if owner[end, start] != group:
            rim = rims.setdefault(group, {})
            if start in rim:
                return None
            rim[start] = end
    loops = []
    for group in sorted(rims):
        rim = rims[group]
        loop = [min(rim)]
        while rim[loop[-1]] != loop[0]:
            loop.append(rim[loop[-1]])
            if len(loop) > len(rim):
                return None
        if len(loop) != len(rim):
            return None
        loops.append(loop)
    return loops


def _without_midpoints(points: Array, loops: list[list[int]], tolerance: float) -> list[list[int]]:
    """Drop points that lie within an edge: they belong to two faces only, and to their line."""
    faces: dict[int, list[int]] = {}
    for face, loop in enumerate(loops):
        for point in loop:
            faces.setdefault(point, []).append(face)
    kept = [list(loop) for loop in loops]
    for point, owners in sorted(faces.items()):
        if len(owners) != 2 or min(len(kept[face]) for face in owners) <= 3:
            continue
        loop = kept[owners[0]]
        at = loop.index(point)
        before, after = points[loop[at - 1]], points[loop[(at + 1) % len(loop)]]
        along = after - before
        length = float(np.sqrt(dot(along, along)))
        off = np.cross(points[point] - before, along)
        if length > 0.0 and float(np.sqrt(dot(off, off))) <= tolerance * length:
            for face in owners:
                kept[face].remove(point)
    return kept
