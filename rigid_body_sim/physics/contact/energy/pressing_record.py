# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A group of bodies that press on each other, in the row of its first body.
"""

from rigid_body_sim.physics.arrays import Record

group = Record()
GAIN = group.number('J', 'energy that contact has given it over the tick')
FALL = group.number('J', 'kinetic energy of its bodies, if each fell for a substep from rest')
KINETIC_ENERGY = group.number('J', 'of its bodies')
FORCE = group.vector('N', 'upon it, without contacts')
BODIES = group.number('-', 'how many it has')
HELD = group.number('-', 'how it is held: one of the names below')
PRESS = group.vector('N s', 'what it got from all that cannot move')
NORMAL = group.vector('-', 'of the plane on which it slides')
MASS = group.number('kg', '')
FIRST_MOMENT = group.vector('kg m', 'sum of mass times position')
CENTRE = group.vector('m', 'of mass')
MOMENTUM = group.vector('kg m/s', '')
ANGULAR_MOMENTUM = group.vector('kg m^2/s', 'about the centre of mass')
INERTIA = group.symmetric('kg m^2', 'about the centre of mass')
VELOCITY = group.vector('m/s', 'of its rigid motion u, at the centre of mass')
ANGULAR_VELOCITY = group.vector('rad/s', 'of its rigid motion u')
RELATIVE_ENERGY = group.number('J', 'kinetic, of the motion relative to u')
LET_DOWN = group.number('m/(N s)', 'how far a body alone is let down, over the impulse; <= 0')
SIZE = group.size

# how a group is held by what cannot move, in rising order; only groups that have gained are asked
CALM = -2.0  # it has not gained
UNHELD = -1.0  # nothing presses in it
FREE = 0.0  # its bodies press on each other alone
SLIDING = 1.0  # along one plane without friction
FAST = 2.0  # by friction, or by several planes
