# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whose surface the points of a manifold follow over a substep, and what is round of its pair.

The numbers that `separation` and `rolling_frame` read, once for each manifold that is new.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact.collision import bounds_record, collider, collider_record
from rigid_body_sim.physics.contact.solver import constraint
from rigid_body_sim.physics.contact.solver_bodies import (
    ABOUT_AXIS,
    CENTRED_BALL,
    FIXED,
    SIZE,
    SYMMETRY,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def _symmetry(body: int, bodies: Array) -> float:
    """Tell how a body turns (`solver_bodies.SYMMETRY`); FIXED: it cannot move."""
    return bodies[body * SIZE + SYMMETRY] if body >= 0 else FIXED


@inline
def roundness(collider_a: int, collider_b: int, table: Indices, bodies: Array) -> float:
    """
    Tell what is round of a pair: two balls, a ball beside what cannot move, the rim of a body of
    revolution on a side that cannot move, or nothing (`constraint.ROUNDNESS`).
    """
    body_a = table[collider_a * collider_record.SIZE + collider_record.BODY]
    body_b = table[collider_b * collider_record.SIZE + collider_record.BODY]
    type_a = table[collider_a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[collider_b * collider_record.SIZE + collider_record.TYPE]
    symmetry_a, symmetry_b = _symmetry(body_a, bodies), _symmetry(body_b, bodies)
    if type_a == collider.CYLINDER and type_b == collider.PLANE and body_a >= 0:
        return constraint.RIM_OF_A if symmetry_a == ABOUT_AXIS else constraint.NOT_ROUND
    if type_a == collider.BOX and type_b == collider.CYLINDER and body_a < 0 and body_b >= 0:
        return constraint.RIM_OF_B if symmetry_b == ABOUT_AXIS else constraint.NOT_ROUND
    ball_a, ball_b = symmetry_a == CENTRED_BALL, symmetry_b == CENTRED_BALL
    fixed_a = body_a < 0 and type_a == collider.SPHERE
    fixed_b = body_b < 0 and type_b == collider.SPHERE
    if (ball_a and (ball_b or fixed_b)) or (ball_b and fixed_a):
        return constraint.TWO_BALLS
    if (ball_a and body_b < 0) or (ball_b and body_a < 0):
        return constraint.BALL_ON_FIXED
    return constraint.NOT_ROUND


@inline
def surface_weight(collider_a: int, collider_b: int, table: Indices, bodies: Array) -> float:
    """
    Tell whose surface the points follow: that of the body that moves, of the rounder one, else of
    both.
    """
    symmetry_a = _symmetry(table[collider_a * collider_record.SIZE + collider_record.BODY], bodies)
    symmetry_b = _symmetry(table[collider_b * collider_record.SIZE + collider_record.BODY], bodies)
    if symmetry_a == symmetry_b:
        return 0.5
    return 0.0 if symmetry_a > symmetry_b else 1.0


@inline
def layer(number: int, bounds: Array) -> float:
    """Radius of the layer of a collider about its core; a plane has none."""
    thick = bounds[number * bounds_record.SIZE + bounds_record.ROUNDING]
    return thick if thick < math.inf else 0.0
