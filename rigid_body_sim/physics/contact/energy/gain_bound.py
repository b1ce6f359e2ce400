# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bound on gains: contact only passes energy on, or takes it. What it gives by its errors to what
goes round on a rim, beyond a few millionths, is taken back at the end of the tick.

For each group of bodies that press on each other, one of them with its rim on what cannot move:

    gain   = sum of T_1 - (T_0 + W)            what contact gave [J]
    size   = sum of T_0 + |F| k                of the energy of the group [J], k radius of gyration
    if gain > SHARE size:   p <- s p,  L <- s L,   T_1 (1 - s^2) = gain - SHARE size

A group on one plane without friction keeps its momentum along the plane and its angular momentum
about the normal: there p_n and L_t shrink alone. Momenta of what floats, and of what lies between
several surfaces without friction, stay as they are. No more than MOST of the motion is taken in a
tick: where an overlap goes, what lifts is no motion.

The lowest point of a thin disc that falls goes round by a radian and more in a tick, at tens of
times its weight: of second order in the substep, but of a substep that is too long. Contacts are
read without what is taken here. Where forces depend on the state, their own errors would be taken
for gains, and nothing is bounded.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.energy import gain_record
from rigid_body_sim.physics.contact.energy.account import kinetic, twice_kinetic
from rigid_body_sim.physics.contact.energy.pressing_groups import group_of, unite_pressing
from rigid_body_sim.physics.contact.solver import batch_record, constraint, wide_lanes
from rigid_body_sim.physics.contact.touching import bodies_of
from rigid_body_sim.physics.vectors import (
    add_scaled,
    apply_symmetric,
    dot,
    load,
    load_symmetric,
    scale,
    store,
    subtract,
)

SHARE_OF_FEW = 3e-6  # [-] of the energy, of up to FEW bodies
SHARE_OF_MANY = 6e-6  # [-] of the energy, of more
FEW = 3.0  # [-] bodies
MOST = 0.2  # [-] of the kinetic energy that a tick may take back
ONE_NORMAL = 1e-9  # [-] cosine less than 1: normals that are one


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
def _find_what_holds(
    batch_count: int, static: int, batches: Indices, rows: Array, roots: Indices, gains: Array
) -> None:
    """Find what holds each group: see `gain_record.HELD`."""
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if rows[lane + constraint.TOUCHED] == 0.0 or (body_a != static and body_b != static):
                continue
            gain = group_of(body_a, body_b, static, roots) * gain_record.SIZE
            if rows[lane + constraint.ROUNDNESS] < constraint.NOT_ROUND:
                gains[gain + gain_record.ON_RIM] = 1.0
            normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
            held = gains[gain + gain_record.HELD]
            if rows[lane + constraint.FRICTION] > 0.0:
                held = gain_record.RUBBED
            elif held == gain_record.FLOATS:
                held = gain_record.ON_PLANE
                store(gains, gain + gain_record.NORMAL, normal)
            elif held == gain_record.ON_PLANE:
                along = dot(normal, load(gains, gain + gain_record.NORMAL))
                held = gain_record.IN_CORNER if abs(along) < 1.0 - ONE_NORMAL else held
            gains[gain + gain_record.HELD] = held


@inline
def _parts(row: int, gain: int, gains: Array, bodies: Array) -> Any:
    """Momenta of a body that stay, and those that shrink: p, L and p', L'."""
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
    stays, turns_on = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if gains[gain + gain_record.HELD] == gain_record.ON_PLANE:
        normal = load(gains, gain + gain_record.NORMAL)
        stays = add_scaled(momentum, -dot(normal, momentum), normal)
        turns_on = scale(dot(normal, angular_momentum), normal)
    return stays, turns_on, subtract(momentum, stays), subtract(angular_momentum, turns_on)


@inline
def _add_body(row: int, gain: int, gains: Array, bodies: Array) -> None:
    """Add a body to the account of its group."""
    stays, turns_on, shrinks, turns_less = _parts(row, gain, gains, bodies)
    inverse = load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA)
    constant = 0.5 * twice_kinetic(bodies, row, stays, turns_on)
    square = 0.5 * twice_kinetic(bodies, row, shrinks, turns_less)
    both = dot(turns_on, apply_symmetric(inverse, turns_less))
    gains[gain + gain_record.GAIN] += constant + both + square - bodies[row + solver_bodies.ENERGY]
    gains[gain + gain_record.PART] += constant
    gains[gain + gain_record.PART + 1] += both
    gains[gain + gain_record.PART + 2] += square
    gains[gain + gain_record.SIZE_OF_ENERGY] += _size_of_energy(row, bodies)
    gains[gain + gain_record.BODIES] += 1.0


@inline
def _find_factor(share: float, gain: int, gains: Array) -> None:
    """Find s of a group: T(s) = T_1 - excess, with T(s) = constant + s both + s^2 square."""
    gains[gain + gain_record.FACTOR] = 1.0
    held = gains[gain + gain_record.HELD]
    rolls = gains[gain + gain_record.ON_RIM] > 0.0
    if not rolls or held == gain_record.FLOATS or held == gain_record.IN_CORNER:
        return
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
    share: float, batch_count: int, static: int, touching: Indices, batches: Indices, rows: Array,
    roots: Indices, gains: Array, bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what contact gave to each group beyond its share; tell whether there was anything.

    share  : [-] length of the tick over that of one that is not cut
    static : index of what cannot move; it joins nobody
    roots  : scratch, a number for each body
    gains  : see `gain_record`
    """
    if not _any_gains(share, touching, bodies):
        return False
    unite_pressing(batch_count, static, touching, batches, rows, roots)
    for index in range(len(touching)):
        gain = touching[index] * gain_record.SIZE
        for entry in range(gain_record.SIZE):
            gains[gain + entry] = 0.0
    _find_what_holds(batch_count, static, batches, rows, roots, gains)
    for index in range(len(touching)):
        body = touching[index]
        _add_body(body * solver_bodies.SIZE, roots[body] * gain_record.SIZE, gains, bodies)
    found = False
    for index in range(len(touching)):
        body = touching[index]
        if roots[body] == body:
            _find_factor(share, body * gain_record.SIZE, gains)
            found = found or gains[body * gain_record.SIZE + gain_record.FACTOR] < 1.0
    for index in range(len(touching)):
        row = touching[index] * solver_bodies.SIZE
        gain = roots[touching[index]] * gain_record.SIZE
        factor = gains[gain + gain_record.FACTOR]
        if factor < 1.0:
            stays, turns_on, shrinks, turns_less = _parts(row, gain, gains, bodies)
            store(bodies, row + solver_bodies.MOMENTUM, add_scaled(stays, factor, shrinks))
            store(
                bodies,
                row + solver_bodies.ANGULAR_MOMENTUM,
                add_scaled(turns_on, factor, turns_less),
            )
    return found
