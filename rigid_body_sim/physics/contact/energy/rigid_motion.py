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
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.energy import pressing_groups
from rigid_body_sim.physics.state.blocks import RX, TRANSLATION, at
from rigid_body_sim.physics.vectors import apply_symmetric, cross, load

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
        bodies[o + solver_bodies.INVERSE_INERTIA], bodies[o + solver_bodies.INVERSE_INERTIA + 1], bodies[o + solver_bodies.INVERSE_INERTIA + 2], bodies[o + solver_bodies.INVERSE_INERTIA + 3],
        bodies[o + solver_bodies.INVERSE_INERTIA + 4], bodies[o + solver_bodies.INVERSE_INERTIA + 5], x, y, z,
    )  # fmt: skip


@inline
def _arm(i: int, g: int, translation: Array, accounts: Array) -> Any:
    k = at(i, TRANSLATION)
    return (
        translation[k + RX] - accounts[g + pressing_groups.CENTRE],
        translation[k + RX + 64] - accounts[g + pressing_groups.CENTRE + 1],
        translation[k + RX + 128] - accounts[g + pressing_groups.CENTRE + 2],
    )


@inline
def rigid_momenta(i: int, g: int, translation: Array, bodies: Array, accounts: Array) -> Any:
    """Momenta of a body in the rigid motion u of its group: linear, angular."""
    o = i * solver_bodies.SIZE
    if accounts[g + pressing_groups.HELD] == pressing_groups.FAST:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y, z = _arm(i, g, translation, accounts)
    u, v, w = (
        accounts[g + pressing_groups.OMEGA],
        accounts[g + pressing_groups.OMEGA + 1],
        accounts[g + pressing_groups.OMEGA + 2],
    )
    m = 1.0 / bodies[o + solver_bodies.INVERSE_MASS]
    px, py, pz = cross((u, v, w), (x, y, z))
    lx, ly, lz = _spin(bodies, o, u, v, w)
    return (
        m * (px + accounts[g + pressing_groups.U]),
        m * (py + accounts[g + pressing_groups.U + 1]),
        m * (pz + accounts[g + pressing_groups.U + 2]),
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
        o, g, k = i * solver_bodies.SIZE, groups[i] * pressing_groups.ACCOUNT, at(i, TRANSLATION)
        if (
            accounts[g + pressing_groups.HELD] == pressing_groups.FREE
            or accounts[g + pressing_groups.HELD] == pressing_groups.SLIDING
        ):
            m = 1.0 / bodies[o + solver_bodies.INVERSE_MASS]
            accounts[g + pressing_groups.MASS] += m
            for axis in range(3):
                accounts[g + pressing_groups.CENTRE + axis] += m * translation[k + RX + 64 * axis]
                accounts[g + pressing_groups.U + axis] += bodies[o + solver_bodies.MOMENTUM + axis]
    for t in range(touched):
        g = touching[t] * pressing_groups.ACCOUNT
        if groups[touching[t]] == touching[t] and accounts[g + pressing_groups.MASS] > 0.0:
            for axis in range(3):
                accounts[g + pressing_groups.CENTRE + axis] /= accounts[g + pressing_groups.MASS]
                accounts[g + pressing_groups.U + axis] /= accounts[g + pressing_groups.MASS]
    for t in range(touched):
        i = touching[t]
        o, g = i * solver_bodies.SIZE, groups[i] * pressing_groups.ACCOUNT
        if (
            accounts[g + pressing_groups.HELD] == pressing_groups.FREE
            or accounts[g + pressing_groups.HELD] == pressing_groups.SLIDING
        ):
            m = 1.0 / bodies[o + solver_bodies.INVERSE_MASS]
            x, y, z = _arm(i, g, translation, accounts)
            lx, ly, lz = cross((x, y, z), load(bodies, o + solver_bodies.MOMENTUM))
            accounts[g + pressing_groups.OMEGA] += bodies[o + solver_bodies.ANGULAR_MOMENTUM] + lx
            accounts[g + pressing_groups.OMEGA + 1] += (
                bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1] + ly
            )
            accounts[g + pressing_groups.OMEGA + 2] += (
                bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2] + lz
            )
            xx, xy, xz = _spin(bodies, o, 1.0, 0.0, 0.0)
            _, yy, yz = _spin(bodies, o, 0.0, 1.0, 0.0)
            _, _, zz = _spin(bodies, o, 0.0, 0.0, 1.0)
            accounts[g + pressing_groups.INERTIA] += xx + m * (y * y + z * z)
            accounts[g + pressing_groups.INERTIA + 1] += xy - m * x * y
            accounts[g + pressing_groups.INERTIA + 2] += xz - m * x * z
            accounts[g + pressing_groups.INERTIA + 3] += yy + m * (x * x + z * z)
            accounts[g + pressing_groups.INERTIA + 4] += yz - m * y * z
            accounts[g + pressing_groups.INERTIA + 5] += zz + m * (x * x + y * y)
    for t in range(touched):
        if groups[touching[t]] == touching[t]:
            _keep_to_what_is_free(touching[t] * pressing_groups.ACCOUNT, accounts)


@inline
def _keep_to_what_is_free(g: int, accounts: Array) -> None:
    """Turn the angular momentum of a group into the angular velocity of its rigid motion."""
    i = g + pressing_groups.INERTIA
    xx, xy, xz, yy, yz, zz = (
        accounts[i], accounts[i + 1], accounts[i + 2], accounts[i + 3], accounts[i + 4],
        accounts[i + 5],
    )  # fmt: skip
    x, y, z = (
        accounts[g + pressing_groups.OMEGA],
        accounts[g + pressing_groups.OMEGA + 1],
        accounts[g + pressing_groups.OMEGA + 2],
    )
    if accounts[g + pressing_groups.HELD] == pressing_groups.SLIDING:
        u, v, w = (
            accounts[g + pressing_groups.NORMAL],
            accounts[g + pressing_groups.NORMAL + 1],
            accounts[g + pressing_groups.NORMAL + 2],
        )
        across = (
            u * accounts[g + pressing_groups.U]
            + v * accounts[g + pressing_groups.U + 1]
            + w * accounts[g + pressing_groups.U + 2]
        )
        accounts[g + pressing_groups.U] -= across * u
        accounts[g + pressing_groups.U + 1] -= across * v
        accounts[g + pressing_groups.U + 2] -= across * w
        a, b, c = apply_symmetric((xx, xy, xz, yy, yz, zz), (u, v, w))
        about = u * a + v * b + w * c
        turn = (u * x + v * y + w * z) / about if about > 0.0 else 0.0
        x, y, z = turn * u, turn * v, turn * w
    else:
        x, y, z = _solve(xx, xy, xz, yy, yz, zz, x, y, z)
    (
        accounts[g + pressing_groups.OMEGA],
        accounts[g + pressing_groups.OMEGA + 1],
        accounts[g + pressing_groups.OMEGA + 2],
    ) = x, y, z
