# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Read the contacts of the last tick from the rows of the solver.

A tick that was cut into pieces has rows for each piece in turn: what was read of each is put
`together`, the same point of the same pair being one contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record, manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.energy.scratch import OF_MOMENTUM, OF_PLACE, TAKEN
from rigid_body_sim.physics.contact.solver import constraint, contact_point
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.plain_products import cross
from rigid_body_sim.physics.state.contacts import NO_CONTACTS, Contacts

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def read(
    manifold_count: int, *, width: int, bounces: bool, angular: int, moving: int, table: Indices,
    manifolds: Array, rows: Array, bodies: Array,
) -> tuple[Contacts, Array]:  # fmt: skip
    """
    Read the contacts of a tick or piece, and which they are: (m, 2), pair id and feature.

    table, manifolds, rows, bodies : of the kernel of the ticks
    width   : numbers of a point
    bounces : whether rows hold restitution impulses
    moving  : how many bodies move freely
    angular : substeps, where rows hold angular impulses; else 0
    """
    if not manifold_count:
        return NO_CONTACTS, np.zeros((0, 2))
    found = manifolds[: manifold_count * manifold_record.SIZE].reshape(manifold_count, -1)
    counts = found[:, manifold_record.POINT_COUNT].astype(np.int64)
    owner = np.repeat(np.arange(manifold_count), counts)
    index = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    place = found[owner, manifold_record.LANE].astype(np.int64)
    lane = place % constraint.LANES
    row = place - lane + constraint.SIZE + index * width + lane
    normal = _vectors(rows, place + constraint.NORMAL, constraint.LANES)
    impulses = _vectors(rows, row + contact_point.TOTAL_IMPULSE, constraint.LANES) + _vectors(
        rows, row + contact_point.NORMAL_IMPULSE, constraint.LANES
    )
    impulses = impulses + (
        _vectors(rows, row + contact_point.RESTITUTION_NORMAL, constraint.LANES)
        if bounces
        else 0.0
    )
    impulse = (
        impulses[:, :1] * normal
        + impulses[:, 1:2] * _vectors(rows, place + constraint.TANGENT_1, constraint.LANES)
        + impulses[:, 2:] * _vectors(rows, place + constraint.TANGENT_2, constraint.LANES)
    )
    separation = rows[row + contact_point.SEPARATION] + (
        rows[place + constraint.SINK] * rows[row + contact_point.SINK_SHARE]
    )
    about = np.zeros_like(impulse)
    if angular:
        for field, axis in (
            (contact_point.ROLLING_IMPULSE_1, constraint.TANGENT_1),
            (contact_point.ROLLING_IMPULSE_2, constraint.TANGENT_2),
            (contact_point.TWIST_IMPULSE, constraint.NORMAL),
        ):
            of_axis = angular * rows[row + field][:, None]
            about += of_axis * _vectors(rows, place + axis, constraint.LANES)
    point = _points(rows, place, row, separation, normal, bodies, moving * solver_bodies.SIZE)
    touches = (impulses != 0.0).any(axis=1) | (separation <= 0.0)
    pair = found[owner][:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]]
    scene_index = pair.astype(np.int64) * collider_record.SIZE + collider_record.SCENE_INDEX
    feature = manifold_record.POINTS + index * manifold.POINT + manifold.FEATURE
    which = np.stack((found[owner, manifold_record.PAIR_ID], found[owner, feature]), axis=1)
    contacts = Contacts(
        table[scene_index][touches],
        point[touches],
        normal[touches],
        separation[touches],
        impulse[touches],
        about[touches],
    )
    return contacts, which[touches]


def together(pieces: Sequence[tuple[Contacts, Array]]) -> tuple[Contacts, Array]:
    """
    Join the contacts of successive pieces of a tick, each as `read` gives them.

    Impulses of the same point add up; place, normal and separation are those of the last piece in
    which it touched. A point that no longer touches stays where it acted; if it never pushed it is
    gone.
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
    impulse, about = np.zeros((count, 3)), np.zeros((count, 3))
    np.add.at(impulse, same, impulses)
    np.add.at(about, same, np.concatenate([c.angular_impulse for c, _ in pieces]))
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
        about[order],
        np.concatenate([contacts.damped for contacts, _ in pieces]),
        np.concatenate([contacts.taken_back for contacts, _ in pieces]),
    )
    return contacts, which[chosen]


def with_taken_back(
    contacts: Contacts, taken: Array, scene_indices: Indices, pivoted: Sequence[int]
) -> Contacts:
    """
    Add to the contacts of a tick or piece what it took back. Of a body on a pivot that is a
    couple, the same about its centre of mass as about the pivot: the momentum of its solver body
    is what the pivot has taken of impulses, and not its own.

    taken         : see `energy.scratch`
    scene_indices : of the bodies in the order of the core
    pivoted       : core indices of those on a pivot
    """
    rows = taken[:-TAKEN].reshape(-1, TAKEN)[:, OF_MOMENTUM:OF_PLACE].copy()
    rows[list(pivoted), :3] = 0.0
    damped = np.flatnonzero(rows.any(axis=1))
    return replace(contacts, damped=scene_indices[damped], taken_back=rows[damped])


def _vectors(array: Array, places: Indices, stride: int, count: int = 3) -> Array:
    """Read vectors (n, count) that begin at places, their numbers a stride apart."""
    return array[places[:, None] + stride * np.arange(count)]


def _points(
    rows: Array, place: Indices, row: Indices, separation: Array, normal: Array, bodies: Array,
    fixed: int,
) -> Array:  # fmt: skip
    """
    Points midway between the surfaces, at the end of the tick; place, row: of lane and point;
    fixed: where the first body begins that no contact moves.

    Two bodies that move have arms to it; beside one that cannot move the arm of the other ends on
    its surface, half a separation away. Arms have followed the bodies (`solver.separation`), but
    for those of what bounces off something that cannot move: they are of the start of the tick.
    """
    row_a, row_b = (
        rows[place + body].astype(np.int64) for body in (constraint.BODY_A, constraint.BODY_B)
    )
    arm_a = _vectors(rows, row + contact_point.ARM_A, constraint.LANES)
    arm_b = _vectors(rows, row + contact_point.ARM_B, constraint.LANES)
    half = 0.5 * separation[:, None] * normal
    bounces_off = (rows[place + constraint.RESTITUTION] > 0.0) & (
        rows[row + contact_point.APPROACH_VELOCITY] < 0.0
    )
    position_a, position_b = (
        _vectors(bodies, body + solver_bodies.SUBSTEP_POSITION, 1)
        + _vectors(bodies, body + solver_bodies.DISPLACEMENT, 1)
        for body in (row_a, row_b)
    )
    a_moves, b_moves = (body[:, None] < fixed for body in (row_a, row_b))
    both = a_moves & b_moves
    stayed = bounces_off & ~both[:, 0] & (rows[place + constraint.ROUNDNESS] != constraint.CURVED)
    if stayed.any():
        arm_a[stayed] = _turned(bodies, row_a[stayed], arm_a[stayed])
        arm_b[stayed] = _turned(bodies, row_b[stayed], arm_b[stayed])
    alone = np.where(a_moves, position_a + arm_a + half, position_b + arm_b - half)
    return np.where(both, position_a + arm_a, alone)


def _turned(bodies: Array, body: Indices, arm: Array) -> Array:
    """
    Turn arms (n, 3) as their bodies have turned over the tick, by the rules of `solver_bodies`.

    The nearest point of a ball does not turn; that of a body of revolution turns with the axis, by
    the smallest turn that takes it from where it was to where it is.
    """
    before = _vectors(bodies, body + solver_bodies.START_ORIENTATION, 1, 4)
    turn = _vectors(bodies, body + solver_bodies.TURN, 1, 4)
    substep = _vectors(bodies, body + solver_bodies.SUBSTEP_ORIENTATION, 1, 4)
    whole = so3.rotate(turn, so3.rotate(substep, so3.rotate_back(before, arm)))
    axis = _vectors(bodies, body + solver_bodies.SYMMETRY_AXIS, 1)
    old, new = so3.rotate(before, axis), so3.rotate(turn, so3.rotate(substep, axis))
    axes = cross(old, new)
    share = 1.0 / (1.0 + np.maximum(np.sum(old * new, axis=1), 0.0))
    across = cross(axes, arm)
    of_axis = arm + across + share[:, None] * cross(axes, across)
    symmetry = bodies[body + solver_bodies.SYMMETRY][:, None]
    turned = np.where(symmetry == solver_bodies.ABOUT_AXIS, of_axis, arm)
    return np.where(symmetry == solver_bodies.AS_IT_IS, whole, turned)


def joined(parts: Sequence[Contacts]) -> Contacts:
    """Put lists of contacts one after the other."""
    return Contacts(
        *(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Contacts))
    )
