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
from rigid_body_sim.physics.contact.collision.narrow_phase import COUNT, LANE, RECORD
from rigid_body_sim.physics.contact.energy.account import kinetic, twice
from rigid_body_sim.physics.contact.energy.groups import (
    ACCOUNT,
    FACTOR,
    LINEAR,
    SHARE,
    SQUARE,
    TAKEN,
    join_pressing,
)
from rigid_body_sim.physics.contact.solver.constraint import (
    APPROACH,
    BN,
    BO,
    BOUNCE,
    BT,
    MANIFOLD,
    TOUCHED,
    A,
    B,
)
from rigid_body_sim.physics.contact.solver_bodies import BODY, ENERGY, L_HELD, P_HELD, L, P

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@kernel
def before_bounce(i: int, bodies: Array) -> None:
    """Keep the momenta from which the bounce starts."""
    o = i * BODY
    for axis in range(3):
        bodies[o + P_HELD + axis] = bodies[o + P + axis]
        bodies[o + L_HELD + axis] = bodies[o + L + axis]


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
        g = touching[t] * ACCOUNT
        for entry in range(TAKEN, FACTOR):
            accounts[g + entry] = 0.0
        accounts[g + FACTOR] = 1.0
    for m in range(manifolds):
        place = int(records[m * RECORD + LANE])
        a, b = int(rows[place + A]) // BODY, int(rows[place + B]) // BODY
        g = groups[b if a == nothing else a] * ACCOUNT
        begin = place + MANIFOLD
        for point in range(int(records[m * RECORD + COUNT])):
            q = begin + point * width
            if rows[place + TOUCHED] > 0.0 and rows[q + APPROACH] < 0.0:
                accounts[g + SHARE] = max(accounts[g + SHARE], rows[place + BOUNCE])
    for t in range(touched):
        o = touching[t] * BODY
        g = groups[touching[t]] * ACCOUNT
        x, y, z = bodies[o + P_HELD], bodies[o + P_HELD + 1], bodies[o + P_HELD + 2]
        u, v, w = bodies[o + L_HELD], bodies[o + L_HELD + 1], bodies[o + L_HELD + 2]
        before = 0.5 * twice(bodies, o, x, y, z, u, v, w)
        x, y, z = bodies[o + P] - x, bodies[o + P + 1] - y, bodies[o + P + 2] - z
        u, v, w = bodies[o + L] - u, bodies[o + L + 1] - v, bodies[o + L + 2] - w
        square = 0.5 * twice(bodies, o, x, y, z, u, v, w)
        accounts[g + TAKEN] += bodies[o + ENERGY] - before
        accounts[g + SQUARE] += square
        accounts[g + LINEAR] += kinetic(bodies, o) - before - square
    for t in range(touched):
        g = touching[t] * ACCOUNT
        if groups[touching[t]] == touching[t]:
            taken = accounts[g + SHARE] * accounts[g + SHARE] * accounts[g + TAKEN]
            accounts[g + FACTOR] = _factor(taken, accounts[g + LINEAR], accounts[g + SQUARE])
    for t in range(touched):
        o = touching[t] * BODY
        s = accounts[groups[touching[t]] * ACCOUNT + FACTOR]
        if s < 1.0:
            for axis in range(3):
                p, j = bodies[o + P_HELD + axis], bodies[o + L_HELD + axis]
                bodies[o + P + axis] = p + s * (bodies[o + P + axis] - p)
                bodies[o + L + axis] = j + s * (bodies[o + L + axis] - j)
    for m in range(manifolds):
        place = int(records[m * RECORD + LANE])
        a, b = int(rows[place + A]) // BODY, int(rows[place + B]) // BODY
        s = accounts[groups[b if a == nothing else a] * ACCOUNT + FACTOR]
        begin = place + MANIFOLD
        if s < 1.0:
            for point in range(int(records[m * RECORD + COUNT])):
                q = begin + point * width
                rows[q + BN] *= s
                rows[q + BT] *= s
                rows[q + BO] *= s
