# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A batch of wide constraints: up to eight that share no moving body, as a row of integers.
"""

from rigid_body_sim.physics.arrays import Record

COLOURS = 60  # [-] of the graph colouring; beyond, a manifold gets a batch of its own

batch = Record()
BEGIN = batch.number('-', 'where it begins in the rows')
POINT_COUNT = batch.number('-', 'points of each of its manifolds')
NEAR_COUNT = batch.number('-', 'of them, that are visited in this tick: `far_points`')
LANE_COUNT = batch.number('-', 'lanes in use')
KIND = batch.number('-', 'one of the names below')
COLOUR = batch.number('-', 'of its manifolds')
SIZE = batch.size
ROOM = 2 * SIZE  # of a batch in the list: once, and once more as scratch while they are sorted

# kinds of batches of a colour: of one point each, what is not round, balls among themselves or on
# what cannot move, and two layers about cores (`curved_cores`); of several points, those of bodies
# that have others, and those that are the only ones of theirs (`whole_manifold`)
MIXED, BALLS, CURVED, SEVERAL_POINTS, WHOLE = range(5)
KINDS = 5
OPEN_BATCHES = KINDS * (COLOURS + 1)  # [-] that may be open at a time
NONE_OPEN = -1
