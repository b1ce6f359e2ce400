# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The kernels that write what is held: into the lanes of the blocks (`state.blocks`), with the weight
of each body, and what turns with a body into the table of `elements.held_body_wrench`.
"""

from __future__ import annotations

import sys

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.forces.elements import held_body_wrench
from rigid_body_sim.physics.model.scene import Vector
from rigid_body_sim.physics.state.blocks import (
    FORCE,
    HELD_FORCE,
    HELD_TORQUE,
    LANES,
    ROTATION,
    TORQUE,
    TRANSLATION,
    at,
)
from rigid_body_sim.physics.vectors import add, dot, load, store, store_strided

NO_VECTOR: Vector = (0.0, 0.0, 0.0)
LARGEST = sys.float_info.max
BODY, RIGID = held_body_wrench.BODY, held_body_wrench.RIGID
TURNING_FORCE, TURNING_TORQUE = held_body_wrench.FORCE, held_body_wrench.TORQUE
COLUMNS = held_body_wrench.COLUMNS


@kernel
def put_one(core, fx, fy, fz, tx, ty, tz, n_rigid, weights, translation, rotation):
    """Write what is held by one body, and its weight, into its lane; no zero is negative."""
    force = add((fx + 0.0, fy + 0.0, fz + 0.0), load(weights, 3 * core))
    place = at(core, TRANSLATION)
    store_strided(translation, place + HELD_FORCE, LANES, force)
    store_strided(translation, place + FORCE, LANES, force)
    if core < n_rigid:
        place = at(core, ROTATION)
        torque = (tx + 0.0, ty + 0.0, tz + 0.0)
        store_strided(rotation, place + HELD_TORQUE, LANES, torque)
        store_strided(rotation, place + TORQUE, LANES, torque)


@inline
def _to_principal(axes, core, force, torque):
    x, y, z = load(axes, 9 * core), load(axes, 9 * core + 3), load(axes, 9 * core + 6)
    return (
        (dot(x, force), dot(y, force), dot(z, force)),
        (dot(x, torque), dot(y, torque), dot(z, torque)),
    )


@kernel
def put_row(number, fx, fy, fz, tx, ty, tz, of_body, axes, table):
    """
    Write what turns with a body into its row of the table; no zero is negative.

    of_body : 1: from body axes; 0: it is in principal axes already
    """
    row = COLUMNS * number
    force, torque = (fx, fy, fz), (tx, ty, tz)
    if of_body == 1:
        force, torque = _to_principal(axes, int(table[row + BODY]), force, torque)
    store(table, row + TURNING_FORCE, add(force, NO_VECTOR))
    store(table, row + TURNING_TORQUE, add(torque, NO_VECTOR))


@kernel
def put_all(forces, torques, n_moving, n_rigid, weights, translation, rotation):
    """Write what is held by all bodies, and their weights, into their lanes."""
    for core in range(n_moving):
        force = add(load(forces, 3 * core), load(weights, 3 * core))
        place = at(core, TRANSLATION)
        store_strided(translation, place + HELD_FORCE, LANES, force)
        store_strided(translation, place + FORCE, LANES, force)
    for core in range(n_rigid):
        torque = load(torques, 3 * core)
        place = at(core, ROTATION)
        store_strided(rotation, place + HELD_TORQUE, LANES, torque)
        store_strided(rotation, place + TORQUE, LANES, torque)


@inline
def _is_asked(vectors, i):
    x, y, z = load(vectors, 3 * i)
    return x != 0.0 or y != 0.0 or z != 0.0


@kernel
def take_rows(given_force, given_torque, scene_index, still, n_rigid, turns, axes, force, torque):
    """
    Copy rows in scene order into rows in core order: as they are, where they turn with the bodies
    in principal axes. Return how many numbers are not as they may be; then nothing is copied.
    """
    wrong = 0
    for i in range(len(given_force)):
        if not (abs(given_force[i]) <= LARGEST and abs(given_torque[i]) <= LARGEST):
            wrong += 1
    for number in range(len(still)):
        i = still[number]
        if _is_asked(given_force, i) or _is_asked(given_torque, i):
            wrong += 1
    for core in range(n_rigid, len(scene_index)):
        i = scene_index[core]
        if _is_asked(given_torque, i) or (turns == 1 and _is_asked(given_force, i)):
            wrong += 1
    if wrong > 0:
        return wrong
    for core in range(len(scene_index)):
        f = load(given_force, 3 * scene_index[core])
        t = load(given_torque, 3 * scene_index[core])
        if turns == 1 and core < n_rigid:
            f, t = _to_principal(axes, core, f, t)
        store(force, 3 * core, add(f, NO_VECTOR))  # no zero is negative
        store(torque, 3 * core, add(t, NO_VECTOR))
    return wrong


@kernel
def take_and_put_rows(
    given_force, given_torque, scene_index, still, n_rigid, axes, force, torque, weights,
    translation, rotation,
):  # fmt: skip
    """Do what `take_rows` does, in world axes, and at once what `put_all` does of the rows."""
    wrong = take_rows(
        given_force, given_torque, scene_index, still, n_rigid, 0, axes, force, torque
    )
    if wrong == 0:
        put_all(force, torque, len(scene_index), n_rigid, weights, translation, rotation)
    return wrong


@kernel
def list_turning(forces, torques, n_rigid, table):
    """List the rigid bodies of which something is asked, as `held_body_wrench` has them."""
    count = 0
    for core in range(n_rigid):
        if _is_asked(forces, core) or _is_asked(torques, core):
            row = COLUMNS * count
            table[row + BODY] = table[row + RIGID] = float(core)
            store(table, row + TURNING_FORCE, load(forces, 3 * core))
            store(table, row + TURNING_TORQUE, load(torques, 3 * core))
            count += 1
    return count


@kernel
def take_and_list_rows(
    given_force, given_torque, scene_index, still, n_rigid, axes, force, torque, table
):
    """
    Do what `take_rows` does, in body axes, and at once what `list_turning` does of the rows; -1:
    these are not as many as the table has, which stays as it is.
    """
    wrong = take_rows(
        given_force, given_torque, scene_index, still, n_rigid, 1, axes, force, torque
    )
    if wrong == 0:
        count = 0
        for core in range(n_rigid):
            if _is_asked(force, core) or _is_asked(torque, core):
                count += 1
        if COLUMNS * count != len(table):
            return -1
        list_turning(force, torque, n_rigid, table)
    return wrong
