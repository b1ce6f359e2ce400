# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Forces that depend on the state, in a substep with contacts: those of before the motion act for
half of it, those of after it for the other half (velocity Verlet).
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.state.blocks import LANES, at
from rigid_body_sim.physics.vectors import (
    add_scaled,
    load,
    load_strided,
    store_strided,
    subtract,
)

saved = Record(stride=LANES)  # of a block of bodies
FORCE = saved.vector('N', 'before the motion')
TORQUE = saved.vector('N m', 'before the motion')
SAVED = saved.size


@inline
def _blocks(bodies: int) -> int:
    return (bodies + LANES - 1) // LANES


@kernel
def save_wrenches(
    n_bodies: int, n_rigid: int, translation: Array, rotation: Array, workspace: Array
) -> None:
    """Keep the forces and torques of the instant; workspace: SAVED numbers per block."""
    for block in range(_blocks(n_bodies)):
        begin, to = block * blocks.TRANSLATION, block * SAVED
        for lane in range(min(LANES, n_bodies - LANES * block)):
            force = load_strided(translation, begin + lane + blocks.FX, LANES)
            store_strided(workspace, to + lane + FORCE, LANES, force)
    for block in range(_blocks(n_rigid)):
        begin, to = block * blocks.ROTATION, block * SAVED
        for lane in range(min(LANES, n_rigid - LANES * block)):
            torque = load_strided(rotation, begin + lane + blocks.TX, LANES)
            store_strided(workspace, to + lane + TORQUE, LANES, torque)


@inline
def _correct(
    state: Array, momentum: int, wrench: int, half: float, workspace: Array, before: int
) -> None:
    """Add half a substep of the change of a force to a momentum: places of their x components."""
    change = subtract(load_strided(state, wrench, LANES), load_strided(workspace, before, LANES))
    store_strided(
        state, momentum, LANES, add_scaled(load_strided(state, momentum, LANES), half, change)
    )


@kernel
def correct_momenta(
    n_bodies: int, n_rigid: int, half: float, translation: Array, rotation: Array, workspace: Array
) -> None:
    """Let the change of the forces act: p += h/2 (F - F_saved)."""
    for block in range(_blocks(n_bodies)):
        begin, before = block * blocks.TRANSLATION, block * SAVED + FORCE
        for place in range(begin, begin + min(LANES, n_bodies - LANES * block)):
            _correct(
                translation, place + blocks.PX, place + blocks.FX, half, workspace,
                before + place - begin,
            )  # fmt: skip
    for block in range(_blocks(n_rigid)):
        begin, before = block * blocks.ROTATION, block * SAVED + TORQUE
        for place in range(begin, begin + min(LANES, n_rigid - LANES * block)):
            _correct(
                rotation, place + blocks.LX, place + blocks.TX, half, workspace,
                before + place - begin,
            )  # fmt: skip


@kernel
def add_warm_start(
    body: int, n_rigid: int, sign: float, translation: Array, rotation: Array, bodies: Array
) -> None:
    """
    Let forces that depend on velocity see a carried body with the second half of its warm start,
    which it gets later (sign 1), and take that back (sign -1).
    """
    row = body * solver_bodies.SIZE
    if not bodies[row + solver_bodies.CARRIED] > 0.0:
        return
    place = at(body, blocks.TRANSLATION) + blocks.PX
    impulse = load(bodies, row + solver_bodies.WARM_IMPULSE)
    momentum = add_scaled(load_strided(translation, place, LANES), sign, impulse)
    store_strided(translation, place, LANES, momentum)
    if body < n_rigid:
        place = at(body, blocks.ROTATION) + blocks.LX
        impulse = load(bodies, row + solver_bodies.WARM_ANGULAR_IMPULSE)
        momentum = add_scaled(load_strided(rotation, place, LANES), sign, impulse)
        store_strided(rotation, place, LANES, momentum)
