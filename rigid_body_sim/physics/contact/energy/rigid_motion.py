# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The rigid motion u of a group of bodies that its contacts could not change.

    nothing that cannot move is touched:    u = V + Omega x r of its momentum and angular momentum
    it is, along one plane, without friction:  of these V along it, Omega about its normal
    else:                                   0

In u nothing moves against anything else that presses, and what u is made of is conserved: so the
rest of the motion, v - u, may shrink without opening or closing a contact.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.energy.groups import (
    ACCOUNT,
    CENTRE,
    FAST,
    FREE,
    HELD,
    INERTIA,
    MASS,
    NORMAL,
    OMEGA,
    SLIDING,
    U,
)
from rigid_body_sim.physics.contact.solver.wide_lanes import cross, times
from rigid_body_sim.physics.contact.solver_bodies import BODY, II, IM, L, P
from rigid_body_sim.physics.state.blocks import RX, TRANSLATION, at

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


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
def rigid_momenta(i: int, g: int, translation: Array, bodies: Array, accounts: Array) -> Any:
    """Momenta of a body in the rigid motion u of its group: linear, angular."""
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


@kernel
def find_rigid_motions(
    touched: int, touching: Indices, groups: Indices, translation: Array, bodies: Array,
    accounts: Array,
) -> None:  # fmt: skip
    """Find the rigid motion u of each group that is held (`groups.find_held`) or free."""
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
