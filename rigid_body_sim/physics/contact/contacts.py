# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the contacts of the last tick from the rows of the solver."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collider import SCENE, TABLE
from rigid_body_sim.physics.contact.detection import (
    BODY_A,
    BODY_B,
    COUNT,
    LANE,
    RECORD,
    RECORD_POINTS,
)
from rigid_body_sim.physics.contact.geometry.manifold import POINT as FOUND_POINT
from rigid_body_sim.physics.contact.rows import (
    BN,
    GAP,
    JN,
    LANES,
    MANIFOLD,
    RA,
    RB,
    SUM,
    T2,
    A,
    B,
    N,
    T,
)
from rigid_body_sim.physics.contact.touching_bodies import C, D, U, W
from rigid_body_sim.physics.contact_readout import NO_CONTACTS, Contacts

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def read(
    manifolds: int, *, width: int, bounces: bool, table: Indices, records: Array, rows: Array,
    bodies: Array,
) -> Contacts:  # fmt: skip
    """
    Read the contacts of a tick.

    manifolds, table, records, rows, bodies : of the plan
    width   : numbers of a point
    bounces : whether rows hold impulses of bounces
    """
    if not manifolds:
        return NO_CONTACTS
    found = records[: manifolds * RECORD].reshape(manifolds, RECORD)
    counts = found[:, COUNT].astype(np.int64)
    manifold = np.repeat(np.arange(manifolds), counts)
    index = np.arange(len(manifold)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = found[manifold, LANE].astype(np.int64)
    lane = place % LANES
    row = place - lane + MANIFOLD + index * width + lane

    def of_manifold(offset: int) -> Array:
        return np.stack([rows[place + offset + 8 * axis] for axis in range(3)], axis=1)

    def of_point(offset: int) -> Array:
        return np.stack([rows[row + offset + 8 * axis] for axis in range(3)], axis=1)

    normal = of_manifold(N)
    sums = of_point(SUM) + of_point(JN) + (of_point(BN) if bounces else 0.0)
    impulse = sums[:, :1] * normal + sums[:, 1:2] * of_manifold(T) + sums[:, 2:] * of_manifold(T2)
    at = RECORD_POINTS + index * FOUND_POINT
    point = np.stack([found[manifold, at + axis] for axis in range(3)], axis=1)
    moved_a = _moved(bodies, rows[place + A].astype(np.int64), of_point(RA))
    moved_b = _moved(bodies, rows[place + B].astype(np.int64), of_point(RB))
    gap = rows[row + GAP]
    touches = (sums[:, 0] > 0.0) | (gap <= 0.0)
    colliders = found[manifold][:, [BODY_A, BODY_B]].astype(np.int64)
    return Contacts(
        table[colliders * TABLE + SCENE][touches],
        (point + 0.5 * (moved_a + moved_b))[touches],
        normal[touches],
        gap[touches],
        impulse[touches],
    )


def _moved(bodies: Array, at: Indices, arm: Array) -> Array:
    """Motion of points at arms from bodies over the tick: d + w t + c u x t, t = 2 u x r."""
    d, u = (np.stack([bodies[at + first + axis] for axis in range(3)], axis=1) for first in (D, U))
    t = 2.0 * np.cross(u, arm)
    return d + bodies[at + W][:, None] * t + bodies[at + C][:, None] * np.cross(u, t)
