# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact takes energy, or leaves it: what a group of bodies that press on each other has gained
over a tick, because a tick is not infinitely short, is taken back.

The motion of a substep is of second order, so a group may gain or lose some (omega h)^3 of its
energy in it, and what had sunk in a little is lifted when it is unloaded. Losses look like
contact. Gains do not, and grow into vibration:

    gain = sum over the group of T - (T_0 + W) > 0        (`energy_account`)

A group pays with its motion relative to u, the motion that contact could not change
(`group_motion`):

    v <- u + s (v - u),   s^2 = 1 - gain / (kinetic energy of v - u)

which is a projection onto the energy that has not risen (Hairer, Lubich, Wanner 2006, IV.4),
one-sided. That would hold back what hardly moves, so a body alone that is slow (`SLOW`), but does
not rest (`STILL`), pays with its place: it is let down again onto what holds it by what it was
lifted,

    r <- r + d n,   d = gain / (n . F),   |d| <= LIFT h^2 |F| / m
        n : [-] direction of the impulse of all that cannot move, F : [N] force upon the body

which is some nanometres; and so it pays what its motion does not suffice for.

Limits: what overlaps by more than LIFT gains what lifts it, and so do piles. To several bodies
that are slow, gains below `START` are left. Where friction holds the group, momentum goes with the
energy; `charged_impulses` tells which contacts gave it. Two planes without friction that are not
parallel count as one that holds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.energy import pressing_groups
from rigid_body_sim.physics.contact.energy.account import kinetic, twice
from rigid_body_sim.physics.contact.energy.pressing_groups import find_held, join_pressing
from rigid_body_sim.physics.contact.energy.rigid_motion import find_rigid_motions, rigid_momenta
from rigid_body_sim.physics.contact.solver import batch_record, constraint, contact_point
from rigid_body_sim.physics.state.blocks import FX, RX, TRANSLATION, at

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# [-] of the energy of what falls for a substep from rest, see above: kinetic energies, which are
# 0.1 mm/s and 0.03 m/s with 4 substeps in 1/240 s, and gains that are left
STILL, SLOW = 1e-4, 10.0
SMALL, START = 1e-6, 2e-3
ROUND_OFF = 1e-13  # [-] of its kinetic energy
LIFT = 0.2  # [-] of h^2 |F| / m: twice what the ground gives way under a body


@inline
def _fall(i: int, h: float, translation: Array, bodies: Array) -> Any:
    """Kinetic energy of a body that falls for a substep from rest [J]."""
    k = at(i, TRANSLATION)
    x, y, z = h * translation[k + FX], h * translation[k + FX + 64], h * translation[k + FX + 128]
    return (
        0.5 * bodies[i * solver_bodies.SIZE + solver_bodies.INVERSE_MASS] * (x * x + y * y + z * z)
    )


@inline
def _allowed(bodies: float, fall: float, moving: float) -> Any:
    """Gain [J] that is left to so many bodies that move with a kinetic energy."""
    share = START if bodies > 1.0 and moving < SLOW * fall else SMALL
    return share * fall + ROUND_OFF * moving


@kernel
def _find_gains(
    touched: int, h: float, touching: Indices, groups: Indices, translation: Array,
    bodies: Array, accounts: Array,
) -> bool:  # fmt: skip
    """Open the accounts of the groups, and tell whether any has gained."""
    for t in range(touched):
        g = touching[t] * pressing_groups.ACCOUNT
        for entry in range(pressing_groups.HELD):
            accounts[g + entry] = 0.0
        accounts[g + pressing_groups.MOVING] = 0.0
    for t in range(touched):
        i = touching[t]
        g, k = groups[i] * pressing_groups.ACCOUNT, at(i, TRANSLATION)
        accounts[g + pressing_groups.GAIN] += bodies[i * solver_bodies.SIZE + solver_bodies.ENERGY]
        accounts[g + pressing_groups.BODIES] += 1.0
        accounts[g + pressing_groups.FALL] += _fall(i, h, translation, bodies)
        accounts[g + pressing_groups.MOVING] += kinetic(bodies, i * solver_bodies.SIZE)
        for axis in range(3):
            accounts[g + pressing_groups.FORCE + axis] += translation[k + FX + 64 * axis]
    found = False
    for t in range(touched):
        g = touching[t] * pressing_groups.ACCOUNT
        gains = groups[touching[t]] == touching[t] and accounts[
            g + pressing_groups.GAIN
        ] > _allowed(
            accounts[g + pressing_groups.BODIES],
            accounts[g + pressing_groups.FALL],
            accounts[g + pressing_groups.MOVING],
        )
        found = found or gains
        accounts[g + pressing_groups.HELD] = (
            pressing_groups.UNHELD if gains else pressing_groups.CALM
        )
        for entry in range(pressing_groups.HELD + 1, pressing_groups.ACCOUNT):
            accounts[g + entry] = 0.0
    return found


@kernel
def _find_moving(
    touched: int, touching: Indices, groups: Indices, translation: Array, bodies: Array,
    accounts: Array,
) -> None:  # fmt: skip
    """Add up the kinetic energy of each group relative to its rigid motion."""
    for t in range(touched):
        i = touching[t]
        o, g = i * solver_bodies.SIZE, groups[i] * pressing_groups.ACCOUNT
        if accounts[g + pressing_groups.HELD] >= pressing_groups.FREE:
            x, y, z, u, v, w = rigid_momenta(i, g, translation, bodies, accounts)
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
            accounts[g + pressing_groups.MOVING] += 0.5 * twice(bodies, o, x, y, z, u, v, w)


@inline
def _pays_with_its_place(g: int, accounts: Array) -> bool:
    """Tell whether a group is a body alone that is slow but does not rest."""
    moving, fall = accounts[g + pressing_groups.MOVING], accounts[g + pressing_groups.FALL]
    return accounts[g + pressing_groups.BODIES] == 1.0 and STILL * fall < moving < SLOW * fall


@inline
def _let_down(g: int, accounts: Array) -> Any:
    """
    How far a body alone is let down.

    returns : d / |impulse| [m/(N s)], negative or 0
    """
    rest = accounts[g + pressing_groups.GAIN]
    if not _pays_with_its_place(g, accounts):
        rest -= accounts[g + pressing_groups.MOVING]
    if (
        not rest > 0.0
        or accounts[g + pressing_groups.BODIES] > 1.0
        or accounts[g + pressing_groups.HELD] < pressing_groups.SLIDING
    ):
        return 0.0
    i, j = g + pressing_groups.PRESS, g + pressing_groups.FORCE
    x, y, z = accounts[i], accounts[i + 1], accounts[i + 2]
    u, v, w = accounts[j], accounts[j + 1], accounts[j + 2]
    along = x * u + y * v + z * w
    if not along < 0.0:
        return 0.0
    size = math.sqrt((x * x + y * y + z * z) * (u * u + v * v + w * w))
    # h^2 |F| / m = 2 `FALL` / |F|
    return (
        rest / along
        if rest * size <= -2.0 * LIFT * accounts[g + pressing_groups.FALL] * along
        else 0.0
    )


@kernel
def _let_gaps_follow(
    count: int, nothing: int, width: int, batches: Indices, rows: Array, groups: Indices,
    accounts: Array,
) -> None:  # fmt: skip
    """Let the gaps of those that were let down be those of their new places."""
    for batch in range(count):
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        length = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT] * width
        for place in range(
            begin, begin + batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        ):
            a, b = (
                int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE,
                int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE,
            )
            g = groups[b if a == nothing else a] * pressing_groups.ACCOUNT
            if (
                accounts[g + pressing_groups.HELD] == pressing_groups.CALM
                or accounts[g + pressing_groups.DOWN] == 0.0
            ):
                continue
            closer = 0.0
            for axis in range(3):
                closer += (
                    accounts[g + pressing_groups.PRESS + axis]
                    * rows[place + constraint.NORMAL + 8 * axis]
                )
            closer *= (
                accounts[g + pressing_groups.DOWN]
                if a == nothing
                else -accounts[g + pressing_groups.DOWN]
            )
            first = place + constraint.SIZE
            for q in range(first, first + length, width):
                rows[q + contact_point.SEPARATION] += closer


@inline
def _slow_down(i: int, g: int, translation: Array, bodies: Array, accounts: Array) -> None:
    """Let a body pay with its motion; IMPULSE becomes the change of its momentum."""
    o = i * solver_bodies.SIZE
    moving = accounts[g + pressing_groups.MOVING]
    if not moving > 0.0:
        return
    k = i * pressing_groups.ACCOUNT + pressing_groups.IMPULSE
    s = math.sqrt(max(0.0, 1.0 - accounts[g + pressing_groups.GAIN] / moving))
    x, y, z, u, v, w = rigid_momenta(i, g, translation, bodies, accounts)
    x, y, z = (
        x - bodies[o + solver_bodies.MOMENTUM],
        y - bodies[o + solver_bodies.MOMENTUM + 1],
        z - bodies[o + solver_bodies.MOMENTUM + 2],
    )
    x, y, z = (1.0 - s) * x, (1.0 - s) * y, (1.0 - s) * z
    (
        accounts[k],
        accounts[k + 1],
        accounts[k + 2],
    ) = x, y, z
    bodies[o + solver_bodies.MOMENTUM] += x
    bodies[o + solver_bodies.MOMENTUM + 1] += y
    bodies[o + solver_bodies.MOMENTUM + 2] += z
    bodies[o + solver_bodies.ANGULAR_MOMENTUM] = u + s * (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM] - u
    )
    bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1] = v + s * (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1] - v
    )
    bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2] = w + s * (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2] - w
    )


@kernel
def take_back(
    count: int, touched: int, nothing: int, width: int, h: float, touching: Indices,
    batches: Indices, rows: Array, groups: Indices, translation: Array, accounts: Array,
    bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what groups have gained over a tick of substeps h. Tell whether any has: then IMPULSE
    of each body is the change of its momentum.

        count   : batches
        nothing : index of what cannot move
        width   : numbers of a point
        groups  : scratch, one number a body
        accounts: scratch, ACCOUNT numbers a body
    """
    any_gain = False
    for t in range(touched):
        i = touching[t]
        o = i * solver_bodies.SIZE
        moving = kinetic(bodies, o)
        gain = moving - bodies[o + solver_bodies.ENERGY]
        bodies[o + solver_bodies.ENERGY] = gain
        if gain > _allowed(1.0, _fall(i, h, translation, bodies), moving):
            any_gain = True
    if not any_gain:
        return False
    join_pressing(count, touched, nothing, touching, batches, rows, groups)
    if not _find_gains(touched, h, touching, groups, translation, bodies, accounts):
        return False
    find_held(count, nothing, width, batches, rows, groups, accounts)
    find_rigid_motions(touched, touching, groups, translation, bodies, accounts)
    _find_moving(touched, touching, groups, translation, bodies, accounts)
    let_down = False
    for t in range(touched):
        i = touching[t]
        g, k = groups[i] * pressing_groups.ACCOUNT, at(i, TRANSLATION)
        for axis in range(3):
            accounts[i * pressing_groups.ACCOUNT + pressing_groups.IMPULSE + axis] = 0.0
        if accounts[g + pressing_groups.HELD] < pressing_groups.FREE:
            continue
        down = _let_down(g, accounts)
        accounts[g + pressing_groups.DOWN] = down
        let_down = let_down or down < 0.0
        for axis in range(3):
            translation[k + RX + 64 * axis] += down * accounts[g + pressing_groups.PRESS + axis]
            bodies[i * solver_bodies.SIZE + solver_bodies.DISPLACEMENT + axis] += (
                down * accounts[g + pressing_groups.PRESS + axis]
            )
        if not (down < 0.0 and _pays_with_its_place(g, accounts)):
            _slow_down(i, g, translation, bodies, accounts)
    if let_down:
        _let_gaps_follow(count, nothing, width, batches, rows, groups, accounts)
    return True
