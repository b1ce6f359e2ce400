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
    order = np.arange(len(owner))
    index = order - np.repeat(np.cumsum(counts) - counts, counts)
    found = found[owner]  # a row for each point
    place = found[:, manifold_record.LANE].astype(np.int64)
    lane = place % constraint.LANES
    row = place - lane + constraint.SIZE + index * width + lane
    frames, points = _fields(rows, place, constraint.SIZE), _fields(rows, row, width)
    normal = _vector(frames, constraint.NORMAL)
    impulses = _vector(points, contact_point.TOTAL_IMPULSE) + _vector(
        points, contact_point.NORMAL_IMPULSE
    )
    impulses = impulses + (_vector(points, contact_point.RESTITUTION_NORMAL) if bounces else 0.0)
    impulse = (
        impulses[:, :1] * normal
        + impulses[:, 1:2] * _vector(frames, constraint.TANGENT_1)
        + impulses[:, 2:] * _vector(frames, constraint.TANGENT_2)
    )
    separation = _number(points, contact_point.SEPARATION) + (
        _number(frames, constraint.SINK) * _number(points, contact_point.SINK_SHARE)
    )
    about = np.zeros_like(impulse)
    if angular:
        for field, axis in (
            (contact_point.ROLLING_IMPULSE_1, constraint.TANGENT_1),
            (contact_point.ROLLING_IMPULSE_2, constraint.TANGENT_2),
            (contact_point.TWIST_IMPULSE, constraint.NORMAL),
        ):
            about += angular * _number(points, field)[:, None] * _vector(frames, axis)
    point = _points(frames, points, separation, normal, bodies, moving * solver_bodies.SIZE)
    touches = (impulses != 0.0).any(axis=1) | (separation <= 0.0)
    pair = found[:, [manifold_record.COLLIDER_A, manifold_record.COLLIDER_B]]
    scene_index = pair.astype(np.int64) * collider_record.SIZE + collider_record.SCENE_INDEX
    feature = manifold_record.POINTS + index * manifold.POINT + manifold.FEATURE
    which = np.stack((found[:, manifold_record.PAIR_ID], found[order, feature]), axis=1)
    bodies_of = table[scene_index]
    if touches.all():
        return Contacts(bodies_of, point, normal.copy(), separation, impulse, about), which
    contacts = Contacts(
        bodies_of[touches],
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


def _fields(rows: Array, places: Indices, size: int) -> Array:
    """Read all fields of constraints or points in wide lanes: (n, fields)."""
    return rows[places[:, None] + np.arange(0, size, constraint.LANES)]


def _number(fields: Array, field: int) -> Array:
    """Return a field (n,) of `_fields`."""
    return fields[:, field // constraint.LANES]


def _vector(fields: Array, field: int) -> Array:
    """Return a vector (n, 3) of `_fields`."""
    first = field // constraint.LANES
    return fields[:, first : first + 3]


def _of_bodies(bodies: Array, places: Indices, field: int, count: int = 3) -> Array:
    """Return numbers (..., count) of the solver's bodies that begin at places (...)."""
    return bodies[places[..., None] + np.arange(field, field + count)]


def _points(
    frames: Array, points: Array, separation: Array, normal: Array, bodies: Array, fixed: int
) -> Array:
    """
    Points midway between the surfaces, at the end of the tick; frames, points: see `_fields`;
    fixed: where the first body begins that no contact moves.

    Two bodies that move have arms to it; beside one that cannot move the arm of the other ends on
    its surface, half a separation away. Arms have followed the bodies (`solver.separation`), but
    for those of what bounces off something that cannot move: they are of the start of the tick.
    """
    columns = [constraint.BODY_A // constraint.LANES, constraint.BODY_B // constraint.LANES]
    of_bodies = frames[:, columns].T.astype(np.int64)
    position_a, position_b = _of_bodies(
        bodies, of_bodies, solver_bodies.SUBSTEP_POSITION
    ) + _of_bodies(bodies, of_bodies, solver_bodies.DISPLACEMENT)
    arm_a, arm_b = (_vector(points, arm) for arm in (contact_point.ARM_A, contact_point.ARM_B))
    half = 0.5 * separation[:, None] * normal
    bounces_off = (_number(frames, constraint.RESTITUTION) > 0.0) & (
        _number(points, contact_point.APPROACH_VELOCITY) < 0.0
    )
    a_moves, b_moves = of_bodies[:, :, None] < fixed
    both = a_moves & b_moves
    stayed = (
        bounces_off & ~both[:, 0] & (_number(frames, constraint.ROUNDNESS) != constraint.CURVED)
    )
    if stayed.any():
        arm_a[stayed] = _turned(bodies, of_bodies[0][stayed], arm_a[stayed])
        arm_b[stayed] = _turned(bodies, of_bodies[1][stayed], arm_b[stayed])
    alone = np.where(a_moves, position_a + arm_a + half, position_b + arm_b - half)
    return np.where(both, position_a + arm_a, alone)


def _turned(bodies: Array, body: Indices, arm: Array) -> Array:
    """
    Turn arms (n, 3) as their bodies have turned over the tick, by the rules of `solver_bodies`.

    The nearest point of a ball does not turn; that of a body of revolution turns with the axis, by
    the smallest turn that takes it from where it was to where it is.
    """
    before = _of_bodies(bodies, body, solver_bodies.START_ORIENTATION, 4)
    turn = _of_bodies(bodies, body, solver_bodies.TURN, 4)
    substep = _of_bodies(bodies, body, solver_bodies.SUBSTEP_ORIENTATION, 4)
    whole = so3.rotate(turn, so3.rotate(substep, so3.rotate_back(before, arm)))
    axis = _of_bodies(bodies, body, solver_bodies.SYMMETRY_AXIS)
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
