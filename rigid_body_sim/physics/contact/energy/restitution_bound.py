# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a bounce may give back: at most the share e^2 of the energy that the impact took.

Newton's law, v_n <- -e v_n at each point, gives a ball or a central impact the right energy. At an
eccentric one with friction it can create energy (Kane and Levinson 1985), and where several points
strike at once too. So bodies that press on each other in a tick, a group, account for it:

    taken    = sum over the group of T_0 + W - T_1
    returned = T_2 - T_1 <= e^2 taken
        T_0, T_1, T_2 : [J] kinetic energy at the start of the tick, before and after the bounce
        W             : [J] work of all other forces over the tick
        e             : [-] largest restitution of its points that bounce

This is the energetic restitution of Stronge (1990) for the group as a whole. Where it is broken,
all impulses of the bounce of the group shrink by one factor s: momenta p_1 + s (p_2 - p_1),

    T(s) - T_1 = s b + s^2 c,   b = v_1 . (p_2 - p_1),   c = half of (p_2 - p_1) . (v_2 - v_1),

so that what one body gives another gets, and no friction leaves its cone.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.energy import pressing_groups
from rigid_body_sim.physics.contact.energy.account import kinetic, twice
from rigid_body_sim.physics.contact.energy.pressing_groups import join_pressing
from rigid_body_sim.physics.contact.solver import constraint, contact_point

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@kernel
def before_bounce(i: int, bodies: Array) -> None:
    """Keep the momenta from which the bounce starts."""
    o = i * solver_bodies.SIZE
    for axis in range(3):
        bodies[o + solver_bodies.MOMENTUM_BEFORE_RESTITUTION + axis] = bodies[
            o + solver_bodies.MOMENTUM + axis
        ]
        bodies[o + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION + axis] = bodies[
            o + solver_bodies.ANGULAR_MOMENTUM + axis
        ]


@inline
def _factor(taken: float, linear: float, square: float) -> Any:
    """Return the largest s in [0, 1] with s b + s^2 c <= taken, else what gives the least."""
    if linear + square <= taken:
        return 1.0
    root = linear * linear + 4.0 * square * taken
    if not root > 0.0:
        return min(max(-0.5 * linear / square, 0.0), 1.0) if square > 0.0 else 0.0
    root = math.sqrt(root)
    # the larger root, without a difference of like numbers
    s = 2.0 * taken / (linear + root) if linear > 0.0 else 0.5 * (root - linear) / square
    return min(max(s, 0.0), 1.0)


@kernel
def limit(
    manifolds: int, count: int, touched: int, nothing: int, width: int, touching: Indices,
    batches: Indices, records: Array, rows: Array, groups: Indices, accounts: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Shrink the bounce of each group that would return more than its share.

    count   : batches
    nothing : index of what cannot move; it joins nobody
    groups  : scratch, one number a body
    accounts: scratch, ACCOUNT numbers a body
    """
    join_pressing(count, touched, nothing, touching, batches, rows, groups)
    for t in range(touched):
        g = touching[t] * pressing_groups.ACCOUNT
        for entry in range(pressing_groups.TAKEN, pressing_groups.FACTOR):
            accounts[g + entry] = 0.0
        accounts[g + pressing_groups.FACTOR] = 1.0
    for m in range(manifolds):
        place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
        a, b = (
            int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
            int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
        )
        g = groups[b if a == nothing else a] * pressing_groups.ACCOUNT
        begin = place + constraint.SIZE
        for point in range(int(records[m * manifold_record.SIZE + manifold_record.POINT_COUNT])):
            q = begin + point * width
            if (
                rows[place + constraint.TOUCHED] > 0.0
                and rows[q + contact_point.APPROACH_VELOCITY] < 0.0
            ):
                accounts[g + pressing_groups.SHARE] = max(
                    accounts[g + pressing_groups.SHARE], rows[place + constraint.RESTITUTION]
                )
    for t in range(touched):
        o = touching[t] * solver_bodies.SIZE
        g = groups[touching[t]] * pressing_groups.ACCOUNT
        x, y, z = (
            bodies[o + solver_bodies.MOMENTUM_BEFORE_RESTITUTION],
            bodies[o + solver_bodies.MOMENTUM_BEFORE_RESTITUTION + 1],
            bodies[o + solver_bodies.MOMENTUM_BEFORE_RESTITUTION + 2],
        )
        u, v, w = (
            bodies[o + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION],
            bodies[o + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION + 1],
            bodies[o + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION + 2],
        )
        before = 0.5 * twice(bodies, o, x, y, z, u, v, w)
        x, y, z = (
            bodies[o + solver_bodies.MOMENTUM] - x,
            bodies[o + solver_bodies.MOMENTUM + 1] - y,
            bodies[o + solver_bodies.MOMENTUM + 2] - z,
        )
        u, v, w = (
            bodies[o + solver_bodies.ANGULAR_MOMENTUM] - u,
            bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1] - v,
            bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2] - w,
        )
        square = 0.5 * twice(bodies, o, x, y, z, u, v, w)
        accounts[g + pressing_groups.TAKEN] += bodies[o + solver_bodies.ENERGY] - before
        accounts[g + pressing_groups.SQUARE] += square
        accounts[g + pressing_groups.LINEAR] += kinetic(bodies, o) - before - square
    for t in range(touched):
        g = touching[t] * pressing_groups.ACCOUNT
        if groups[touching[t]] == touching[t]:
            taken = (
                accounts[g + pressing_groups.SHARE]
                * accounts[g + pressing_groups.SHARE]
                * accounts[g + pressing_groups.TAKEN]
            )
            accounts[g + pressing_groups.FACTOR] = _factor(
                taken, accounts[g + pressing_groups.LINEAR], accounts[g + pressing_groups.SQUARE]
            )
    for t in range(touched):
        o = touching[t] * solver_bodies.SIZE
        s = accounts[groups[touching[t]] * pressing_groups.ACCOUNT + pressing_groups.FACTOR]
        if s < 1.0:
            for axis in range(3):
                p, j = (
                    bodies[o + solver_bodies.MOMENTUM_BEFORE_RESTITUTION + axis],
                    bodies[o + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION + axis],
                )
                bodies[o + solver_bodies.MOMENTUM + axis] = p + s * (
                    bodies[o + solver_bodies.MOMENTUM + axis] - p
                )
                bodies[o + solver_bodies.ANGULAR_MOMENTUM + axis] = j + s * (
                    bodies[o + solver_bodies.ANGULAR_MOMENTUM + axis] - j
                )
    for m in range(manifolds):
        place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
        a, b = (
            int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
            int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
        )
        s = accounts[
            groups[b if a == nothing else a] * pressing_groups.ACCOUNT + pressing_groups.FACTOR
        ]
        begin = place + constraint.SIZE
        if s < 1.0:
            for point in range(
                int(records[m * manifold_record.SIZE + manifold_record.POINT_COUNT])
            ):
                q = begin + point * width
                rows[q + contact_point.RESTITUTION_NORMAL] *= s
                rows[q + contact_point.RESTITUTION_TANGENT_1] *= s
                rows[q + contact_point.RESTITUTION_TANGENT_2] *= s
