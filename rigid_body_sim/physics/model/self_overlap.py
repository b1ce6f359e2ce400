# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whether a closed surface counts some of its inside twice.

The volume integrals count each point as often as the surface winds about it: right for a surface
that bounds a solid (once inside, never outside), twice where faces stand twice or where parts of
one mesh reach into each other. The winding number of a point p is the sum of the solid angles of
the faces over 4 pi,

    tan(omega / 2) = det(a, b, c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|)

with a, b, c from p to the corners. On a face that bounds a solid the others sum to one half: one
inside and none outside, less the half that the face itself is. This is asked on points spread
evenly over the faces: an overlap smaller than their distances can stay unseen.
Source: Van Oosterom and Strackee, The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30
(1983); Jacobson, Kavan, Sorkine-Hornung, Robust inside-outside segmentation using generalized
winding numbers, ACM Trans. Graph. 32 (2013).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel

Array = NDArray[np.float64]
Faces = NDArray[np.int64]

WORK = 1_000_000  # [-] solid angles: a quarter of a second
BLOCK = 50_000  # [-] of them at once
MOST_POINTS = 2000
ON_A_FACE = (
    1e-6  # [rad] of a full half space: the point lies on another face, which side is chance
)
# even in the plane: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018
EVENLY = np.array([1.0 / 1.324717957244746, 1.0 / 1.324717957244746**2])


def need_single(vertices: Array, faces: Faces, *, name: str) -> None:
    """
    Refuse faces that stand twice, and a closed surface that passes through itself.

    vertices : (n, 3) [m]
    faces    : (m, 3) int
    """
    _need_no_twins(faces, name=name)
    with np.errstate(all='ignore'):
        corners = (vertices - np.mean(vertices, axis=0))[faces]
        corners = corners / np.max(np.abs(corners))
        if not np.all(np.isfinite(corners)) or not _areas(corners)[1][-1] > 0.0:
            return  # refused for having no volume
    points, own = _points(corners)
    size = max(1, BLOCK // len(corners))
    wound = np.concatenate(
        [
            _wound(corners, points[start : start + size], own[start : start + size])
            for start in range(0, len(points), size)
        ]
    )
    outward = 1.0 if np.nansum(wound) >= 0.0 else -1.0  # turned as a whole it is turned back
    inside = np.rint(outward * wound[np.isfinite(wound)] + 0.5)
    if np.any(inside > 1.0):
        raise InvalidModel(
            f'mesh {name!r} passes through itself: points inside are counted {np.max(inside):.0f} '
            'times, and so would be their mass; join its parts into one surface, or state mass, '
            'inertia and center_of_mass',
            at=('shape',),
        )
    if np.any(inside < 1.0):
        raise InvalidModel(
            f'mesh {name!r}: the faces of some parts look outward, those of others inward, whose '
            'mass would be taken off; orient all faces counter-clockwise seen from outside',
            at=('shape',),
        )


def _need_no_twins(faces: Faces, *, name: str) -> None:
    """Refuse faces on the same corners, unless they look opposite ways and cancel."""
    order = np.sort(faces, axis=1)
    low = np.argmin(faces, axis=1)
    rows = np.arange(len(faces))
    following = faces[rows, (low + 1) % 3]
    turns = np.where(following == order[:, 1], 1.0, -1.0)
    distinct, index = np.unique(order, axis=0, return_inverse=True)
    is_real = (distinct[:, 0] != distinct[:, 1]) & (distinct[:, 1] != distinct[:, 2])
    counted = np.bincount(index.reshape(-1), weights=turns, minlength=len(distinct))
    twice = int(np.sum((np.abs(counted) > 1.0) & is_real))
    if twice:
        raise InvalidModel(
            f'mesh {name!r}: {twice} of its faces stand there more than once, so that its volume '
            'would be counted as often; remove the copies',
            at=('shape',),
        )


def _areas(corners: Array) -> tuple[Array, Array]:
    """Areas (m,) [m^2] of the faces, and their sums one after the other."""
    with np.errstate(all='ignore'):
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = 0.5 * np.linalg.norm(across, axis=1)
    return areas, np.cumsum(areas)


def _points(corners: Array) -> tuple[Array, Faces]:
    """Spread points (k, 3) evenly over the faces; each with its face (k,)."""
    count = max(1, min(MOST_POINTS, WORK // len(corners)))
    areas, sums = _areas(corners)
    steps = (np.arange(count) + 0.5) / count * sums[-1]
    chosen = np.minimum(np.searchsorted(sums, steps), len(areas) - 1)
    u, v = np.modf(np.outer(np.arange(1, count + 1), EVENLY))[0].T
    outside = u + v > 1.0
    u, v = np.where(outside, 1.0 - u, u), np.where(outside, 1.0 - v, v)
    a, b, c = (corners[chosen, corner] for corner in range(3))
    return a + u[:, None] * (b - a) + v[:, None] * (c - a), chosen


def _wound(corners: Array, points: Array, own: Faces) -> Array:
    """
    How often the surface winds about points (k,) on its faces, without the face of each.

    NaN where a point lies on another face too: then on which side of it is chance.
    """
    a, b, c = (corners[None, :, corner] - points[:, None] for corner in range(3))
    la, lb, lc = (np.sqrt(np.einsum('kij,kij->ki', x, x)) for x in (a, b, c))
    volume = np.einsum('kij,kij->ki', a, np.cross(b, c))
    along = (
        la * lb * lc
        + np.einsum('kij,kij->ki', a, b) * lc
        + np.einsum('kij,kij->ki', b, c) * la
        + np.einsum('kij,kij->ki', c, a) * lb
    )
    angles = 2.0 * np.arctan2(volume, along)
    angles[np.arange(len(points)), own] = 0.0
    on_another = np.any(np.abs(np.abs(angles) - 2.0 * math.pi) < ON_A_FACE, axis=1)
    return np.where(on_another, np.nan, np.sum(angles, axis=1) / (4.0 * math.pi))
