# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The tables of an impact at several points at once: its bodies, and its points.
"""

from rigid_body_sim.physics.arrays import Record

body = Record()
INVERSE_MASS = body.number('1/kg', '0: cannot move')
INVERSE_INERTIA = body.symmetric('1/(kg m^2)', 'world axes')
VELOCITY = body.vector('m/s', 'of the centre of mass; in: before, out: after the impact')
ANGULAR_VELOCITY = body.vector('rad/s', 'world axes; the same')
COMPRESSED_VELOCITY = body.vector('m/s', 'at the end of the compression')
COMPRESSED_SPIN = body.vector('rad/s', 'the same')
BODY_SIZE = body.padding(24)

point = Record()
BODY_A = point.number('-', 'row of body A in the table of bodies; -1: the world')
BODY_B = point.number('-', 'row of body B; -1: the world')
ARM_A = point.vector('m', 'of the point from the centre of mass of A, world axes')
ARM_B = point.vector('m', 'of B')
NORMAL = point.vector('-', 'unit normal from A to B, world axes')
RESTITUTION = point.number('-', 'of what strikes here; 0 where a contact carries load')
FRICTION = point.number('-', '')
IMPULSE = point.vector('N s', 'out: on B; A gets the opposite')
NORMAL_IMPULSE = point.number('N s', 'so far')
FRICTION_IMPULSE = point.vector('N s', 'so far, across the normal')
START = point.number('m/s', 'normal velocity before the impact')
NORMAL_MASS = point.number('kg', 'effective mass along the normal')
TANGENT_MASS = point.number('kg', 'the smallest effective mass across it')
COMPRESSION = point.number('N s', 'normal impulse of the compression')
COMPRESSION_IMPULSE = point.vector('N s', 'all of the compression, on B')
COMPRESSED = point.vector('m/s', 'velocity of B against A at the end of the compression')
COLLIDER_A = point.number('-', 'whose point it is, for the list of impacts')
COLLIDER_B = point.number('-', 'the same')
BEFORE = point.vector('N s', 'impulse on B before the sweep')
DIRECTION = point.vector('N s', 'in which the sweeps go on: conjugate gradients')
OF_EVENT = point.number('-', 'where the event begins that it was added for: `flush_faces`')
TOLD = point.vector('m/s', 'of the velocity of B against A what no impulse changes')
POINT_SIZE = point.padding(48)
