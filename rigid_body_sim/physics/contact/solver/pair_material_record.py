# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The material of a pair of colliders that the scene gives one of its own; NaN: not given.
"""

from rigid_body_sim.physics.arrays import Record

material = Record()
PAIR_ID = material.number('-', 'later collider times their count plus earlier one')
RESTITUTION = material.number('-', 'coefficient of restitution')
FRICTION = material.number('-', 'coefficient of friction')
ROLLING = material.number('m', 'rolling friction')
TORSIONAL = material.number('m', 'torsional friction')
SIZE = material.size

MATERIAL = slice(RESTITUTION, TORSIONAL + 1)
