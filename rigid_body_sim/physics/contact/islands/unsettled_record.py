# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What is known of an island that goes on after the usual passes, in the row of its root: see
`islands.unsettled`.
"""

from rigid_body_sim.physics.arrays import Record

island = Record()
GOES_ON = island.number('-', '1: the last pass has changed something of it')
CHANGE = island.number('J', 'by the last pass: sum of dJ^2/m of points and patches')
CHANGE_BEFORE = island.number('J', 'the same of the pass before')
AHEAD = island.number('-', 'share of their last step by which impulses go ahead')
BODIES = island.number('-', 'that move')
MOST_PASSES = island.number('-', 'that it may take')
RESTARTS = island.number('-', 'how often they have begun anew')
SIZE = island.size
