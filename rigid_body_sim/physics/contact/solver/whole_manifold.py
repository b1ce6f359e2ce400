# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Normals of a manifold of bodies that touch no more than two others, solved as a whole before its
points are visited one by one: so a motion that has a plane of symmetry keeps it, and a stack that
is put down flat stays flat. All that cannot move is one other.

Sequential impulses give a body that lands on an edge a turn with the first point and take it back
with the other, to the tolerance of the iteration. The points of a manifold are those of two rigid
bodies: at the place (x, y) in the plane of contact their velocity is v + x w_1 + y w_2. So the
change of their impulses is sought in the same form,

    J'_i = sum_j mu_j psi_j(i),   psi_0 = w_i, psi_1 = w_i (x_i - x), psi_2 = w_i (y_i - y)

over the points that press or are about to, w_i the part of the face for which each stands over the
mean (`face_spring`), k their sum and (x, y) their middle. With b and c of their one spring,
r_i = v_n + b_i + c sum_j J_j of point i,

    (B + C) mu = -sum_i psi(i) r_i,   J_i <- J_i + t J'_i

    B_jl = G_j x n . I^-1 (G_l x n) of A and of B, and k^2 (1/m_A + 1/m_B) in B_00
    G_j = sum_i psi_j(i) r_i,  r_i the arm;   C = c S S^T,  S = sum psi(i) of what is soft,
    or of what has springs at its points C = sum c_i psi(i) psi(i)^T, c_i w_i the same of all

It is the change after which visits of the points find nothing (Galerkin's equations in the space
of rigid motions). t <= 1 is the share at which the first impulse comes to 0: so far, no change
takes energy from the bodies that it gives back (the method of active sets; Nocedal and Wright,
Numerical Optimization, 2006, section 16.5). What then has no impulse and would be given less is
dropped, and the rest is solved again, ROUNDS times at most. Points that lie on a line have no
psi across it. Where a change would let one point go before the others, it is first tried with
w_i = J_i: so what lets go does so at all points at once.

Manifolds are solved one after the other. Where each one gives its bodies no turn, none of them
turns, however far the passes go. Several that are one surface are solved together
(`whole_surface`). Of bodies that touch three and more, only what is common is solved
(`common_impulse`): heaps of hulls would cost a twelfth more by this, and come to rest no sooner.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.arrays import Array
from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    bends,
    constraint,
    contact_point,
    face_spring,
    far_points,
    lane_scratch,
    static_sink,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.contact_point import ONE_POINT
from rigid_body_sim.physics.contact.solver.softness import spring_mass
from rigid_body_sim.physics.contact.solver.solve import LIFTS, OPEN, soft_law, waits_to_bounce
from rigid_body_sim.physics.vectors import (
    add,
    add_symmetric,
    cross,
    dot,
    scale,
    subtract,
)

STILL = 1e-12  # [m/s] r below which nothing is solved
ROUNDS = 6  # of active sets, at most: what is left then, the next pass does
LINE = 1e-12  # [-] of the sum of squares along one tangent: less along the other is none
ROUNDING = 1e-9  # [-] of an impulse, with what is to come: what is left where it comes to nothing
ONE_PLACE = 1e-13  # [-] of the squares of ways from the origin: points as near as that are one
SINGULAR = 1e-12  # [-] of its entry: a pivot that is no larger is none

# how points are weighed in a round; in this visit nothing is left
ALIKE, BY_IMPULSE, ALIKE_AGAIN, DONE = 0.0, 1.0, 2.0, 3.0

SOFT = slot('[-] whether overlaps are soft, before the motion')
BOUNCING = slot('[-] whether it is the impulse of restitution')
WIDTH = slot('[-] numbers of a point')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')
RIMS = slot('[-] whether a cylinder may touch')
BENDS = slot('[-] whether anything turns but balls about their centres')
LAYERED = slot('[-] whether anything is a ball or a capsule')
law = slot('kernel (constraints, points, ...): r, c, and whether a point takes part')
give_to_point = slot('kernel (row, share, part, points): gives a point its part')
part_of = slot('kernel (row, lane, change, ...): what a point has, and its part')
changes = slot('kernel (lane, ...): change of the points of a lane')
sums_of = slot('kernel (point, lane, ...): its sums')


@inline
def begin(lanes: int, width: int, points: Array, scratch: Array) -> None:
    """Begin a visit: all points of each lane may take part."""
    for lane in range(lanes):
        scratch[lane + lane_scratch.WHOLE_ACTIVE] = scratch[lane + lane_scratch.ACTIVE]
        scratch[lane + lane_scratch.WHOLE_WEIGHS] = ALIKE
        scratch[lane + lane_scratch.WHOLE_MOST] = 1.0
    for row in range(contact_point.DROPPED, manifold.MOST * width, width):
        for lane in range(lanes):
            points[row + lane] = 0.0


@inline
def _is_lifted(lane: int, width: int, points: Array, scratch: Array) -> Any:
    """Tell whether the friction of a lane lifts some point of it: `solve.LIFTS`."""
    slide_1 = scratch[lane + lane_scratch.SLIDE_1]
    slide_2 = scratch[lane + lane_scratch.SLIDE_2]
    lifts = 0.0
    for row in range(lane, lane + manifold.MOST * width, width):
        more = points[row + contact_point.NORMAL_MASS] * (
            slide_1 * points[row + contact_point.CROSS_TERM_1]
            + slide_2 * points[row + contact_point.CROSS_TERM_2]
        )
        lifts = more if more > lifts else lifts
    return lifts > LIFTS


@inline
def rest(
    lanes: int, width: int, slides: bool, constraints: Array, points: Array, scratch: Array
) -> None:
    """
    Let visits of the points leave alone what has been solved as a whole, until `resume`; but not
    what friction lifts, or brakes as it rolls or twists.

    slides : friction follows what presses: `patch_friction.find_slide`
    """
    for lane in range(lanes):
        visited = constraints[lane + constraint.ROLLING_FRICTION] > 0.0
        visited = visited | (constraints[lane + constraint.TORSIONAL_FRICTION] > 0.0)
        if slides:
            visited = visited | _is_lifted(lane, width, points, scratch)
        if not visited:
            scratch[lane + lane_scratch.ACTIVE] = 0.0


@inline
def any_active(lanes: int, scratch: Array) -> bool:
    """Tell whether visits of the points would change any lane."""
    found = False
    for lane in range(lanes):
        found = found or scratch[lane + lane_scratch.ACTIVE] > 0.0
    return found


@inline
def note_presses(lanes: int, width: int, points: Array, scratch: Array) -> None:
    """Note which lanes press, as visits of their points do."""
    for row in range(contact_point.NORMAL_IMPULSE, manifold.MOST * width, width):
        for lane in range(lanes):
            presses = points[row + lane] > 0.0
            before = scratch[lane + lane_scratch.PRESSES]
            scratch[lane + lane_scratch.PRESSES] = 1.0 if presses else before


@inline
def add_press(lanes: int, width: int, points: Array, scratch: Array) -> None:
    """Add up what presses on each lane, as visits of its points do."""
    for row in range(contact_point.NORMAL_IMPULSE, manifold.MOST * width, width):
        for lane in range(lanes):
            scratch[lane + lane_scratch.PRESS] += points[row + lane]


@inline
def resume(lanes: int, scratch: Array) -> None:
    """Let lanes that were visited be visited again: see `rest`."""
    for lane in range(lanes):
        scratch[lane + lane_scratch.ACTIVE] = scratch[lane + lane_scratch.WHOLE_ACTIVE]


@inline
def any_stirs(used: int, scratch: Array) -> bool:
    """Tell whether some lane has anything to be solved: what rests has not."""
    found = False
    for lane in range(used):
        found = found or scratch[lane + lane_scratch.WHOLE_STIRS] > 0.0
    return found


def _law(
    constraints: Array, points: Array, scratch: Array, lane: int, row: int, velocity: float,
    inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Return what `solve` has for a point: r, c, and whether it takes part: what presses, or is about
    to.

    row      : where the point begins in this lane
    velocity : [m/s] of it along the normal
    """
    separation = points[row + contact_point.SEPARATION]
    mass = points[row + contact_point.NORMAL_MASS]
    is_open = separation > OPEN
    bounces = constraints[lane + constraint.RESTITUTION]
    softness, may = 0.0, True
    field = contact_point.RESTITUTION_NORMAL if BOUNCING else contact_point.NORMAL_IMPULSE
    impulse = points[row + field]
    if BOUNCING:
        approach = points[row + contact_point.APPROACH_VELOCITY]
        bias = bounces * approach if approach < 0.0 else 0.0
        pressure = (
            points[row + contact_point.LARGEST_NORMAL_IMPULSE]
            + points[row + contact_point.NORMAL_IMPULSE]
        )
        may = (pressure > 0.0) & (constraints[lane + constraint.BOUNCES] > 0.0)
    elif SOFT:
        sudden = impulse - 2.0 * points[row + contact_point.WARM_NORMAL]
        sink = static_sink.of_point(lane, row, constraints, points)
        if RIMS:
            rolls = scratch[lane + lane_scratch.RIM_ROLLS]
            separation += rolls * sink
            impulse -= 2.0 * rolls * points[row + contact_point.WARM_NORMAL]
        one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
        impulse = scratch[lane + lane_scratch.SPRING_IMPULSE] if one_spring else impulse
        bias, softness = soft_law(
            constraints, lane, spring_mass(lane, row, constraints, points), separation, sink,
            impulse, sudden, inverse_h, slop, cap,
        )  # fmt: skip
        if BENDS:
            bias += bends.bend_of_point(row, lane, LAYERED, points, scratch)
    else:
        is_new = points[row + contact_point.WARM_NORMAL] <= 0.0
        bias = separation * inverse_h if is_open & is_new else 0.0
        gap = separation * inverse_h
        may = not waits_to_bounce(lane, velocity, gap, impulse, mass, constraints)
    # rows that have no point have no mass
    residual = velocity + bias
    if SOFT:
        residual += softness * impulse
    presses = points[row + field] > 0.0
    dropped = points[row + contact_point.DROPPED] > 0.0
    takes_part = may & (mass > 0.0) & (presses | ((residual < 0.0) & (not dropped)))
    return residual, softness, takes_part


@inline
def find_motion(lane: int, turns: bool, constraints: Array, scratch: Array) -> Any:
    """
    Return how a lane moves along its normal: its centres [m/s], and n x omega of A and B, which is
    what an arm gives [rad/s].
    """
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    spin_a, spin_b = wide_lanes.angular_velocities(constraints, scratch, lane, turns)
    of_centers = wide_lanes.velocity_of_centers(constraints, scratch, lane)
    return dot(normal, of_centers), cross(normal, spin_a), cross(normal, spin_b)


@inline
def _place(row: int, lane: int, constraints: Array, points: Array) -> Any:
    """Return where a point of a lane is from its first, along the two tangents [m]."""
    way = subtract(
        wide_lanes.vector(points, row + contact_point.ARM_B),
        wide_lanes.vector(points, lane + contact_point.ARM_B),
    )
    return (
        dot(way, wide_lanes.vector(constraints, lane + constraint.TANGENT_1)),
        dot(way, wide_lanes.vector(constraints, lane + constraint.TANGENT_2)),
    )


def _sums_of(
    point: int, lane: int, motion: Any, constraints: Array, points: Array,
    scratch: Array, inverse_h: float, slop: float, cap: float,
) -> Any:  # fmt: skip
    """
    Return what a point adds to the sums of its lane: 1, x, y, x^2, xy, y^2; r, r x, r y; c and the
    same of it. Nothing where it takes no part.

    motion : of the lane: see `find_motion`
    """
    row = lane + point * WIDTH
    x, y = _place(row, lane, constraints, points)
    arm_a, arm_b = wide_lanes.arms(points, row)
    velocity = motion[0] + (dot(motion[2], arm_b) - dot(motion[1], arm_a))
    found = law(constraints, points, scratch, lane, row, velocity, inverse_h, slop, cap)
    takes_part = found[2]
    share = points[row + contact_point.SPRING_SHARE]
    if scratch[lane + lane_scratch.WHOLE_WEIGHS] == BY_IMPULSE:
        most = scratch[lane + lane_scratch.WHOLE_MOST]
        share = impulse_so_far(row, points, SOFT, BOUNCING) / most
    share = share if takes_part else 0.0
    points[row + contact_point.TAKES_PART] = share
    along_x, along_y = share * x, share * y
    r = share * found[0] if takes_part else 0.0
    if SOFT:
        softness = found[1]
        soft_share = share if softness > 0.0 else 0.0
        one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
        softness *= 1.0 if one_spring else share
        soft = soft_share * softness, (soft_share, soft_share * x, soft_share * y)
    else:
        soft = 0.0, (0.0, 0.0, 0.0)
    return (
        (share, along_x, along_y, along_x * x, along_x * y, along_y * y), (r, r * x, r * y), soft
    )  # fmt: skip


@inline
def _added(sums: Any, more: Any) -> Any:
    """Add the sums of points."""
    places, drives, (softness, soft_places) = sums
    more_places, more_drives, (more_softness, more_soft_places) = more
    return (
        add_symmetric(places, more_places), add(drives, more_drives),
        (softness + more_softness, add(soft_places, more_soft_places)),
    )  # fmt: skip


@inline
def stirs(places: Any, drives: Any) -> Any:
    """Tell whether what moves the points that take part is more than STILL."""
    count, s_x, s_y, s_xx, _, s_yy = places
    share = 1.0 / (count if count > 0.0 else 1.0)
    x, y = share * s_x, share * s_y
    of_all, along_x, along_y = drives[0], drives[1] - x * drives[0], drives[2] - y * drives[0]
    spread = (s_xx - x * s_x) + (s_yy - y * s_y)
    turns = along_x * along_x + along_y * along_y > STILL * STILL * (spread + ONE_POINT)
    return turns | (of_all * of_all > STILL * STILL * count)


def _sum_up(
    lanes: int, constraints: Array, points: Array, scratch: Array, inverse_h: float, slop: float,
    cap: float,
) -> None:  # fmt: skip
    """
    Add up what takes part of each lane, and find the lanes that stir, of those that are visited.

    points : all points of each lane; what it has not, has no mass
    """
    if SOFT:
        face_spring.find_impulses(lanes, manifold.MOST, WIDTH, RIMS, constraints, points, scratch)
    for lane in range(lanes):
        motion = find_motion(lane, TURNS, constraints, scratch)
        one = sums_of(0, lane, motion, constraints, points, scratch, inverse_h, slop, cap)
        two = sums_of(1, lane, motion, constraints, points, scratch, inverse_h, slop, cap)
        three = sums_of(2, lane, motion, constraints, points, scratch, inverse_h, slop, cap)
        four = sums_of(3, lane, motion, constraints, points, scratch, inverse_h, slop, cap)
        places, drives, soft = _added(_added(_added(one, two), three), four)
        moves = stirs(places, drives) & (scratch[lane + lane_scratch.ACTIVE] > 0.0)
        # also if others go on: what a lane does must not depend on them
        moves = moves & (scratch[lane + lane_scratch.WHOLE_WEIGHS] != DONE)
        scratch[lane + lane_scratch.WHOLE_STIRS] = 1.0 if moves else 0.0
        count, x, y, xx, xy, yy = places
        wide_lanes.put_vector(scratch, lane + lane_scratch.WHOLE_PLACES, (count, x, y))
        wide_lanes.put_vector(scratch, lane + lane_scratch.WHOLE_SQUARES, (xx, xy, yy))
        wide_lanes.put_vector(scratch, lane + lane_scratch.WHOLE_DRIVES, drives)
        if SOFT:
            scratch[lane + lane_scratch.WHOLE_SOFTNESS] = soft[0]
            wide_lanes.put_vector(scratch, lane + lane_scratch.WHOLE_SOFT_PLACES, soft[1])


@inline
def _arms_of(row: int, lane: int, middle: Any, constraints: Array, points: Array) -> Any:
    """
    Return the arms of a point on A times psi_0, psi_1, psi_2, and those on B; zeros where it takes
    no part.

    middle : x, y of what takes part
    """
    x, y = _place(row, lane, constraints, points)
    share = points[row + contact_point.TAKES_PART]
    one, two = share * (x - middle[0]), share * (y - middle[1])
    arm_a, arm_b = wide_lanes.arms(points, row)
    return (
        (scale(share, arm_a), scale(one, arm_a), scale(two, arm_a)),
        (scale(share, arm_b), scale(one, arm_b), scale(two, arm_b)),
    )  # fmt: skip


@inline
def _added_arms(one: Any, two: Any) -> Any:
    """Add what `_arms_of` returns of two points."""
    one_a, one_b = one
    two_a, two_b = two
    return (
        (add(one_a[0], two_a[0]), add(one_a[1], two_a[1]), add(one_a[2], two_a[2])),
        (add(one_b[0], two_b[0]), add(one_b[1], two_b[1]), add(one_b[2], two_b[2])),
    )


@inline
def _moments(arms: Any, normal: Any) -> Any:
    """Return three arms x normal: G_0 x n, G_1 x n, G_2 x n."""
    return cross(arms[0], normal), cross(arms[1], normal), cross(arms[2], normal)


@inline
def response_of(row: int, turns: bool, moments: Any, constraints: Array) -> Any:
    """
    Return what the turn of one body adds to B: 00, 01, 02, 11, 12, 22.

    row     : where its inverse inertia begins
    moments : of impulses psi_0, psi_1, psi_2 about its centre
    """
    zero, one, two = moments
    of_zero = wide_lanes.apply_inverse_inertia(constraints, row, turns, zero)
    of_one = wide_lanes.apply_inverse_inertia(constraints, row, turns, one)
    of_two = wide_lanes.apply_inverse_inertia(constraints, row, turns, two)
    return (
        dot(zero, of_zero), dot(one, of_zero), dot(two, of_zero), dot(one, of_one),
        dot(one, of_two), dot(two, of_two),
    )  # fmt: skip


@inline
def _response(
    lane: int, turns: bool, width: int, middle: Any, constraints: Array, points: Array
) -> Any:
    """Return B without its masses: 00, 01, 02, 11, 12, 22; middle: x, y of what takes part."""
    arms = _arms_of(lane, lane, middle, constraints, points)
    arms = _added_arms(arms, _arms_of(lane + width, lane, middle, constraints, points))
    arms = _added_arms(arms, _arms_of(lane + 2 * width, lane, middle, constraints, points))
    arms = _added_arms(arms, _arms_of(lane + 3 * width, lane, middle, constraints, points))
    normal = wide_lanes.vector(constraints, lane + constraint.NORMAL)
    row_a, row_b = lane + constraint.INVERSE_INERTIA_A, lane + constraint.INVERSE_INERTIA_B
    arms_a, arms_b = arms
    return add_symmetric(
        response_of(row_a, turns, _moments(arms_a, normal), constraints),
        response_of(row_b, turns, _moments(arms_b, normal), constraints),
    )


@inline
def _solved(m: Any, d: Any) -> Any:
    """
    Solve a system of three that is not negative, by its factors L D L^T: 00, 01, 02, 11, 12, 22.
    What depends on those before it is 0.
    """
    m_00, m_01, m_02, m_11, m_12, m_22 = m
    i_0 = 1.0 / m_00
    l_1, l_2 = m_01 * i_0, m_02 * i_0
    d_1 = m_11 - l_1 * m_01
    n_12 = m_12 - l_1 * m_02
    has_1 = d_1 > SINGULAR * m_11
    i_1 = 1.0 / (d_1 if has_1 else 1.0)
    i_1 = i_1 if has_1 else 0.0
    l_3 = n_12 * i_1
    d_2 = m_22 - l_2 * m_02 - l_3 * n_12
    has_2 = d_2 > SINGULAR * m_22
    i_2 = 1.0 / (d_2 if has_2 else 1.0)
    i_2 = i_2 if has_2 else 0.0
    y_1 = d[1] - l_1 * d[0]
    y_2 = d[2] - l_2 * d[0] - l_3 * y_1
    z = y_2 * i_2
    y = y_1 * i_1 - l_3 * z
    return d[0] * i_0 - l_1 * y - l_2 * z, y, z


@inline
def spread_along(squares: Any, middle: Any, ways: Any) -> Any:
    """
    Return the sum of the squares of ways from their middle along a tangent, from those from the
    origin [m^2]: 0 where it is what rounding leaves, as of one point.
    """
    spread = squares - middle * ways
    return spread if spread > ONE_PLACE * squares else 0.0


def _changes(lane: int, constraints: Array, points: Array, scratch: Array) -> Any:
    """
    Return the change of the points of a lane: at the first, and along the two tangents per way
    from there; zeros where it does not stir.
    """
    count, s_x, s_y = wide_lanes.vector(scratch, lane + lane_scratch.WHOLE_PLACES)
    s_xx, s_xy, s_yy = wide_lanes.vector(scratch, lane + lane_scratch.WHOLE_SQUARES)
    r, r_x, r_y = wide_lanes.vector(scratch, lane + lane_scratch.WHOLE_DRIVES)
    stirs = scratch[lane + lane_scratch.WHOLE_STIRS] > 0.0
    share = 1.0 / (count if stirs else 1.0)
    x, y = share * s_x, share * s_y
    inverse_mass = (
        constraints[lane + constraint.INVERSE_MASS_A]
        + constraints[lane + constraint.INVERSE_MASS_B]
    )
    b_00, b_01, b_02, b_11, b_12, b_22 = _response(lane, TURNS, WIDTH, (x, y), constraints, points)
    b_00 += count * count * inverse_mass
    m = b_00, b_01, b_02, b_11, b_12, b_22
    spread = spread_along(s_xx, x, s_x), spread_along(s_yy, y, s_y)
    if SOFT:
        softness = scratch[lane + lane_scratch.WHOLE_SOFTNESS]
        soft, soft_x, soft_y = wide_lanes.vector(scratch, lane + lane_scratch.WHOLE_SOFT_PLACES)
        softness /= soft if soft > 0.0 else 1.0
        of_one = square_of(softness, soft, soft_x - x * soft, soft_y - y * soft)
        one_spring = constraints[lane + constraint.SPRING_MASS] > 0.0
        of_each = (
            softness * count, 0.0, 0.0,
            softness * spread[0], softness * (s_xy - x * s_y), softness * spread[1],
        )  # fmt: skip
        m = add_symmetric(m, of_one if one_spring else of_each)
    return change_from(spread, (r, r_x, r_y), m, (x, y), stirs)


@inline
def square_of(factor: float, one: float, x: float, y: float) -> Any:
    """Return a vector times itself, and a factor: 00, 01, 02, 11, 12, 22."""
    along = factor * one, factor * x, factor * y
    return along[0] * one, along[0] * x, along[0] * y, along[1] * x, along[1] * y, along[2] * y


@inline
def change_from(spread: Any, drives: Any, m: Any, middle: Any, stirs: bool) -> Any:
    """
    Return the change of points: at their origin, and along the two tangents per way from there;
    zeros where nothing stirs.

        spread : sums of the squares of the ways from the middle along the tangents [m^2]
        drives : sums of r, r x, r y
        m      : B + C: 00, 01, 02, 11, 12, 22
    """
    r, r_x, r_y = drives
    x, y = middle
    # along one of them nothing is told apart where the points lie across it
    p, q = spread
    m_00, m_01, m_02, m_11, m_12, m_22 = m
    wide, broad = p > LINE * (q + ONE_POINT), q > LINE * (p + ONE_POINT)
    zero, one, two = _solved(
        (
            m_00 if stirs else 1.0, m_01 if wide else 0.0, m_02 if broad else 0.0,
            m_11 if wide else 0.0, m_12 if wide & broad else 0.0, m_22 if broad else 0.0,
        ),
        (-r, x * r - r_x, y * r - r_y),
    )  # fmt: skip
    if not stirs:
        return 0.0, 0.0, 0.0
    return zero - (one * x + two * y), one, two


@inline
def impulse_so_far(row: int, points: Array, soft: bool, bouncing: bool) -> Any:
    """
    Return the impulse that a point has, as far as it has come: half of the warm start is still to
    come, before the motion, of what presses.

        soft, bouncing : of the pass: see SOFT, BOUNCING
    """
    field = contact_point.RESTITUTION_NORMAL if bouncing else contact_point.NORMAL_IMPULSE
    impulse = points[row + field]
    warm = points[row + contact_point.WARM_NORMAL] if soft else 0.0
    return impulse - warm if impulse > 0.0 else 0.0


def _part(row: int, lane: int, change: Any, constraints: Array, points: Array) -> Any:
    """Return the impulse that a point has, as far as it has come, and its part of the change."""
    before = impulse_so_far(row, points, SOFT, BOUNCING)
    x, y = _place(row, lane, constraints, points)
    takes_part = points[row + contact_point.TAKES_PART] > 0.0
    part = change[0] + (x * change[1] + y * change[2])
    part *= points[row + contact_point.TAKES_PART]
    return before, part if takes_part else 0.0


@inline
def _all_take_part(lane: int, width: int, points: Array) -> Any:
    """Tell whether all points of a lane take part."""
    found = True
    for row in range(lane, lane + manifold.MOST * width, width):
        # what a manifold has not is out of reach, or has no mass where its batch has not either
        is_point = points[row + contact_point.SEPARATION] < far_points.NONE
        is_point = is_point & (points[row + contact_point.NORMAL_MASS] > 0.0)
        found = found & ((points[row + contact_point.TAKES_PART] > 0.0) | (not is_point))
    return found


@inline
def _weigh(lane: int, share: Any, impulses: Any, scratch: Array) -> Any:
    """
    Return the share that a lane is given, and choose how its points are weighed in the next round:
    by their impulses, and none of this change, where it would let one of them go before the
    others.

        share    : of its change that it can take
        impulses : of its four points so far
    """
    before = scratch[lane + lane_scratch.WHOLE_WEIGHS]
    one, two, three, four = impulses
    most = wide_lanes.larger(one, two)
    most = wide_lanes.larger(wide_lanes.larger(most, three), four)
    waits = (before == ALIKE) & (share < 1.0) & (most > 0.0)
    most_before = scratch[lane + lane_scratch.WHOLE_MOST]
    scratch[lane + lane_scratch.WHOLE_MOST] = most if waits else most_before
    was_weighed = (before == BY_IMPULSE) & (scratch[lane + lane_scratch.WHOLE_STIRS] > 0.0)
    after = ALIKE_AGAIN if was_weighed else before
    scratch[lane + lane_scratch.WHOLE_WEIGHS] = BY_IMPULSE if waits else after
    return 0.0 if waits else share


@inline
def sooner(row: int, part: Any, before: Any, points: Array) -> Any:
    """
    Return of the point that comes to no impulse first what it has, and what it is to give up. A
    point that has none, and would be given less, is dropped.

    part   : what the point of the row has, and its part of the change
    before : what is returned, of the points before it; at first 1 and 1: the whole change
    """
    gives_up = -part[1]
    less, has = gives_up > 0.0, part[0] > 0.0
    points[row + contact_point.DROPPED] = (
        1.0 if less & (not has) else points[row + contact_point.DROPPED]
    )
    is_sooner = less & (part[0] * before[1] < before[0] * gives_up)
    return part[0] if is_sooner else before[0], gives_up if is_sooner else before[1]


def _give_to_point(row: int, share: float, part: Any, points: Array) -> Any:
    """
    Give a point a share of its part; return what it is given, and that times its arms.

    part : what it has, and its part
    """
    field = contact_point.RESTITUTION_NORMAL if BOUNCING else contact_point.NORMAL_IMPULSE
    warm = points[row + contact_point.WARM_NORMAL] if SOFT else 0.0
    before = part[0]
    now = before + share * part[1]
    now = now if now > ROUNDING * (before + warm) else 0.0
    given = share * part[1] != 0.0
    # else it keeps its bits
    new = now + warm if now > 0.0 else 0.0
    points[row + field] = new if given else points[row + field]
    change = now - before if given else 0.0
    arm_a, arm_b = wide_lanes.arms(points, row)
    return change, scale(change, arm_a), scale(change, arm_b)


def _give(lanes: int, constraints: Array, points: Array, scratch: Array) -> None:
    """
    Give the points of each lane that stirs their impulses, and its bodies what these do.

    points : all points of each lane
    """
    for lane in range(lanes):
        change = changes(lane, constraints, points, scratch)
        part_1 = part_of(lane, lane, change, constraints, points)
        part_2 = part_of(lane + WIDTH, lane, change, constraints, points)
        part_3 = part_of(lane + 2 * WIDTH, lane, change, constraints, points)
        part_4 = part_of(lane + 3 * WIDTH, lane, change, constraints, points)
        soonest = sooner(lane, part_1, (1.0, 1.0), points)
        soonest = sooner(lane + WIDTH, part_2, soonest, points)
        soonest = sooner(lane + 2 * WIDTH, part_3, soonest, points)
        soonest = sooner(lane + 3 * WIDTH, part_4, soonest, points)
        share = soonest[0] / soonest[1]
        share = _weigh(lane, share, (part_1[0], part_2[0], part_3[0], part_4[0]), scratch)
        one = give_to_point(lane, share, part_1, points)
        two = give_to_point(lane + WIDTH, share, part_2, points)
        three = give_to_point(lane + 2 * WIDTH, share, part_3, points)
        four = give_to_point(lane + 3 * WIDTH, share, part_4, points)
        wide_lanes.apply_along_normal(lane, (one, two, three, four), constraints, scratch)
        # where all points have taken part, and all of their change, nothing is left
        stirs_still = scratch[lane + lane_scratch.WHOLE_STIRS]
        weighs = scratch[lane + lane_scratch.WHOLE_WEIGHS]
        is_done = _all_take_part(lane, WIDTH, points) & (share >= 1.0)
        is_done = is_done & (weighs == ALIKE) & (stirs_still > 0.0)
        scratch[lane + lane_scratch.WHOLE_STIRS] = 0.0 if is_done else stirs_still
        scratch[lane + lane_scratch.WHOLE_WEIGHS] = DONE if is_done else weighs


def visit(
    kind: str, width: int, *, turns: bool, arcs: bool, layered: bool, on_rims: bool
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """
    Make the kernels of a pass: they sum up what takes part, and give it its impulses.

        kind    : solve, relax or restore
        width   : numbers of a point
        turns   : whether the inertia of anything turns with it
        arcs    : something turns but balls about their centres
        layered : something is a ball or a capsule
        on_rims : a cylinder may touch
    """
    offered = offered_for(kind, width, turns=turns, arcs=arcs, layered=layered, on_rims=on_rims)
    name = f'{kind}_{width}'
    for slot_name, source in {'changes': _changes, 'part_of': _part, 'sums_of': _sums_of}.items():
        offered[slot_name] = specialise(source, name=name, inlined=True, offered=offered)
    return (
        specialise(_sum_up, name=name, offered=offered),
        specialise(_give, name=name, offered=offered),
    )


def offered_for(
    kind: str, width: int, *, turns: bool, arcs: bool, layered: bool, on_rims: bool
) -> dict[str, Any]:
    """Return what the slots of such a pass are filled with, and the law of its points."""
    offered: dict[str, Any] = {
        'SOFT': kind == 'solve',
        'BOUNCING': kind == 'restore',
        'WIDTH': width,
        'TURNS': turns,
        'RIMS': on_rims,
        'BENDS': arcs,
        'LAYERED': layered,
    }
    for slot_name, source in {'law': _law, 'give_to_point': _give_to_point}.items():
        offered[slot_name] = specialise(
            source, name=f'{kind}_{width}', inlined=True, offered=offered
        )
    return offered
