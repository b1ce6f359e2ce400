# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the solver knows of one contact point, in wide lanes: rows of eight numbers, see `constraint`.

Accumulated impulses are those of the substep under way; they are clamped as sums (sequential
impulses). Tangential ones lie along the two tangents of the manifold.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.solver.constraint import LANES

ONE_POINT = 1e-16  # [m^2] sum of squared ways from their middle: points with less are one

point = Record(stride=LANES)
ARM_A = point.vector('m', 'from the centre of mass of A, world axes')
ARM_B = point.vector('m', 'from the centre of mass of B, world axes')
INITIAL_SEPARATION = point.number('m', 'separation at the start of the tick; negative: overlap')
SEPARATION = point.number('m', 'separation now, less its static sink')
NORMAL_MASS = point.number('kg', 'effective mass along the normal: impulse per velocity')
TANGENT_MASS = point.number('kg', 'effective mass along the tangents')
NORMAL_IMPULSE = point.number('N s', 'accumulated in this substep')
TANGENT_IMPULSE_1 = point.number('N s', 'accumulated in this substep, first tangent')
TANGENT_IMPULSE_2 = point.number('N s', 'accumulated in this substep, second tangent')
LARGEST_NORMAL_IMPULSE = point.number('N s', 'largest of any substep before this one')
APPROACH_VELOCITY = point.number(
    'm/s', 'relative normal velocity with which the surfaces would meet'
)
TOTAL_IMPULSE = point.vector('N s', 'over the tick, without this substep: normal, tangents')
CROSS_TERM_1 = point.number(
    '1/kg', 'entry of J M^-1 J^T: velocity along tangent 1 per normal impulse'
)
CROSS_TERM_2 = point.number('1/kg', 'the same along tangent 2')
WARM_NORMAL = point.number('N s', 'half the warm-start impulse of this substep')
WARM_TANGENT_1 = point.number('N s', 'the same, first tangent')
WARM_TANGENT_2 = point.number('N s', 'the same, second tangent')
SINK_SHARE = point.number('-', 'its own static sink over that of its manifold: `static_sink`')
SPRING_SHARE = point.number(
    '-', 'part of its face for which it stands, over the mean of all: `face_spring`'
)
TAKES_PART = point.number('-', '1: in what its manifold has in common: `common_impulse`')
DROPPED = point.number('-', '1: takes no more part in this visit: `whole_manifold`')
# while an island goes on that the usual passes have left unsettled: see `islands.unsettled`
BEGUN_BEFORE = point.vector('N s', 'normal, tangents, from which the pass before has begun')
BEGUN = point.vector('N s', 'the same of this pass')
SIZE = point.size  # where nothing rolls, twists or bounces

# beyond, where something does
ROLLING_IMPULSE_1 = point.number('N m s', 'accumulated angular impulse against rolling, tangent 1')
ROLLING_IMPULSE_2 = point.number('N m s', 'the same, tangent 2')
TWIST_IMPULSE = point.number('N m s', 'accumulated angular impulse against twisting')
RESTITUTION_NORMAL = point.number('N s', 'impulse of restitution')
RESTITUTION_TANGENT_1 = point.number('N s', 'impulse of restitution, tangent 1')
RESTITUTION_TANGENT_2 = point.number('N s', 'impulse of restitution, tangent 2')
WARM_ROLLING_1 = point.number('N m s', 'half the warm-start angular impulse, tangent 1')
WARM_ROLLING_2 = point.number('N m s', 'the same, tangent 2')
WARM_TWIST = point.number('N m s', 'the same, normal')
RECALLED_ANGULAR_IMPULSE = point.vector('N m s', 'of the impulse cache, world axes')
SIZE_LONG = point.size
