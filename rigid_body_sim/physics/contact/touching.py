# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The bodies that touch, or nearly do: those that some manifold of the tick names.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.solver import constraint

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@inline
def lane_of(manifold: int, manifolds: Array) -> Any:
    """Where the lane of a manifold begins in the rows."""
    return int(manifolds[manifold * manifold_record.SIZE + manifold_record.LANE])


@inline
def bodies_of(lane: int, static: int, rows: Array) -> Any:
    """Core indices of the bodies A and B of a constraint; static: of what no contact moves."""
    return (
        min(int(rows[lane + constraint.BODY_A]) // solver_bodies.SIZE, static),
        min(int(rows[lane + constraint.BODY_B]) // solver_bodies.SIZE, static),
    )


@inline
def moving_body_of(lane: int, static: int, rows: Array) -> int:
    """Core index of a body of a constraint that can move."""
    body_a, body_b = bodies_of(lane, static, rows)
    return body_b if body_a == static else body_a


@kernel
def list_touching(
    manifold_count: int,
    body_count: int,
    manifolds: Array,
    rows: Array,
    order: Indices,
    marks: Indices,
    touching: Indices,
) -> int:
    """
    List the bodies that some manifold names, in the order of the core; return how many.

    manifold_count : how many manifolds there are
    order     : in which they lie in the rows
    marks     : scratch, a number for each body and for what cannot move
    """
    for body in range(body_count + 1):
        marks[body] = 0
    for index in range(manifold_count):
        body_a, body_b = bodies_of(lane_of(order[index], manifolds), body_count, rows)
        marks[body_a] = 1
        marks[body_b] = 1
    count = 0
    for body in range(body_count):
        if marks[body] == 1:
            touching[count] = body
            count += 1
    return count
