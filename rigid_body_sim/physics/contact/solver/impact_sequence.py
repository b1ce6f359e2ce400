# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts of balls that meet several in one tick, in the order in which they come.

Where two balls meet that may meet others in the same tick (`ball_impacts`), what they give each
other depends on who comes first: the first of two balls in a row stops and the last one leaves,
while both at once would throw the first one back. So does what walls give a ball that meets two of
them: the first one turns it, and its friction too, to the other or away from it. So the impacts of
such a *cluster* are followed from one to the next before anything moves, on parabolas,

    x = x_0 + P + V t + a t^2/2,   V <- V + dv,   P <- P - dv t   by an impact at t

each by Newton's law, and then Coulomb's. The balls then pass the tick as if they did not know of
each other, and are given all impulses at its end, with the way that they have missed. What comes
nearer at the same instant, as two balls that a third one strikes between, comes in a *round*: all
normals at once, and then all friction,

    v_n' = -e v_n or J_n = 0;   J_t = -v_t/lambda, at most mu J_n
        J_n <- J_n + (-e v_n - v_n')/(k_A/m_A + k_B/m_B)   until nothing changes (Jacobi)

k: impacts of the round that a body has part in, each with a share 1/k of its mass, in lambda too.
So a symmetry stays, momentum too, elastic impacts keep their energy, and friction takes some: a
body of which each share had its own impulse has more energy than one with their mean. Balls that
touch come one round later, as in Newton's cradle.

A cluster are balls that move, joined by pairs without a load; what cannot move is a part of it
where a ball meets it and something else in the tick, as the plane of their contact (a ball as it
is). It is left to the substeps where one has anything else near, unless the normal of that is
across to all pairs of it, as a table is; where a ball comes to rest on what cannot move, for loads
are theirs; where there are more than MOST pairs; and where there is no end of it.

x_0, a : of the centre at the start of the tick; acceleration without impacts, see `ball_impacts`
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
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

NEWTON = 4  # steps to an instant, from that without acceleration
ACROSS = 1e-4  # [-] cosine of two normals
LEAST = 1e-12  # [s] rest of the tick: what meets at its end is kept too
TIE = 1e-10  # [s] what comes within it comes at once
SLOW = 1e-6  # [m/s] what comes nearer slower does not meet; less takes more rounds
MANY, ROUNDS = 20.0, 200.0  # [-] of a pair, from which more is too slow; at most
MOST = 100.0  # [-] pairs of a cluster: more cost too much time
OPEN = 0.1  # [-] of the radii: less overlap is what is left of impacts, and ends in them
LIGHT = 1e-4  # [m/s] that a load gives in a substep: less is none

FOLLOWED = -2.0  # in place of a rest of the tick
# of a lane, while impacts are followed
COUNT, NO_MEMBER = constraint.BOUNCES, -1.0  # rounds that it had part in
NORMAL, IMPULSE = contact_point.BEGUN_BEFORE, contact_point.BEGUN  # n of the first, sum of J on B
LATE, TWIST = contact_point.TOTAL_IMPULSE, contact_point.WARM_NORMAL  # sums of t J, n x J
OF_ROUND = contact_point.NORMAL_IMPULSE  # J_n of this round, v_n to come, 1; then J_t
CHANGE = constraint.UNSETTLED  # of J_n, then J_n
# stages of a round
BEGIN, FIND_PRESS, PRESS, FIND_FRICTION, RUB = range(5)
VISITS, SETTLED = 300, 1e-14  # [-] of the pairs of a round, at most; [m/s] what may still change
# until the tick ends, in place of arms: sums of (h - t) J, and n x J
MISSED, TURNS = contact_point.ARM_A, contact_point.ARM_B
# of a body
VELOCITY = solver_bodies.MOMENTUM_BEFORE_RESTITUTION
SPIN = solver_bodies.ANGULAR_MOMENTUM_BEFORE_RESTITUTION
BEGINS = solver_bodies.SUBSTEP_POSITION  # P
LIES_ON = solver_bodies.DISPLACEMENT  # normal of what it rests on or is near to
LABEL, LAST, TIES = LIES_ON, LIES_ON + 1, LIES_ON + 2  # then: cluster, instant, impacts of a round
HAS_NORMAL, STATE = solver_bodies.TURN, solver_bodies.TURN + 1
PAIRS = HAS_NORMAL  # of the cluster that has the label of this body
HOT = solver_bodies.TURN + 2  # 1: a cluster in which balls meet that may meet others
FREE, LEFT = 0.0, 1.0  # states


@inline
def moves(body: int, bodies: Array) -> bool:
    """Tell whether impulses move a body: what hangs on a pivot through its centre counts not."""
    return bodies[body + solver_bodies.INVERSE_MASS] > solver_bodies.HELD


@inline
def _bodies(lane: int, rows: Array) -> Any:
    """Where the bodies of a lane begin."""
    return int(rows[lane + constraint.BODY_A]), int(rows[lane + constraint.BODY_B])


@inline
def _balls(lane: int, rows: Array, bodies: Array) -> Any:
    """Where the balls of a lane begin that move: of one that meets what cannot, twice its own."""
    body_a, body_b = _bodies(lane, rows)
    return (
        body_a if moves(body_a, bodies) else body_b,
        body_b if moves(body_b, bodies) else body_a,
    )


@inline
def _reach(lane: int, rows: Array, bodies: Array) -> float:
    """Length of the line of a lane where it touches [m]: of centres, or onto what cannot move."""
    body_a, _ = _bodies(lane, rows)
    radius_a, radius_b = rows[lane + constraint.RADIUS_A], rows[lane + constraint.RADIUS_B]
    if rows[lane + constraint.ROUNDNESS] == constraint.TWO_BALLS:
        return radius_a + radius_b
    return radius_a if moves(body_a, bodies) else radius_b


@inline
def _is_light(lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane of balls carries nothing, and overlaps by little."""
    point = lane + constraint.SIZE
    light = LIGHT * rows[point + contact_point.NORMAL_MASS]
    apart = rows[point + contact_point.INITIAL_SEPARATION]
    return bool(
        rows[point + contact_point.NORMAL_IMPULSE] < light
        and apart >= -OPEN * _reach(lane, rows, bodies)
    )


@inline
def is_pair(lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane of balls is one of two that move, are apart and carry nothing."""
    body_a, body_b = _bodies(lane, rows)
    return bool(
        rows[lane + constraint.ROUNDNESS] == constraint.TWO_BALLS
        and _is_light(lane, rows, bodies)
        and moves(body_a, bodies)
        and moves(body_b, bodies)
    )


@inline
def is_at_fixed(lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane is one of a ball and what cannot move, and carries nothing."""
    mass_a = bodies[int(rows[lane + constraint.BODY_A]) + solver_bodies.INVERSE_MASS]
    mass_b = bodies[int(rows[lane + constraint.BODY_B]) + solver_bodies.INVERSE_MASS]
    return bool(
        rows[lane + constraint.ROUNDNESS] >= constraint.BALL_ON_FIXED
        and (mass_a == 0.0 or mass_b == 0.0)
        and mass_a + mass_b > solver_bodies.HELD
        and _is_light(lane, rows, bodies)
    )


@inline
def is_met_in_a_corner(lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane is one of a ball that meets several that cannot move in the tick."""
    return bool(rows[lane + constraint.WAITS] < 0.0 and is_at_fixed(lane, rows, bodies))


@inline
def _state(lane: int, rows: Array, bodies: Array) -> Any:
    """Return the state of a lane: the larger one of its bodies."""
    body_a, body_b = _balls(lane, rows, bodies)
    return max(bodies[body_a + STATE], bodies[body_b + STATE])


@inline
def _leave(lane: int, rows: Array, bodies: Array) -> None:
    """Leave the bodies of a lane to the substeps."""
    body_a, body_b = _balls(lane, rows, bodies)
    bodies[body_a + STATE] = LEFT
    bodies[body_b + STATE] = LEFT


@inline
def _note_normal(lane: int, rows: Array, bodies: Array) -> None:
    """Note for the bodies of a lane that is no member what is near to them: one normal at most."""
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    for body in _bodies(lane, rows):
        if not moves(body, bodies):
            continue
        if bodies[body + HAS_NORMAL] > 0.0:
            along = dot(normal, load(bodies, body + LIES_ON))
            if 1.0 - abs(along) > ACROSS * ACROSS:
                bodies[body + STATE] = LEFT
        bodies[body + HAS_NORMAL] = 1.0
        store(bodies, body + LIES_ON, normal)


@inline
def _check_across(lane: int, rows: Array, bodies: Array) -> None:
    """Leave a pair that is not across to what its balls lie on to the substeps."""
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    for body in _bodies(lane, rows):
        beside = load(bodies, body + LIES_ON)
        if bodies[body + HAS_NORMAL] > 0.0 and not abs(dot(normal, beside)) < ACROSS:
            _leave(lane, rows, bodies)


@inline
def _begin(body: int, bodies: Array) -> None:
    """Let a ball start on its way."""
    momentum = load(bodies, body + solver_bodies.MOMENTUM)
    velocity = scale(bodies[body + solver_bodies.INVERSE_MASS], momentum)
    store(bodies, body + VELOCITY, velocity)
    store(bodies, body + SPIN, solver_bodies.spin(body, bodies))
    store(bodies, body + BEGINS, (0.0, 0.0, 0.0))
    bodies[body + LABEL] = float(body)
    bodies[body + LAST] = 0.0
    bodies[body + TIES] = 0.0
    bodies[body + PAIRS] = 0.0


@kernel
def _choose_members(members: Indices, constraints: Constraints, bodies: Array) -> None:
    """Find the pairs whose impacts are followed, and let their balls start."""
    batches, rows = constraints.batches, constraints.rows
    for index in range(len(members)):
        row = members[index] * solver_bodies.SIZE
        for entry in (HAS_NORMAL, STATE, HOT):
            bodies[row + entry] = 0.0
    for stage in range(4):
        for batch in range(0, len(batches), batch_record.SIZE):
            begin = batches[batch + batch_record.BEGIN]
            of_balls = batches[batch + batch_record.KIND] == batch_record.BALLS
            for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
                body_a, body_b = _balls(lane, rows, bodies)
                if stage == 0:
                    is_member = of_balls and (
                        is_pair(lane, rows, bodies) or is_met_in_a_corner(lane, rows, bodies)
                    )
                    rows[lane + COUNT] = 0.0 if is_member else NO_MEMBER
                    if not is_member:
                        _note_normal(lane, rows, bodies)
                elif of_balls and not rows[lane + COUNT] < 0.0:
                    if stage == 1:
                        _check_across(lane, rows, bodies)
                    elif stage == 2:
                        _begin(body_a, bodies)
                        _begin(body_b, bodies)
                    elif rows[lane + constraint.WAITS] < 0.0:
                        bodies[body_a + HOT] = 1.0
                        bodies[body_b + HOT] = 1.0


@inline
def _is_followed(lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether the impacts of a lane of balls are followed."""
    if rows[lane + COUNT] < 0.0:
        return False
    body_a, _ = _balls(lane, rows, bodies)
    return bool(
        _state(lane, rows, bodies) == FREE
        and bodies[body_a + HOT] > 0.0
        and bodies[int(bodies[body_a + LABEL]) + PAIRS] <= MOST
    )


@inline
def _clear(lane: int, rows: Array) -> None:
    """Let a pair begin its sums."""
    point = lane + constraint.SIZE
    for sums in (IMPULSE, LATE, TWIST, OF_ROUND):
        wide_lanes.put_vector(rows, point + sums, (0.0, 0.0, 0.0))
    rows[lane + CHANGE] = 0.0


@kernel
def _begin_clusters(batches: Indices, rows: Array, bodies: Array) -> None:
    """Count the pairs of each cluster; let those begin their sums whose impacts are followed."""
    for stage in range(2):
        for batch in range(0, len(batches), batch_record.SIZE):
            if batches[batch + batch_record.KIND] != batch_record.BALLS:
                continue
            begin = batches[batch + batch_record.BEGIN]
            for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
                if stage == 1 and _is_followed(lane, rows, bodies):
                    _clear(lane, rows)
                elif stage == 0 and not rows[lane + COUNT] < 0.0:
                    body_a, _ = _balls(lane, rows, bodies)
                    bodies[int(bodies[body_a + LABEL]) + PAIRS] += 1.0


@kernel
def _join_clusters(batches: Indices, rows: Array, bodies: Array) -> None:
    """Let the balls of a cluster have one label, one state, and be hot if one is."""
    goes_on = True
    while goes_on:
        goes_on = False
        for batch in range(0, len(batches), batch_record.SIZE):
            if batches[batch + batch_record.KIND] != batch_record.BALLS:
                continue
            begin = batches[batch + batch_record.BEGIN]
            for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
                if rows[lane + COUNT] < 0.0:
                    continue
                body_a, body_b = _balls(lane, rows, bodies)
                for entry in (LABEL, STATE, HOT):
                    of_a, of_b = bodies[body_a + entry], bodies[body_b + entry]
                    if of_a != of_b:
                        bodies[body_a + entry] = bodies[body_b + entry] = max(of_a, of_b)
                        goes_on = True


@inline
def _acceleration(body: int, bodies: Array) -> Any:
    return load(bodies, body + solver_bodies.PULL)


@inline
def instant(line: Any, velocity: Any, acceleration: Any, reach: float) -> float:
    """Time until two balls touch [s], NaN: they miss each other; line: d, reach: R_A + R_B."""
    ahead, speed = dot(line, velocity), dot(velocity, velocity)
    room = ahead * ahead - speed * (dot(line, line) - reach * reach)
    if not (ahead < 0.0 and room >= 0.0):
        return math.nan
    time = (dot(line, line) - reach * reach) / (math.sqrt(room) - ahead)
    for _ in range(NEWTON):
        rate = add_scaled(velocity, time, acceleration)
        way = add_scaled(line, time, add_scaled(velocity, 0.5 * time, acceleration))
        slope = 2.0 * dot(way, rate)
        if not slope < 0.0:
            return math.nan
        time -= (dot(way, way) - reach * reach) / slope
    return time


@inline
def _line_and_velocity(lane: int, time: float, rows: Array, bodies: Array) -> Any:
    """
    Return the line of a lane at a time [s], of centres, or from a ball onto the plane of what
    cannot move; then velocity and acceleration of B less those of A.
    """
    body_a, body_b = _bodies(lane, rows)
    arm_a, arm_b = wide_lanes.arms(rows, lane + constraint.SIZE)
    acceleration = subtract(_acceleration(body_b, bodies), _acceleration(body_a, bodies))
    velocity = subtract(load(bodies, body_b + VELOCITY), load(bodies, body_a + VELOCITY))
    begins = subtract(load(bodies, body_b + BEGINS), load(bodies, body_a + BEGINS))
    way = add(begins, scale(time, add_scaled(velocity, 0.5 * time, acceleration)))
    line = add(subtract(arm_a, arm_b), way)
    if rows[lane + constraint.ROUNDNESS] != constraint.TWO_BALLS:
        normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
        apart = rows[lane + constraint.SIZE + contact_point.INITIAL_SEPARATION]
        apart += dot(normal, way)
        line = scale(_reach(lane, rows, bodies) + apart, normal)
    return line, add_scaled(velocity, time, acceleration), acceleration


@inline
def _along(lane: int, vector: Any, rows: Array) -> Any:
    """Return of a vector what changes the length of the line of a lane: of a plane, along it."""
    if rows[lane + constraint.ROUNDNESS] == constraint.TWO_BALLS:
        return vector
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    return scale(dot(normal, vector), normal)


@inline
def _next_time(lane: int, h: float, rows: Array, bodies: Array) -> float:
    """When a pair meets next within the tick [s], else infinity."""
    body_a, body_b = _balls(lane, rows, bodies)
    since = max(bodies[body_a + LAST], bodies[body_b + LAST])
    line, velocity, acceleration = _line_and_velocity(lane, since, rows, bodies)
    reach = _reach(lane, rows, bodies)
    time = instant(line, _along(lane, velocity, rows), _along(lane, acceleration, rows), reach)
    if not since + time <= h:
        return math.inf
    time = since + max(time, 0.0)
    line, velocity, _ = _line_and_velocity(lane, time, rows, bodies)
    return time if dot(line, velocity) < -_slow(lane, rows) * reach else math.inf


@inline
def _slow(lane: int, rows: Array) -> float:
    """Speed [m/s] below which what comes nearer does not meet: the more impacts, the faster."""
    rounds = rows[lane + COUNT] / MANY
    return SLOW * (1.0 + rounds * rounds * rounds * rounds)


@inline
def _comes_to_rest(lane: int, h: float, rows: Array, bodies: Array) -> bool:
    """Tell whether a ball ends the tick in what cannot move: it comes too slow to meet it."""
    line, _, _ = _line_and_velocity(lane, h, rows, bodies)
    into = _reach(lane, rows, bodies) - math.sqrt(dot(line, line))
    return bool(is_at_fixed(lane, rows, bodies) and into > _slow(lane, rows) * h)


@kernel
def _find_next(h: float, batches: Indices, rows: Array, bodies: Array) -> Any:
    """Return when the next impact comes, and a ball of it."""
    first, ball = math.inf, 0
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if _is_followed(lane, rows, bodies):
                time = _next_time(lane, h, rows, bodies)
                if time < first:
                    first = time
                    ball, _ = _balls(lane, rows, bodies)
    return first, ball


@inline
def _normal(lane: int, time: float, rows: Array, bodies: Array) -> Any:
    """Normal of a pair at a time [s], its line of centres, and velocity of B less that of A."""
    line, velocity, _ = _line_and_velocity(lane, time, rows, bodies)
    return scale(1.0 / math.sqrt(dot(line, line)), line), line, velocity


@inline
def _begin_round(lane: int, time: float, threshold: float, rows: Array, bodies: Array) -> None:
    """Let a pair have part in a round."""
    for body in _bodies(lane, rows):
        bodies[body + TIES] += 1.0 if moves(body, bodies) else 0.0
    normal, _, velocity = _normal(lane, time, rows, bodies)
    point = lane + constraint.SIZE
    if rows[lane + COUNT] == 0.0:
        wide_lanes.put_vector(rows, point + NORMAL, normal)
    elif rows[lane + COUNT] >= ROUNDS:
        _leave(lane, rows, bodies)
    rows[lane + COUNT] += 1.0
    speed = dot(normal, velocity)
    share = rows[lane + constraint.RESTITUTION] if speed < -threshold else 0.0
    wide_lanes.put_vector(rows, point + OF_ROUND, (0.0, -share * speed, 1.0))


@inline
def _yields(lane: int, rows: Array, bodies: Array) -> Any:
    """Velocity that an impulse gives a pair with its shares of the masses [1/kg]."""
    body_a, body_b = _bodies(lane, rows)
    of_a = bodies[body_a + TIES] * bodies[body_a + solver_bodies.INVERSE_MASS]
    return of_a + bodies[body_b + TIES] * bodies[body_b + solver_bodies.INVERSE_MASS]


@inline
def _find_press(lane: int, time: float, rows: Array, bodies: Array) -> float:
    """
    Find by how much the impulse of a pair along its normal changes; return what is left of the
    velocity that it is to have.
    """
    point = lane + constraint.SIZE
    normal, _, velocity = _normal(lane, time, rows, bodies)
    old, target = rows[point + OF_ROUND], rows[point + OF_ROUND + LANES]
    wants = target - dot(normal, velocity)
    new = max(old + wants / _yields(lane, rows, bodies), 0.0)
    rows[lane + CHANGE] = new - old
    return abs(new - old) * _yields(lane, rows, bodies)


@inline
def _press(lane: int, time: float, rows: Array, bodies: Array) -> None:
    """Let a pair have what its impulse along its normal has changed by."""
    body_a, body_b = _bodies(lane, rows)
    normal, _, _ = _normal(lane, time, rows, bodies)
    impulse = scale(rows[lane + CHANGE], normal)
    rows[lane + constraint.SIZE + OF_ROUND] += rows[lane + CHANGE]
    _give(body_a, -1.0, time, impulse, bodies)
    _give(body_b, 1.0, time, impulse, bodies)


@inline
def _find_friction(lane: int, time: float, rows: Array, bodies: Array) -> None:
    """Find the friction of a pair, with its shares of the masses."""
    body_a, body_b = _bodies(lane, rows)
    point = lane + constraint.SIZE
    normal, line, velocity = _normal(lane, time, rows, bodies)
    reach = _reach(lane, rows, bodies)
    arm_a = scale(rows[lane + constraint.RADIUS_A] / reach, line)
    arm_b = scale(-rows[lane + constraint.RADIUS_B] / reach, line)
    turns_a = cross(load(bodies, body_a + SPIN), arm_a)
    turns_b = cross(load(bodies, body_b + SPIN), arm_b)
    velocity = add(velocity, subtract(turns_b, turns_a))
    slip = add_scaled(velocity, -dot(normal, velocity), normal)
    turn_a = bodies[body_a + TIES] * bodies[body_a + solver_bodies.INVERSE_INERTIA]
    turn_b = bodies[body_b + TIES] * bodies[body_b + solver_bodies.INVERSE_INERTIA]
    yields = _yields(lane, rows, bodies)
    rub = 1.0 / (yields + turn_a * dot(arm_a, arm_a) + turn_b * dot(arm_b, arm_b))
    press = rows[point + OF_ROUND]
    size, most = rub * math.sqrt(dot(slip, slip)), rows[lane + constraint.FRICTION] * press
    rub *= most / size if size > most else 1.0
    rows[lane + CHANGE] = press
    wide_lanes.put_vector(rows, point + OF_ROUND, scale(-rub, slip))


@inline
def _turn(body: int, radius: float, twist: Any, bodies: Array) -> None:
    """Let n x J change the spin of a ball."""
    share = radius * bodies[body + solver_bodies.INVERSE_INERTIA]
    store(bodies, body + SPIN, add_scaled(load(bodies, body + SPIN), share, twist))


@inline
def _give(body: int, sign: float, time: float, impulse: Any, bodies: Array) -> None:
    """Let an impulse change the way of a ball."""
    change = scale(sign * bodies[body + solver_bodies.INVERSE_MASS], impulse)
    store(bodies, body + VELOCITY, add(load(bodies, body + VELOCITY), change))
    store(bodies, body + BEGINS, add_scaled(load(bodies, body + BEGINS), -time, change))


@inline
def _rub(lane: int, time: float, rows: Array, bodies: Array) -> None:
    """Let a pair have its friction of a round at a time [s], and sum up what it was given."""
    body_a, body_b = _bodies(lane, rows)
    point = lane + constraint.SIZE
    normal, line, _ = _normal(lane, time, rows, bodies)
    friction = wide_lanes.vector(rows, point + OF_ROUND)
    impulse = add_scaled(friction, rows[lane + CHANGE], normal)
    reach = _reach(lane, rows, bodies)
    twist = scale(1.0 / reach, cross(line, friction))
    wide_lanes.add_to_vector(rows, point + IMPULSE, 1.0, impulse)
    wide_lanes.add_to_vector(rows, point + LATE, time, impulse)
    wide_lanes.add_to_vector(rows, point + TWIST, 1.0, twist)
    _give(body_a, -1.0, time, friction, bodies)
    _give(body_b, 1.0, time, friction, bodies)
    _turn(body_a, -rows[lane + constraint.RADIUS_A], twist, bodies)
    _turn(body_b, -rows[lane + constraint.RADIUS_B], twist, bodies)
    for body in _balls(lane, rows, bodies):
        bodies[body + LAST] = time
        bodies[body + TIES] = 0.0
    wide_lanes.put_vector(rows, point + OF_ROUND, (0.0, 0.0, 0.0))
    rows[lane + CHANGE] = 0.0


@inline
def _is_of(label: float, lane: int, rows: Array, bodies: Array) -> bool:
    """Tell whether a lane of balls is a pair of a cluster."""
    body_a, _ = _balls(lane, rows, bodies)
    return bool(not rows[lane + COUNT] < 0.0 and bodies[body_a + LABEL] == label)


@kernel
def _visit(
    stage: int, time: float, label: float, h: float, threshold: float, batches: Indices,
    rows: Array, bodies: Array,
) -> float:  # fmt: skip
    """
    Do a stage of a round for all pairs of a cluster; return the largest change of a velocity [m/s]
    where normals are pressed.
    """
    largest = 0.0
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not _is_of(label, lane, rows, bodies):
                continue
            if stage == BEGIN:
                if _next_time(lane, h, rows, bodies) <= time + TIE:
                    _begin_round(lane, time, threshold, rows, bodies)
                continue
            point = lane + constraint.SIZE
            is_rubbed = stage == RUB and rows[lane + CHANGE] > 0.0
            if not (rows[point + OF_ROUND + 2 * LANES] == 1.0 or is_rubbed):
                continue
            if stage == FIND_PRESS:
                largest = max(largest, _find_press(lane, time, rows, bodies))
            elif stage == PRESS:
                _press(lane, time, rows, bodies)
            elif stage == FIND_FRICTION:
                _find_friction(lane, time, rows, bodies)
            else:
                _rub(lane, time, rows, bodies)
    return largest


@kernel
def _pass_round(
    time: float, label: float, h: float, threshold: float, batches: Indices, rows: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """Let all impacts of a cluster happen that come at a time [s]."""
    _visit(BEGIN, time, label, h, threshold, batches, rows, bodies)
    for _ in range(VISITS):
        change = _visit(FIND_PRESS, time, label, h, threshold, batches, rows, bodies)
        _visit(PRESS, time, label, h, threshold, batches, rows, bodies)
        if change < SETTLED:
            break
    _visit(FIND_FRICTION, time, label, h, threshold, batches, rows, bodies)
    _visit(RUB, time, label, h, threshold, batches, rows, bodies)


@kernel
def _leave_what_comes_to_rest(h: float, batches: Indices, rows: Array, bodies: Array) -> None:
    """Leave clusters to the substeps in which a ball comes to rest on what cannot move."""
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if _is_followed(lane, rows, bodies) and _comes_to_rest(lane, h, rows, bodies):
                _leave(lane, rows, bodies)


@inline
def _keep(lane: int, h: float, rows: Array, bodies: Array) -> None:
    """Let a pair have its impulses at the end of the tick and nothing else within it."""
    point = lane + constraint.SIZE
    rows[point + contact_point.NORMAL_MASS] = 0.0
    rows[point + contact_point.TANGENT_MASS] = 0.0
    rows[lane + constraint.WAITS] = LEAST
    if not rows[lane + COUNT] > 0.0:
        return
    impulse = wide_lanes.vector(rows, point + IMPULSE)
    late, twist = wide_lanes.vector(rows, point + LATE), wide_lanes.vector(rows, point + TWIST)
    normal = wide_lanes.vector(rows, point + NORMAL)
    frame = turned_frame(wide_lanes.contact_frame(rows, lane), normal)
    wide_lanes.put_vector(rows, lane + constraint.NORMAL, frame[0])
    wide_lanes.put_vector(rows, lane + constraint.TANGENT_1, frame[1])
    wide_lanes.put_vector(rows, lane + constraint.TANGENT_2, frame[2])
    press = dot(frame[0], impulse)
    along = (press, dot(frame[1], impulse), dot(frame[2], impulse))
    wide_lanes.put_vector(rows, point + contact_point.TOTAL_IMPULSE, along)
    wide_lanes.put_vector(rows, point + TWIST, (0.0, 0.0, 0.0))
    wide_lanes.put_vector(rows, point + MISSED, add_scaled(scale(h, impulse), -1.0, late))
    wide_lanes.put_vector(rows, point + TURNS, twist)
    rows[lane + constraint.TOUCHED] = 1.0
    rows[point + contact_point.LARGEST_NORMAL_IMPULSE] = press
    if rows[lane + constraint.RESTITUTION] > 0.0:  # what else they touch takes part in a bounce
        body_a, body_b = _bodies(lane, rows)
        inverse_mass = bodies[body_a + solver_bodies.INVERSE_MASS]
        inverse_mass += bodies[body_b + solver_bodies.INVERSE_MASS]
        rows[point + contact_point.APPROACH_VELOCITY] = -press * inverse_mass


@kernel
def follow(
    h: float, threshold: float, members: Indices, constraints: Constraints, bodies: Array
) -> None:
    """
    Follow the impacts of the clusters of a group through the tick, before other pairs are kept.

    h         : [s] tick
    threshold : [m/s] slower impacts do not bounce
    members   : bodies of the group
    """
    batches, rows = constraints.batches, constraints.rows
    _choose_members(members, constraints, bodies)
    _join_clusters(batches, rows, bodies)
    _begin_clusters(batches, rows, bodies)
    time, ball = _find_next(h, batches, rows, bodies)
    while time <= h:
        _pass_round(time, bodies[ball + LABEL], h, threshold, batches, rows, bodies)
        time, ball = _find_next(h, batches, rows, bodies)
    _leave_what_comes_to_rest(h, batches, rows, bodies)
    _join_clusters(batches, rows, bodies)
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if _is_followed(lane, rows, bodies):
                rows[lane + constraint.WAITS] = FOLLOWED
                continue
            rows[lane + constraint.WAITS] = max(rows[lane + constraint.WAITS], 0.0)
            if rows[lane + COUNT] > 0.0:
                _clear(lane, rows)


@kernel
def keep_followed(h: float, batches: Indices, rows: Array, bodies: Array) -> None:
    """Let pairs whose impacts were followed have what came of it."""
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if rows[lane + constraint.WAITS] == FOLLOWED:
                _keep(lane, h, rows, bodies)
            rows[lane + COUNT] = 0.0


@inline
def is_given_at_the_end(lane: int, rows: Array) -> bool:
    """Tell whether a lane is one of a cluster whose impacts are followed."""
    point = lane + constraint.SIZE
    return bool(
        rows[lane + constraint.WAITS] > 0.0 and rows[point + contact_point.NORMAL_MASS] == 0.0
    )


@kernel
def give(batch_count: int, batches: Indices, rows: Array, bodies: Array) -> bool:
    """Give balls the impulses of their impacts of the tick; tell whether there are any."""
    found = False
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not (is_given_at_the_end(lane, rows) and rows[lane + constraint.TOUCHED] > 0.0):
                continue
            normal, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
            point = lane + constraint.SIZE
            given = wide_lanes.vector(rows, point + contact_point.TOTAL_IMPULSE)
            impulse = wide_lanes.impulse_of(
                given[0], given[1], given[2], normal, tangent_1, tangent_2
            )
            twist = wide_lanes.vector(rows, point + TURNS)
            body_a, body_b = _bodies(lane, rows)
            radius_a, radius_b = rows[lane + constraint.RADIUS_A], rows[lane + constraint.RADIUS_B]
            for body, radius, sign in ((body_a, radius_a, -1.0), (body_b, radius_b, 1.0)):
                if not moves(body, bodies):
                    continue
                momentum = body + solver_bodies.MOMENTUM
                turn = body + solver_bodies.ANGULAR_MOMENTUM
                store(bodies, momentum, add_scaled(load(bodies, momentum), sign, impulse))
                store(bodies, turn, add_scaled(load(bodies, turn), -radius, twist))
            found = True
    return found


@inline
def _position(body: int, bodies: Array) -> Any:
    """Centre of a ball after the last substep."""
    place = load(bodies, body + solver_bodies.SUBSTEP_POSITION)
    moved = add(
        load(bodies, body + solver_bodies.SUBSTEP_RESIDUAL),
        load(bodies, body + solver_bodies.DISPLACEMENT),
    )
    return place, moved


@inline
def _line_at_start(body_a: int, body_b: int, bodies: Array) -> Any:
    """Centre of B less that of A at the start of the tick; of what cannot move, zero."""
    place_a = load(bodies, body_a + solver_bodies.START_POSITION)
    place_b = load(bodies, body_b + solver_bodies.START_POSITION)
    moved_a = load(bodies, body_a + solver_bodies.START_RESIDUAL)
    moved_b = load(bodies, body_b + solver_bodies.START_RESIDUAL)
    return add(subtract(place_b, place_a), subtract(moved_b, moved_a))


@inline
def measure(lane: int, rows: Array, bodies: Array) -> None:
    """
    Find how far apart the balls of a lane are that have been taken to where they belong, and their
    arms.
    """
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    arm_a = scale(rows[lane + constraint.RADIUS_A], normal)
    arm_b = scale(-rows[lane + constraint.RADIUS_B], normal)
    wide_lanes.put_vector(rows, lane + constraint.SIZE + contact_point.ARM_A, arm_a)
    wide_lanes.put_vector(rows, lane + constraint.SIZE + contact_point.ARM_B, arm_b)
    body_a, body_b = _bodies(lane, rows)
    place_a, moved_a = _position(body_a, bodies)
    place_b, moved_b = _position(body_b, bodies)
    line = add(subtract(place_b, place_a), subtract(moved_b, moved_a))
    if moves(body_a, bodies) and moves(body_b, bodies):
        separation = math.sqrt(dot(line, line)) - _reach(lane, rows, bodies)
    else:
        separation = rows[lane + constraint.SIZE + contact_point.INITIAL_SEPARATION]
        separation += dot(normal, subtract(line, _line_at_start(body_a, body_b, bodies)))
    rows[lane + constraint.SIZE + contact_point.SEPARATION] = separation
