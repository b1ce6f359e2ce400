# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
One iteration over one batch of wide constraints: sequential impulses, lane by lane.

Each point changes its accumulated impulse J by what makes its own velocity right, and clamps the
sum, not the change (sequential impulses). Normals are soft constraints (TGS-Soft): first soft,
with a bias that brings overlaps out, then, after the motion, relaxed without it. What is still
apart may close its separation within the substep, no more (speculative contact).

With relative velocity at the point v = v_B + omega_B x r_B - v_A - omega_A x r_A, v_n = n . v,
separation s, substep h, and beta, sigma, iota the bias rate, mass scale and impulse scale of
`manifold_constraints`:

    soft:     s > 0: dJ = -m (v_n + s/h)
              s <= 0: dJ = -m/(1 + c m) (v_n + max(beta (s + slop), -cap) + c J),
                      c = iota/(m sigma), with the m of its spring, or that of all points
                      together: `face_spring`
                      c J <= beta a: rigid where more would press: `soft_law`
              J_n - J_warm/2 >= 0: the other half of the warm start is still to come
    relaxed:  dJ = -m (v_n + max(s, 0)/h),  J_n >= 0; with a warm start: dJ = -m v_n
              m/(1 + x) for m where x = m (J_t . K_tn) / J_n > 1/2
    friction: J_t <- J_t - v_t / lambda_max, then onto the disc |J_t| <= mu J_n

m : effective mass, 1/(n-entry of J M^-1 J^T); lambda_max largest eigenvalue of its tangential
block. A step by 1/lambda_max and not by the inverse of the block: only so is the friction of a
slide opposite to its velocity. K_tn: velocity along the tangents per normal impulse. Friction that
slides follows what presses, and lifts by x of what it presses with: visits that leave this out
fall by x from one to the next, and end at no impulse at all where x > 1 (a steep rod that slides,
Painleve's ratio mu K/k_n).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver import (
    bends,
    constraint,
    contact_point,
    lane_scratch,
    static_sink,
    transfers,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.softness import spring_mass
from rigid_body_sim.physics.vectors import dot, scale, subtract

# [-] by which changes of friction count for more where a contact starts. Friction that tips a body
# changes what presses, and a visit finds less than half of it: what is left of its slip then,
# friction at its limit never takes back.
START = 100.0

# [m] separation from which surfaces are apart: less is rounding, by which the points of a body
# that lands flat must not differ
OPEN = 1e-12

# [-] of a substep. What is to bounce, and touches so shortly before the end of one, waits for the
# next, and is held from then on: whether it touches before or behind that end is rounding
NEARLY = 1e-6

# [1/s] speed at which a deep overlap goes, at most, over `constraint.DEEP`: five radii a second.
# Faster throws bodies apart that begin in each other
PUSH_OUT = 1000.0

# [-] of `constraint.DEEP`, r/200: by how much a spring gives way beyond the sink of what it is
# known to carry, at most (and MOST_SINK at all); there it is rigid. With more what is put down
# sinks in deeper, and is lifted again
GIVES = 0.3

# [-] ratio of two masses beyond which less than the usual changes are left alone, and the share
# that is, at least; more lets what is heavy rock on what is light, less takes all passes
UNLIKE, LEAST_SHARE = 30.0, 1e-3
# [-] the same of a line on which something rolls on what cannot move: more tilts a disc that
# changes from tile to tile; of points, less costs a capsule on its end a third of its accuracy
OF_ROLLING = 0.01

# [1/s] at which what is deeper than `constraint.DEEP` comes out, beside the pace: at once, loads
# that change, which let a contact sink a little deeper each time, end in a jump of the energy;
# slowly, piles are still lifted when nothing is lost any more in impacts
RATE = 200.0

# [-] impulse over that of the highest pace, from which a pace falls: what lies below something
# much heavier needs more than its own, and with 3 stacks topple that begin in each other; without
# end what is jammed between two is given more than numbers can hold
JAMS = 200.0

# [m/s] change of a velocity by a pass from which something is struck: passes before the motion go
# on (more lets heaps gain energy, less costs time), and balls are given more than mends a point.
# What lies in a steep groove is changed by less: given more, it would be stirred for ever, its
# loads off by some per cent
STRUCK = 1e-3

LIFTS = 0.5  # [-] x from which a visit takes into account that friction lifts

BENDS = slot('[-] whether anything turns but balls about their centres')
LAYERED = slot('[-] whether anything is a ball or a capsule')
RUBS = slot('[-] whether friction is that of the points, not of a patch of them')
RIMS = slot('[-] whether a cylinder may touch')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')


@kernel
def gather_inverse_masses(constraints: Array, bodies: Array) -> None:
    """Fetch the inverse masses and inertias of the bodies of a batch."""
    transfers.fetch_seven(
        constraints, constraint.BODY_A, bodies, solver_bodies.INVERSE_MASS, constraints,
        constraint.INVERSE_MASS_A,
    )  # fmt: skip
    transfers.fetch_seven(
        constraints, constraint.BODY_B, bodies, solver_bodies.INVERSE_MASS, constraints,
        constraint.INVERSE_MASS_B,
    )  # fmt: skip


@inline
def _fetch_momenta(constraints: Array, scratch: Array, bodies: Array) -> None:
    """Fetch the momenta of the bodies of a batch."""
    transfers.fetch_six(
        constraints, constraint.BODY_A, bodies, solver_bodies.MOMENTUM, scratch,
        lane_scratch.MOMENTUM_A,
    )  # fmt: skip
    transfers.fetch_six(
        constraints, constraint.BODY_B, bodies, solver_bodies.MOMENTUM, scratch,
        lane_scratch.MOMENTUM_B,
    )  # fmt: skip


@inline
def begin_lane(lane: int, constraints: Array, scratch: Array) -> None:
    """Find the relative velocity of the bodies of a lane, and begin its sums."""
    inverse_mass_a = constraints[lane + constraint.INVERSE_MASS_A]
    inverse_mass_b = constraints[lane + constraint.INVERSE_MASS_B]
    velocity_a = scale(inverse_mass_a, wide_lanes.vector(scratch, lane + lane_scratch.MOMENTUM_A))
    velocity_b = scale(inverse_mass_b, wide_lanes.vector(scratch, lane + lane_scratch.MOMENTUM_B))
    wide_lanes.put_vector(
        scratch, lane + lane_scratch.RELATIVE_VELOCITY, subtract(velocity_b, velocity_a)
    )
    wide_lanes.put_vector(scratch, lane + lane_scratch.IMPULSE, (0.0, 0.0, 0.0))
    scratch[lane + lane_scratch.PRESSES] = 0.0
    scratch[lane + lane_scratch.LARGEST_CHANGE] = 0.0


@kernel
def gather_momenta(lanes: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Fetch the momenta of the bodies of a batch; what empty lanes hold does not matter."""
    _fetch_momenta(constraints, scratch, bodies)
    for lane in range(lanes):
        begin_lane(lane, constraints, scratch)
        scratch[lane + lane_scratch.ACTIVE] = 1.0
        scratch[lane + lane_scratch.VISITED] = 1.0


@kernel
def gather_unsettled(
    lanes: int, step: float, constraints: Array, scratch: Array, bodies: Array
) -> None:
    """
    Do what `gather_momenta` does for the lanes that the last pass has changed; let the others
    stand still.

    step : [-] of the impulse along a normal that would mend its point alone, what a visit gives
           of balls, whose normals turn nothing, where the last pass has changed more than STRUCK;
           1 elsewhere: by more, bodies that tumble gain energy, and what lies never comes to rest
    """
    _fetch_momenta(constraints, scratch, bodies)
    for lane in range(lanes):
        begin_lane(lane, constraints, scratch)
        unsettled = constraints[lane + constraint.UNSETTLED]
        goes_on = unsettled > 0.0
        whose = constraints[lane + constraint.ROUNDNESS]
        of_balls = (whose == constraint.TWO_BALLS) | (whose == constraint.BALL_ON_FIXED)
        share = step if of_balls & (unsettled > STRUCK) else 1.0
        scratch[lane + lane_scratch.ACTIVE] = share if goes_on else 0.0
        scratch[lane + lane_scratch.VISITED] = 1.0 if goes_on else 0.0


@kernel
def scatter_momenta(constraints: Array, scratch: Array, bodies: Array) -> None:
    """Give the bodies of a batch what a pass has changed."""
    transfers.replace_on_a(
        constraints, constraint.BODY_A, bodies, solver_bodies.MOMENTUM, scratch,
        lane_scratch.IMPULSE, lane_scratch.ANGULAR_MOMENTUM_A, lane_scratch.VISITED,
    )  # fmt: skip
    transfers.replace_on_b(
        constraints, constraint.BODY_B, bodies, solver_bodies.MOMENTUM, scratch,
        lane_scratch.IMPULSE, lane_scratch.ANGULAR_MOMENTUM_B, lane_scratch.VISITED,
    )  # fmt: skip


@inline
def any_unsettled(used: int, constraints: Array) -> bool:
    """Tell whether the last pass has changed any lane."""
    found = False
    for lane in range(used):
        found = found or constraints[lane + constraint.UNSETTLED] > 0.0
    return found


@inline
def ratio_of_masses(lane: int, constraints: Array) -> Any:
    """Ratio of the masses of the two bodies of a lane, the larger over the smaller; of one: 1."""
    inverse_a = constraints[lane + constraint.INVERSE_MASS_A]
    inverse_b = constraints[lane + constraint.INVERSE_MASS_B]
    least = inverse_a if inverse_a < inverse_b else inverse_b
    most = inverse_b if inverse_a < inverse_b else inverse_a
    return most / least if least > 0.0 else 1.0


@inline
def share_left_alone(lane: int, constraints: Array) -> Any:
    """
    Share of the usual changes that is left alone of a lane: (UNLIKE m/M)^2 between bodies of very
    unlike mass M > m. What one pass cannot bring through grows there from tick to tick, until
    further passes are made.
    """
    share = UNLIKE / ratio_of_masses(lane, constraints)
    share = share if share < 1.0 else 1.0
    share *= share
    return share if share > LEAST_SHARE else LEAST_SHARE


@kernel
def find_shares_left_alone(used: int, point_count: int, constraints: Array) -> None:
    """Find what passes leave alone of the lanes of a batch with so many points, for a tick."""
    for lane in range(used):
        whose = constraints[lane + constraint.ROUNDNESS]
        of_ball = whose == constraint.TWO_BALLS or whose == constraint.BALL_ON_FIXED
        rolls = not of_ball and (
            whose < constraint.NOT_ROUND
            or constraints[lane + constraint.RADIUS_A] > 0.0
            or constraints[lane + constraint.RADIUS_B] > 0.0
        )
        on_fixed = not (
            wide_lanes.gives_way_a(constraints, lane) and wide_lanes.gives_way_b(constraints, lane)
        )
        constraints[lane + constraint.LEFT_ALONE] = (
            OF_ROLLING
            if rolls and on_fixed and point_count > 1
            else share_left_alone(lane, constraints)
        )


@inline
def leave_settled(used: int, constraints: Array) -> None:
    """Note that a pass has changed nothing in a batch."""
    for lane in range(used):
        constraints[lane + constraint.UNSETTLED] = 0.0


@inline
def mark_unsettled(
    used: int, rest: float, constraints: Array, points: Array, scratch: Array
) -> bool:
    """
    Note by how much this pass has changed the lanes where that is more than settles; tell whether
    there are any.

        rest   : [m/s] change of a velocity that is left alone
        points : the first of each lane
    """
    any_changed = False
    for lane in range(used):
        size = scratch[lane + lane_scratch.LARGEST_CHANGE]
        mass = points[lane + contact_point.NORMAL_MASS]
        changed = size > rest * constraints[lane + constraint.LEFT_ALONE] * mass
        constraints[lane + constraint.UNSETTLED] = size / mass if changed else 0.0
        any_changed = any_changed or changed
    return any_changed


@inline
def mark_touched(used: int, constraints: Array) -> None:
    """Note that the lanes have touched that the relaxation has changed."""
    for lane in range(used):
        if constraints[lane + constraint.UNSETTLED] > 0.0:
            constraints[lane + constraint.TOUCHED] = 1.0


@kernel
def mark_carried(used: int, constraints: Array, scratch: Array, bodies: Array) -> None:
    """Mark the bodies on which some point of a batch presses."""
    for lane in range(used):
        if scratch[lane + lane_scratch.PRESSES] > 0.0:
            constraints[lane + constraint.TOUCHED] = 1.0
            body_a = int(constraints[lane + constraint.BODY_A])
            body_b = int(constraints[lane + constraint.BODY_B])
            bodies[body_a + solver_bodies.CARRIED] = 1.0
            bodies[body_b + solver_bodies.CARRIED] = 1.0


@inline
def waits_to_bounce(
    lane: int, velocity: Any, gap: Any, impulse: Any, mass: Any, constraints: Array
) -> Any:  # fmt: skip
    """
    Tell whether a point that is still apart has to wait for the substep in which it touches, as it
    is to bounce there. What trembles comes slower, and must not: it would be let go, and lifted
    again, for ever.

    velocity : [m/s] along the normal
    gap      : [m/s] separation over the substep
    impulse  : [N s] what it has in this substep, on an effective mass [kg]
    """
    nearly = -NEARLY * velocity
    return (
        (constraints[lane + constraint.RESTITUTION] > 0.0)
        & (velocity < -constraints[lane + constraint.BOUNCE_SPEED])
        & (gap > -nearly)
        & (impulse <= nearly * mass)
    )


@inline
def soft_law(
    constraints: Array, lane: int, mass: float, separation: float, sink: float, impulse: float,
    sudden: float, inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Return bias and softness c = iota/(m sigma) of a point of a lane, soft where surfaces overlap.

    The spring of a point gives way by its sink and GIVES at most, MOST_SINK at all, and is rigid
    there: c J is no more than beta times that. Where the bias is that of the pace, beyond what the
    load takes, it is -(c J + pace), and its part with J cancels c J: then c is 0. What is jammed
    between two that both push it out cannot obey: its pace falls from JAMS times the impulse that
    gives the highest one, to none at twice that.

        mass    : [kg] on which its own spring acts: `softness.spring_mass`
        sink    : [m] its static sink, which its separation is less
        impulse : [N s] J, or of all points with their one spring: `face_spring`
        sudden  : [N s] of it, what no load explains
        cap     : [m/s] speed at which a deep overlap goes, at most
    """
    is_open = separation > OPEN
    depth = separation + slop
    depth = depth if depth < 0.0 else 0.0
    soft = constraints[lane + constraint.BIAS_RATE] * depth
    of_all = constraints[lane + constraint.SPRING_MASS]
    stiff = constraints[lane + constraint.MASS_SCALE] * (of_all if of_all > 0.0 else mass)
    deep = constraints[lane + constraint.DEEP]
    beneath = -depth - deep
    limit = PUSH_OUT * deep
    limit = limit if limit < cap else cap
    pace = constraints[lane + constraint.PACE] + (RATE * beneath if beneath > 0.0 else 0.0)
    pace = limit if pace > limit else pace
    free = JAMS * limit * mass
    left = 2.0 - sudden / (free if free > 0.0 else 1.0)
    left = left if left > 0.0 else 0.0
    pace *= left if left < 1.0 else 1.0
    most = sink + GIVES * deep
    limit = static_sink.MOST_SINK * deep
    most = most if most < limit else limit
    stop = constraints[lane + constraint.BIAS_RATE] * most
    softness = constraints[lane + constraint.IMPULSE_SCALE] / (stiff if stiff > 0.0 else 1.0)
    stands = softness * impulse > stop
    gives = stop if stands else softness * impulse
    bears = soft + gives + pace > 0.0
    bias = (soft + stop if stands else soft) if bears else -pace
    bias = separation * inverse_h if is_open else bias
    return bias, softness if bears & (not stands) & (not is_open) else 0.0


def _solve_normals(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float, slop: float,
    cap: float,
) -> None:  # fmt: skip
    """
    Solve the normal of one point of each lane, soft where the surfaces overlap.

        cap : [m/s] speed at which a deep overlap goes, at most
    """
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, TURNS)
        old = points[lane + contact_point.NORMAL_IMPULSE]
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        pressed_already = scratch[lane + lane_scratch.PRESSES]
        separation = points[lane + contact_point.SEPARATION]
        sink = static_sink.of_point(lane, lane, constraints, points)
        beyond = old
        if RIMS:
            rolls = scratch[lane + lane_scratch.RIM_ROLLS]
            separation += rolls * sink
            beyond -= 2.0 * rolls * points[lane + contact_point.WARM_NORMAL]
        mass = points[lane + contact_point.NORMAL_MASS]
        one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
        beyond = scratch[lane + lane_scratch.SPRING_IMPULSE] if one_spring else beyond
        bias, softness = soft_law(
            constraints, lane, spring_mass(lane, lane, constraints, points), separation, sink,
            beyond, old - 2.0 * points[lane + contact_point.WARM_NORMAL], inverse_h, slop, cap,
        )  # fmt: skip
        if BENDS:
            bias += bends.bend_of_point(lane, lane, LAYERED, points, scratch)
        # half of the warm start is still to come, of what presses
        pressed = old > 0.0
        warm = points[lane + contact_point.WARM_NORMAL]
        before = old - warm if pressed else 0.0
        step = scratch[lane + lane_scratch.ACTIVE]
        step *= mass / (1.0 + softness * mass)
        now = before - step * (dot(normal, velocity) + bias + softness * beyond)
        now = now if now > 0.0 else 0.0
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        now = now if active else before
        presses = now > 0.0 if active else pressed
        change = now - before
        scratch[lane + lane_scratch.SPRING_IMPULSE] += change if separation <= OPEN else 0.0
        impulse = scale(change, normal)
        if RUBS:
            # friction of the last substep is none of this one where less presses: it keeps its
            # share
            old_1 = points[lane + contact_point.TANGENT_IMPULSE_1]
            old_2 = points[lane + contact_point.TANGENT_IMPULSE_2]
            warm_1 = points[lane + contact_point.WARM_TANGENT_1]
            warm_2 = points[lane + contact_point.WARM_TANGENT_2]
            before_1 = old_1 - warm_1 if pressed else 0.0
            before_2 = old_2 - warm_2 if pressed else 0.0
            less = now < before
            share = now / (before if less else 1.0) if less else 1.0
            now_1, now_2 = share * before_1, share * before_2
            impulse = wide_lanes.impulse_of(
                change, now_1 - before_1, now_2 - before_2, normal, tangent_1, tangent_2
            )
            new_1 = now_1 + warm_1 if presses else 0.0
            new_2 = now_2 + warm_2 if presses else 0.0
            points[lane + contact_point.TANGENT_IMPULSE_1] = new_1 if active else old_1
            points[lane + contact_point.TANGENT_IMPULSE_2] = new_2 if active else old_2
        new = now + warm if presses else 0.0
        # a lane that is not visited keeps its bits
        points[lane + contact_point.NORMAL_IMPULSE] = new if active else old
        size = abs(change)
        scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
        scratch[lane + lane_scratch.PRESSES] = 1.0 if presses else pressed_already
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


@inline
def _with_slide(mass: float, slide_1: Any, slide_2: Any, points: Array, lane: int) -> Any:
    """
    Return the mass against what presses and the friction that follows it.

        slide_1, slide_2 : [-] friction over what presses
    """
    lifts = mass * (
        slide_1 * points[lane + contact_point.CROSS_TERM_1]
        + slide_2 * points[lane + contact_point.CROSS_TERM_2]
    )
    return mass / (1.0 + lifts) if lifts > LIFTS else mass


def _relax(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float
) -> None:  # fmt: skip
    """
    Solve normal and friction of one point of each lane, without push-out.

    Friction sees the tangential velocity that the new normal impulse leaves. What was warm-started
    touches: a motion along a curve has opened it by h^2 only. To send it back at s/h, as what is
    still apart, would take energy of first order in h.
    """
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        velocity = wide_lanes.relative_velocity(constraints, scratch, lane, arm_a, arm_b, TURNS)
        separation = points[lane + contact_point.SEPARATION]
        old = points[lane + contact_point.NORMAL_IMPULSE]
        mass = points[lane + contact_point.NORMAL_MASS]
        largest = scratch[lane + lane_scratch.LARGEST_CHANGE]
        is_open = separation > OPEN
        is_new = points[lane + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        if RUBS:
            share = 1.0 / old if old > 0.0 else 0.0
            slide_1 = share * points[lane + contact_point.TANGENT_IMPULSE_1]
            slide_2 = share * points[lane + contact_point.TANGENT_IMPULSE_2]
        else:
            slide_1 = scratch[lane + lane_scratch.SLIDE_1]
            slide_2 = scratch[lane + lane_scratch.SLIDE_2]
        mass = _with_slide(mass, slide_1, slide_2, points, lane)
        new = old - scratch[lane + lane_scratch.ACTIVE] * mass * (dot(normal, velocity) + bias)
        new = new if new > 0.0 else 0.0
        # what touches in the next substep bounces there: at the end of a tick here is too early;
        # balls whose impact is foreseen are struck there too
        waits = waits_to_bounce(
            lane, dot(normal, velocity), separation * inverse_h, old, mass, constraints
        )
        waits = waits | (is_open & (constraints[lane + constraint.WAITS] > 0.0) & (old <= 0.0))
        new = 0.0 if waits else new
        active = scratch[lane + lane_scratch.ACTIVE] > 0.0
        new = new if active else old
        change = new - old
        impulse = scale(change, normal)
        size = abs(change)
        if RUBS:
            old_1 = points[lane + contact_point.TANGENT_IMPULSE_1]
            old_2 = points[lane + contact_point.TANGENT_IMPULSE_2]
            tangent_mass = points[lane + contact_point.TANGENT_MASS]
            new_1 = old_1 - tangent_mass * (
                dot(tangent_1, velocity) + points[lane + contact_point.CROSS_TERM_1] * change
            )
            new_2 = old_2 - tangent_mass * (
                dot(tangent_2, velocity) + points[lane + contact_point.CROSS_TERM_2] * change
            )
            new_1, new_2 = wide_lanes.clamp_to_disc(
                new_1, new_2, constraints[lane + constraint.FRICTION] * new
            )
            new_1, new_2 = (new_1, new_2) if active else (old_1, old_2)
            change_1, change_2 = new_1 - old_1, new_2 - old_2
            impulse = wide_lanes.impulse_of(
                change, change_1, change_2, normal, tangent_1, tangent_2
            )
            slip = abs(change_1) + abs(change_2)
            slip = START * slip if is_new else slip
            size = size if size > slip else slip
            points[lane + contact_point.TANGENT_IMPULSE_1] = new_1
            points[lane + contact_point.TANGENT_IMPULSE_2] = new_2
        else:
            scratch[lane + lane_scratch.PRESS] += new
        scratch[lane + lane_scratch.LARGEST_CHANGE] = size if size > largest else largest
        points[lane + contact_point.NORMAL_IMPULSE] = new
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


def visits(
    *, rubs: bool, on_rims: bool, turns: bool, arcs: bool, layered: bool
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """
    Make the kernels that solve and relax a point.

        rubs    : with its friction
        on_rims : a cylinder may touch
        turns   : the inertia of something turns with it
        arcs    : something turns but balls about their centres
        layered : something is a ball or a capsule
    """
    name = f'{"rubs" if rubs else "smooth"}_{"rims" if on_rims else "plain"}'
    name += '' if turns else '_round'
    name += ('_bends' if arcs else '') + ('_layered' if layered else '')
    solves = specialise(
        _solve_normals, name=name, RUBS=rubs, RIMS=on_rims, TURNS=turns, BENDS=arcs,
        LAYERED=layered,
    )  # fmt: skip
    return solves, specialise(_relax, name=name, RUBS=rubs, TURNS=turns)
