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
ROUND_PAIR = 280  # [-] 2: two balls, 1: a ball and what cannot move, 0: others; rims on a side
# that cannot move: -1 of A, -2 of B
UNREST = 288  # [-] 1: what its points gave has changed in the last pass by more than rest
TOUCHED = 296  # [-] 1: some point of it has pressed in this tick
LAYER_A, LAYER_B = 304, 312  # [m] radius of the balls or the capsule that meet here, else 0
MANIFOLD = 320  # numbers of the manifold

# of a point
RA, RB = 0, 24  # (3) [m] arms from the centres of mass
GAP0, GAP = 48, 56  # [m] gap at the start of the tick, now
GAIN, SLIP_GAIN = 64, 72  # [kg] impulse per velocity: normal, tangential
JN, JT, JO = 80, 88, 96  # [N s] impulses of this substep
MOST = 104  # [N s] largest normal impulse of any substep before this one
APPROACH = 112  # [m/s] normal velocity with which the surfaces would meet
SUM = 120  # (3) [N s] impulses over the tick, without those of the last substep
COUPLE_T, COUPLE_O = 144, 152  # [1/kg] tangential velocities per normal impulse
HN, HT, HO = 160, 168, 176  # [N s] half the load from which this substep started
POINT = 184  # numbers of a point where nothing rolls, twists or bounces
JR, JQ, JS = 184, 192, 200  # [N m s] angular impulses of this substep: rolling (2), twisting
BN, BT, BO = 208, 216, 224  # [N s] impulses of the bounce
HR, HQ, HS = 232, 240, 248  # [N m s] half the angular load
POINT_LONG = 256  # numbers of a point else

# scratch: what a pass knows of the two bodies of a lane, and what it has done to them so far
V = 0  # (3) [m/s] velocity of B relative to A before the pass
PS = 24  # (3) [N s] impulse on B so far
LA, LB = 48, 72  # (3) [kg m^2/s] angular momenta as they are now
DA, UA, SA = 96, 120, 144  # motion of A over the substep; accelerations
DB, UB, SB = 160, 184, 208  # the same of B
PUSHED = 224  # [-] whether some point pushes
CHANGE = 232  # [N s] largest change of a normal impulse, less what is calm
ACTIVE = 240  # [-] 1: the lane is visited; what is calm is not visited again
LARGEST = 248  # [N s] largest change of an impulse, less what is rest
SCRATCH = 256
