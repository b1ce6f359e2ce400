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
from rigid_body_sim.physics.contact.energy import pressing_record
from rigid_body_sim.physics.contact.energy.pressing_record import FAST, FREE, SLIDING
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    add,
    apply_symmetric,
    cross,
    dot,
    load,
    load_strided,
    load_symmetric,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

AT_REST = (0.0, 0.0, 0.0)


@inline
def _solve(matrix: Any, vector: Any) -> Any:
    """Solve a symmetric system; 0 where it is singular."""
    xx, xy, xz, yy, yz, zz = matrix
    cofactors = (
        yy * zz - yz * yz,
        xz * yz - xy * zz,
        xy * yz - xz * yy,
        xx * zz - xz * xz,
        xy * xz - xx * yz,
        xx * yy - xy * xy,
    )
    determinant = xx * cofactors[0] + xy * cofactors[1] + xz * cofactors[2]
    inverse = 1.0 / determinant if determinant > 0.0 else 0.0
    return scale(inverse, apply_symmetric(cofactors, vector))


@inline
def _angular_momentum(bodies: Array, row: int, angular_velocity: Any) -> Any:
    """Angular momentum of a body at an angular velocity: solves I^-1 L = omega."""
    inverse_inertia = load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA)
    return _solve(inverse_inertia, angular_velocity)


@inline
def _arm(body: int, group: int, translation: Array, groups: Array) -> Any:
    """Place of a body from the centre of mass of its group."""
    place = blocks.at(body, blocks.TRANSLATION)
    position = load_strided(translation, place + blocks.RX, blocks.LANES)
    return subtract(position, load(groups, group + pressing_record.CENTRE))


@inline
def rigid_momenta(body: int, group: int, translation: Array, bodies: Array, groups: Array) -> Any:
    """Momentum and angular momentum of a body in the rigid motion u of its group."""
    if groups[group + pressing_record.HELD] == FAST:
        return AT_REST, AT_REST
    row = body * solver_bodies.SIZE
    arm = _arm(body, group, translation, groups)
    angular_velocity = load(groups, group + pressing_record.ANGULAR_VELOCITY)
    velocity = add(cross(angular_velocity, arm), load(groups, group + pressing_record.VELOCITY))
    mass = 1.0 / bodies[row + solver_bodies.INVERSE_MASS]
    return scale(mass, velocity), _angular_momentum(bodies, row, angular_velocity)


@inline
def _accumulate(groups: Array, place: int, vector: Any) -> None:
    store(groups, place, add(load(groups, place), vector))


@inline
def _moves(group: int, groups: Array) -> bool:
    """Tell whether a group has a rigid motion that contact cannot change."""
    return (
        groups[group + pressing_record.HELD] == FREE
        or groups[group + pressing_record.HELD] == SLIDING
    )


@inline
def _add_body(body: int, group: int, translation: Array, bodies: Array, groups: Array) -> None:
    """Add mass and momentum of a body to those of its group."""
    row, place = body * solver_bodies.SIZE, blocks.at(body, blocks.TRANSLATION)
    mass = 1.0 / bodies[row + solver_bodies.INVERSE_MASS]
    groups[group + pressing_record.MASS] += mass
    position = load_strided(translation, place + blocks.RX, blocks.LANES)
    _accumulate(groups, group + pressing_record.FIRST_MOMENT, scale(mass, position))
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    _accumulate(groups, group + pressing_record.MOMENTUM, momentum)


@inline
def _add_turning(body: int, group: int, translation: Array, bodies: Array, groups: Array) -> None:
    """Add angular momentum and inertia of a body about the centre to those of its group."""
    row = body * solver_bodies.SIZE
    mass = 1.0 / bodies[row + solver_bodies.INVERSE_MASS]
    arm = _arm(body, group, translation, groups)
    orbital = cross(arm, load(bodies, row + solver_bodies.MOMENTUM))
    spin = load(bodies, row + solver_bodies.ANGULAR_MOMENTUM)
    _accumulate(groups, group + pressing_record.ANGULAR_MOMENTUM, add(spin, orbital))
    xx, xy, xz = _angular_momentum(bodies, row, (1.0, 0.0, 0.0))
    _, yy, yz = _angular_momentum(bodies, row, (0.0, 1.0, 0.0))
    _, _, zz = _angular_momentum(bodies, row, (0.0, 0.0, 1.0))
    arm_x, arm_y, arm_z = arm
    inertia = group + pressing_record.INERTIA
    _accumulate(
        groups,
        inertia,
        (
            xx + mass * (arm_y * arm_y + arm_z * arm_z),
            xy - mass * arm_x * arm_y,
            xz - mass * arm_x * arm_z,
        ),
    )
    _accumulate(
        groups,
        inertia + 3,
        (
            yy + mass * (arm_x * arm_x + arm_z * arm_z),
            yz - mass * arm_y * arm_z,
            zz + mass * (arm_x * arm_x + arm_y * arm_y),
        ),
    )


@kernel
def find_rigid_motions(
    touching: Indices, roots: Indices, translation: Array, bodies: Array, groups: Array
) -> None:
    """Find the rigid motion u of each group that is held (`find_held`) or free."""
    for index in range(len(touching)):
        body = touching[index]
        group = roots[body] * pressing_record.SIZE
        if _moves(group, groups):
            _add_body(body, group, translation, bodies, groups)
    for index in range(len(touching)):
        group = touching[index] * pressing_record.SIZE
        mass = groups[group + pressing_record.MASS]
        if roots[touching[index]] == touching[index] and mass > 0.0:
            for axis in range(3):
                groups[group + pressing_record.CENTRE + axis] = (
                    groups[group + pressing_record.FIRST_MOMENT + axis] / mass
                )
                groups[group + pressing_record.VELOCITY + axis] = (
                    groups[group + pressing_record.MOMENTUM + axis] / mass
                )
    for index in range(len(touching)):
        body = touching[index]
        group = roots[body] * pressing_record.SIZE
        if _moves(group, groups):
            _add_turning(body, group, translation, bodies, groups)
    for index in range(len(touching)):
        if roots[touching[index]] == touching[index]:
            _keep_to_what_is_free(touching[index] * pressing_record.SIZE, groups)


@inline
def _keep_to_what_is_free(group: int, groups: Array) -> None:
    """Find the angular velocity of the rigid motion; keep what slides to its plane."""
    inertia = load_symmetric(groups, group + pressing_record.INERTIA)
    angular_momentum = load(groups, group + pressing_record.ANGULAR_MOMENTUM)
    if groups[group + pressing_record.HELD] == SLIDING:
        normal = load(groups, group + pressing_record.NORMAL)
        across = dot(normal, load(groups, group + pressing_record.VELOCITY))
        along = subtract(load(groups, group + pressing_record.VELOCITY), scale(across, normal))
        store(groups, group + pressing_record.VELOCITY, along)
        about = dot(normal, apply_symmetric(inertia, normal))
        rate = dot(normal, angular_momentum) / about if about > 0.0 else 0.0
        angular_velocity = scale(rate, normal)
    else:
        angular_velocity = _solve(inertia, angular_momentum)
    store(groups, group + pressing_record.ANGULAR_VELOCITY, angular_velocity)
