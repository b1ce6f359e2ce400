# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Exact volume, centre and inertia of a solid bounded by triangles.

The solid is the signed sum of the tetrahedra from a reference point to each triangle (a, b, c):

    V = det(a, b, c) / 6,   integral x dV = V s / 4,   integral x x^T dV = V (a a^T + b b^T + c c^T
    + s s^T) / 20

with s = a + b + c. Source: Tonon, Explicit exact formulas for the 3-D tetrahedron inertia tensor,
J. Math. Stat. 1 (2005) 8. The reference point is the mean of the vertices, then the centre of
mass, so a far origin costs no digits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.plain_products import cross, dot, length

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

FLAT = 1e-12  # [-] volume / (area x extent) below which a solid is flat; round-off is near 1e-16
ROUND_OFF = (
    32 * np.finfo(np.float64).eps
)  # [-] products of inertia below this share of the trace are set to zero


def volume_integrals(
    vertices: Array, faces: Faces, *, name: str = 'the surface'
) -> tuple[float, Array, Array]:
    """
    Return volume [m^3], centre [m] and inertia per mass [m^2] about the centre.

    vertices : (n, 3) [m]
    faces    : (m, 3) int  closed surface, all outward or all inward (then it is turned)
    name     : what to call it in a refusal
    """
    origin = np.mean(vertices, axis=0)
    corners = (vertices - origin)[faces]
    volumes = _volumes(corners)
    volume = float(np.sum(volumes))
    _need_thickness(volume, corners, name=name)
    weights = np.repeat(volumes, 3)
    center = np.sum(weights[:, None] * corners.reshape(-1, 3), axis=0) / (4.0 * volume)
    corners = corners - center
    volumes = _volumes(corners)  # about the centre: the large terms that would cancel are gone
    total = np.sum(corners, axis=1)
    second = second_moments(np.repeat(volumes, 3), corners.reshape(-1, 3))
    second += second_moments(volumes, total)
    second /= 20.0 * volume
    inertia = np.trace(second) * np.eye(3) - second
    inertia[np.abs(inertia) <= ROUND_OFF * np.trace(inertia)] = (
        0.0  # a symmetric solid gets an exactly diagonal tensor
    )
    return abs(volume), origin + center, 0.5 * (inertia + inertia.T)


def second_moments(weights: Array, points: Array) -> Array:
    """Return the sum of w x x^T (3, 3) of weights (n,) and points (n, 3), first term first."""
    columns = [weights * points[:, j] for j in range(3)]
    rows = [
        [np.sum(columns[min(j, k)] * points[:, max(j, k)]) for k in range(3)] for j in range(3)
    ]
    return np.array(rows)


def hull_faces(vertices: Array) -> Faces:
    """Return the triangles of the convex hull, counter-clockwise seen from outside."""
    # A quarter of a second to import: only for the scenes that have a hull.
    from scipy.spatial import ConvexHull as QuickHull
    from scipy.spatial import QhullError

    shifted = vertices - np.mean(vertices, axis=0)
    try:
        hull = QuickHull(shifted)
    except (QhullError, ValueError) as error:
        raise InvalidModel(
            f'{len(vertices)} vertices span no volume; a convex hull needs at least four points '
            'that do not lie in one plane',
            at=('shape',),
        ) from error
    faces = hull.simplices.astype(np.int64)
    a, b, c = (shifted[faces[:, corner]] for corner in range(3))
    inward = dot(cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return faces


def need_closed(faces: Faces, *, name: str) -> None:
    """
    Refuse a surface with a hole, or with neighbours that disagree about the outside.

    Each edge must be met as often in one direction as in the other.
    """
    edges = np.concatenate((faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]))
    forward = np.where(edges[:, 0] < edges[:, 1], 1, -1)
    undirected, index = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    index = index.reshape(-1)
    is_real = undirected[:, 0] != undirected[:, 1]
    uses = np.bincount(index, minlength=len(undirected))
    single = int(np.sum((uses % 2 == 1) & is_real))
    if single:
        raise InvalidModel(
            f'mesh {name!r} is open: {single} edges belong to an odd number of triangles; '
            'only a closed surface has a volume: close the holes, or state '
            'mass, inertia and center_of_mass',
            at=('shape',),
        )
    balance = np.bincount(index, weights=forward, minlength=len(undirected))
    twisted = int(np.sum((balance != 0) & is_real))
    if twisted:
        raise InvalidModel(
            f'mesh {name!r}: the triangles at {twisted} edges disagree about the outside; '
            'orient all faces counter-clockwise seen from outside',
            at=('shape',),
        )


def _volumes(corners: Array) -> Array:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return dot(a, cross(b, c)) / 6.0


def _need_thickness(volume: float, corners: Array, *, name: str) -> None:
    edges = corners[:, 1:] - corners[:, :1]
    area = 0.5 * float(np.sum(length(cross(edges[:, 0], edges[:, 1]))))
    extent = float(np.max(np.abs(corners)))
    if not abs(volume) > FLAT * area * extent or not np.isfinite(volume):
        raise InvalidModel(
            f'{name} encloses {volume:.3g} m^3 with {area:.3g} m^2; a solid needs a finite volume '
            'above zero: give it thickness, or state mass, inertia and center_of_mass',
            at=('shape',),
        )
