# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A group of islands, which the solver visits before the next one: see `islands.solver_groups`. A row
more than there are groups tells where the last one ends.
"""

from rigid_body_sim.physics.arrays import Record

group = Record()
FIRST_MANIFOLD = group.number('-', 'place of its first manifold in their order by groups')
FIRST_BATCH = group.number('-', 'number of its first batch')
FIRST_BODY = group.number('-', 'place of its first body in the list of those that touch')
SHARED = group.number('-', '1: some of its manifolds were as soft as one in the last tick')
SURFACES = group.number('-', '1: some of its manifolds have one friction in this tick')
SIZE = group.size


def most_groups(body_count: int) -> int:
    """Rows of a table of groups of so many bodies, with the last one."""
    return body_count + 2
