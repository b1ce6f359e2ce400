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
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.energy import pressing_groups
from rigid_body_sim.physics.contact.solver import constraint, contact_point

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
    accounts[nothing * pressing_groups.ACCOUNT + pressing_groups.PARENT] = HUNG
    for t in range(touched):
        i = touching[t]
        held = accounts[groups[i] * pressing_groups.ACCOUNT + pressing_groups.HELD]
        on_none = held == pressing_groups.FREE and groups[i] == i
        accounts[i * pressing_groups.ACCOUNT + pressing_groups.PARENT] = (
            HUNG if on_none or held < pressing_groups.FREE else LOOSE
        )
    count, before = 0, -1
    while count > before:
        before = count
        for m in range(manifolds):
            place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
            a, b = (
                int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
                int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
            )
            a_hangs = accounts[a * pressing_groups.ACCOUNT + pressing_groups.PARENT] != LOOSE
            b_hangs = accounts[b * pressing_groups.ACCOUNT + pressing_groups.PARENT] != LOOSE
            if a_hangs != b_hangs and rows[place + constraint.TOUCHED] > 0.0:
                i = b if a_hangs else a
                accounts[i * pressing_groups.ACCOUNT + pressing_groups.PARENT] = float(m)
                accounts[count * pressing_groups.ACCOUNT + pressing_groups.ORDER] = float(i)
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
        i = int(accounts[(count - 1 - k) * pressing_groups.ACCOUNT + pressing_groups.ORDER])
        m = int(accounts[i * pressing_groups.ACCOUNT + pressing_groups.PARENT])
        place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
        a, b = (
            int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
            int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
        )
        other = a if i == b else b
        x, y, z = (
            accounts[i * pressing_groups.ACCOUNT + pressing_groups.IMPULSE],
            accounts[i * pressing_groups.ACCOUNT + pressing_groups.IMPULSE + 1],
            accounts[i * pressing_groups.ACCOUNT + pressing_groups.IMPULSE + 2],
        )
        if other != nothing:
            accounts[other * pressing_groups.ACCOUNT + pressing_groups.IMPULSE] += x
            accounts[other * pressing_groups.ACCOUNT + pressing_groups.IMPULSE + 1] += y
            accounts[other * pressing_groups.ACCOUNT + pressing_groups.IMPULSE + 2] += z
        normal, first, second = (
            place + constraint.NORMAL,
            place + constraint.TANGENT_1,
            place + constraint.TANGENT_2,
        )
        sign = 1.0 if i == b else -1.0
        along = sign * (x * rows[normal] + y * rows[normal + 8] + z * rows[normal + 16])
        across = sign * (x * rows[first] + y * rows[first + 8] + z * rows[first + 16])
        other_way = sign * (x * rows[second] + y * rows[second + 8] + z * rows[second + 16])
        begin, points = (
            place + constraint.SIZE,
            int(records[m * manifold_record.SIZE + manifold_record.POINT_COUNT]),
        )
        total = 0.0
        for q in range(begin, begin + points * width, width):
            total += rows[q + contact_point.TOTAL_IMPULSE] + rows[q + contact_point.NORMAL_IMPULSE]
        for q in range(begin, begin + points * width, width):
            pressing = (
                rows[q + contact_point.TOTAL_IMPULSE] + rows[q + contact_point.NORMAL_IMPULSE]
            )
            share = pressing / total if total > 0.0 else 1.0 / points
            rows[q + contact_point.TOTAL_IMPULSE] += share * along
            rows[q + contact_point.TOTAL_IMPULSE + 8] += share * across
            rows[q + contact_point.TOTAL_IMPULSE + 16] += share * other_way
