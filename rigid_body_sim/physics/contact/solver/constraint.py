# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The contact constraint: what the solver knows of one manifold, in a lane of a wide constraint.

Constraints are kept in batches of eight manifolds that share no moving body (`colouring`). A batch
is one wide constraint: rows of eight numbers, one for each manifold ("lane"), first those of the
manifold, here, then those of its points, one after the other (`contact_point`). Because the lanes
of a batch share no body that can move, the solver may treat them at once, which the compiler turns
into SIMD: the result is that of one after the other. An empty lane names the body that cannot move
and has zeros elsewhere.

At the head of the array lies one batch of scratch: the bodies of the lanes under way
(`lane_scratch`).
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.model.material import add_material

LANES = 8  # [-] manifolds side by side

constraint = Record(stride=LANES)
BODY_A = constraint.number('-', 'where the row of body A begins (`solver_bodies`)')
BODY_B = constraint.number('-', 'the same of B')
NORMAL = constraint.vector('-', 'unit normal from A to B, world axes')
TANGENT_1 = constraint.vector('-', 'first tangent, world axes')
TANGENT_2 = constraint.vector('-', 'second tangent, normal x first')
RESTITUTION, FRICTION, ROLLING_FRICTION, TORSIONAL_FRICTION = add_material(constraint)
MATERIAL = RESTITUTION  # where the material of the pair begins
BIAS_RATE = constraint.number('1/s', 'beta of the soft normal')
MASS_SCALE = constraint.number('-', 'sigma of the soft normal')
IMPULSE_SCALE = constraint.number('-', 'iota of the soft normal')
SPRING_MASS = constraint.number(
    'kg', 'of the one spring of all its points: `face_spring`; 0: each has its own'
)
MEAN_SPRING_MASS = constraint.number(
    'kg', 'of the spring of a point that stands for the mean part; 0: each has its effective mass'
)
MANIFOLDS = constraint.number('-', 'of its bodies, of the one that has more')
ALONE = constraint.number('-', '1: these are all of one surface, or this one')
OTHERS_IMPULSE = constraint.number('N s', 'by which the others of its surface press that')
LASTS = constraint.number('-', 'share of what presses it that lasts: `warm_start`')
GOES_ON = constraint.number('-', 'share of their change with which its loads go on: `warm_start`')
BOUNCE_SPEED = constraint.number('m/s', 'slower impacts do not bounce, where anything does')
ROLLING_MASS = constraint.number('kg m^2', 'effective mass: angular impulse per rolling velocity')
TWIST_MASS = constraint.number('kg m^2', 'effective mass: angular impulse per twisting velocity')
INVERSE_MASS_A = constraint.number('1/kg', 'of A')
INVERSE_INERTIA_A = constraint.symmetric('1/(kg m^2)', 'of A now, world axes')
INVERSE_MASS_B = constraint.number('1/kg', 'of B')
INVERSE_INERTIA_B = constraint.symmetric('1/(kg m^2)', 'of B now, world axes')
SURFACE_WEIGHT = constraint.number(
    '-', 'share in which a point of A goes with B: `manifold_constraints`'
)
ROUNDNESS = constraint.number('-', 'what is round of the pair: one of the names below')
UNSETTLED = constraint.number(
    'm/s', 'by which the last pass has changed its points; 0: by less than settles'
)
LEFT_SUBSTEPS = constraint.number(
    '-', 'substeps of this tick that have left it sinking in: `islands.left_sinking`'
)
LEFT_SPEED = constraint.number('m/s', 'with which it does, the least of them')
TOUCHED = constraint.number('-', '1: some point of it has pressed in this tick')
BOUNCES = constraint.number('-', '1: its bodies take part in a bounce: `islands.bouncing`')
SLIP_LEFT_1 = constraint.number(
    'm/s', 'along tangent 1, of what bounces: by forces, behind the impact: `islands.waiting`'
)
SLIP_LEFT_2 = constraint.number('m/s', 'the same, tangent 2')
RADIUS_A = constraint.number(
    'm', 'of the ball, capsule or mantle that meets here as A, else 0: see `curved_cores`'
)
RADIUS_B = constraint.number('m', 'the same of B')
PACE = constraint.number('m/s', 'with which an overlap goes beyond what carries its load')
DEEP = constraint.number('m', 'an overlap beyond which it comes out at a rate of its own')
LOAD = constraint.number('m/s^2', 'what it carries, of the last ticks: see `static_sink`')
SINK = constraint.number('m', 'which that takes out of the separations of its points')
SHARE = constraint.number('-', 'w: of the surface that its face is a part of, see `softness`')
LEFT_ALONE = constraint.number(
    '-', 'share of the usual changes of its velocity that passes leave alone'
)
WAITS = constraint.number(
    's', 'of two balls: rest of the tick when they meet, 0: they do not: `ball_impacts`'
)
FAR_SEPARATION = constraint.number('m', 'least of its far points: `far_points`')
FAR_ARM_A = constraint.number('m', 'longest of their arms on A, with what lies beyond')
FAR_ARM_B = constraint.number('m', 'the same of B')
FACES = constraint.number('-', 'whose face the normal belongs to, where it may turn: names below')
SURFACE = constraint.number('-', 'of several manifolds solved as a whole: names below')
NEXT_OF_SURFACE = constraint.number('-', 'where the next lane of it is in the rows, 0: none')
NEXT_SURFACE = constraint.number('-', 'where the first lane of the next surface is, 0: none')
SURFACE_POINTS = constraint.number('-', 'points of it that are asked')
SURFACE_CHANGE = constraint.number('N s', 'largest change by it in this pass')
SIZE = constraint.size

# what is round of a pair
TWO_BALLS, BALL_ON_FIXED, CURVED, NOT_ROUND, RIM_OF_A, RIM_OF_B = 2.0, 1.0, 0.5, 0.0, -1.0, -2.0
NO_FACE, FACE_OF_A, FACE_OF_B, TWO_FACES = 0.0, 1.0, 2.0, 3.0
OF_NO_SURFACE, FIRST_OF_SURFACE, OF_SURFACE = 0.0, 1.0, 2.0
