# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Scratch of the batch under way: the bodies of its lanes, gathered, and what impulses have done to
them so far. Rows of eight lanes, see `constraint`. Each thread has its own.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.solver.constraint import LANES

scratch = Record(stride=LANES)
MOMENTUM_A = scratch.vector('kg m/s', 'before the pass')
ANGULAR_MOMENTUM_A = scratch.vector('kg m^2/s', 'as it is now')
MOMENTUM_B = scratch.vector('kg m/s', 'before the pass')
ANGULAR_MOMENTUM_B = scratch.vector('kg m^2/s', 'as it is now')
RELATIVE_VELOCITY = scratch.vector('m/s', 'of the centre of B from that of A, before the pass')
IMPULSE = scratch.vector('N s', 'on B so far')
DISPLACEMENT_A = scratch.vector('m', 'of A over the substep')
TURN_A = scratch.vector('-', 'vector part of its turn')
TURN_SCALAR_A = scratch.number('-', 'scalar part of its turn')
DISPLACEMENT_B = scratch.vector('m', 'the same of B')
TURN_B = scratch.vector('-', 'the same of B')
TURN_SCALAR_B = scratch.number('-', 'the same of B')
ACCELERATION_A = scratch.vector('m/s^2', 'of A without contact')
ANGULAR_ACCELERATION_A = scratch.vector('rad/s^2', 'of the core of A without contact: `approach`')
CORE_SPIN_A = scratch.vector('rad/s', 'angular velocity of the core of A')
ACCELERATION_B = scratch.vector('m/s^2', 'of B without contact')
ANGULAR_ACCELERATION_B = scratch.vector('rad/s^2', 'of the core of B without contact')
CORE_SPIN_B = scratch.vector('rad/s', 'angular velocity of the core of B')
RIM_AXIS = scratch.vector('-', 'axis of the body of revolution whose rim touches, or zeros')
ROUNDING = scratch.number('1/s^2', 'how its lowest point goes round, see `approach`')
PRESSES = scratch.number('-', '1: some point presses')
ACTIVE = scratch.number(
    '-', 'of the impulse that would mend a normal alone, what a visit gives; 0: nothing is changed'
)
VISITED = scratch.number('-', '1: the bodies of the lane have been fetched')
LARGEST_CHANGE = scratch.number('N s', 'largest change of an impulse in this pass')
AHEAD = scratch.number('-', 'share of its last change by which an impulse goes ahead')
STARTS = scratch.number('-', '1: friction that starts has changed by more than settles')
PRESS = scratch.number('N s', 'along the normal of all points: see `patch_friction`')
PRESS_1 = scratch.number('N m s', 'the same times its place along the first tangent')
PRESS_2 = scratch.number('N m s', 'the same, second tangent')
PRESS_11 = scratch.number('N m^2 s', 'the same times the place along the first tangent squared')
PRESS_12 = scratch.number('N m^2 s', 'the same times both places')
PRESS_22 = scratch.number('N m^2 s', 'the same times the place along the second tangent squared')
SLIDE_1 = scratch.number('-', 'friction of a patch over what presses, first tangent')
SLIDE_2 = scratch.number('-', 'the same, second tangent')
COMMON_STIRS = scratch.number('-', '1: the points have something to be solved in common')
COMMON_COUNT = scratch.number('-', 'how many points take part: see `common_impulse`')
COMMON_MASS = scratch.number('kg', 'sum of m sigma')
COMMON_DRIVE = scratch.number('N s', 'sum of m sigma b + iota J')
COMMON_SOFTNESS = scratch.number('-', 'sum of iota')
COMMON_ARM_A = scratch.vector('m', 'sum of the arms on A')
COMMON_ARM_B = scratch.vector('m', 'the same on B')
SPRING_IMPULSE = scratch.number('N s', 'by which the one spring of all points is pressed')
WHOLE_STIRS = scratch.number('-', '1: the manifold has something to be solved as a whole')
WHOLE_ACTIVE = scratch.number('-', 'ACTIVE, while visits of its points leave it alone')
WHOLE_PLACES = scratch.vector('-, m', 'k, sums of x, y of what takes part: `whole_manifold`')
WHOLE_SQUARES = scratch.vector('m^2', 'sums of x^2, xy, y^2')
WHOLE_DRIVES = scratch.vector('m/s', 'sums of r, r x, r y')
WHOLE_SOFTNESS = scratch.number('1/kg', 'sum of c of what is soft')
WHOLE_SOFT_PLACES = scratch.vector('-, m', 'sums of 1, x, y of what is soft')
BEND_A = scratch.vector('1/s', 'by which an arm of A departs from its velocity: `bends`')
BEND_B = scratch.vector('1/s', 'the same of B')
BEND = scratch.number('m/s', 'to be added to it, of layers about cores')
BEND_BY_GAP = scratch.number('1/s', 'the same, times the separation')
RIM_ROLLS = scratch.number('-', '1: it goes round, and one point of it carries all')
LINE_A = scratch.vector('-', 'axis along which the core of A meets as a line, or zeros')
LINE_B = scratch.vector('-', 'the same of B')
CURVED = scratch.number('-', '1: the normal is that of two cores: `curved_cores`')
SHARED = scratch.number('-', 'lane 0: 1: manifolds of the group are as soft as one: `softness`')
SURFACES = scratch.number('-', 'lane 0: 1: manifolds of the group have one friction in this tick')
WHOLE_WEIGHS = scratch.number('-', 'how its points are weighed in a round: `whole_manifold`')
WHOLE_MOST = scratch.number('N s', 'their largest impulse so far')
WHOLE_SURFACES = scratch.number(
    '-', 'lane 0: first lane of the first surface in the rows, 0: none'
)
SIZE = scratch.size
