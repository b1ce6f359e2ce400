# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Where the numbers of contacts are kept: batches of eight manifolds that share no moving body.

A batch has rows of eight numbers, one for each manifold ("lane"): first those of the manifold,
then those of its points, one after the other. Because the lanes of a batch share no body that can
move, the solver may treat them at once, which the compiler turns into SIMD: the result is that of
one after the other. An empty lane names the body that cannot move and has zeros elsewhere.

At the head of the array lies one batch of scratch: the bodies of the lanes under way.
"""

LANES = 8

# of the manifold
A, B = 0, 8  # [-] where the rows of the two bodies begin
N, T, T2 = 16, 40, 64  # (3) [-] unit normal from A to B, two tangents
MU = 88  # [-] friction
RATE, SCALE, KEEP = 96, 104, 112  # beta [1/s], sigma [-], iota [-] of the soft normal
BOUNCE = 120  # [-] restitution
ROLL, SPIN = 128, 136  # [m] rolling and torsional friction
ROLL_GAIN, SPIN_GAIN = 144, 152  # [kg m^2] angular impulse per angular velocity
MASS_A, MASS_B = 160, 168  # [1/kg] inverse masses
IA, IB = 176, 224  # (6) [1/(kg m^2)] inverse inertias now: xx, xy, xz, yy, yz, zz
WEIGHT = 272  # [-] share in which a contact point of A goes with B, see `passes.follow`
ROUND_PAIR = 280  # [-] 2: a ball and a ball, 1: a ball and what cannot move, 0: others
MANIFOLD = 288  # numbers of the manifold

# of a point
RA, RB = 0, 24  # (3) [m] arms from the centres of mass
GAP0, GAP = 48, 56  # [m] gap at the start of the tick, now
GAIN, SLIP_GAIN = 64, 72  # [kg] impulse per velocity: normal, tangential
JN, JT, JO = 80, 88, 96  # [N s] impulses of this substep
MOST = 104  # [N s] largest normal impulse of any substep before this one
APPROACH = 112  # [m/s] normal velocity with which the surfaces would meet
SUM = 120  # (3) [N s] impulses over the tick, without those of the last substep
COUPLE_T, COUPLE_O = 144, 152  # [1/kg] tangential velocities per normal impulse
HELD = 160  # [N s] normal impulse from which this substep started: a load
POINT = 168  # numbers of a point where nothing rolls, twists or bounces
JR, JQ, JS = 168, 176, 184  # [N m s] angular impulses of this substep: rolling (2), twisting
BN, BT, BO = 192, 200, 208  # [N s] impulses of the bounce
POINT_LONG = 216  # numbers of a point else

# scratch: what a pass knows of the two bodies of a lane, and what it has done to them so far
V = 0  # (3) [m/s] velocity of B relative to A before the pass
PS = 24  # (3) [N s] impulse on B so far
LA, LB = 48, 72  # (3) [kg m^2/s] angular momenta as they are now
DA, UA, SA, CA = 96, 120, 144, 152  # motion of A over the substep; accelerations
DB, UB, SB, CB = 160, 184, 208, 216  # the same of B
PUSHED = 224  # [-] whether some point pushes
CHANGE = 232  # [N s] largest change of a normal impulse, less what is calm
ACTIVE = 240  # [-] 1: the lane is visited; what is calm is not visited again
SCRATCH = 248
