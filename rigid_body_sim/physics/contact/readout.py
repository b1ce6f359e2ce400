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

from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider, manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import constraint, contact_point
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts

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
    found = records[: manifolds * manifold_record.SIZE].reshape(manifolds, manifold_record.SIZE)
    counts = found[:, manifold_record.POINT_COUNT].astype(np.int64)
    owner = np.repeat(np.arange(manifolds), counts)
    index = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = found[owner, manifold_record.LANE].astype(np.int64)
    lane = place % constraint.LANES
    row = place - lane + constraint.SIZE + index * width + lane

    def of_manifold(offset: int) -> Array:
        return np.stack([rows[place + offset + 8 * axis] for axis in range(3)], axis=1)

    def of_point(offset: int) -> Array:
        return np.stack([rows[row + offset + 8 * axis] for axis in range(3)], axis=1)

    normal = of_manifold(constraint.NORMAL)
    sums = (
        of_point(contact_point.TOTAL_IMPULSE)
        + of_point(contact_point.NORMAL_IMPULSE)
        + (of_point(contact_point.RESTITUTION_NORMAL) if bounces else 0.0)
    )
    impulse = (
        sums[:, :1] * normal
        + sums[:, 1:2] * of_manifold(constraint.TANGENT_1)
        + sums[:, 2:] * of_manifold(constraint.TANGENT_2)
    )
    at = manifold_record.POINTS + index * manifold.POINT
    gap = rows[row + contact_point.SEPARATION]
    bounces_off = (rows[place + constraint.RESTITUTION] > 0.0) & (
        rows[row + contact_point.APPROACH_VELOCITY] < 0.0
    )
    point = _point(
        bodies, rows[place + constraint.BODY_A].astype(np.int64), rows[place + constraint.BODY_B].astype(np.int64), of_point(contact_point.ARM_A),
        of_point(contact_point.ARM_B), 0.5 * gap[:, None] * normal, bounces_off,
    )  # fmt: skip
    touches = (sums != 0.0).any(axis=1) | (gap <= 0.0)
    colliders = found[owner][:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]].astype(
        np.int64
    )
    which = np.stack(
        (found[owner, manifold_record.PAIR_ID], found[owner, at + manifold.FEATURE]), axis=1
    )
    contacts = Contacts(
        table[colliders * collider.TABLE + collider.SCENE][touches],
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
    bodies: Array, a: Indices, b: Indices, arm_a: Array, arm_b: Array, half: Array,
    bounces_off: NDArray[np.bool_],
) -> Array:  # fmt: skip
    """
    Points midway between the surfaces, at the end of the tick.

    Two bodies that move have arms to it; beside one that cannot move the arm of the other ends on
    its surface, half a gap away. Arms have followed the bodies (`following`), but for those of
    what bounces off something that cannot move: they are of the start of the tick.
    """
    x_a, x_b = (
        np.stack(
            [
                bodies[at + solver_bodies.SUBSTEP_POSITION + axis]
                + bodies[at + solver_bodies.DISPLACEMENT + axis]
                for axis in range(3)
            ],
            axis=1,
        )
        for at in (a, b)
    )
    a_moves, b_moves = (bodies[at + solver_bodies.INVERSE_MASS][:, None] > 0.0 for at in (a, b))
    both = a_moves & b_moves
    stayed = bounces_off & ~both[:, 0]
    if stayed.any():
        arm_a[stayed] = _turned(bodies, a[stayed], arm_a[stayed])
        arm_b[stayed] = _turned(bodies, b[stayed], arm_b[stayed])
    alone = np.where(a_moves, x_a + arm_a + half, x_b + arm_b - half)
    return np.where(both, x_a + arm_a, alone)


def _turned(bodies: Array, body: Indices, arm: Array) -> Array:
    """
    Turn arms (n, 3) as their bodies have turned over the tick, by the rules of `touching_bodies`.

    The nearest point of a ball does not turn; that of a body of revolution turns with the axis, by
    the smallest turn that takes it from where it was to where it is.
    """

    def of_body(first: int, count: int) -> Array:
        return np.stack([bodies[body + first + k] for k in range(count)], axis=1)

    before, turn = of_body(solver_bodies.START_ORIENTATION, 4), of_body(solver_bodies.TURN, 4)
    whole = so3.rotate(
        turn,
        so3.rotate(of_body(solver_bodies.SUBSTEP_ORIENTATION, 4), so3.rotate_back(before, arm)),
    )
    axis = of_body(solver_bodies.SYMMETRY_AXIS, 3)
    old, new = (
        so3.rotate(before, axis),
        so3.rotate(turn, so3.rotate(of_body(solver_bodies.SUBSTEP_ORIENTATION, 4), axis)),
    )
    cross = np.cross(old, new)
    share = 1.0 / (1.0 + np.maximum(np.sum(old * new, axis=1), 0.0))
    across = np.cross(cross, arm)
    of_axis = arm + across + share[:, None] * np.cross(cross, across)
    kind = bodies[body + solver_bodies.SYMMETRY][:, None]
    return np.where(kind == 0.0, whole, np.where(kind == 1.0, of_axis, arm))
