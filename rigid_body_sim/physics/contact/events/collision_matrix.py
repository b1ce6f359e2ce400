# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The collision matrix of a point at which two bodies meet: what an impulse on B, and its opposite on
A, changes in the velocity of B against A there.

    du = K p,   K = sum over both bodies of  1/m - [r]x I^-1 [r]x        [1/kg]

    r : arm of the point from the centre of mass       I : inertia in world axes

Also called the inverse effective mass, or the Delassus matrix of one contact.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.vectors import add_symmetric, apply_symmetric, cross, dot


class StruckBody(NamedTuple):
    """
    A body at a point where it is struck; zeros for what cannot move.

    inverse_mass    : [1/kg]
    inverse_inertia : [1/(kg m^2)] world axes: xx, xy, xz, yy, yz, zz
    arm             : [m] of the point from the centre of mass, world axes
    """

    inverse_mass: float
    inverse_inertia: Any
    arm: Any


class CollisionMatrix(NamedTuple):
    """
    K in the axes (1, 2, n) of a contact: n the normal, 1 and 2 in the tangent plane [1/kg].
    """

    k_11: float
    k_12: float
    k_22: float
    k_1n: float
    k_2n: float
    k_nn: float


@inline
def _turning(inverse_inertia: Any, arm: Any, axes: Any) -> Any:
    """What the turning of one body gives to K: (r x e_i) . I^-1 (r x e_j), i <= j."""
    lever_1, lever_2, lever_n = cross(arm, axes[0]), cross(arm, axes[1]), cross(arm, axes[2])
    turn_1 = apply_symmetric(inverse_inertia, lever_1)
    turn_2 = apply_symmetric(inverse_inertia, lever_2)
    turn_n = apply_symmetric(inverse_inertia, lever_n)
    return (
        dot(lever_1, turn_1), dot(lever_1, turn_2), dot(lever_1, turn_n),
        dot(lever_2, turn_2), dot(lever_2, turn_n), dot(lever_n, turn_n),
    )  # fmt: skip


@inline
def in_axes(first: StruckBody, second: StruckBody, axes: Any) -> CollisionMatrix:
    """
    Return K in the axes of a contact.

    axes : two tangents and the normal, unit vectors, world axes
    """
    k_11, k_12, k_1n, k_22, k_2n, k_nn = add_symmetric(
        _turning(first.inverse_inertia, first.arm, axes),
        _turning(second.inverse_inertia, second.arm, axes),
    )
    mass = first.inverse_mass + second.inverse_mass
    return CollisionMatrix(mass + k_11, k_12, mass + k_22, k_1n, k_2n, mass + k_nn)


@inline
def across(normal: Any) -> Any:
    """Return a unit vector across a normal."""
    x, y, z = normal
    if abs(x) <= abs(y) and abs(x) <= abs(z):
        size = math.sqrt(y * y + z * z)
        return 0.0, z / size, -y / size
    if abs(y) <= abs(z):
        size = math.sqrt(x * x + z * z)
        return -z / size, 0.0, x / size
    size = math.sqrt(x * x + y * y)
    return y / size, -x / size, 0.0
