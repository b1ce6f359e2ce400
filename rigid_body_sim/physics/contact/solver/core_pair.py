# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the solver knows of two curved surfaces that meet at one point, in wide lanes: the cores that
they are layers of, see `curved_cores`. Rows of eight numbers behind those of the point.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.solver.constraint import LANES

cores = Record(stride=LANES)
OFFSET = cores.vector('m', 'of the centre of mass of B from that of A, world axes')
MIDDLE_A = cores.vector('m', 'of the core of A, from its centre of mass, world axes')
AXIS_A = cores.vector('-', 'along the core, world axes; zeros: it is a point')
HALF_A = cores.number('m', 'half length of the core')
MIDDLE_B = cores.vector('m', 'the same of B')
AXIS_B = cores.vector('-', 'the same of B')
HALF_B = cores.number('m', 'the same of B')
DISTANCE = cores.number('m', 'of the nearest points of both cores')
TURNS = cores.number('-', '1: the normal lies along these; 0: it stays as it is for the tick')
SIZE = cores.size
