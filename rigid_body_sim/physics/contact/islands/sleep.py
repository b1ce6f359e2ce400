# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Islands that sleep: who falls asleep, who wakes, and how a sleeper keeps still.

An island falls asleep at the end of a tick if something that cannot move holds it and each of its
bodies has, for `sleep_time` without a break,

    touched something        |v| < sleep_speed,  |omega| r < sleep_speed
    felt the same wrench     |F - F'| <= STEADY |F|,  |T - T'| <= STEADY (|T| + |F| r)

    r      : [m] radius of the ball about the centre of mass that holds its shape
    F, T   : all but contacts; F', T' when the time began to count

Its momenta become zero: what was left of them is lost, at most m sleep_speed a body. To detection
and solver a sleeper is like what cannot move; its contacts with sleepers and with what cannot move
are neither looked for nor solved.

An island wakes, as a whole and before anything else happens in a tick, if momentum or wrench of a
body are no longer those it fell asleep with, to the bit (impulses, commands, forces that begin or
end), or if something awake may touch it within the tick. Its contacts then go on with the impulses
they had.

Limits: whatever creeps more slowly than `sleep_speed` is stopped, a ball that rolls without
resistance too. An island wakes and sleeps as one, however large it is.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    collider,
    manifold_record,
    narrow_phase,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.islands.islands import find_islands, may_touch
from rigid_body_sim.physics.state.blocks import (
    EX,
    FX,
    GX,
    LX,
    PX,
    QX,
    ROTATION,
    RX,
    TRANSLATION,
    TX,
    at,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STEADY = 1e-5  # [-] change of a wrench that drives a body; springs at rest jitter by less

# of a body
ISLAND, TIMER, WRENCH = 0, 1, 2  # 0: awake, n > 0: asleep in island n, -n: wakes; [s]; F', T'
SLEEPER = 8

# limits: speed [m/s], time [s], then the radius of each body [m]
SLEEP_SPEED, SLEEP_TIME, RADIUS = range(3)


@inline
def asleep(i: int, slumber: Array) -> bool:
    """Tell whether a body sleeps."""
    return slumber[i * SLEEPER + ISLAND] != 0.0


@inline
def _home(core: int) -> int:
    """Core index in the table of a body that sleeps or not; -1 where it cannot move."""
    return core if core >= -1 else -2 - core


# ward: integers: how many are restless, then parts of n numbers, one a body; then the blocks
GROUPS, PARENTS, HELD_UP, RESTLESS, BLOCKS = range(5)  # restless: shares a block with what moves


@inline
def _part(which: int, n: int) -> int:
    """Where a part of the ward begins."""
    return 1 + which * n


@inline
def stirs(block: int, n: int, ward: Indices) -> Any:
    """Tell whether some body of a block is awake."""
    return ward[_part(BLOCKS, n) + block] > 0


def ward_of(groups: Indices) -> Indices:
    """Make the integers that the kernels need of a scene: groups of force elements, and room."""
    n = len(groups)
    ward = np.zeros(1 + 4 * n + (n + 63) // 64, dtype=np.int64)
    ward[1 : 1 + n] = groups
    return ward


@kernel
def lay_down(
    n: int, n_bodies: int, n_rigid: int, translation: Array, rotation: Array, table: Indices,
    mounts: Array, poses: Array, reaches: Array, bodies: Array, slumber: Array,
) -> None:  # fmt: skip
    """Give sleepers the poses they keep, and let the table say who sleeps: core -2 - core."""
    for i in range(n):
        table[i * collider.TABLE + collider.CORE] = _home(
            table[i * collider.TABLE + collider.CORE]
        )
    narrow_phase.find_poses(n, n_rigid, translation, rotation, table, mounts, poses)
    for i in range(n):
        core = table[i * collider.TABLE + collider.CORE]
        if core >= 0 and asleep(core, slumber):
            table[i * collider.TABLE + collider.CORE] = -2 - core
            for entry in range(4):  # velocity, and what turning adds
                reaches[i * swept_aabbs.SIZE + swept_aabbs.VELOCITY + entry] = 0.0
    for i in range(n_bodies):
        if asleep(i, slumber):
            solver_bodies.begin_tick(i, n_rigid, translation, rotation, bodies)


@inline
def _same_wrench(i, n_rigid, translation, rotation, slumber):
    o = i * SLEEPER + WRENCH
    k = at(i, TRANSLATION)
    same = True
    for axis in range(3):
        same = same and translation[k + FX + 64 * axis] == slumber[o + axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            same = same and rotation[k + TX + 64 * axis] == slumber[o + 3 + axis]
    return same


@inline
def _still(i, n_rigid, translation, rotation):
    k = at(i, TRANSLATION)
    still = True
    for axis in range(3):
        still = still and translation[k + PX + 64 * axis] == 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            still = still and rotation[k + LX + 64 * axis] == 0.0
    return still


@kernel
def stir(
    n_bodies: int, n_rigid: int, translation: Array, rotation: Array, slumber: Array,
    ward: Indices,
) -> int:  # fmt: skip
    """Count the bodies that are awake; -1: some sleeper, now marked, wakes."""
    awake = 0
    woken = False
    for block in range((n_bodies + 63) // 64):
        here = 0
        for i in range(64 * block, min(64 * block + 64, n_bodies)):
            if not asleep(i, slumber):
                here += 1
            elif not (
                _still(i, n_rigid, translation, rotation)
                and _same_wrench(i, n_rigid, translation, rotation, slumber)
            ):
                slumber[i * SLEEPER + ISLAND] = -abs(slumber[i * SLEEPER + ISLAND])
                woken = True
        ward[1 + 4 * n_bodies + block] = here
        awake += here
    if woken:
        return -1
    restless = _part(RESTLESS, n_bodies)
    count = 0
    for block in range((n_bodies + 63) // 64):
        if stirs(block, n_bodies, ward):
            for i in range(64 * block, min(64 * block + 64, n_bodies)):
                if asleep(i, slumber):
                    ward[restless + count] = i
                    count += 1
    ward[0] = count
    return awake


@kernel
def reached(
    manifolds: int, h: float, table: Indices, reaches: Array, records: Array, slumber: Array
) -> bool:
    """Tell whether something awake may touch a sleeper within the tick, and mark whom."""
    some = False
    for m in range(manifolds):
        a = table[
            int(records[m * manifold_record.SIZE + manifold_record.COLLIDER_A]) * collider.TABLE
            + collider.CORE
        ]
        b = table[
            int(records[m * manifold_record.SIZE + manifold_record.COLLIDER_B]) * collider.TABLE
            + collider.CORE
        ]
        if (a < -1 or b < -1) and may_touch(m, h, reaches, records):
            o = _home(min(a, b)) * SLEEPER
            slumber[o + ISLAND] = -abs(slumber[o + ISLAND])
            some = True
    return some


@kernel
def keep_still(
    n_bodies: int, n_rigid: int, translation: Array, rotation: Array, bodies: Array, ward: Indices
) -> None:
    """Put the sleepers of blocks that moved back to the bit."""
    restless = _part(RESTLESS, n_bodies)
    for j in range(ward[0]):
        i = ward[restless + j]
        o = i * solver_bodies.SIZE
        _stop(i, n_rigid, translation, rotation)
        k = at(i, TRANSLATION)
        for axis in range(3):
            translation[k + RX + 64 * axis] = bodies[o + solver_bodies.START_POSITION + axis]
            translation[k + EX + 64 * axis] = bodies[o + solver_bodies.START_RESIDUAL + axis]
        if i < n_rigid:
            k = at(i, ROTATION)
            for entry in range(4):
                rotation[k + QX + 64 * entry] = bodies[o + solver_bodies.START_ORIENTATION + entry]


@inline
def _stop(i, n_rigid, translation, rotation):
    """Take all momentum."""
    k = at(i, TRANSLATION)
    for axis in range(3):
        translation[k + PX + 64 * axis] = 0.0
        translation[k + GX + 64 * axis] = 0.0
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            rotation[k + LX + 64 * axis] = 0.0


@inline
def _is_slow(i, radius, limit, bodies):
    o = i * solver_bodies.SIZE
    u, v, w = (
        bodies[o + solver_bodies.MOMENTUM],
        bodies[o + solver_bodies.MOMENTUM + 1],
        bodies[o + solver_bodies.MOMENTUM + 2],
    )
    speed = bodies[o + solver_bodies.INVERSE_MASS] * math.sqrt(u * u + v * v + w * w)
    x, y, z = (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2],
    )
    p = (
        bodies[o + solver_bodies.INVERSE_INERTIA] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 1] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 2] * z
    )
    q = (
        bodies[o + solver_bodies.INVERSE_INERTIA + 1] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 3] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 4] * z
    )
    r = (
        bodies[o + solver_bodies.INVERSE_INERTIA + 2] * x
        + bodies[o + solver_bodies.INVERSE_INERTIA + 4] * y
        + bodies[o + solver_bodies.INVERSE_INERTIA + 5] * z
    )
    return speed < limit and radius * math.sqrt(p * p + q * q + r * r) < limit


@inline
def _note_wrench(i, n_rigid, translation, rotation, slumber):
    o = i * SLEEPER + WRENCH
    k = at(i, TRANSLATION)
    for axis in range(3):
        slumber[o + axis] = translation[k + FX + 64 * axis]
    if i < n_rigid:
        k = at(i, ROTATION)
        for axis in range(3):
            slumber[o + 3 + axis] = rotation[k + TX + 64 * axis]


@inline
def _is_steady(i, n_rigid, radius, translation, rotation, slumber):
    o = i * SLEEPER + WRENCH
    k = at(i, TRANSLATION)
    size, change = 0.0, 0.0
    for axis in range(3):
        f = translation[k + FX + 64 * axis]
        size += f * f
        change += (f - slumber[o + axis]) * (f - slumber[o + axis])
    steady = change <= STEADY * STEADY * size
    if i < n_rigid:
        k = at(i, ROTATION)
        size *= radius * radius
        change = 0.0
        for axis in range(3):
            f = rotation[k + TX + 64 * axis]
            size += f * f
            change += (f - slumber[o + 3 + axis]) * (f - slumber[o + 3 + axis])
        steady = steady and change <= STEADY * STEADY * size
    return steady


@kernel
def settle(
    whole: bool, touched: int, manifolds: int, h: float, n_bodies: int, n_rigid: int,
    translation: Array, rotation: Array, table: Indices, reaches: Array, records: Array,
    memory: Array, bodies: Array, touching: Indices, slumber: Array, limits: Array, ward: Indices,
) -> int:  # fmt: skip
    """
    Count the time that bodies rest, and let islands fall asleep; return how many bodies did.

    whole             : not a piece of a tick: in the middle of one nobody falls asleep
    touched, touching : the bodies with contacts in this tick, whose rows in `bodies` are current
    """
    for j in range(touched):
        i = touching[j]
        o = i * SLEEPER
        radius = limits[RADIUS + i]
        if not _is_steady(i, n_rigid, radius, translation, rotation, slumber):
            _note_wrench(i, n_rigid, translation, rotation, slumber)
        elif _is_slow(i, radius, limits[SLEEP_SPEED], bodies):
            slumber[o + TIMER] = -(slumber[o + TIMER] + h)  # the sign: in this tick
    tired = False
    for i in range(n_bodies):
        timer = -slumber[i * SLEEPER + TIMER]
        slumber[i * SLEEPER + TIMER] = timer if timer > 0.0 else 0.0
        tired = tired or (timer >= limits[SLEEP_TIME] and timer > 0.0)
    if not (tired and whole):
        return 0
    begin = _part(GROUPS, n_bodies)
    groups = ward[begin : begin + n_bodies]
    parents = ward[begin + n_bodies : begin + 2 * n_bodies]
    held = ward[begin + 2 * n_bodies : begin + 3 * n_bodies]
    find_islands(
        manifolds, n_bodies, h, table, reaches, records, memory, groups, parents,
        held,
    )  # fmt: skip
    for i in range(n_bodies):
        timer = slumber[i * SLEEPER + TIMER]
        if not (timer >= limits[SLEEP_TIME] and timer > 0.0):
            held[parents[i]] = 0
    fell = 0
    for i in range(n_bodies):
        if held[parents[i]] == 1:
            slumber[i * SLEEPER + ISLAND] = float(1 + parents[i])
            _stop(i, n_rigid, translation, rotation)
            fell += 1
    return fell


@kernel
def note_wrenches(
    n_bodies: int, n_rigid: int, translation: Array, rotation: Array, slumber: Array
) -> None:
    """Note the wrenches with which bodies fell asleep in this tick."""
    for i in range(n_bodies):
        if slumber[i * SLEEPER + TIMER] > 0.0 and asleep(i, slumber):
            slumber[i * SLEEPER + TIMER] = 0.0
            _note_wrench(i, n_rigid, translation, rotation, slumber)


KERNELS = {
    'asleep': asleep,
    'keep_still': keep_still,
    'lay_down': lay_down,
    'note_wrenches': note_wrenches,
    'reached': reached,
    'settle': settle,
    'stir': stir,
    'stirs': stirs,
}  # by the names that `tick` leaves open
