# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact takes energy, or leaves it: what a group of bodies that press on each other has gained
over a tick by rounding off of its motion is taken back.

The motion of a substep is of second order, so a group may gain or lose some (omega h)^3 of its
energy in it, and what had sunk in a little is lifted when it is unloaded. Losses look like
contact. Gains do not, and grow into vibration:

    gain = sum over the group of T - (T_0 + W) > 0        (`energy_account`)
    v <- u + s (v - u),   s^2 = 1 - gain / (kinetic energy of the motion relative to u)

u is the rigid motion of the group that contact could not change, which keeps what is conserved:

    nothing that cannot move is touched:    V + Omega x r of its momentum and angular momentum
    it is, along one plane, without friction:  of these V along it, Omega about its normal
    else:                                   0

and, because contacts do not move in u, v - u shrinks without opening or closing any. This is a
projection onto the energy that has not risen (Hairer, Lubich, Wanner 2006, IV.4), one-sided.

Limits: gains below `SMALL` are left, for what starts from rest should not be held by them. A group
that stands still has nothing to give: what sank in is lifted, m g times some micrometres. Where
friction holds the group, momentum goes with the energy; `charged_impulses` tells which contacts
gave it. Two planes without friction that are not parallel count as one that holds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.blocks import FX, RX, TRANSLATION, at
from rigid_body_sim.physics.contact.solving.assembly import BATCH, OFFSET, USED
from rigid_body_sim.physics.contact.solving.energy_account import (
    join_pressing,
    kinetic,
    twice,
)
from rigid_body_sim.physics.contact.solving.lanes import cross, times
from rigid_body_sim.physics.contact.solving.rows import MU, ROLL, SPIN, TOUCHED, A, B, N
from rigid_body_sim.physics.contact.touching_bodies import BODY, ENERGY, II, IM, P_HELD, L, P
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# of the first body of a group
GAIN, ALLOWED = 0, 1  # [J]
HELD = 2  # CALM: has not gained; else how it is held by what cannot move
MASS, CENTRE = 3, 4  # [kg]; (3) [m]
U, OMEGA = 7, 10  # (3) [m/s], (3) [rad/s] of the rigid motion; momenta on the way
INERTIA = 13  # (6) [kg m^2] about the centre: xx, xy, xz, yy, yz, zz
NORMAL = 19  # (3) [-] of the plane
MOVING = 22  # [J] kinetic energy of the motion relative to u
ACCOUNT = 25  # with two of `charged_impulses`

CALM, ALONE, FREE, SLIDING, FAST = -2.0, -1.0, 0.0, 1.0, 2.0  # ALONE: nothing presses

SMALL = 2e-3  # [-] of the energy of a body that falls for a substep from rest
ROUND_OFF = 1e-13  # [-] of its kinetic energy
PARALLEL = 1e-12  # [-] 1 - cosine, at most


@inline
def _allowed(i: int, h: float, translation: Array, bodies: Array) -> Any:
    k = at(i, TRANSLATION)
    x, y, z = h * translation[k + FX], h * translation[k + FX + 64], h * translation[k + FX + 128]
    o = i * BODY
    fall = 0.5 * bodies[o + IM] * (x * x + y * y + z * z)
    return SMALL * fall + ROUND_OFF * kinetic(bodies, o)


@inline
def _solve(xx, xy, xz, yy, yz, zz, x, y, z):
    """Solve a symmetric system; 0 where it is singular."""
    a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    d, e, f = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    determinant = xx * a + xy * b + xz * c
    k = 1.0 / determinant if determinant > 0.0 else 0.0
    return k * (a * x + b * y + c * z), k * (b * x + d * y + e * z), k * (c * x + e * y + f * z)


@inline
def _spin(bodies: Array, o: int, x: float, y: float, z: float) -> Any:
    """Angular momentum of a body at an angular velocity; II is the inverse of its inertia."""
    return _solve(
        bodies[o + II], bodies[o + II + 1], bodies[o + II + 2], bodies[o + II + 3],
        bodies[o + II + 4], bodies[o + II + 5], x, y, z,
    )  # fmt: skip


@inline
def _arm(i: int, g: int, translation: Array, accounts: Array) -> Any:
    k = at(i, TRANSLATION)
    return (
        translation[k + RX] - accounts[g + CENTRE],
        translation[k + RX + 64] - accounts[g + CENTRE + 1],
        translation[k + RX + 128] - accounts[g + CENTRE + 2],
    )


@inline
def _rigid(i: int, g: int, translation: Array, bodies: Array, accounts: Array) -> Any:
    """Momenta of a body in the rigid motion of its group."""
    o = i * BODY
    if accounts[g + HELD] == FAST:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z = _arm(i, g, translation, accounts)
    u, v, w = accounts[g + OMEGA], accounts[g + OMEGA + 1], accounts[g + OMEGA + 2]
    m = 1.0 / bodies[o + IM]
    px, py, pz = cross(u, v, w, x, y, z)
    lx, ly, lz = _spin(bodies, o, u, v, w)
    return (
        m * (px + accounts[g + U]),
        m * (py + accounts[g + U + 1]),
        m * (pz + accounts[g + U + 2]),
        lx,
        ly,
        lz,
    )


@inline
def _note_held(place: int, nothing: int, rows: Array, groups: Indices, accounts: Array) -> None:
    """Note of one manifold how it holds its group."""
    a, b = int(rows[place + A]) // BODY, int(rows[place + B]) // BODY
    g = groups[b if a == nothing else a] * ACCOUNT
    held = accounts[g + HELD]
    if held == CALM or not rows[place + TOUCHED] > 0.0:
        return
    if a != nothing and b != nothing:
        accounts[g + HELD] = max(held, FREE)
        return
    x, y, z = rows[place + N], rows[place + N + 8], rows[place + N + 16]
    slides = rows[place + MU] + rows[place + ROLL] + rows[place + SPIN] == 0.0
    if slides and held == SLIDING:
        i = g + NORMAL
        c = x * accounts[i] + y * accounts[i + 1] + z * accounts[i + 2]
        slides = 1.0 - abs(c) < PARALLEL
    accounts[g + HELD] = max(held, SLIDING if slides else FAST)
    accounts[g + NORMAL], accounts[g + NORMAL + 1], accounts[g + NORMAL + 2] = x, y, z


@kernel
def _find_held(
    count: int, nothing: int, batches: Indices, rows: Array, groups: Indices, accounts: Array
) -> None:
    """Find how each group that has gained is held by what cannot move."""
    for batch in range(count):
        begin = batches[batch * BATCH + OFFSET]
        for place in range(begin, begin + batches[batch * BATCH + USED]):
            _note_held(place, nothing, rows, groups, accounts)


@kernel
def _find_rigid_motions(
    touched: int, touching: Indices, groups: Indices, translation: Array, bodies: Array,
    accounts: Array,
) -> None:  # fmt: skip
    """Find the rigid motion of each group that contact could not change."""
    for t in range(touched):
        i = touching[t]
        o, g, k = i * BODY, groups[i] * ACCOUNT, at(i, TRANSLATION)
        if accounts[g + HELD] == FREE or accounts[g + HELD] == SLIDING:
            m = 1.0 / bodies[o + IM]
            accounts[g + MASS] += m
            for axis in range(3):
                accounts[g + CENTRE + axis] += m * translation[k + RX + 64 * axis]
                accounts[g + U + axis] += bodies[o + P + axis]
    for t in range(touched):
        g = touching[t] * ACCOUNT
        if groups[touching[t]] == touching[t] and accounts[g + MASS] > 0.0:
            for axis in range(3):
                accounts[g + CENTRE + axis] /= accounts[g + MASS]
                accounts[g + U + axis] /= accounts[g + MASS]
    for t in range(touched):
        i = touching[t]
        o, g = i * BODY, groups[i] * ACCOUNT
        if accounts[g + HELD] == FREE or accounts[g + HELD] == SLIDING:
            m = 1.0 / bodies[o + IM]
            x, y, z = _arm(i, g, translation, accounts)
            lx, ly, lz = cross(x, y, z, bodies[o + P], bodies[o + P + 1], bodies[o + P + 2])
            accounts[g + OMEGA] += bodies[o + L] + lx
            accounts[g + OMEGA + 1] += bodies[o + L + 1] + ly
            accounts[g + OMEGA + 2] += bodies[o + L + 2] + lz
            xx, xy, xz = _spin(bodies, o, 1.0, 0.0, 0.0)
            _, yy, yz = _spin(bodies, o, 0.0, 1.0, 0.0)
            _, _, zz = _spin(bodies, o, 0.0, 0.0, 1.0)
            accounts[g + INERTIA] += xx + m * (y * y + z * z)
            accounts[g + INERTIA + 1] += xy - m * x * y
            accounts[g + INERTIA + 2] += xz - m * x * z
            accounts[g + INERTIA + 3] += yy + m * (x * x + z * z)
            accounts[g + INERTIA + 4] += yz - m * y * z
            accounts[g + INERTIA + 5] += zz + m * (x * x + y * y)
    for t in range(touched):
        if groups[touching[t]] == touching[t]:
            _keep_to_what_is_free(touching[t] * ACCOUNT, accounts)


@inline
def _keep_to_what_is_free(g: int, accounts: Array) -> None:
    """Turn the angular momentum of a group into the angular velocity of its rigid motion."""
    i = g + INERTIA
    xx, xy, xz, yy, yz, zz = (
        accounts[i], accounts[i + 1], accounts[i + 2], accounts[i + 3], accounts[i + 4],
        accounts[i + 5],
    )  # fmt: skip
    x, y, z = accounts[g + OMEGA], accounts[g + OMEGA + 1], accounts[g + OMEGA + 2]
    if accounts[g + HELD] == SLIDING:
        u, v, w = accounts[g + NORMAL], accounts[g + NORMAL + 1], accounts[g + NORMAL + 2]
        across = u * accounts[g + U] + v * accounts[g + U + 1] + w * accounts[g + U + 2]
        accounts[g + U] -= across * u
        accounts[g + U + 1] -= across * v
        accounts[g + U + 2] -= across * w
        a, b, c = times(xx, xy, xz, yy, yz, zz, u, v, w)
        about = u * a + v * b + w * c
        turn = (u * x + v * y + w * z) / about if about > 0.0 else 0.0
        x, y, z = turn * u, turn * v, turn * w
    else:
        x, y, z = _solve(xx, xy, xz, yy, yz, zz, x, y, z)
    accounts[g + OMEGA], accounts[g + OMEGA + 1], accounts[g + OMEGA + 2] = x, y, z


@kernel
def _find_gains(
    touched: int, h: float, touching: Indices, groups: Indices, translation: Array,
    bodies: Array, accounts: Array,
) -> bool:  # fmt: skip
    """Open the accounts of the groups, and tell whether any has gained."""
    for t in range(touched):
        g = touching[t] * ACCOUNT
        accounts[g + GAIN], accounts[g + ALLOWED] = 0.0, 0.0
    for t in range(touched):
        i = touching[t]
        g = groups[i] * ACCOUNT
        accounts[g + GAIN] += bodies[i * BODY + ENERGY]
        accounts[g + ALLOWED] += _allowed(i, h, translation, bodies)
    found = False
    for t in range(touched):
        g = touching[t] * ACCOUNT
        accounts[g + HELD] = CALM
        if groups[touching[t]] == touching[t] and accounts[g + GAIN] > accounts[g + ALLOWED]:
            found = True
            for entry in range(HELD, ACCOUNT):
                accounts[g + entry] = 0.0
            accounts[g + HELD] = ALONE
    return found


@kernel
def take_back(
    count: int, touched: int, nothing: int, h: float, touching: Indices, batches: Indices,
    rows: Array, groups: Indices, translation: Array, accounts: Array, bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what groups have gained over a tick of substeps h. Tell whether any has: then P_HELD
    of each body is the change of its momentum.

        count   : batches
        nothing : index of what cannot move
        groups  : the first body of the group of each body
        accounts: scratch, ACCOUNT numbers a body
    """
    any_gain = False
    for t in range(touched):
        o = touching[t] * BODY
        gain = kinetic(bodies, o) - bodies[o + ENERGY]
        bodies[o + ENERGY] = gain
        if gain > 0.0 and gain > _allowed(touching[t], h, translation, bodies):
            any_gain = True
    if not any_gain:
        return False
    join_pressing(count, touched, nothing, touching, batches, rows, groups)
    if not _find_gains(touched, h, touching, groups, translation, bodies, accounts):
        return False
    _find_held(count, nothing, batches, rows, groups, accounts)
    _find_rigid_motions(touched, touching, groups, translation, bodies, accounts)
    for t in range(touched):
        i = touching[t]
        o, g = i * BODY, groups[i] * ACCOUNT
        if accounts[g + HELD] >= FREE:
            x, y, z, u, v, w = _rigid(i, g, translation, bodies, accounts)
            x, y, z = bodies[o + P] - x, bodies[o + P + 1] - y, bodies[o + P + 2] - z
            u, v, w = bodies[o + L] - u, bodies[o + L + 1] - v, bodies[o + L + 2] - w
            accounts[g + MOVING] += 0.5 * twice(bodies, o, x, y, z, u, v, w)
    for t in range(touched):
        i = touching[t]
        o, g = i * BODY, groups[i] * ACCOUNT
        moving = accounts[g + MOVING]
        for axis in range(3):
            bodies[o + P_HELD + axis] = 0.0
        if accounts[g + HELD] >= FREE and moving > 0.0:
            s = math.sqrt(max(0.0, 1.0 - accounts[g + GAIN] / moving))
            x, y, z, u, v, w = _rigid(i, g, translation, bodies, accounts)
            x, y, z = x - bodies[o + P], y - bodies[o + P + 1], z - bodies[o + P + 2]
            x, y, z = (1.0 - s) * x, (1.0 - s) * y, (1.0 - s) * z
            bodies[o + P_HELD], bodies[o + P_HELD + 1], bodies[o + P_HELD + 2] = x, y, z
            bodies[o + P] += x
            bodies[o + P + 1] += y
            bodies[o + P + 2] += z
            bodies[o + L] = u + s * (bodies[o + L] - u)
            bodies[o + L + 1] = v + s * (bodies[o + L + 1] - v)
            bodies[o + L + 2] = w + s * (bodies[o + L + 2] - w)
    return True
