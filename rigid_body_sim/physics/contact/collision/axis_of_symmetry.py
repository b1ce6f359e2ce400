# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Which bodies are round, and about which axis.

Rolling leaves a body of revolution as it is: its motion in a tick is that of its axis (see
`touching_bodies`). So it is with several parts where all of them are balls, capsules and cylinders
about one axis through the centre of mass: dumbbells, pairs of wheels on their axle. Where they
meet something flat that cannot move, the lowest point of a rim goes round it (`rims`).

Of balls and capsules that lie otherwise the core turns with the body, which is exact (see
`following`). Cylinders that lie otherwise are taken to turn with the body: where one of radius r
rolls by theta in a tick, its gap is wrong by r theta^2 / 2 at the end of it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collision.collider import BOX, CAPSULE, CYLINDER, PLANE, SPHERE
from rigid_body_sim.physics.contact.solver_bodies import ABOUT_AXIS, AS_IT_IS, BALL, CENTRED_BALL

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STRAIGHT = 1e-9  # [-] of the largest distance: parts this far off an axis still lie on it


def members(cores: Indices) -> Iterator[tuple[int, Indices]]:
    """Give each body that moves and has colliders, and their places."""
    order = np.argsort(cores, kind='stable')
    order = order[cores[order] >= 0]
    for places in np.split(order, np.flatnonzero(np.diff(cores[order])) + 1):
        if len(places):
            yield int(cores[places[0]]), places


def rolling(kinds: list[int], mounts: Array) -> tuple[float, Array]:
    """
    Tell how a body turns, and about which of its principal axes' directions.

        kinds  : types of its colliders
        mounts : (m, POSE) of its colliders
    """
    turns = mounts[:, 3:].reshape(-1, 3, 3)
    if len(kinds) == 1:
        centered = not mounts[0, :2].any()
        about = kinds[0] in (CAPSULE, CYLINDER) and centered
        if kinds[0] == SPHERE:
            return BALL if mounts[0, :3].any() else CENTRED_BALL, turns[0, :, 2]
        return float(about), turns[0, :, 2]
    centers = -np.einsum('mij,mj->mi', turns, mounts[:, :3])  # of the parts, principal axes
    far = STRAIGHT * float(np.max(np.abs(centers)))
    directions = [
        *(turn[:, 2] for kind, turn in zip(kinds, turns, strict=True) if kind != SPHERE),
        *(center / np.linalg.norm(center) for center in centers if np.abs(center).max() > far),
    ]
    if not set(kinds) <= {SPHERE, CAPSULE, CYLINDER}:
        return AS_IT_IS, turns[0, :, 2]
    if not directions:
        return BALL, turns[0, :, 2]
    straight = [np.abs(np.cross(directions[0], one)).max() <= STRAIGHT for one in directions]
    return (ABOUT_AXIS if all(straight) else AS_IT_IS), directions[0]


def round_features(kinds: Collection[tuple[int, int]]) -> dict[str, bool]:
    """
    Tell what of roundness the solver of a scene needs, as arguments of `solver`.

        kinds : pairs of types that may meet
    """
    return {
        'on_rims': (CYLINDER, PLANE) in kinds or (BOX, CYLINDER) in kinds,
        'layered': any(kind in (SPHERE, CAPSULE) for pair in kinds for kind in pair),
    }
