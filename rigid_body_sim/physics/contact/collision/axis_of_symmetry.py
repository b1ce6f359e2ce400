# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The axis of symmetry of a body: which bodies are round, and about which axis.

Rolling leaves a body of revolution as it is: its motion in a tick is that of its axis (see
`solver_bodies`). So it is with several parts where all of them are balls, capsules and cylinders
about one axis through the centre of mass: dumbbells, pairs of wheels on their axle. Where they
meet something flat that cannot move, the lowest point of a rim goes round it (`rolling_frame`).

Of balls and capsules that lie otherwise the segment or point inside turns with the body, which is
exact (see `separation`). Cylinders that lie otherwise are taken to turn with the body: where one
of radius r rolls by theta in a tick, its separation is wrong by r theta^2 / 2 at the end of it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.collider import (
    CAPSULE,
    CYLINDER,
    SPHERE,
)
from rigid_body_sim.physics.contact.solver_bodies import ABOUT_AXIS, AS_IT_IS, BALL, CENTRED_BALL
from rigid_body_sim.physics.model.plain_products import length, times

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STRAIGHT = 1e-9  # [-] of the largest distance: parts this far off an axis still lie on it


def members(bodies: Indices) -> Iterator[tuple[int, Indices]]:
    """
    Give each body that moves and has colliders, and their places.

        bodies : index of the body of each collider among those that move; below 0: none
    """
    order = np.argsort(bodies, kind='stable')
    order = order[bodies[order] >= 0]
    for places in np.split(order, np.flatnonzero(np.diff(bodies[order])) + 1):
        if len(places):
            yield int(bodies[places[0]]), places


def symmetry_of(kinds: list[int], local_poses: Array) -> tuple[float, Array]:
    """
    Tell how a body turns, and about which of its principal axes' directions.

        kinds       : types of its colliders
        local_poses : (m, pose.SIZE) of its colliders
    """
    turns = local_poses[:, pose.ROW_X :].reshape(-1, 3, 3)
    offsets = local_poses[:, : pose.ROW_X]  # of the centre of mass, shape axes
    if len(kinds) == 1:
        centered = not offsets[0, :2].any()
        about = kinds[0] in (CAPSULE, CYLINDER) and centered
        if kinds[0] == SPHERE:
            return BALL if offsets.any() else CENTRED_BALL, turns[0, :, 2]
        return float(about), turns[0, :, 2]
    centers = -times(turns, offsets)  # of the parts, principal axes
    far = STRAIGHT * float(np.max(np.abs(centers)))
    directions = [
        *(turn[:, 2] for kind, turn in zip(kinds, turns, strict=True) if kind != SPHERE),
        *(center / length(center) for center in centers if np.abs(center).max() > far),
    ]
    if not set(kinds) <= {SPHERE, CAPSULE, CYLINDER}:
        return AS_IT_IS, turns[0, :, 2]
    if not directions:
        return BALL, turns[0, :, 2]
    straight = [np.abs(np.cross(directions[0], one)).max() <= STRAIGHT for one in directions]
    return (ABOUT_AXIS if all(straight) else AS_IT_IS), directions[0]


def symmetry_features(kinds: Collection[tuple[int, int]], *, off_center: bool) -> dict[str, bool]:
    """
    Tell what of roundness the solver of a scene needs, as arguments of `solver.iterations.solver`.

        kinds      : pairs of types that may meet
        off_center : whether a ball is off the centre of mass of a body that moves
    """
    patches = any(SPHERE not in pair for pair in kinds)
    return {
        'on_rims': any(CYLINDER in pair for pair in kinds),
        'patches': patches,
        'surfaces': patches or off_center,
        'curved': any(
            set(pair) <= {SPHERE, CAPSULE, CYLINDER} and (pair != (SPHERE, SPHERE) or off_center)
            for pair in kinds
        ),
        'layered': any(kind in (SPHERE, CAPSULE) for pair in kinds for kind in pair),
    }
