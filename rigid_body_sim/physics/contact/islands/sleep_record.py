# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The sleep state of a body: it is part of what the next tick depends on.
"""

from rigid_body_sim.physics.arrays import Record

state = Record()
ISLAND = state.number('-', 'AWAKE, or n > 0: asleep in island n, or -n: island n wakes')
TIMER = state.number('s', 'how long it has been slow and steady')
FORCE = state.vector('N', 'without contacts, when the timer began, or when it fell asleep')
TORQUE = state.vector('N m', 'the same')
SIZE = state.size

AWAKE = 0.0
