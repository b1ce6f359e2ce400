# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The collider table: what a collider is, and whose.
"""

from rigid_body_sim.physics.arrays import Indices, Record
from rigid_body_sim.physics.compile.kernels import inline

table = Record()
TYPE = table.number('-', 'SPHERE ... PLANE, see `collider`')
PARAMETERS = table.number('-', 'where its shape parameters begin')
BODY = table.number('-', 'index of its body among those that move; STATIC; -2 - i: i sleeps')
SCENE_INDEX = table.number('-', 'index of its body in the scene')
STANDS_BACK = table.number('-', '1: pairs of such colliders are not looked for: `islands.manners`')
FIXED_ROW = table.number('-', 'solver body that it is where it does not move freely')
SIZE = table.size

STATIC = -1  # body index of what never moves


@inline
def solver_body(collider: int, table: Indices) -> int:
    """Index of the solver body of a collider."""
    body = table[collider * SIZE + BODY]
    return body if body >= 0 else table[collider * SIZE + FIXED_ROW]
