# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
An impact, as `restitution_bound` accounts for it: of a group of bodies that press on each other,
in the row of its first body.
"""

from rigid_body_sim.physics.arrays import Record

impact = Record()
TAKEN = impact.number('J', 'what the impact took')
LINEAR = impact.number('J', 'b of T(s) - T_1 = s b + s^2 c')
SQUARE = impact.number('J', 'c')
RESTITUTION = impact.number('-', 'largest e of its points that bounce')
FACTOR = impact.number('-', 's by which its restitution impulses shrink')
SIZE = impact.size
