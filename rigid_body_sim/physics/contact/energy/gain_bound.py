# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bound on gains: contact only passes energy on, or takes it. What it gives by its errors, beyond
a few millionths, is taken back at the end of the tick.

For each group of bodies that press on each other:

    gain = sum of T_1 - (T_0 + W)              what contact gave [J]
    size = sum of T_0 + W + |F| k + M h        of the energy of the group [J]
        F : [N] weight, and what is held on the body: what no state changes
        k : [m] radius of gyration
        h : [J/kg] how far its centre is above its lowest body, times a = (sum of F)/M
    part = (gain - SHARE size)/(T_c + W_up)    if that is positive; 1 at most
        T_c  : [J] kinetic energy of the motion p - p_c, L - L_c that its contacts can change
        W_up : [J] work that its bodies have taken to rise by x_up, against F
    p <- p_c + s (p - p_c),   L <- L_c + s (L - L_c),   s^2 = 1 - part
    x <- x - part x_up
        p_c, L_c : of the motion that its contacts cannot change: see `kept_motion`

The kept motion is the one of least energy with its momenta, so T = T(p_c, L_c) + s^2 T_c. What
contact gives is motion or height, so both go back alike: of an overlap that is lifted out while
nothing moves, the lift; of a blow at the wrong place, the motion. Momentum and angular momentum of
what floats stay, and so does its place; on ice those that the ice cannot change.

A contact gains where it was foreseen elsewhere than it came to be: the lowest point of a thin disc
that falls goes round by a radian and more in a tick, the normal of what tumbles over an edge or a
ball turns, a blow goes on to a body that another one holds, what sank in meanwhile comes out. That
is of second order in the substep, but of a substep that is too long. What is taken is kept, so
that the contact wrench of a body is the change of its momenta.

What other forces give is no gain, whatever they depend on, nor what they err by in free motion
(`account`); nor is the work of what moves as told (`prescribed_bodies`). A group that such a body
carries is seen from it: what goes back is motion and height against it.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints, Group, Motion
from rigid_body_sim.physics.contact.energy import gain_record
from rigid_body_sim.physics.contact.energy.account import kinetic, twice_kinetic
from rigid_body_sim.physics.contact.energy.kept_motion import (
    carrying_motion,
    changeable_momenta,
    find_kept_motion,
    force_on,
    held_force_on,
    held_part,
    is_carried,
    position_of,
)
from rigid_body_sim.physics.contact.energy.pressing_groups import order_of_sums, unite_pressing
from rigid_body_sim.physics.contact.energy.scratch import (
    OF_MOMENTUM,
    OF_PLACE,
    OF_SPIN,
    TAKEN,
    EnergyScratch,
)
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    wide_lanes,
)
from rigid_body_sim.physics.contact.touching import bodies_of
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    dot,
    load,
    load_symmetric,
    scale,
    store,
    subtract,
    trace,
)

# [-] of the energy, in a tick of USUAL and more; in a shorter one less, as its square
SHARE_OF_FEW = 3e-6  # of up to FEW bodies
SHARE_OF_MANY = 6e-6  # of more
USUAL = 0.004  # [s]
FEW = 3.0  # [-] bodies


@inline
def _size_of_energy(body: int, motion: Motion, bodies: Array) -> Any:
    """T_0 + W + |F| k of a body, k its radius of gyration [J]."""
    row, place = body * solver_bodies.SIZE, blocks.at(body, blocks.TRANSLATION)
    inverse_mass = motion.translation[place + blocks.IM]
    acceleration = scale(inverse_mass, held_force_on(body, motion))
    inverses = trace(load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA))
    weight = 0.0
    if inverses > 0.0:
        weight = math.sqrt(3.0 * dot(acceleration, acceleration) / (inverses * inverse_mass))
    return max(bodies[row + solver_bodies.ENERGY], 0.0) + weight


@inline
def share_of_tick(h: float, whole: float) -> float:
    """
    Share of the gains of a tick of USUAL that a tick h [s] may have: it falls as the square.

    whole : [s] tick that is not cut, of which this may be a piece
    """
    return min(1.0, h / whole) * min(1.0, whole * whole / (USUAL * USUAL))


@inline
def _any_gains(share: float, touching: Indices, motion: Motion, bodies: Array) -> bool:
    """Tell whether some body has gained: else no group has."""
    for index in range(len(touching)):
        body = touching[index]
        row = body * solver_bodies.SIZE
        gain = kinetic(bodies, row) - bodies[row + solver_bodies.ENERGY]
        if gain > 0.0 and gain > share * SHARE_OF_FEW * _size_of_energy(body, motion, bodies):
            return True
    return False


@inline
def _rise(
    h: float, body: int, gain: int, motion: Motion, gains: Array, bodies: Array
) -> Any:  # fmt: skip
    """
    How far a body has moved in a tick h [s] against the forces on it, as far as its group is held
    against them, and as seen from what carries it: a vector [m], and the work that took [J].
    """
    row = body * solver_bodies.SIZE
    if bodies[row + solver_bodies.INVERSE_MASS] <= solver_bodies.HELD:
        return (0.0, 0.0, 0.0), 0.0
    force = held_part(gain, force_on(body, motion, bodies), gains)
    square = dot(force, force)
    moved = subtract(position_of(body, motion), load(bodies, row + solver_bodies.START_POSITION))
    if is_carried(gain, gains):
        velocity, _ = carrying_motion(body, gain, motion, gains, bodies)
        moved = add_scaled(moved, -h, velocity)
    work = max(-dot(force, moved), 0.0)
    return scale(-work / square if square > 0.0 else 0.0, force), work


@inline
def _add_body(
    h: float, body: int, gain: int, motion: Motion, gains: Array, bodies: Array
) -> None:  # fmt: skip
    """Add a body to the account of its group."""
    row = body * solver_bodies.SIZE
    momentum, angular = changeable_momenta(body, gain, motion, gains, bodies)
    _, work = _rise(h, body, gain, motion, gains, bodies)
    gains[gain + gain_record.GAIN] += kinetic(bodies, row) - bodies[row + solver_bodies.ENERGY]
    gains[gain + gain_record.SIZE_OF_ENERGY] += _size_of_energy(body, motion, bodies)
    gains[gain + gain_record.CHANGEABLE] += 0.5 * twice_kinetic(bodies, row, momentum, angular)
    gains[gain + gain_record.RISE] += work
    mass = gains[gain + gain_record.MASS]
    if mass > 0.0:
        below = subtract(position_of(body, motion), load(gains, gain + gain_record.CENTER))
        depth = dot(load(gains, gain + gain_record.FORCE), below) / mass
        gains[gain + gain_record.LOWEST] = max(gains[gain + gain_record.LOWEST], depth)
    gains[gain + gain_record.BODIES] += 1.0


@inline
def _find_part(share: float, gain: int, gains: Array) -> None:
    """Find the part of motion and rise that a group gives back."""
    few = gains[gain + gain_record.BODIES] <= FEW
    share *= SHARE_OF_FEW if few else SHARE_OF_MANY
    potential = gains[gain + gain_record.MASS] * gains[gain + gain_record.LOWEST]
    size = gains[gain + gain_record.SIZE_OF_ENERGY] + potential
    excess = gains[gain + gain_record.GAIN] - share * size
    given = gains[gain + gain_record.CHANGEABLE] + gains[gain + gain_record.RISE]
    part = min(excess / given, 1.0) if given > 0.0 else 0.0
    gains[gain + gain_record.PART] = max(part, 0.0)


@inline
def _take_back(
    h: float, body: int, gain: int, motion: Motion, gains: Array, taken: Array, bodies: Array
) -> float:
    """Take its part from the motion and the rise of a body; return the work of what carries it."""
    row = body * solver_bodies.SIZE
    part = gains[gain + gain_record.PART]
    rise, _ = _rise(h, body, gain, motion, gains, bodies)
    momentum, angular = changeable_momenta(body, gain, motion, gains, bodies)
    shrinks = math.sqrt(1.0 - part) - 1.0
    for entry, change, where in (
        (row + solver_bodies.MOMENTUM, scale(shrinks, momentum), body * TAKEN + OF_MOMENTUM),
        (row + solver_bodies.ANGULAR_MOMENTUM, scale(shrinks, angular), body * TAKEN + OF_SPIN),
    ):
        store(bodies, entry, add(load(bodies, entry), change))
        store(taken, where, change)
    back = scale(-part, rise)
    store(taken, body * TAKEN + OF_PLACE, back)
    work = 0.0
    if is_carried(gain, gains):
        velocity, spin = carrying_motion(body, gain, motion, gains, bodies)
        work = shrinks * (dot(momentum, velocity) + dot(angular, spin))
    solver_bodies.shift(body, back, motion, bodies)
    return work


@kernel
def _follow(
    batch_count: int, static: int, width: int, batches: Indices, rows: Array, taken: Array
) -> None:
    """Let the separations of points follow bodies that went back."""
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
            opening = 0.0
            if body_b != static:
                opening += dot(normal, load(taken, body_b * TAKEN + OF_PLACE))
            if body_a != static:
                opening -= dot(normal, load(taken, body_a * TAKEN + OF_PLACE))
            for point in range(batches[batch + batch_record.POINT_COUNT]):
                row = lane + constraint.SIZE + point * width
                rows[row + contact_point.SEPARATION] += opening


@kernel
def bound_gains(
    h: float, whole: float, manifold_count: int, batch_count: int, static: int, width: int,
    group: Group, constraints: Constraints, scratch: EnergyScratch, works: Array, bodies: Array,
) -> bool:  # fmt: skip
    """
    Take back what contact gave to each group beyond its share; tell whether there was anything.

    h, whole : [s] the tick, and one that is not cut
    static   : index of what cannot move; it joins nobody
    width    : numbers of a point
    group    : all bodies that touch, in the blocks of the scene
    works    : (n,) [J] of what is moved as told on each body
    """
    share = share_of_tick(h, whole)
    touching, motion = group.members, group.motion
    batches, rows = constraints.batches, constraints.rows
    roots, gains, taken = scratch.roots, scratch.gains, scratch.taken
    if taken[static * TAKEN] > 0.0:
        for entry in range(len(taken)):
            taken[entry] = 0.0
    if not _any_gains(share, touching, motion, bodies):
        return False
    count = order_of_sums(
        manifold_count, static, touching, constraints.manifolds, rows, roots, scratch.order
    )
    touching = scratch.order[:count]
    unite_pressing(batch_count, static, touching, batches, rows, roots)
    for index in range(len(touching)):
        gain = touching[index] * gain_record.SIZE
        for entry in range(gain_record.SIZE):
            gains[gain + entry] = 0.0
    find_kept_motion(batch_count, static, touching, motion, batches, rows, roots, gains, bodies)
    for index in range(len(touching)):
        body = touching[index]
        _add_body(h, body, roots[body] * gain_record.SIZE, motion, gains, bodies)
    found = False
    for index in range(len(touching)):
        body = touching[index]
        if roots[body] == body:
            _find_part(share, body * gain_record.SIZE, gains)
            if gains[body * gain_record.SIZE + gain_record.PART] > 0.0:
                found = True
    if not found:
        return False
    for index in range(len(touching)):
        body = touching[index]
        gain = roots[body] * gain_record.SIZE
        if gains[gain + gain_record.PART] > 0.0:
            works[body] += _take_back(h, body, gain, motion, gains, taken, bodies)
    taken[static * TAKEN] = 1.0
    _follow(batch_count, static, width, batches, rows, taken)
    return True
