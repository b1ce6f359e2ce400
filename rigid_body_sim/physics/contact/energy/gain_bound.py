# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bound on gains: contact only passes energy on, or takes it. What it gives by its errors, beyond
a few millionths, is taken back at the end of the tick.

For each group of bodies that press on each other:

    gain = sum of T_1 - (T_0 + W)              what contact gave [J]
    size = sum of T_0 + W + |F| k              of the energy of the group [J], k radius of gyration
    if gain > SHARE size:   p <- p_c + s (p - p_c),  L <- L_c + s (L - L_c)
                            T_1 - T(s) = gain - SHARE size
        p_c, L_c : of the motion that its contacts cannot change: see `kept_motion`

So momentum and angular momentum of what floats stay, on ice those that the ice cannot change. No
more than MOST of the motion is taken in a tick: where an overlap goes, what lifts is no motion.

A contact gains where it was foreseen elsewhere than it came to be: the lowest point of a thin disc
that falls goes round by a radian and more in a tick, the normal of what tumbles over an edge or a
ball turns, a blow goes on to a body that another one holds. That is of second order in the
substep, but of a substep that is too long. What is taken is kept, so that the contact wrench of a
body is the change of its momenta. Where forces depend on the state, their own errors would be
taken for gains, and nothing is bounded.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Group, Motion
from rigid_body_sim.physics.contact.energy import gain_record
from rigid_body_sim.physics.contact.energy.account import (
    inverse_inertia_product,
    kinetic,
    twice_kinetic,
)
from rigid_body_sim.physics.contact.energy.kept_motion import find_kept_motion, kept_momenta
from rigid_body_sim.physics.contact.energy.pressing_groups import unite_pressing
from rigid_body_sim.physics.contact.energy.scratch import TAKEN, EnergyScratch
from rigid_body_sim.physics.vectors import add_scaled, dot, load, load_symmetric, store, subtract

SHARE_OF_FEW = 3e-6  # [-] of the energy, of up to FEW bodies
SHARE_OF_MANY = 6e-6  # [-] of the energy, of more
FEW = 3.0  # [-] bodies
MOST = 0.2  # [-] of the kinetic energy that a tick may take back


@inline
def _size_of_energy(row: int, bodies: Array) -> Any:
    """T_0 + W + |F| k of a body, k its radius of gyration [J]."""
    acceleration = load(bodies, row + solver_bodies.FREE_ACCELERATION)
    inverse_mass = bodies[row + solver_bodies.INVERSE_MASS]
    inverse = load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA)
    trace = inverse[0] + inverse[3] + inverse[5]
    weight = 0.0
    if trace > 0.0 and inverse_mass > solver_bodies.HELD:
        weight = math.sqrt(3.0 * dot(acceleration, acceleration) / (trace * inverse_mass))
    return max(bodies[row + solver_bodies.ENERGY], 0.0) + weight


@inline
def _any_gains(share: float, touching: Indices, bodies: Array) -> bool:
    """Tell whether some body has gained: else no group has."""
    for index in range(len(touching)):
        row = touching[index] * solver_bodies.SIZE
        gain = kinetic(bodies, row) - bodies[row + solver_bodies.ENERGY]
        if gain > 0.0 and gain > share * SHARE_OF_FEW * _size_of_energy(row, bodies):
            return True
    return False


@inline
def _add_body(body: int, gain: int, motion: Motion, gains: Array, bodies: Array) -> None:
    """Add a body to the account of its group."""
    row = body * solver_bodies.SIZE
    kept, kept_angular = kept_momenta(body, gain, motion, gains, bodies)
    rest = subtract(load(bodies, row + solver_bodies.MOMENTUM), kept)
    rest_angular = subtract(load(bodies, row + solver_bodies.ANGULAR_MOMENTUM), kept_angular)
    constant = 0.5 * twice_kinetic(bodies, row, kept, kept_angular)
    square = 0.5 * twice_kinetic(bodies, row, rest, rest_angular)
    both = bodies[row + solver_bodies.INVERSE_MASS] * dot(kept, rest)
    both += inverse_inertia_product(bodies, row, kept_angular, rest_angular)
    gains[gain + gain_record.GAIN] += constant + both + square - bodies[row + solver_bodies.ENERGY]
    gains[gain + gain_record.PART] += constant
    gains[gain + gain_record.PART + 1] += both
    gains[gain + gain_record.PART + 2] += square
    gains[gain + gain_record.SIZE_OF_ENERGY] += _size_of_energy(row, bodies)
    gains[gain + gain_record.BODIES] += 1.0


@inline
def _shrink(
    body: int, gain: int, motion: Motion, gains: Array, taken: Array, bodies: Array
) -> None:  # fmt: skip
    """Let the momenta of a body shrink by the factor of its group, but those that it keeps."""
    row, factor = body * solver_bodies.SIZE, gains[gain + gain_record.FACTOR]
    kept, kept_angular = kept_momenta(body, gain, motion, gains, bodies)
    for place, stays, taken_place in (
        (row + solver_bodies.MOMENTUM, kept, body * TAKEN),
        (row + solver_bodies.ANGULAR_MOMENTUM, kept_angular, body * TAKEN + 3),
    ):
        before = load(bodies, place)
        after = add_scaled(stays, factor, subtract(before, stays))
        store(taken, taken_place, subtract(after, before))
        store(bodies, place, after)


@inline
def _find_factor(share: float, gain: int, gains: Array) -> None:
    """Find s of a group: T(s) = T_1 - excess, with T(s) = constant + s both + s^2 square."""
    gains[gain + gain_record.FACTOR] = 1.0
    few = gains[gain + gain_record.BODIES] <= FEW
    share *= SHARE_OF_FEW if few else SHARE_OF_MANY
    excess = gains[gain + gain_record.GAIN] - share * gains[gain + gain_record.SIZE_OF_ENERGY]
    both, square = gains[gain + gain_record.PART + 1], gains[gain + gain_record.PART + 2]
    if not (excess > 0.0 and square > 0.0):
        return
    # square s^2 + both s = square + both - excess: the larger root
    excess = min(excess, MOST * square)
    root = both * both + 4.0 * square * (square + both - excess)
    factor = 0.5 * (math.sqrt(max(root, 0.0)) - both) / square
    gains[gain + gain_record.FACTOR] = min(max(factor, 0.0), 1.0)


@kernel
def bound_gains(
    share: float, batch_count: int, static: int, group: Group, batches: Indices, rows: Array,
    scratch: EnergyScratch, bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what contact gave to each group beyond its share; tell whether there was anything.

    share  : [-] length of the tick over that of one that is not cut
    static : index of what cannot move; it joins nobody
    group  : all bodies that touch, in the blocks of the scene
    """
    touching, motion = group.members, group.motion
    roots, gains, taken = scratch.roots, scratch.gains, scratch.taken
    if taken[static * TAKEN] > 0.0:
        for entry in range(len(taken)):
            taken[entry] = 0.0
    if not _any_gains(share, touching, bodies):
        return False
    unite_pressing(batch_count, static, touching, batches, rows, roots)
    for index in range(len(touching)):
        gain = touching[index] * gain_record.SIZE
        for entry in range(gain_record.SIZE):
            gains[gain + entry] = 0.0
    find_kept_motion(batch_count, static, touching, motion, batches, rows, roots, gains, bodies)
    for index in range(len(touching)):
        body = touching[index]
        _add_body(body, roots[body] * gain_record.SIZE, motion, gains, bodies)
    found = False
    for index in range(len(touching)):
        body = touching[index]
        if roots[body] == body:
            _find_factor(share, body * gain_record.SIZE, gains)
            if gains[body * gain_record.SIZE + gain_record.FACTOR] < 1.0:
                found = True
    for index in range(len(touching)):
        body = touching[index]
        gain = roots[body] * gain_record.SIZE
        if gains[gain + gain_record.FACTOR] < 1.0:
            _shrink(body, gain, motion, gains, taken, bodies)
    if found:
        taken[static * TAKEN] = 1.0
    return found
