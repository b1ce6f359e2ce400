# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The shape parameters of a collider, from the place on that the collider table names.

Of a hull, and of a cylinder behind its two numbers, they go on as a record of polyhedra
(`geometry.polyhedra.hull_records`).
"""

from rigid_body_sim.physics.arrays import Record

rounded = Record()  # sphere, capsule, cylinder; the axis is z
RADIUS = rounded.number('m', '')
HALF_LENGTH = rounded.number('m', 'of the axis, without the caps of a capsule; no sphere has it')

box = Record()
HALF_EDGES = box.vector('m', 'along x, y, z')

plane = Record()
NORMAL = plane.vector('-', 'unit normal out of the solid, world axes')
OFFSET = plane.number('m', 'distance from the origin of the world, along the normal')
