# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
By which contacts bodies got a change of momentum that was found for their group as a whole.

Impulses act between two bodies, so those that give each body of a group its own change can be
found on any tree of contacts that presses the group together: from its leaves to what cannot
move, each body takes its change, and that of all that hangs on it, by the one manifold on which
it hangs. In a manifold they go to the points as what these press already.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.narrow_phase import COUNT, LANE, RECORD
from rigid_body_sim.physics.contact.energy.groups import ACCOUNT, FREE, HELD, ORDER, PARENT
from rigid_body_sim.physics.contact.solver.constraint import (
    JN,
    MANIFOLD,
    SUM,
    T2,
    TOUCHED,
    A,
    B,
    N,
    T,
)
from rigid_body_sim.physics.contact.solver_bodies import BODY, P_HELD

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# PARENT of a body is the manifold on which it hangs, or:
LOOSE, HUNG = -1.0, -2.0


@kernel
def hang(
    manifolds: int, touched: int, nothing: int, touching: Indices, records: Array, rows: Array,
    groups: Indices, accounts: Array,
) -> int:  # fmt: skip
    """
    Hang each body by one manifold that presses onto what cannot move, or onto what hangs already;
    a group that hangs on nothing hangs on its first body. List the bodies in this order, and
    return how many they are.
    """
    accounts[nothing * ACCOUNT + PARENT] = HUNG
    for t in range(touched):
        i = touching[t]
        held = accounts[groups[i] * ACCOUNT + HELD]
        on_none = held == FREE and groups[i] == i
        accounts[i * ACCOUNT + PARENT] = HUNG if on_none or held < FREE else LOOSE
    count, before = 0, -1
    while count > before:
        before = count
        for m in range(manifolds):
            place = int(records[m * RECORD + LANE])
            a, b = int(rows[place + A]) // BODY, int(rows[place + B]) // BODY
            a_hangs = accounts[a * ACCOUNT + PARENT] != LOOSE
            b_hangs = accounts[b * ACCOUNT + PARENT] != LOOSE
            if a_hangs != b_hangs and rows[place + TOUCHED] > 0.0:
                i = b if a_hangs else a
                accounts[i * ACCOUNT + PARENT] = float(m)
                accounts[count * ACCOUNT + ORDER] = float(i)
                count += 1
    return count


@kernel
def charge(
    count: int, nothing: int, width: int, records: Array, rows: Array, accounts: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Add what bodies were given to the impulses of the manifolds by which they hang, the last first:
    contacts are read with the whole change of momentum.
    """
    for k in range(count):
        i = int(accounts[(count - 1 - k) * ACCOUNT + ORDER])
        m = int(accounts[i * ACCOUNT + PARENT])
        place = int(records[m * RECORD + LANE])
        a, b = int(rows[place + A]) // BODY, int(rows[place + B]) // BODY
        other = a if i == b else b
        x, y, z = (
            bodies[i * BODY + P_HELD],
            bodies[i * BODY + P_HELD + 1],
            bodies[i * BODY + P_HELD + 2],
        )
        if other != nothing:
            bodies[other * BODY + P_HELD] += x
            bodies[other * BODY + P_HELD + 1] += y
            bodies[other * BODY + P_HELD + 2] += z
        normal, first, second = place + N, place + T, place + T2
        sign = 1.0 if i == b else -1.0
        along = sign * (x * rows[normal] + y * rows[normal + 8] + z * rows[normal + 16])
        across = sign * (x * rows[first] + y * rows[first + 8] + z * rows[first + 16])
        other_way = sign * (x * rows[second] + y * rows[second + 8] + z * rows[second + 16])
        begin, points = place + MANIFOLD, int(records[m * RECORD + COUNT])
        total = 0.0
        for q in range(begin, begin + points * width, width):
            total += rows[q + SUM] + rows[q + JN]
        for q in range(begin, begin + points * width, width):
            pressing = rows[q + SUM] + rows[q + JN]
            share = pressing / total if total > 0.0 else 1.0 / points
            rows[q + SUM] += share * along
            rows[q + SUM + 8] += share * across
            rows[q + SUM + 16] += share * other_way
