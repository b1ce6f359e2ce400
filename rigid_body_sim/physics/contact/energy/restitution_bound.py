# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The restitution bound: a bounce gives back at most the share e^2 of the energy that the impact
took.

Newton's law, v_n <- -e v_n at each point, gives a ball or a central impact the right energy. At an
eccentric one with friction it can create energy (Kane and Levinson 1985), and where several points
strike at once too. So bodies that press on each other in a tick, a group, account for it:

    taken    = sum over the group of T_0 + W - T_1
    returned = T_2 - T_1 <= e^2 taken
        T_0, T_1, T_2 : [J] kinetic energy at the start of the tick, before and after the bounce
        W             : [J] work of all other forces over the tick
        e             : [-] largest restitution of its points that bounce
    (of T_2 - T_1, the work of what is moved as told does not count)

This is the energetic restitution of Stronge (1990) for the group as a whole. Where it is broken,
all impulses of the bounce of the group shrink by one factor s: momenta p_1 + s (p_2 - p_1),

    T(s) - T_1 = s b + s^2 c,   b = v_1 . (p_2 - p_1),   c = half of (p_2 - p_1) . (v_2 - v_1),

so that what one body gives another gets, and no friction leaves its cone.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.energy import impact_record
from rigid_body_sim.physics.contact.energy.account import kinetic, twice_kinetic
from rigid_body_sim.physics.contact.energy.pressing_groups import (
    group_of,
    order_of_sums,
    unite_pressing,
)
from rigid_body_sim.physics.contact.energy.scratch import EnergyScratch
from rigid_body_sim.physics.contact.solver import constraint, contact_point, friction_patch
from rigid_body_sim.physics.contact.touching import bodies_of, lane_of
from rigid_body_sim.physics.vectors import load, store, subtract

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@kernel
def keep_momenta(touching: Indices, bodies: Array) -> None:
    """Keep the momenta from which the bounce starts."""
    for index in range(len(touching)):
        row = touching[index] * solver_bodies.SIZE
        momentum = load(bodies, row + solver_bodies.MOMENTUM)
        angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
        store(bodies, row + solver_bodies.MOMENTUM_BEFORE_RESTITUTION, momentum)
        store(bodies, row + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION, angular_momentum)


@inline
def _largest_factor(allowed: float, linear: float, square: float) -> Any:
    """Return the largest s in [0, 1] with s b + s^2 c <= allowed, else what gives the least."""
    if linear + square <= allowed:
        return 1.0
    root = linear * linear + 4.0 * square * allowed
    if not root > 0.0:
        return min(max(-0.5 * linear / square, 0.0), 1.0) if square > 0.0 else 0.0
    root = math.sqrt(root)
    # the larger root, without a difference of like numbers
    factor = 2.0 * allowed / (linear + root) if linear > 0.0 else 0.5 * (root - linear) / square
    return min(max(factor, 0.0), 1.0)


@inline
def _find_restitutions(
    manifold_count: int, static: int, width: int, manifolds: Array, rows: Array, roots: Indices,
    impacts: Array,
) -> None:  # fmt: skip
    """Find the largest restitution of the points of each group that bounce."""
    for manifold in range(manifold_count):
        lane = lane_of(manifold, manifolds)
        body_a, body_b = bodies_of(lane, static, rows)
        impact = group_of(body_a, body_b, static, roots) * impact_record.SIZE
        points = int(manifolds[manifold * manifold_record.SIZE + manifold_record.POINT_COUNT])
        first = lane + constraint.SIZE
        for point in range(first, first + points * width, width):
            if (
                rows[lane + constraint.TOUCHED] > 0.0
                and rows[point + contact_point.APPROACH_VELOCITY] < 0.0
            ):
                impacts[impact + impact_record.RESTITUTION] = max(
                    impacts[impact + impact_record.RESTITUTION],
                    rows[lane + constraint.RESTITUTION],
                )


@inline
def _add_energies(body: int, impact: int, bodies: Array, impacts: Array) -> None:
    """Add to the account of a group what the impact took of a body, and what the bounce gave."""
    row = body * solver_bodies.SIZE
    momentum = load(bodies, row + solver_bodies.MOMENTUM_BEFORE_RESTITUTION)
    angular_momentum = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION)
    before = 0.5 * twice_kinetic(bodies, row, momentum, angular_momentum)
    change = subtract(load(bodies, row + solver_bodies.MOMENTUM), momentum)
    angular_change = subtract(load(bodies, row + solver_bodies.ANGULAR_MOMENTUM), angular_momentum)
    square = 0.5 * twice_kinetic(bodies, row, change, angular_change)
    impacts[impact + impact_record.TAKEN] += bodies[row + solver_bodies.ENERGY] - before
    impacts[impact + impact_record.SQUARE] += square
    impacts[impact + impact_record.LINEAR] += kinetic(bodies, row) - before - square


@inline
def _shrink_momenta(body: int, factor: float, bodies: Array) -> None:
    row = body * solver_bodies.SIZE
    for axis in range(3):
        momentum = bodies[row + solver_bodies.MOMENTUM_BEFORE_RESTITUTION + axis]
        angular_momentum = bodies[row + solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION + axis]
        bodies[row + solver_bodies.MOMENTUM + axis] = momentum + factor * (
            bodies[row + solver_bodies.MOMENTUM + axis] - momentum
        )
        bodies[row + solver_bodies.ANGULAR_MOMENTUM + axis] = angular_momentum + factor * (
            bodies[row + solver_bodies.ANGULAR_MOMENTUM + axis] - angular_momentum
        )


@inline
def _shrink_impulses(
    manifold_count: int, static: int, width: int, manifolds: Array, rows: Array, roots: Indices,
    impacts: Array,
) -> None:  # fmt: skip
    """Let the restitution impulses of each group shrink by its factor."""
    for manifold in range(manifold_count):
        lane = lane_of(manifold, manifolds)
        body_a, body_b = bodies_of(lane, static, rows)
        group = group_of(body_a, body_b, static, roots)
        factor = impacts[group * impact_record.SIZE + impact_record.FACTOR]
        if factor < 1.0:
            points = int(manifolds[manifold * manifold_record.SIZE + manifold_record.POINT_COUNT])
            first = lane + constraint.SIZE
            for point in range(first, first + points * width, width):
                rows[point + contact_point.RESTITUTION_NORMAL] *= factor
                rows[point + contact_point.RESTITUTION_TANGENT_1] *= factor
                rows[point + contact_point.RESTITUTION_TANGENT_2] *= factor
            if points > 1:
                face = first + MOST * width
                rows[face + friction_patch.RESTITUTION_1] *= factor
                rows[face + friction_patch.RESTITUTION_2] *= factor
                rows[face + friction_patch.RESTITUTION_TWIST] *= factor


@kernel
def bound_restitution(
    manifold_count: int, batch_count: int, static: int, width: int, touching: Indices,
    constraints: Constraints, scratch: EnergyScratch, works: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Shrink the bounce of each group that would return more than its share.

    static : index of what cannot move; it joins nobody
    width  : numbers of a point
    works  : [J] that driven bodies did by the bounce on each body; none where nothing is driven
    """
    manifolds, rows = constraints.manifolds, constraints.rows
    roots, impacts = scratch.roots, scratch.impacts
    count = order_of_sums(manifold_count, static, touching, manifolds, rows, roots, scratch.order)
    touching = scratch.order[:count]
    unite_pressing(batch_count, static, touching, constraints.batches, rows, roots)
    for index in range(len(touching)):
        impact = touching[index] * impact_record.SIZE
        impacts[impact + impact_record.TAKEN] = 0.0
        impacts[impact + impact_record.LINEAR] = 0.0
        impacts[impact + impact_record.SQUARE] = 0.0
        impacts[impact + impact_record.RESTITUTION] = 0.0
        impacts[impact + impact_record.FACTOR] = 1.0
    _find_restitutions(manifold_count, static, width, manifolds, rows, roots, impacts)
    for index in range(len(touching)):
        body = touching[index]
        impact = roots[body] * impact_record.SIZE
        _add_energies(body, impact, bodies, impacts)
        if len(works) > 0:
            impacts[impact + impact_record.LINEAR] -= works[body]
    for index in range(len(touching)):
        impact = touching[index] * impact_record.SIZE
        if roots[touching[index]] == touching[index]:
            allowed = (
                impacts[impact + impact_record.RESTITUTION]
                * impacts[impact + impact_record.RESTITUTION]
                * impacts[impact + impact_record.TAKEN]
            )
            impacts[impact + impact_record.FACTOR] = _largest_factor(
                allowed,
                impacts[impact + impact_record.LINEAR],
                impacts[impact + impact_record.SQUARE],
            )
    for index in range(len(touching)):
        body = touching[index]
        factor = impacts[roots[body] * impact_record.SIZE + impact_record.FACTOR]
        if factor < 1.0:
            _shrink_momenta(body, factor, bodies)
    _shrink_impulses(manifold_count, static, width, manifolds, rows, roots, impacts)
