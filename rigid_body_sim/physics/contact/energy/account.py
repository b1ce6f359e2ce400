# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The energy balance of bodies that touch.

    E = T_0 + W     what the kinetic energy of a body would be without contacts
        T_0 : [J] kinetic energy at the start of the tick
        W   : [J] work of all other forces over the tick

Constant forces work by the trapezoidal rule. Those that depend on the state do in a substep what
its motion does to the kinetic energy, from half a kick to half a kick:

    W = T(p + h/2 F_1, L + h/2 torque_1) - T(p - h/2 F_0, L - h/2 torque_0)
        p, L : momenta of the motion;   0, 1 : of before and after it, at both ends as it stands
      = h/2 (F_0 + F_1) . v + h^2/(8 m) (F_1^2 - F_0^2)       of a force, m constant

which is their work by the trapezoidal rule, and what velocity Verlet errs by in free motion: that
no contact gave.

A body is number k in the blocks of the motion: see `packed_bodies`.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Group, Motion
from rigid_body_sim.physics.contact.packed_bodies import member
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    add_scaled,
    apply_symmetric,
    dot,
    load,
    load_strided,
    load_symmetric,
)


@inline
def inverse_inertia_product(bodies: Array, row: int, first: Any, second: Any) -> Any:
    """Return first . I^-1 second of a body."""
    inverse_inertia = load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA)
    return dot(first, apply_symmetric(inverse_inertia, second))


@inline
def twice_kinetic(bodies: Array, row: int, momentum: Any, angular_momentum: Any) -> Any:
    """Return p . v + L . omega of a body for these momenta: 2 T."""
    return bodies[row + solver_bodies.INVERSE_MASS] * dot(
        momentum, momentum
    ) + inverse_inertia_product(bodies, row, angular_momentum, angular_momentum)


@inline
def kinetic(bodies: Array, row: int) -> Any:
    """Return the kinetic energy of a body [J]."""
    return 0.5 * twice_kinetic(
        bodies,
        row,
        load(bodies, row + solver_bodies.MOMENTUM),
        load(bodies, row + solver_bodies.ANGULAR_MOMENTUM),
    )


@kernel
def begin(members: Indices, bodies: Array) -> None:
    """Start the balance of bodies with their kinetic energy."""
    for index in range(len(members)):
        row = members[index] * solver_bodies.SIZE
        bodies[row + solver_bodies.ENERGY] = kinetic(bodies, row)


@inline
def _power_of_torque(body: int, k: int, motion: Motion, bodies: Array) -> Any:
    """Power of the torques of this instant [W]."""
    if k >= motion.rigid_count:
        return 0.0
    place = blocks.at(k, blocks.ROTATION)
    torque = load_strided(motion.rotation, place + blocks.TX, blocks.LANES)
    if torque[0] == 0.0 and torque[1] == 0.0 and torque[2] == 0.0:
        return 0.0
    row = body * solver_bodies.SIZE
    angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
    return inverse_inertia_product(bodies, row, torque, angular_momentum)


@inline
def _work_of_force(body: int, k: int, translation: Array, bodies: Array) -> Any:
    """Work of the forces of this instant since the start of the tick [J]."""
    row, place = body * solver_bodies.SIZE, blocks.at(k, blocks.TRANSLATION)
    work = 0.0
    for axis in range(3):
        lane = place + blocks.LANES * axis
        moved = translation[lane + blocks.RX] - bodies[row + solver_bodies.START_POSITION + axis]
        moved += translation[lane + blocks.EX] - bodies[row + solver_bodies.START_RESIDUAL + axis]
        work += translation[lane + blocks.FX] * moved
    return work


@kernel
def begin_motion(half: float, group: Group, bodies: Array) -> None:
    """
    Take off the kinetic energy with which the motion of a substep begins: that of its momenta less
    a kick of half of it [s] by the forces of before it.
    """
    motion = group.motion
    for index in range(len(group.members)):
        body, k = member(index, group)
        row, place = body * solver_bodies.SIZE, blocks.at(k, blocks.TRANSLATION)
        force = load_strided(motion.translation, place + blocks.FX, blocks.LANES)
        momentum = add_scaled(load(bodies, row + solver_bodies.MOMENTUM), -half, force)
        angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
        if k < motion.rigid_count:
            place = blocks.at(k, blocks.ROTATION)
            torque = load_strided(motion.rotation, place + blocks.TX, blocks.LANES)
            angular_momentum = add_scaled(angular_momentum, -half, torque)
        bodies[row + solver_bodies.ENERGY] -= 0.5 * twice_kinetic(
            bodies, row, momentum, angular_momentum
        )


@kernel
def end_motion(members: Indices, bodies: Array) -> None:
    """Add the kinetic energy with which it ends, before any contact acts again."""
    for index in range(len(members)):
        row = members[index] * solver_bodies.SIZE
        bodies[row + solver_bodies.ENERGY] += kinetic(bodies, row)


@kernel
def add_half_the_torque(h: float, group: Group, bodies: Array) -> None:
    """
    Add half the work of constant torques over a tick h [s]: called before and after it, which is
    exact where the axis is fixed.
    """
    for index in range(len(group.members)):
        body, k = member(index, group)
        bodies[body * solver_bodies.SIZE + solver_bodies.ENERGY] += (
            0.5 * h * _power_of_torque(body, k, group.motion, bodies)
        )


@kernel
def add_work(group: Group, bodies: Array) -> None:
    """Add the work of constant forces over a tick."""
    for index in range(len(group.members)):
        body, k = member(index, group)
        bodies[body * solver_bodies.SIZE + solver_bodies.ENERGY] += _work_of_force(
            body, k, group.motion.translation, bodies
        )
