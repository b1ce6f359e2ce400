# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Projection onto non-increasing energy. Contact takes energy, or leaves it: what a group of bodies
that press on each other has gained over a tick, because a tick is not infinitely short, is taken
back.

The motion of a substep is of second order, so a group may gain or lose some (omega h)^3 of its
energy in it, and what had sunk in a little is lifted when it is unloaded. Losses look like
contact. Gains do not, and grow into vibration:

    gain = sum over the group of T - (T_0 + W) > 0        (`account`)

A group pays with its motion relative to u, the motion that contact could not change
(`rigid_motion`):

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
energy; `attribution` tells which contacts gave it. Two planes without friction that are not
parallel count as one that holds. The numbers are in `limits`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.energy import pressing_record
from rigid_body_sim.physics.contact.energy.account import kinetic, twice_kinetic
from rigid_body_sim.physics.contact.energy.attribution import attribute_changes
from rigid_body_sim.physics.contact.energy.limits import LIFT, ROUND_OFF, SLOW, SMALL, START, STILL
from rigid_body_sim.physics.contact.energy.pressing_groups import (
    find_held,
    group_of,
    unite_pressing,
)
from rigid_body_sim.physics.contact.energy.pressing_record import CALM, FREE, SLIDING, UNHELD
from rigid_body_sim.physics.contact.energy.rigid_motion import find_rigid_motions, rigid_momenta
from rigid_body_sim.physics.contact.energy.scratch import CHANGE, EnergyScratch
from rigid_body_sim.physics.contact.solver import batch_record, constraint, contact_point
from rigid_body_sim.physics.contact.touching import bodies_of
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    add,
    dot,
    load,
    load_strided,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def _fall(body: int, substep: float, translation: Array, bodies: Array) -> Any:
    """Kinetic energy of a body that falls for a substep from rest [J]."""
    place = blocks.at(body, blocks.TRANSLATION) + blocks.FX
    impulse = scale(substep, load_strided(translation, place, blocks.LANES))
    inverse_mass = bodies[body * solver_bodies.SIZE + solver_bodies.INVERSE_MASS]
    return 0.5 * inverse_mass * dot(impulse, impulse)


@inline
def _allowed(body_count: float, fall: float, kinetic_energy: float) -> Any:
    """Gain [J] that is left to so many bodies that move with a kinetic energy."""
    share = START if body_count > 1.0 and kinetic_energy < SLOW * fall else SMALL
    return share * fall + ROUND_OFF * kinetic_energy


@inline
def _some_body_gains(substep: float, touching: Indices, translation: Array, bodies: Array) -> bool:
    """Tell whether the energy of any body has risen."""
    for index in range(len(touching)):
        row = touching[index] * solver_bodies.SIZE
        kinetic_energy = kinetic(bodies, row)
        gain = kinetic_energy - bodies[row + solver_bodies.ENERGY]
        fall = _fall(touching[index], substep, translation, bodies)
        if gain > _allowed(1.0, fall, kinetic_energy):
            return True
    return False


@kernel
def _find_gains(
    substep: float, touching: Indices, roots: Indices, translation: Array, bodies: Array,
    groups: Array,
) -> bool:  # fmt: skip
    """Open the rows of the groups, and tell whether any group has gained."""
    for index in range(len(touching)):
        group = touching[index] * pressing_record.SIZE
        for entry in range(pressing_record.HELD):
            groups[group + entry] = 0.0
    for index in range(len(touching)):
        body = touching[index]
        row, group = body * solver_bodies.SIZE, roots[body] * pressing_record.SIZE
        place = blocks.at(body, blocks.TRANSLATION) + blocks.FX
        kinetic_energy = kinetic(bodies, row)
        groups[group + pressing_record.GAIN] += kinetic_energy - bodies[row + solver_bodies.ENERGY]
        groups[group + pressing_record.BODIES] += 1.0
        groups[group + pressing_record.FALL] += _fall(body, substep, translation, bodies)
        groups[group + pressing_record.KINETIC_ENERGY] += kinetic_energy
        for axis in range(3):
            groups[group + pressing_record.FORCE + axis] += translation[
                place + blocks.LANES * axis
            ]
    found = False
    for index in range(len(touching)):
        group = touching[index] * pressing_record.SIZE
        gains = roots[touching[index]] == touching[index] and groups[
            group + pressing_record.GAIN
        ] > _allowed(
            groups[group + pressing_record.BODIES],
            groups[group + pressing_record.FALL],
            groups[group + pressing_record.KINETIC_ENERGY],
        )
        found = found or gains
        groups[group + pressing_record.HELD] = UNHELD if gains else CALM
    return found


@inline
def _clear_motions(touching: Indices, groups: Array) -> None:
    """Clear what is found of a group once some group has gained."""
    for index in range(len(touching)):
        group = touching[index] * pressing_record.SIZE
        for entry in range(pressing_record.HELD + 1, pressing_record.SIZE):
            groups[group + entry] = 0.0


@inline
def _find_relative_energies(
    touching: Indices, roots: Indices, translation: Array, bodies: Array, groups: Array
) -> None:
    """Add up the kinetic energy of each group relative to its rigid motion."""
    for index in range(len(touching)):
        body = touching[index]
        row, group = body * solver_bodies.SIZE, roots[body] * pressing_record.SIZE
        if groups[group + pressing_record.HELD] >= FREE:
            momentum, angular_momentum = rigid_momenta(body, group, translation, bodies, groups)
            groups[group + pressing_record.RELATIVE_ENERGY] += 0.5 * twice_kinetic(
                bodies,
                row,
                subtract(load(bodies, row + solver_bodies.MOMENTUM), momentum),
                subtract(load(bodies, row + solver_bodies.ANGULAR_MOMENTUM), angular_momentum),
            )


@inline
def _pays_with_its_place(group: int, groups: Array) -> bool:
    """Tell whether a group is a body alone that is slow but does not rest."""
    fall = groups[group + pressing_record.FALL]
    relative_energy = groups[group + pressing_record.RELATIVE_ENERGY]
    return (
        groups[group + pressing_record.BODIES] == 1.0
        and STILL * fall < relative_energy < SLOW * fall
    )


@inline
def _find_let_down(group: int, groups: Array) -> Any:
    """
    How far a body alone is let down.

    returns : d / |impulse| [m/(N s)], negative or 0
    """
    unpaid = groups[group + pressing_record.GAIN]
    if not _pays_with_its_place(group, groups):
        unpaid -= groups[group + pressing_record.RELATIVE_ENERGY]
    if (
        not unpaid > 0.0
        or groups[group + pressing_record.BODIES] > 1.0
        or groups[group + pressing_record.HELD] < SLIDING
    ):
        return 0.0
    press = load(groups, group + pressing_record.PRESS)
    force = load(groups, group + pressing_record.FORCE)
    along = dot(press, force)
    if not along < 0.0:
        return 0.0
    size = math.sqrt(dot(press, press) * dot(force, force))
    # h^2 |F| / m = 2 `FALL` / |F|
    most = -2.0 * LIFT * groups[group + pressing_record.FALL] * along
    return unpaid / along if unpaid * size <= most else 0.0


@kernel
def _update_separations(
    batch_count: int, static: int, width: int, batches: Indices, rows: Array, roots: Indices,
    groups: Array,
) -> None:  # fmt: skip
    """Let the separations of those that were let down be those of their new places."""
    for batch in range(batch_count):
        record = batch * batch_record.SIZE
        begin = batches[record + batch_record.BEGIN]
        length = batches[record + batch_record.POINT_COUNT] * width
        for lane in range(begin, begin + batches[record + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            group = group_of(body_a, body_b, static, roots) * pressing_record.SIZE
            let_down = groups[group + pressing_record.LET_DOWN]
            if groups[group + pressing_record.HELD] == CALM or let_down == 0.0:
                continue
            closer = 0.0
            for axis in range(3):
                closer += (
                    groups[group + pressing_record.PRESS + axis]
                    * rows[lane + constraint.NORMAL + constraint.LANES * axis]
                )
            closer *= let_down if body_a == static else -let_down
            first = lane + constraint.SIZE
            for point in range(first, first + length, width):
                rows[point + contact_point.SEPARATION] += closer


@inline
def _slow_down(
    body: int, group: int, translation: Array, bodies: Array, groups: Array, changes: Array
) -> None:
    """Let a body pay with its motion, and note the change of its momentum."""
    relative_energy = groups[group + pressing_record.RELATIVE_ENERGY]
    if not relative_energy > 0.0:
        return
    row = body * solver_bodies.SIZE
    factor = math.sqrt(max(0.0, 1.0 - groups[group + pressing_record.GAIN] / relative_energy))
    rigid, angular_rigid = rigid_momenta(body, group, translation, bodies, groups)
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
    change = scale(1.0 - factor, subtract(rigid, momentum))
    store(changes, body * CHANGE, change)
    store(bodies, row + solver_bodies.MOMENTUM, add(momentum, change))
    store(
        bodies,
        row + solver_bodies.ANGULAR_MOMENTUM,
        add(angular_rigid, scale(factor, subtract(angular_momentum, angular_rigid))),
    )


@inline
def _pay(
    body: int, roots: Indices, translation: Array, bodies: Array, groups: Array, changes: Array
) -> bool:
    """Let a body of a group that has gained pay; tell whether it was let down."""
    row, group = body * solver_bodies.SIZE, roots[body] * pressing_record.SIZE
    store(changes, body * CHANGE, (0.0, 0.0, 0.0))
    if groups[group + pressing_record.HELD] < FREE:
        return False
    let_down = _find_let_down(group, groups)
    groups[group + pressing_record.LET_DOWN] = let_down
    moved = scale(let_down, load(groups, group + pressing_record.PRESS))
    place = blocks.at(body, blocks.TRANSLATION) + blocks.RX
    position = load_strided(translation, place, blocks.LANES)
    store_strided(translation, place, blocks.LANES, add(position, moved))
    displacement = load(bodies, row + solver_bodies.DISPLACEMENT)
    store(bodies, row + solver_bodies.DISPLACEMENT, add(displacement, moved))
    if not (let_down < 0.0 and _pays_with_its_place(group, groups)):
        _slow_down(body, group, translation, bodies, groups, changes)
    return let_down < 0.0


@kernel
def _project(
    manifold_count: int, batch_count: int, static: int, width: int, substep: float,
    touching: Indices, constraints: Constraints, scratch: EnergyScratch, translation: Array,
    bodies: Array,
) -> bool:  # fmt: skip
    """Project the energy of the groups that have gained; tell whether any has."""
    batches, rows = constraints.batches, constraints.rows
    roots, groups = scratch.roots, scratch.groups
    unite_pressing(batch_count, static, touching, batches, rows, roots)
    if not _find_gains(substep, touching, roots, translation, bodies, groups):
        return False
    _clear_motions(touching, groups)
    find_held(batch_count, static, width, batches, rows, roots, groups)
    find_rigid_motions(touching, roots, translation, bodies, groups)
    _find_relative_energies(touching, roots, translation, bodies, groups)
    any_let_down = False
    for index in range(len(touching)):
        body = touching[index]
        if _pay(body, roots, translation, bodies, groups, scratch.changes):
            any_let_down = True
    if any_let_down:
        _update_separations(batch_count, static, width, batches, rows, roots, groups)
    attribute_changes(manifold_count, static, width, touching, constraints, scratch)
    return True


@inline
def project_energy(
    manifold_count: int, batch_count: int, static: int, width: int, substep: float,
    touching: Indices, constraints: Constraints, scratch: EnergyScratch, translation: Array,
    bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what groups have gained over a tick, and attribute it to contacts. Tell whether any
    group has gained: then momenta in `bodies` have changed.

        static : index of what cannot move
        width  : numbers of a point
    """
    return _some_body_gains(substep, touching, translation, bodies) and _project(
        manifold_count, batch_count, static, width, substep, touching, constraints, scratch,
        translation, bodies,
    )  # fmt: skip
