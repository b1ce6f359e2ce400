# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The impact of two balls at its place and its instant, where neither can meet anybody else in the
tick.

The normal of two balls is their line of centres, and turns as they pass each other: one struck off
its middle by a thirtieth of a radius in a tick leaves by a thirtieth of a radian off its way. So
the line of centres of the instant is foreseen,

    |d + w t + a t^2/2| = R_A + R_B,   n = (d + w t + a t^2/2)/(R_A + R_B)

and kept for the tick, with the separation along it; the bounce comes after the last substep, by
that normal. Without one they keep their distance meanwhile. Two balls that move are then taken to
where they would be had each impulse come at that instant: by its lateness times what it has
changed of the velocity. So directions, and the angular momentum of the two, are those of the
impact there. And two balls that pass each other by are not touched: for the tick they have the
normal of where they are nearest.

d, w, a  : centre, velocity, acceleration of B less those of A; of what rests on something that
           which this does not hold, and that of its friction
R_A, R_B : [m] radii

Alone are two balls of which neither has another within h (|w'| + 2 |w| + 2 |w''|), w' the relative
velocity of the two, w'' the largest of that other with anybody: no impact changes a velocity by
more than twice the relative one. What cannot move may be that near if its normal is across n, as a
table is. Impacts of balls that may meet several others, or several things that cannot move, or
some of both, within h (|w'| + |omega| R + 2 |w''|): see `impact_sequence`.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints, Motion
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    impact_sequence,
    prepare,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.impact_sequence import (
    ACROSS,
    LEAST,
    instant,
    moves,
)
from rigid_body_sim.physics.contact.solver.separation import turned_frame
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    scale,
    store,
    subtract,
)

NONE, OTHERS = 0.0, -1.0  # in place of a rest of the tick; they meet, and may meet others too


@inline
def _velocity(body: int, arm: Any, bodies: Array) -> Any:
    """Velocity of a point of a body at an arm."""
    momentum = load(bodies, body + solver_bodies.MOMENTUM)
    spin = solver_bodies.spin(body, bodies)
    return add_scaled(cross(spin, arm), bodies[body + solver_bodies.INVERSE_MASS], momentum)


@inline
def _velocity_apart(body_a: int, body_b: int, bodies: Array) -> Any:
    """Velocity of the centre of B less that of A."""
    velocity_a = scale(
        bodies[body_a + solver_bodies.INVERSE_MASS], load(bodies, body_a + solver_bodies.MOMENTUM)
    )
    velocity_b = scale(
        bodies[body_b + solver_bodies.INVERSE_MASS], load(bodies, body_b + solver_bodies.MOMENTUM)
    )
    return subtract(velocity_b, velocity_a)


@inline
def _bodies(lane: int, rows: Array) -> Any:
    """Where the bodies of a lane begin."""
    return int(rows[lane + constraint.BODY_A]), int(rows[lane + constraint.BODY_B])


@inline
def _nearest(lane: int, points: int, width: int, rows: Array) -> float:
    """Return the least separation of the points of a lane [m]."""
    least = math.inf
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        least = min(least, rows[point + contact_point.INITIAL_SEPARATION])
    return least


@inline
def _speed(lane: int, points: int, width: int, rows: Array, bodies: Array) -> float:
    """Return the largest relative velocity of the points of a lane [m/s]."""
    body_a, body_b = _bodies(lane, rows)
    largest = 0.0
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        arm_a, arm_b = wide_lanes.arms(rows, point)
        velocity = subtract(_velocity(body_b, arm_b, bodies), _velocity(body_a, arm_a, bodies))
        largest = max(largest, dot(velocity, velocity))
    return math.sqrt(largest)


@inline
def _bears(lane: int, points: int, width: int, rows: Array) -> bool:
    """Tell whether a lane starts with a load, and not with what is left of one."""
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        light = impact_sequence.LIGHT * rows[point + contact_point.NORMAL_MASS]
        if rows[point + contact_point.NORMAL_IMPULSE] > light:
            return True
    return False


@inline
def _is_candidate(lane: int, ahead: float, rows: Array, bodies: Array) -> bool:
    """
    Tell whether a lane of one point is one of two balls that carry nothing yet, and come near
    enough to meet within the tick, or a substep behind it: where balls are not kept, they are
    slowed down that much before.
    """
    point = lane + constraint.SIZE
    if (
        rows[lane + constraint.ROUNDNESS] != constraint.TWO_BALLS
        or rows[point + contact_point.NORMAL_IMPULSE] > 0.0
    ):
        return False
    body_a, body_b = _bodies(lane, rows)
    velocity = _velocity_apart(body_a, body_b, bodies)
    pulls = subtract(
        load(bodies, body_b + solver_bodies.FREE_ACCELERATION),
        load(bodies, body_a + solver_bodies.FREE_ACCELERATION),
    )
    comes = add_scaled(velocity, 0.5 * ahead, pulls)
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    apart = rows[point + contact_point.INITIAL_SEPARATION]
    return bool(apart >= 0.0 and apart + ahead * dot(normal, comes) <= 0.0)


@inline
def _meets_fixed(lane: int, ahead: float, threshold: float, rows: Array, bodies: Array) -> bool:
    """
    Tell whether a ball that carries nothing meets what cannot move within the tick, and does not
    come to rest on it: that is left to the substeps.
    """
    if not impact_sequence.is_at_fixed(lane, rows, bodies):
        return False
    body_a, body_b = _bodies(lane, rows)
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    pulls = subtract(
        load(bodies, body_b + solver_bodies.FREE_ACCELERATION),
        load(bodies, body_a + solver_bodies.FREE_ACCELERATION),
    )
    speed = dot(normal, _velocity_apart(body_a, body_b, bodies))
    pull = dot(normal, pulls)
    if pull < 0.0 and not rows[lane + constraint.RESTITUTION] > 0.0:
        return False
    apart = rows[lane + constraint.SIZE + contact_point.INITIAL_SEPARATION]
    return bool(speed < -threshold and apart + ahead * (speed + 0.5 * ahead * pull) <= 0.0)


@inline
def _may_be_cornered(
    lane: int, ahead: float, threshold: float, rows: Array, bodies: Array
) -> bool:  # fmt: skip
    """Tell whether a ball meets what cannot move, and there are others that it may meet."""
    return bool(
        rows[lane + constraint.MANIFOLDS] > 1.0
        and _meets_fixed(lane, ahead, threshold, rows, bodies)
    )


@inline
def _comes_near(lane: int, ahead: float, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane of balls that carries nothing may touch, turned by another impact."""
    if not (
        impact_sequence.is_pair(lane, rows, bodies)
        or impact_sequence.is_at_fixed(lane, rows, bodies)
    ):
        return False
    body_a, body_b = _bodies(lane, rows)
    velocity = _velocity_apart(body_a, body_b, bodies)
    reach = math.sqrt(dot(velocity, velocity))
    for body, radius in ((body_a, constraint.RADIUS_A), (body_b, constraint.RADIUS_B)):
        spin = solver_bodies.spin(body, bodies)
        pull = load(bodies, body + solver_bodies.FREE_ACCELERATION)
        reach += rows[lane + radius] * math.sqrt(dot(spin, spin))
        reach += ahead * math.sqrt(dot(pull, pull))
        if moves(body, bodies):
            reach += 2.0 * bodies[body + solver_bodies.FASTEST]
    return bool(rows[lane + constraint.SIZE + contact_point.INITIAL_SEPARATION] <= ahead * reach)


@inline
def _count_near(lane: int, ahead: float, threshold: float, rows: Array, bodies: Array) -> None:
    """Count for balls whom and what they may touch by a lane, and tell whether they do touch."""
    if not _comes_near(lane, ahead, rows, bodies):
        return
    meets = rows[lane + constraint.WAITS] > 0.0
    meets = meets or _meets_fixed(lane, ahead, threshold, rows, bodies)
    for body in _bodies(lane, rows):
        if moves(body, bodies):
            bodies[body + solver_bodies.NEAR] += 1.0
            if meets:
                bodies[body + solver_bodies.MEETS] = 1.0


@inline
def _is_in_a_corner(lane: int, ahead: float, rows: Array, bodies: Array) -> bool:
    """Tell whether a ball meets several in the tick, of which that of the lane cannot move."""
    if not (
        impact_sequence.is_at_fixed(lane, rows, bodies) and _comes_near(lane, ahead, rows, bodies)
    ):
        return False
    for body in _bodies(lane, rows):
        if (
            moves(body, bodies)
            and bodies[body + solver_bodies.NEAR] > 1.0
            and bodies[body + solver_bodies.MEETS] > 0.0
        ):
            return True
    return False


@inline
def _goes_on_to_meet(lane: int, threshold: float, rows: Array, bodies: Array) -> bool:
    """
    Tell whether two balls carry nothing, overlap a little and come nearer: one was taken there
    after an impact of the tick before, in which it could not be known to come so far.
    """
    point = lane + constraint.SIZE
    apart = rows[point + contact_point.INITIAL_SEPARATION]
    if not (apart < 0.0 and impact_sequence.is_pair(lane, rows, bodies)):
        return False
    body_a, body_b = _bodies(lane, rows)
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    return bool(dot(normal, _velocity_apart(body_a, body_b, bodies)) < -threshold)


@inline
def _rub(lane: int, body: int, substep: float, rows: Array, bodies: Array) -> None:
    """Let what a body rests on hold it, and rub it as recalled, until it meets something."""
    pull = body + solver_bodies.PULL
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    point = lane + constraint.SIZE
    sign = 1.0 if body == int(rows[lane + constraint.BODY_B]) else -1.0
    pulled = load(bodies, pull)
    into = min(sign * dot(normal, pulled), 0.0)
    store(bodies, pull, add_scaled(pulled, -sign * into, normal))
    share = sign * bodies[body + solver_bodies.INVERSE_MASS] / substep
    along_1 = scale(share * rows[point + contact_point.TANGENT_IMPULSE_1], tangent_1)
    along_2 = scale(share * rows[point + contact_point.TANGENT_IMPULSE_2], tangent_2)
    store(bodies, pull, add(load(bodies, pull), add(along_1, along_2)))


@inline
def _note_speeds(
    lane: int, points: int, width: int, substep: float, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Note for the bodies of a lane how fast they meet somebody, and what they rest on."""
    speed, bears = _speed(lane, points, width, rows, bodies), _bears(lane, points, width, rows)
    for body in _bodies(lane, rows):
        if moves(body, bodies):
            fastest = body + solver_bodies.FASTEST
            bodies[fastest] = max(bodies[fastest], speed)
            if bears and points == 1:
                _rub(lane, body, substep, rows, bodies)


@inline
def _count_others(
    lane: int, points: int, width: int, h: float, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Count for bodies that meet somebody whom else they may meet by a lane."""
    body_a, body_b = _bodies(lane, rows)
    for body, other in ((body_a, body_b), (body_b, body_a)):
        if not bodies[body + solver_bodies.MEETINGS] > 0.0 or not moves(body, bodies):
            continue
        reach = _speed(lane, points, width, rows, bodies)
        reach += 2.0 * bodies[body + solver_bodies.PAIR_SPEED]
        if moves(other, bodies):
            reach += 2.0 * bodies[other + solver_bodies.FASTEST]
        else:
            normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
            along = load(bodies, body + solver_bodies.MEETS_ALONG)
            reach = -math.inf if abs(dot(normal, along)) < ACROSS else reach
        if _nearest(lane, points, width, rows) <= h * reach:
            bodies[body + solver_bodies.MEETINGS] += 1.0


@inline
def _acceleration(body: int, bodies: Array) -> Any:
    """Acceleration of a body until the impact; of what rests on something that of friction."""
    if not moves(body, bodies):
        return 0.0, 0.0, 0.0
    return load(bodies, body + solver_bodies.PULL)


@inline
def _foresee(lane: int, h: float, rows: Array, bodies: Array) -> Any:
    """
    Return of a lane of two balls whether they touch within the tick, when that is, or when they
    are nearest; line of centres and velocity there.
    """
    body_a, body_b = _bodies(lane, rows)
    arm_a, arm_b = wide_lanes.arms(rows, lane + constraint.SIZE)
    reach = rows[lane + constraint.RADIUS_A] + rows[lane + constraint.RADIUS_B]
    line, velocity = subtract(arm_a, arm_b), _velocity_apart(body_a, body_b, bodies)
    acceleration = subtract(_acceleration(body_b, bodies), _acceleration(body_a, bodies))
    time = instant(line, velocity, acceleration, reach)
    touches = 0.0 <= time <= h
    if not touches:
        speed = dot(velocity, velocity)
        nearest = -dot(line, velocity) / speed if speed > 0.0 else 0.0
        time = min(max(nearest, 0.0), h)
    way = add_scaled(line, time, add_scaled(velocity, 0.5 * time, acceleration))
    length = math.sqrt(dot(way, way))
    met = add_scaled(velocity, time, acceleration)
    return touches, time, scale(1.0 / (length if length > 0.0 else 1.0), way), met


@inline
def _note_meeting(
    lane: int, h: float, threshold: float, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Note for the bodies of a candidate along which line they meet, and how fast."""
    touches, time, normal, met = _foresee(lane, h, rows, bodies)
    if touches and not dot(normal, met) < -threshold:
        rows[lane + constraint.WAITS] = NONE
        return
    rows[lane + constraint.WAITS] = max(h - time, LEAST) if touches else LEAST
    for body in _bodies(lane, rows):
        if moves(body, bodies):
            bodies[body + solver_bodies.PAIR_SPEED] = math.sqrt(dot(met, met))
            store(bodies, body + solver_bodies.MEETS_ALONG, normal)
            bodies[body + solver_bodies.MEETINGS] += 1.0


@inline
def _part(
    lane: int, h: float, ahead: float, threshold: float, rows: Array, bodies: Array
) -> bool:  # fmt: skip
    """Note of a lane of balls whether they meet others; tell whether they and others meet."""
    if rows[lane + constraint.WAITS] > 0.0:
        for body in _bodies(lane, rows):
            # itself is counted too
            if moves(body, bodies) and bodies[body + solver_bodies.MEETINGS] != 2.0:
                touches, _, _, _ = _foresee(lane, h, rows, bodies)
                rows[lane + constraint.WAITS] = OTHERS if touches else NONE
    if _goes_on_to_meet(lane, threshold, rows, bodies):
        rows[lane + constraint.WAITS] = OTHERS
    if _is_in_a_corner(lane, ahead, rows, bodies):
        rows[lane + constraint.WAITS] = OTHERS
    return bool(rows[lane + constraint.WAITS] == OTHERS)


@inline
def _keep(lane: int, h: float, rows: Array, bodies: Array) -> bool:
    """Give a lane of two balls that meet alone the normal of their impact; tell whether it is."""
    point = lane + constraint.SIZE
    if not rows[lane + constraint.WAITS] > 0.0:
        return False
    touches, _, normal, met = _foresee(lane, h, rows, bodies)
    frame = turned_frame(wide_lanes.contact_frame(rows, lane), normal)
    wide_lanes.put_vector(rows, lane + constraint.NORMAL, frame[0])
    wide_lanes.put_vector(rows, lane + constraint.TANGENT_1, frame[1])
    wide_lanes.put_vector(rows, lane + constraint.TANGENT_2, frame[2])
    arm_a, arm_b = wide_lanes.arms(rows, point)
    radius_a, radius_b = rows[lane + constraint.RADIUS_A], rows[lane + constraint.RADIUS_B]
    apart = dot(normal, subtract(arm_a, arm_b)) - (radius_a + radius_b)
    rows[point + contact_point.SEPARATION] = apart
    wide_lanes.put_vector(rows, point + contact_point.ARM_A, scale(radius_a, normal))
    wide_lanes.put_vector(rows, point + contact_point.ARM_B, scale(-radius_b, normal))
    if touches and rows[lane + constraint.RESTITUTION] > 0.0:
        rows[point + contact_point.APPROACH_VELOCITY] = dot(normal, met)
    return True


@inline
def _any_candidate(
    ahead: float, threshold: float, batches: Indices, rows: Array, bodies: Array
) -> bool:  # fmt: skip
    """Tell whether there are two balls that come near enough to meet, or one in a corner."""
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] == batch_record.BALLS:
            begin = batches[batch + batch_record.BEGIN]
            for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
                if _is_candidate(lane, ahead, rows, bodies):
                    return True
                if _goes_on_to_meet(lane, threshold, rows, bodies):
                    return True
                if _may_be_cornered(lane, ahead, threshold, rows, bodies):
                    return True
    return False


@kernel
def foresee(
    lanes: int, width: int, h: float, substep: float, threshold: float, members: Indices,
    constraints: Constraints, bodies: Array,
) -> None:  # fmt: skip
    """
    Find the impacts of two balls of a group, and give them their normals for the tick; follow
    those of balls that meet several.

    lanes   : to go over, of each batch: see `iterations`
    width   : numbers of a point
    h, substep : [s] tick, and a part of it
    threshold : [m/s] who meets slower comes to rest on the other
    members : bodies of the group
    """
    batches, rows = constraints.batches, constraints.rows
    ahead, any_others = h + substep, False
    if not _any_candidate(ahead, threshold, batches, rows, bodies):
        return
    for index in range(len(members)):
        row = members[index] * solver_bodies.SIZE
        for entry in (
            solver_bodies.MEETINGS, solver_bodies.PAIR_SPEED, solver_bodies.FASTEST,
            solver_bodies.NEAR, solver_bodies.MEETS,
        ):  # fmt: skip
            bodies[row + entry] = 0.0
        store(
            bodies, row + solver_bodies.PULL, load(bodies, row + solver_bodies.FREE_ACCELERATION)
        )
    for stage in range(5):
        if stage == 4 and any_others:
            impact_sequence.follow(h, threshold, members, constraints, bodies)
        for batch in range(0, len(batches), batch_record.SIZE):
            begin = batches[batch + batch_record.BEGIN]
            points = batches[batch + batch_record.POINT_COUNT]
            of_balls = batches[batch + batch_record.KIND] == batch_record.BALLS
            any_kept = False
            for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
                if stage == 0:
                    _note_speeds(lane, points, width, substep, rows, bodies)
                elif stage == 2:
                    _count_others(lane, points, width, h, rows, bodies)
                    _count_near(lane, ahead, threshold, rows, bodies)
                elif of_balls and stage == 1 and _is_candidate(lane, ahead, rows, bodies):
                    _note_meeting(lane, h, threshold, rows, bodies)
                elif of_balls and stage == 3:
                    any_others = _part(lane, h, ahead, threshold, rows, bodies) or any_others
                elif of_balls and stage == 4:
                    any_kept = _keep(lane, h, rows, bodies) or any_kept
            if any_kept:
                first = begin + constraint.SIZE
                prepare.effective_masses(lanes, rows[begin:first], rows[first : first + width])
    if any_others:
        impact_sequence.keep_followed(h, batches, rows, bodies)
    for index in range(len(members)):
        row = members[index] * solver_bodies.SIZE
        store(bodies, row + solver_bodies.DISPLACEMENT, (0.0, 0.0, 0.0))
        store(bodies, row + solver_bodies.TURN, (0.0, 0.0, 0.0))
        bodies[row + solver_bodies.TURN_SCALAR] = 1.0


@inline
def _late(lane: int, substep: float, bounces: bool, rows: Array) -> Any:
    """Impulses on B of a lane, each times by how much it came too late [N s^2]."""
    if impact_sequence.is_given_at_the_end(lane, rows):
        return wide_lanes.vector(rows, lane + constraint.SIZE + impact_sequence.MISSED)
    normal, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    point = lane + constraint.SIZE
    waits = rows[lane + constraint.WAITS]
    # friction of the impact comes at the end of its substep
    late = waits - int(waits / substep) * substep
    rubs_1 = rows[point + contact_point.TANGENT_IMPULSE_1]
    rubs_2 = rows[point + contact_point.TANGENT_IMPULSE_2]
    rubs_1 += rows[point + contact_point.TOTAL_IMPULSE + LANES]
    rubs_2 += rows[point + contact_point.TOTAL_IMPULSE + 2 * LANES]
    along, across_1, across_2 = 0.0, late * rubs_1, late * rubs_2
    if bounces:
        along = waits * rows[point + contact_point.RESTITUTION_NORMAL]
        across_1 += waits * rows[point + contact_point.RESTITUTION_TANGENT_1]
        across_2 += waits * rows[point + contact_point.RESTITUTION_TANGENT_2]
    return wide_lanes.impulse_of(along, across_1, across_2, normal, tangent_1, tangent_2)


@inline
def _kept_out(
    body: int, way: Any, batch_count: int, width: int, batches: Indices, rows: Array
) -> Any:  # fmt: skip
    """Return of a way of a body what does not lead into others that it touches."""
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = _bodies(lane, rows)
            if rows[lane + constraint.WAITS] > 0.0 or (body != body_a and body != body_b):
                continue
            away = wide_lanes.vector(rows, lane + constraint.NORMAL)
            out = scale(1.0 if body == body_b else -1.0, away)
            room = math.inf
            first = lane + constraint.SIZE
            for point in range(first, first + points * width, width):
                room = min(room, rows[point + contact_point.SEPARATION])
            beyond = -dot(out, way) - max(room, 0.0)
            if beyond > 0.0:
                way = add_scaled(way, beyond, out)
    return way


@inline
def _catch_up(
    body: int, sign: float, late: Any, rubs: bool, batch_count: int, width: int, motion: Motion,
    batches: Indices, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Take a body to where it would be, had impulses come when they should; late: see `_late`.

    Friction may press it onto what it rests on, which holds it up as late: rubs.
    """
    way = scale(sign * bodies[body + solver_bodies.INVERSE_MASS], late)
    if rubs:
        way = _kept_out(body, way, batch_count, width, batches, rows)
    solver_bodies.shift(body // solver_bodies.SIZE, way, motion, bodies)


@kernel
def catch_up(
    batch_count: int, width: int, substep: float, bounces: bool, motion: Motion, batches: Indices,
    rows: Array, bodies: Array,
) -> bool:  # fmt: skip
    """
    Take balls that have met to where they would be, had they not waited for their bounce; tell
    whether there are any.

    width   : numbers of a point
    substep : [s]
    bounces : whether anything in the scene does
    """
    found = False
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not (rows[lane + constraint.WAITS] > 0.0 and rows[lane + constraint.TOUCHED] > 0.0):
                continue
            body_a, body_b = _bodies(lane, rows)
            at_end = impact_sequence.is_given_at_the_end(lane, rows)
            if at_end or (moves(body_a, bodies) and moves(body_b, bodies)):
                late = _late(lane, substep, bounces, rows)
                rubs = rows[lane + constraint.FRICTION] > 0.0
                for body, sign in ((body_a, -1.0), (body_b, 1.0)):
                    if moves(body, bodies):
                        _catch_up(
                            body, sign, late, rubs, batch_count, width, motion, batches, rows,
                            bodies,
                        )  # fmt: skip
                found = True
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if found and impact_sequence.is_given_at_the_end(lane, rows):
                impact_sequence.measure(lane, rows, bodies)
    return found
