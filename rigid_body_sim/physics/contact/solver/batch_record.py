# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A batch of eight constraints that share no moving body, as a row of integers.
"""

from rigid_body_sim.physics.arrays import Record

COLOURS = 60  # [-] of the graph colouring; beyond, a manifold gets a batch of its own

batch = Record()
BEGIN = batch.number('-', 'where it begins in the rows')
POINT_COUNT = batch.number('-', 'points of each of its manifolds')
LANE_COUNT = batch.number('-', 'lanes in use')
KIND = batch.number('-', '1: balls among themselves')
SIZE = batch.size
