# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the contacts of the last tick from the rows of the solver.

A tick that was cut into pieces has rows for each piece in turn: what was read of each is put
`together`, the same point of the same pair being one contact.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact.collider import SCENE, TABLE
from rigid_body_sim.physics.contact.finding.detection import (
    BODY_A,
    BODY_B,
    COUNT,
    KEY,
    LANE,
    RECORD,
    RECORD_POINTS,
)
from rigid_body_sim.physics.contact.geometry.manifold import FEATURE
from rigid_body_sim.physics.contact.geometry.manifold import POINT as FOUND_POINT
from rigid_body_sim.physics.contact.solving.rows import (
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
from rigid_body_sim.physics.contact.touching_bodies import IM, XS, D
from rigid_body_sim.physics.contact_readout import NO_CONTACTS, Contacts

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def read(
    manifolds: int, *, width: int, bounces: bool, table: Indices, records: Array, rows: Array,
    bodies: Array,
) -> tuple[Contacts, Array]:  # fmt: skip
    """
    Read the contacts of a tick or piece, and which they are: (m, 2), key of the pair and feature.

    manifolds, table, records, rows, bodies : of the plan
    width   : numbers of a point
    bounces : whether rows hold impulses of bounces
    """
    if not manifolds:
        return NO_CONTACTS, np.zeros((0, 2))
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
    gap = rows[row + GAP]
    point = _point(
        bodies, rows[place + A].astype(np.int64), rows[place + B].astype(np.int64), of_point(RA),
        of_point(RB), 0.5 * gap[:, None] * normal,
    )  # fmt: skip
    touches = (sums[:, 0] > 0.0) | (gap <= 0.0)
    colliders = found[manifold][:, [BODY_A, BODY_B]].astype(np.int64)
    which = np.stack((found[manifold, KEY], found[manifold, at + FEATURE]), axis=1)
    contacts = Contacts(
        table[colliders * TABLE + SCENE][touches],
        point[touches],
        normal[touches],
        gap[touches],
        impulse[touches],
    )
    return contacts, which[touches]


def together(pieces: Sequence[tuple[Contacts, Array]]) -> tuple[Contacts, Array]:
    """
    Join the contacts of successive pieces of a tick, each as `read` gives them.

    Impulses of the same point add up; place, normal and gap are those of the last piece in which
    it touched. A point that no longer touches stays where it acted; if it never pushed it is gone.
    """
    which = np.concatenate([keys for _, keys in pieces])
    if not len(which):
        return NO_CONTACTS, which
    impulses = np.concatenate([contacts.impulse for contacts, _ in pieces])
    _, same = np.unique(which, axis=0, return_inverse=True)
    same = same.ravel()
    count = int(same.max()) + 1
    last = np.zeros(count, dtype=np.int64)
    np.maximum.at(last, same, np.arange(len(same)))
    impulse = np.zeros((count, 3))
    np.add.at(impulse, same, impulses)
    acted = np.any(impulse != 0.0, axis=1) | (last >= len(which) - len(pieces[-1][1]))
    order = np.flatnonzero(acted)[np.argsort(last[acted])]
    chosen = last[order]

    def of_all(name: str) -> Array:
        return np.concatenate([getattr(contacts, name) for contacts, _ in pieces])[chosen]

    contacts = Contacts(
        np.concatenate([contacts.bodies for contacts, _ in pieces])[chosen],
        of_all('point'),
        of_all('normal'),
        of_all('gap'),
        impulse[order],
    )
    return contacts, which[chosen]


def _point(
    bodies: Array, a: Indices, b: Indices, arm_a: Array, arm_b: Array, half: Array
) -> Array:
    """
    Points midway between the surfaces.

    Two bodies that move have arms to it; beside one that cannot move the arm of the other ends on
    its surface, half a gap away.
    """
    x_a, x_b = (
        np.stack([bodies[at + XS + axis] + bodies[at + D + axis] for axis in range(3)], axis=1)
        for at in (a, b)
    )
    a_moves, b_moves = (bodies[at + IM][:, None] > 0.0 for at in (a, b))
    alone = np.where(a_moves, x_a + arm_a + half, x_b + arm_b - half)
    return np.where(a_moves & b_moves, x_a + arm_a, alone)
