# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whose surface the points of a manifold follow over a substep, and how round it is.

The numbers that `following` and `rims` read, once for each manifold that is new: see `rows`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def round_pair(a: int, b: int, table: Indices, bodies: Array) -> float:
    """
    Tell two balls (2), a ball beside what cannot move (1) and the rims of A (-1) or B (-2), a body
    of revolution, on a side that cannot move, from others (0).
    """
    core_a, core_b = (
        table[a * collider.TABLE + collider.CORE],
        table[b * collider.TABLE + collider.CORE],
    )
    type_a, type_b = (
        table[a * collider.TABLE + collider.TYPE],
        table[b * collider.TABLE + collider.TYPE],
    )
    if type_a == collider.CYLINDER and type_b == collider.PLANE and core_a >= 0:
        return -1.0 if bodies[core_a * solver_bodies.SIZE + solver_bodies.SYMMETRY] == 1.0 else 0.0
    if type_a == collider.BOX and type_b == collider.CYLINDER and core_a < 0 and core_b >= 0:
        return -2.0 if bodies[core_b * solver_bodies.SIZE + solver_bodies.SYMMETRY] == 1.0 else 0.0
    ball_a = core_a >= 0 and bodies[core_a * solver_bodies.SIZE + solver_bodies.SYMMETRY] == 3.0
    ball_b = core_b >= 0 and bodies[core_b * solver_bodies.SIZE + solver_bodies.SYMMETRY] == 3.0
    fixed_a = core_a < 0 and type_a == collider.SPHERE
    fixed_b = core_b < 0 and type_b == collider.SPHERE
    if (ball_a and (ball_b or fixed_b)) or (ball_b and fixed_a):
        return 2.0
    return 1.0 if (ball_a and core_b < 0) or (ball_b and core_a < 0) else 0.0


@inline
def weight(a: int, b: int, table: Indices, bodies: Array) -> float:
    """
    Tell whose surface the points follow: that of the body that moves, of the rounder one, else of
    both.
    """
    core_a, core_b = (
        table[a * collider.TABLE + collider.CORE],
        table[b * collider.TABLE + collider.CORE],
    )
    round_a = bodies[core_a * solver_bodies.SIZE + solver_bodies.SYMMETRY] if core_a >= 0 else -1.0
    round_b = bodies[core_b * solver_bodies.SIZE + solver_bodies.SYMMETRY] if core_b >= 0 else -1.0
    if round_a == round_b:
        return 0.5
    return 0.0 if round_a > round_b else 1.0


@inline
def layer(a: int, bounds: Array) -> float:
    """Radius of the layer of a collider about its core; a plane has none."""
    thick = bounds[a * collider.BOUNDS + 6]
    return thick if thick < math.inf else 0.0
