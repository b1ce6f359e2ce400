# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The time of impact: the instant at which two colliders in flight meet. A lower bound of their gap
with exact value and rate, and a bound on its second derivative, step by step up to the root.

    gap(t + D) >= min over points a of A, b of B of  c0 + c1 D + c2 D^2 / 2
        c0 = n . (b - a) - r_A - r_B
        c1 = n . (v_b - v_a) + n' . (b - a)
        c2 = n . (a_B - a_A) - k,   k : what turning of A, of B and of n may add

with the points that are extreme along n + D (n' + n x w): Newton's method from the safe side. It
never steps over the instant, converges quadratically, and needs no step off after an impact: a gap
of zero that grows has its own next root.

Where the two touch and neither part nor approach, or creep along each other, or overlap already,
there is no instant: such a pair is left to the solver. So is one whose instant was not found in so
many steps, or only behind it, but then the tick tells (`collision.deep_overlaps`).
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider_record
from rigid_body_sim.physics.contact.collision.nearest_axis import core_point, radius_about_core
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET, RADIUS
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.events.closest_axis import turn_of_axis
from rigid_body_sim.physics.contact.events.flight import Flights, body_of, pose_of_side
from rigid_body_sim.physics.contact.events.ground_parts import is_ground, lever_of, plane_of
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

EVALUATIONS = 64  # [-] of the axis; what is undecided then is left to the solver
ROUNDS = 8  # [-] of the extreme points for one axis; 2 to 4 are needed
PLACE_ROUND_OFF = 2e-15  # [-] of place and size: a smaller gap is none
STILL = 1e-13  # [-] of the speeds: slower approach is none
EVEN = 1e-15  # [-] of accelerations that are the same
SOON = 1e-7  # [-] of the time left: extreme points of now are those of then
OVERLAP = 1e-6  # [-] of the radii: what overlaps more does not meet, it is pushed apart
AT_ONCE = 1e-13  # [-] of the tick: a step that is none

NO_VECTOR = (0.0, 0.0, 0.0)
MISSES, MEETS, STAYS = 0, 1, 2  # what is found

look = slot('kernel (side, collider, time, flights): shows a collider at an instant')
axis = slot('kernel (a, b, flights): the axis along which two colliders are farthest apart')


@inline
def _point_of_plane(begin: int, point: Any, flights: Flights) -> Any:
    """Return the point of a plane that is nearest to a point."""
    colliders = flights.colliders
    out = load(colliders.parameters, begin + NORMAL)
    height = dot(out, point) - colliders.parameters[begin + OFFSET]
    return add_scaled(point, -height, out)


@kernel
def extremes(
    a: int, b: int, normal: Any, turn: Any, ahead: float, rounding: float, flights: Flights
) -> Any:
    """
    Return c0 and c1 of the points that are nearest along the axis some time ahead [s].

        rounding : r_A + r_B [m]
    """
    colliders, views = flights.colliders, flights.views
    spin_a = load(views, flight_record.SPIN)
    spin_b = load(views, flight_record.VIEW + flight_record.SPIN)
    center_a = load(views, flight_record.CENTER)
    center_b = load(views, flight_record.VIEW + flight_record.CENTER)
    of_a = add_scaled(normal, ahead, add(turn, cross(normal, spin_a)))
    point_a = core_point(a, pose_of_side(0, flights), of_a, center_a, colliders)
    plane = plane_of(b, flights.colliders)
    if plane >= 0:
        point_b = subtract(_point_of_plane(plane, add(point_a, center_a), flights), center_b)
    else:
        of_b = add_scaled(normal, ahead, add(turn, cross(normal, spin_b)))
        point_b = core_point(b, pose_of_side(1, flights), negate(of_b), center_b, colliders)
    between = add(subtract(center_b, center_a), subtract(point_b, point_a))
    rate_a = add(load(views, flight_record.VELOCITY), cross(spin_a, point_a))
    rate_b = add(load(views, flight_record.VIEW + flight_record.VELOCITY), cross(spin_b, point_b))
    rate = dot(normal, subtract(rate_b, rate_a)) + dot(turn, between)
    return dot(normal, between) - rounding, rate


@inline
def _first_root(c0: float, c1: float, c2: float) -> float:
    """Return the first positive root of c0 + c1 D + c2 D^2/2, c0 >= 0; NEVER: there is none."""
    inside = c1 * c1 - 2.0 * c0 * c2
    if inside < 0.0:
        return flight_record.NEVER
    root = math.sqrt(inside)
    if c1 < 0.0:
        return 2.0 * c0 / (root - c1)
    if c2 < 0.0:
        return (c1 + root) / -c2
    return flight_record.NEVER


@inline
def _is_bare_ball(collider: int, flights: Flights) -> bool:
    """Tell whether a collider is a ball about its centre of mass that moves freely."""
    body = body_of(collider, flights)
    if body < 0:
        return False
    return (
        flights.bodies[body * solver_bodies.SIZE + solver_bodies.SYMMETRY]
        == solver_bodies.CENTRED_BALL
    )


@inline
def _balls_meet(a: int, b: int, rest: float, row: int, flights: Flights) -> Any:
    """
    Return whether two balls with the same acceleration meet within a time [s], and when, in closed
    form; write approach and normal.
    """
    colliders, views = flights.colliders, flights.views
    shape_a = colliders.table[a * collider_record.SIZE + collider_record.PARAMETERS]
    shape_b = colliders.table[b * collider_record.SIZE + collider_record.PARAMETERS]
    reach = colliders.parameters[shape_a + RADIUS] + colliders.parameters[shape_b + RADIUS]
    center_b = load(views, flight_record.VIEW + flight_record.CENTER)
    way = subtract(center_b, load(views, flight_record.CENTER))
    velocity = subtract(
        load(views, flight_record.VIEW + flight_record.VELOCITY),
        load(views, flight_record.VELOCITY),
    )
    approach = -dot(way, velocity)
    squared = dot(velocity, velocity)
    distance = math.sqrt(dot(way, way))
    if not approach > STILL * distance * math.sqrt(squared):
        return MISSES, 0.0
    beyond = (distance - reach) * (distance + reach)
    inside = approach * approach - squared * beyond
    if inside <= 0.0:
        return MISSES, 0.0
    time = max(beyond, 0.0) / (approach + math.sqrt(inside))
    if time > rest:
        return MISSES, 0.0
    then = add_scaled(way, time, velocity)
    normal = scale(1.0 / math.sqrt(dot(then, then)), then)
    flights.pairs[row + flight_record.APPROACH] = -dot(normal, velocity)
    store(flights.pairs, row + flight_record.NORMAL, normal)
    return MEETS, time


@kernel
def _bend(a: int, b: int, turn: Any, distance: float, flights: Flights) -> Any:
    """Bound what turning may take from the second derivative of the gap: k of the module."""
    views = flights.views
    bend = views[flight_record.BEND] + views[flight_record.VIEW + flight_record.BEND]
    squared = dot(turn, turn)
    if squared == 0.0:
        return bend
    velocity = subtract(
        load(views, flight_record.VIEW + flight_record.VELOCITY),
        load(views, flight_record.VELOCITY),
    )
    lever_a, lever_b = lever_of(a, flights.colliders), lever_of(b, flights.colliders)
    speed = (
        math.sqrt(dot(velocity, velocity))
        + views[flight_record.SPIN_BOUND] * lever_a
        + views[flight_record.VIEW + flight_record.SPIN_BOUND] * lever_b
    )
    away = distance + 2.0 * (lever_a + lever_b)
    return bend + squared * away + 2.0 * math.sqrt(squared) * speed


def _find_instant(a: int, b: int, start: float, end: float, row: int, flights: Flights) -> int:
    """
    Tell whether two colliders meet between two instants of the tick [s], both in flight at the
    first one, and write the instant, or NEVER, the approach then and the axis into an event.

        a, b : type of A <= type of B;   row : where the event begins
    """
    views, pairs, rest = flights.views, flights.pairs, end - start
    pairs[row + flight_record.INSTANT] = flight_record.NEVER
    rounding = radius_about_core(a, flights.colliders) + radius_about_core(b, flights.colliders)
    levers = lever_of(a, flights.colliders) + lever_of(b, flights.colliders)
    time, gap, rate = start, 0.0, 0.0
    if not is_ground(b, flights.colliders):
        store(views, flight_record.LAST_AXIS, NO_VECTOR)
    views[flight_record.PIECES_KNOWN] = 0.0
    for _evaluation in range(EVALUATIONS):
        look(0, a, time, flights)
        look(1, b, time, flights)
        pull = subtract(
            load(views, flight_record.VIEW + flight_record.ACCELERATION),
            load(views, flight_record.ACCELERATION),
        )
        forces = load(views, flight_record.ACCELERATION)
        if (
            _is_bare_ball(a, flights)
            and _is_bare_ball(b, flights)
            and dot(pull, pull) <= EVEN * EVEN * dot(forces, forces)
        ):
            found, after = _balls_meet(a, b, rest, row, flights)
            if found == MEETS:
                pairs[row + flight_record.INSTANT] = time + after
            return found
        normal = axis(a, b, flights)
        store(pairs, row + flight_record.NORMAL, normal)
        turn = turn_of_axis(a, b, normal, flights)
        left = end - time
        gap, rate = extremes(a, b, normal, turn, SOON * left, rounding, flights)
        if gap < -OVERLAP * levers:
            break
        bend = _bend(a, b, turn, abs(gap), flights)
        curve = dot(normal, pull) - bend
        if bend > 0.0:
            curve = min(curve, 0.0)
        step = left
        for _round in range(ROUNDS):
            c0, c1 = extremes(a, b, normal, turn, step, rounding, flights)
            root = _first_root(max(c0, 0.0), c1, curve)
            if not root < step:
                break
            step = root
        if step == left:
            return MISSES
        store(views, flight_record.LAST_AXIS, add_scaled(normal, step, turn))
        center = load(views, flight_record.CENTER)
        size = levers + math.sqrt(dot(center, center))
        if gap <= PLACE_ROUND_OFF * size or time + step == time:
            speeds = _speeds(a, b, flights)
            if rate < -STILL * speeds:
                pairs[row + flight_record.INSTANT] = time
                pairs[row + flight_record.APPROACH] = -rate
                return MEETS
            if step < AT_ONCE * rest or time + step == time:
                pairs[row + flight_record.INSTANT] = time
                pairs[row + flight_record.APPROACH] = max(-rate, 0.0)
                return STAYS
        time += step
    pairs[row + flight_record.INSTANT] = time
    pairs[row + flight_record.APPROACH] = 0.0
    if time > start and (gap < -OVERLAP * levers or rate < -pairs[row + flight_record.SLOW]):
        _tell_undecided(a, b, flights)
    return STAYS


@inline
def _tell_undecided(a: int, b: int, flights: Flights) -> None:
    """Note two whose instant was not found; ground has other parts, which may decide."""
    if not is_ground(b, flights.colliders):
        flights.views[flight_record.UNDECIDED] = 1.0
        flights.views[flight_record.UNDECIDED + 1] = float(a)
        flights.views[flight_record.UNDECIDED + 2] = float(b)


@inline
def _speeds(a: int, b: int, flights: Flights) -> Any:
    """Sum of the speeds of the points of two colliders, roughly [m/s]."""
    views = flights.views
    velocity_a = load(views, flight_record.VELOCITY)
    velocity_b = load(views, flight_record.VIEW + flight_record.VELOCITY)
    return (
        math.sqrt(dot(velocity_a, velocity_a))
        + math.sqrt(dot(velocity_b, velocity_b))
        + views[flight_record.SPIN_BOUND] * lever_of(a, flights.colliders)
        + views[flight_record.VIEW + flight_record.SPIN_BOUND] * lever_of(b, flights.colliders)
    )
