# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The energy of bodies that touch.

    E = T_0 + W     what the kinetic energy of a body would be without contacts
        T_0 : [J] kinetic energy at the start of the tick
        W   : [J] work of all other forces over the tick, by the trapezoidal rule
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.state.blocks import EX, FX, ROTATION, RX, TRANSLATION, TX, at

Array = NDArray[np.float64]


@inline
def turning(bodies: Array, o: int, x: float, y: float, z: float, u: float, v: float, w: float):
    """Return (x, y, z) . I^-1 (u, v, w) of a body."""
    xx, xy, xz = (
        bodies[o + solver_bodies.INVERSE_INERTIA],
        bodies[o + solver_bodies.INVERSE_INERTIA + 1],
        bodies[o + solver_bodies.INVERSE_INERTIA + 2],
    )
    yy, yz, zz = (
        bodies[o + solver_bodies.INVERSE_INERTIA + 3],
        bodies[o + solver_bodies.INVERSE_INERTIA + 4],
        bodies[o + solver_bodies.INVERSE_INERTIA + 5],
    )
    return (
        x * (xx * u + xy * v + xz * w)
        + y * (xy * u + yy * v + yz * w)
        + z * (xz * u + yz * v + zz * w)
    )


@inline
def twice(bodies: Array, o: int, x: float, y: float, z: float, u: float, v: float, w: float):
    """Return p . v for the momenta (x, y, z), (u, v, w) of a body, and v for them: 2 T."""
    return bodies[o + solver_bodies.INVERSE_MASS] * (x * x + y * y + z * z) + turning(
        bodies, o, u, v, w, u, v, w
    )


@inline
def kinetic(bodies: Array, o: int) -> Any:
    """Return the kinetic energy of a body [J]."""
    return 0.5 * twice(
        bodies, o, bodies[o + solver_bodies.MOMENTUM], bodies[o + solver_bodies.MOMENTUM + 1], bodies[o + solver_bodies.MOMENTUM + 2], bodies[o + solver_bodies.ANGULAR_MOMENTUM],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1], bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2],
    )  # fmt: skip


@kernel
def begin(i: int, bodies: Array) -> None:
    """Start the account of a body with its kinetic energy."""
    o = i * solver_bodies.SIZE
    bodies[o + solver_bodies.ENERGY] = kinetic(bodies, o)


@inline
def _power(i: int, n_rigid: int, rotation: Array, bodies: Array) -> Any:
    """Power of the torques of this instant [W]."""
    if i >= n_rigid:
        return 0.0
    o, k = i * solver_bodies.SIZE, at(i, ROTATION)
    x, y, z = rotation[k + TX], rotation[k + TX + 64], rotation[k + TX + 128]
    if x == 0.0 and y == 0.0 and z == 0.0:
        return 0.0
    u, v, w = (
        bodies[o + solver_bodies.ANGULAR_MOMENTUM],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 1],
        bodies[o + solver_bodies.ANGULAR_MOMENTUM + 2],
    )
    return turning(bodies, o, x, y, z, u, v, w)


@inline
def _work(i: int, place: int, residual: int, translation: Array, bodies: Array) -> Any:
    """Work of the forces of this instant since a body was at a place [J]."""
    o, k = i * solver_bodies.SIZE, at(i, TRANSLATION)
    work = 0.0
    for axis in range(3):
        row = k + 64 * axis
        moved = translation[row + RX] - bodies[o + place + axis]
        moved += translation[row + EX] - bodies[o + residual + axis]
        work += translation[row + FX] * moved
    return work


@kernel
def add_half_the_work(
    i: int, n_rigid: int, h: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """
    Add half the work of the forces of this instant over the motion of a substep h [s]: called for
    those before and those after the motion, and before the second half of the loads.
    """
    work = _work(
        i, solver_bodies.SUBSTEP_POSITION, solver_bodies.SUBSTEP_RESIDUAL, translation, bodies
    ) + h * _power(i, n_rigid, rotation, bodies)
    bodies[i * solver_bodies.SIZE + solver_bodies.ENERGY] += 0.5 * work


@kernel
def add_half_the_torque(i: int, n_rigid: int, h: float, rotation: Array, bodies: Array) -> None:
    """
    Add half the work of constant torques over a tick h [s]: called before and after it, which is
    exact where the axis is fixed.
    """
    bodies[i * solver_bodies.SIZE + solver_bodies.ENERGY] += (
        0.5 * h * _power(i, n_rigid, rotation, bodies)
    )


@kernel
def add_work(i: int, translation: Array, bodies: Array) -> None:
    """Add the work of constant forces over a tick."""
    bodies[i * solver_bodies.SIZE + solver_bodies.ENERGY] += _work(
        i, solver_bodies.START_POSITION, solver_bodies.START_RESIDUAL, translation, bodies
    )
