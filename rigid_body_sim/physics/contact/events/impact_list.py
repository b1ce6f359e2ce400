# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The list of impacts: what the kernel of the ticks writes of each, in the order in which they happen
in a tick.

An instant is a tick and a part of it: t = TICK h + PART, h the length of a tick of the kernel.
"""

from rigid_body_sim.physics.arrays import Record

impact = Record()
TICK = impact.number('tick', 'number of the tick of the kernel, since the start of the scene')
PART = impact.number('s', 'since the start of that tick')
COLLIDER_A = impact.number('-', 'number of collider A; type of A <= type of B')
COLLIDER_B = impact.number('-', 'number of collider B')
KIND = impact.number('-', 'what kind of impact, by the names below')
POINT = impact.vector('m', 'midway between the surfaces, world axes; of several, their mean')
NORMAL = impact.vector('-', 'unit normal from A to B, world axes')
IMPULSE = impact.vector('N s', 'on B; A gets the opposite; world axes')
APPROACH = impact.number('m/s', 'speed at which the points approached each other along the normal')
SIZE = impact.padding(16)  # two cache lines

# kinds
IMPACT = 0.0  # of one pair, by the law of impact
SUMMED = 1.0  # the rest of a sequence of ever smaller ones, at the instant at which it ends
JOINT = 2.0  # of several pairs at once, with what carries them
UNSETTLED = 3.0  # a cluster that pairwise impacts did not settle, taken at once
