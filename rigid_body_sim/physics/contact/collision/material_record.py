# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The material of a collider, as the solver combines it for a pair.
"""

from rigid_body_sim.physics.arrays import Record

material = Record()
RESTITUTION = material.number('-', 'coefficient of restitution')
FRICTION = material.number('-', 'coefficient of friction')
ROLLING = material.number('m', 'rolling friction')
TORSIONAL = material.number('m', 'torsional friction')
SIZE = material.size
