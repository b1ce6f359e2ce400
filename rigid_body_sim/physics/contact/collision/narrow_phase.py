# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From pairs that may meet to manifolds: poses, the pair kernels, and what they find.

A record of a manifold is RECORD numbers: key of the pair, its colliders A and B (type of A <= type
of B), points, normal from A to B, then the points as the pair kernels give them (`manifold`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, specialise, unbound
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.collider import (
    BOUNDS,
    CORE,
    POSE,
    SIZES,
    TABLE,
    TYPE,
)
from rigid_body_sim.physics.contact.collision.conservative_advancement import (
    FAST,
    MOST_PIECES,
    PIECE,
    advancement,
    motion_of,
    size_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST, POINT, POINTS
from rigid_body_sim.physics.contact.collision.swept_aabbs import ROW, margin_of
from rigid_body_sim.physics.state.blocks import QW, QX, QY, QZ, ROTATION, RX, TRANSLATION, at

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# bound for each link of the chain, and for each scene, by `specialise`
TYPE_A, TYPE_B = 0, 0
collide: Callable[..., Any] = unbound
others: Callable[..., Any] = unbound
meet: Callable[..., Any] = unbound
hits: Callable[..., Any] = unbound


@kernel
def find_poses(
    n: int, n_rigid: int, translation: Array, rotation: Array, table: Indices, mounts: Array,
    poses: Array,
) -> None:  # fmt: skip
    """Find the poses of the shapes that move: R = R(q) M, x = r - R c."""
    for i in range(n):
        core = table[i * TABLE + CORE]
        if core < 0:
            continue
        k = at(core, TRANSLATION)
        o = i * POSE
        for axis in range(3):
            poses[o + axis] = translation[k + RX + 64 * axis]
        if core >= n_rigid:
            continue
        k = at(core, ROTATION)
        x, y, z, w = rotation[k + QX], rotation[k + QY], rotation[k + QZ], rotation[k + QW]
        xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
        yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
        zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
        a, b, c = mounts[o], mounts[o + 1], mounts[o + 2]
        for column in range(3):
            u, v, t = mounts[o + 3 + column], mounts[o + 6 + column], mounts[o + 9 + column]
            poses[o + 3 + column] = xx * u + xy * v + xz * t
            poses[o + 6 + column] = yx * u + yy * v + yz * t
            poses[o + 9 + column] = zx * u + zy * v + zz * t
        for axis in range(3):
            row = o + 3 + 3 * axis
            poses[o + axis] -= poses[row] * a + poses[row + 1] * b + poses[row + 2] * c


@inline
def _no_pair(ta, tb, numbers, a, b, poses, pa, pb, margin, found):
    """End the chain."""
    return 0


def _meet(ta, tb, numbers, a, b, poses, pa, pb, margin, found):
    """Let the kernel of a pair of types answer, or pass on."""
    if ta == TYPE_A and tb == TYPE_B:
        return collide(numbers, a, b, poses, pa, pb, margin, found)
    return others(ta, tb, numbers, a, b, poses, pa, pb, margin, found)


def meeting(kernels: Sequence[tuple[int, int, Callable[..., Any]]]) -> Callable[..., Any]:
    """
    Join the pair kernels of a scene.

        kernels : (type of A, type of B, kernel)
        returns : kernel (type of A, type of B, numbers, a, b, poses, pa, pb, margin, found)
    """
    chain, name = _no_pair, ''
    for a, b, one in reversed(kernels):
        name = f'{a}{b}_{name}'
        chain = specialise(_meet, name=name, TYPE_A=a, TYPE_B=b, collide=one, others=chain)
    return chain


def _find_manifolds(
    pairs: int, n: int, h: float, room: int, keys: Indices, numbers: Array, table: Indices,
    bounds: Array, reaches: Array, poses: Array, found: Array, records: Array, bodies: Array,
    pieces: Indices,
) -> int:  # fmt: skip
    """
    Write the manifolds of pairs that are within their margins; return how many, also beyond the
    room.

    pieces : [0] is set to the pieces into which the tick should be cut, see `advancement`
    """
    count = 0
    pieces[0] = 1
    for pair in range(pairs):
        key = keys[pair]
        a, b = key // n, key % n
        ta, tb = table[a * TABLE + TYPE], table[b * TABLE + TYPE]
        if ta > tb or (ta == tb and a > b):
            a, b = b, a
            ta, tb = tb, ta
        margin = 0.0
        if bounds[b * BOUNDS + 7] == math.inf:
            o = a * ROW
            at_plane = table[b * TABLE + SIZES]
            toward = (
                numbers[at_plane] * reaches[o + 6]
                + numbers[at_plane + 1] * reaches[o + 7]
                + numbers[at_plane + 2] * reaches[o + 8]
            )
            margin = reaches[o + 10] + max(-toward, 0.0) * h + reaches[o + 9]
        else:
            margin = margin_of(reaches, a * ROW, b * ROW, h)
            size = size_of(bounds, a, b)
            motion = motion_of(reaches, a, b, h)
            if motion > FAST * size:
                if not hits(
                    a, b, n, h, motion, numbers, table, bounds, bodies, reaches, poses, found
                ):
                    continue
                finer = motion / max(PIECE * size, motion / MOST_PIECES)
                pieces[0] = max(pieces[0], int(math.ceil(finer)))
        points = meet(
            ta, tb, numbers, table[a * TABLE + SIZES], table[b * TABLE + SIZES], poses,
            a * POSE, b * POSE, margin, found,
        )  # fmt: skip
        if points == 0:
            continue
        if count < room:
            o = count * manifold_record.SIZE
            records[o + manifold_record.PAIR_ID] = float(key)
            records[o + manifold_record.COLLIDER_A] = float(a)
            records[o + manifold_record.COLLIDER_B] = float(b)
            records[o + manifold_record.POINT_COUNT] = float(points)
            for entry in range(3):
                records[o + manifold_record.NORMAL + entry] = found[entry]
            for entry in range(POINT * min(points, MOST)):
                records[o + manifold_record.POINTS + entry] = found[POINTS + entry]
        count += 1
    return count


def manifold_finder(kernels: Sequence[tuple[int, int, Callable[..., Any]]]) -> Callable[..., Any]:
    """Make the kernel that finds the manifolds of a scene with these pair kernels."""
    name = '_'.join(f'{a}{b}' for a, b, _ in kernels)
    meet = meeting(kernels)
    return specialise(_find_manifolds, name=name, meet=meet, hits=advancement(name, meet))
