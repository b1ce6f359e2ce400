# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a group of bodies that press on each other has gained in a tick, as `gain_bound` accounts for
it, in the row of its first body.
"""

from rigid_body_sim.physics.arrays import Record

gain = Record()
GAIN = gain.number('J', 'kinetic energy beyond that of its start and the work of forces')
SIZE_OF_ENERGY = gain.number('J', 'of its energy, by which a gain is measured')
BODIES = gain.number('-', 'how many they are')
HELD = gain.number('-', 'what holds it: one of the names below')
AXIS = gain.vector('-', 'normal of the plane, or direction of the trough, that holds it')
HOLDER = gain.number('-', 'solver body that moves as told and holds it, or a name below')
CHANGEABLE = gain.number('J', 'kinetic energy of the motion that its contacts can change')
RISE = gain.number('J', 'work that its bodies have taken to rise')
PART = gain.number('-', 'of both that is taken back')
MASS = gain.number('kg', 'of its bodies')
CENTER = gain.vector('m', 'of its mass')
FORCE = gain.vector('N', 'on its bodies: weights, and what is held')
LOWEST = gain.number('m^2/s^2', 'largest a . (x - center) of a body, a = force over mass')
VELOCITY = gain.vector('m/s', 'of its centre of mass, where nothing holds it')
SPIN = gain.vector('rad/s', 'with which it so turns as a whole; before, its angular momentum')
INERTIA = gain.symmetric('kg m^2', 'about its centre of mass')
SIZE = gain.size

# what cannot move touches it: not; along one normal, without friction; along normals in one plane,
# without; along others, or with friction
FLOATS, ON_PLANE, IN_TROUGH, GRIPPED = 0.0, 1.0, 2.0, 3.0
# nothing holds it; something that stands, or several that move
NOBODY, STANDS = 0.0, -1.0
