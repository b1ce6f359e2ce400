# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impulse cache: what contacts leave to the next tick, for its warm start.

One list in the order of the pairs: substep [s] and number of manifolds; then for each manifold its
pair id, its number of points, and for each point the fields here. Impulses are vectors of the
world.
"""

from rigid_body_sim.physics.arrays import Record

head = Record()
SUBSTEP = head.number('s', 'length of the substep whose impulses these are')
MANIFOLDS = head.number('-', 'how many follow')
HEAD = head.size

manifold = Record()
PAIR_ID = manifold.number('-', 'see `manifold_record`')
POINTS = manifold.number('-', 'how many follow')
LOAD = manifold.number('m/s^2', 'see `static_sink`')
MANIFOLD_HEAD = manifold.size

point = Record()
FEATURE = point.number('-', 'stays the same while the same parts touch')
NORMAL_IMPULSE = point.number('N s', 'of the last substep')
FRICTION_IMPULSE = point.vector('N s', 'of the last substep, world axes')
ANCHOR = point.vector('m', 'place of the point in the axes of shape A')
ANGULAR_IMPULSE = point.vector('N m s', 'rolling and twisting, of the last substep, world axes')
POINT_SIZE = point.size
