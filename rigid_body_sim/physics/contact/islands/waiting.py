# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What waits for its bounce: a surface that was struck within the tick is left after the last
substep. What the friction of other contacts does meanwhile is not foreseen by the velocity of
approach, which knows forces alone (`solver.approach`). Before the surfaces meet friction changes
that velocity. Behind, they hold what it gives: a ball that has rolled against a wall spins on, the
ground drives it into the wall, and what the wall takes is lost. So the bounce is that of

    v_n <- -e (v_approach + w_tick - k w) + k w,   the last only where w < 0

w      : [m/s] relative normal velocity that friction of the last substep gives, of the contacts of
         both bodies that press and do not bounce; no more of it than a load brings (`warm_start`);
         what it turns others hold up, or does not move what is round
w_tick : [m/s] the same of the tick
k      : [-] substeps from the one in which the surfaces met to the last

Friction of the bounce itself acts at that instant too. What forces turn the slip by behind it, it
must not take, or a wall carries part of what hits it until the tick is over. So the slip that it
strives for is not zero but

    s = (t_B a_B - t_A a_A)_t,   t <- t max(0, 1 - N / m |a| h)

a : [m/s^2] acceleration of the surface of a body without contact
t : [s] from when the surfaces meet to the end of the tick; of a body that lay on something else
    when the tick began, which the impact lifts: all of the k substeps, that held it until then
N : [N s] what else presses on the body in the last substep h, and holds it up

Two balls that meet alone (`solver.ball_impacts`) have nothing else between them than this impact:
all that their contact gives in the tick is its impulse, -(1 + e) m v_approach.
"""

from __future__ import annotations

import math
from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.islands.bouncing import bounces
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    friction_patch,
    impact_sequence,
    wide_lanes,
)
from rigid_body_sim.physics.contact.solver.constraint import LANES
from rigid_body_sim.physics.contact.solver.solve import NEARLY
from rigid_body_sim.physics.contact.solver.warm_start import share_of_point
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    dot,
    load,
    scale,
    store,
    subtract,
)


@inline
def _give(body: int, sums: int, impulse: Any, bodies: Array) -> None:
    """Add an impulse to a sum of a body."""
    if bodies[body + solver_bodies.INVERSE_MASS] > 0.0:
        store(bodies, body + sums, add(load(bodies, body + sums), impulse))


@inline
def _load(lane: int, points: int, width: int, rows: Array) -> Any:
    """Return what presses at the points of a constraint as a load, and its share of all."""
    total, lasts = 0.0, 0.0
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        impulse = rows[point + contact_point.NORMAL_IMPULSE]
        total += impulse
        lasts += share_of_point(lane, point, rows, rows) * impulse
    return lasts, lasts / total if total > 0.0 else 0.0


@inline
def _add_impulse(lane: int, sums: int, along: Any, rows: Array, bodies: Array) -> None:
    """Add a friction, along the two tangents, to sums of the bodies of a constraint."""
    _, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    impulse = add(scale(along[0], tangent_1), scale(along[1], tangent_2))
    _give(int(rows[lane + constraint.BODY_A]), sums, scale(-1.0, impulse), bodies)
    _give(int(rows[lane + constraint.BODY_B]), sums, impulse, bodies)


@inline
def _add_load(lane: int, points: int, width: int, rows: Array, bodies: Array) -> None:
    """Note whether the bodies of a constraint lay on each other, and what presses on them now."""
    total, lay = 0.0, 0.0
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        total += rows[point + contact_point.NORMAL_IMPULSE]
        lay = 1.0 if rows[point + contact_point.INITIAL_SEPARATION] <= 0.0 else lay
    for side in (constraint.BODY_A, constraint.BODY_B):
        body = int(rows[lane + side])
        if bodies[body + solver_bodies.INVERSE_MASS] > 0.0:
            bodies[body + solver_bodies.PRESSED] += total
            bodies[body + solver_bodies.LAY] = max(bodies[body + solver_bodies.LAY], lay)


@inline
def _add_friction(
    lane: int, points: int, width: int, substeps: int, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Add the friction of a constraint to the sums of its bodies."""
    lasts, share = _load(lane, points, width, rows)
    if not lasts > 0.0:
        return
    first = lane + constraint.SIZE
    if points > 1:
        patch = first + MOST * width
        now_1 = rows[patch + friction_patch.IMPULSE_1]
        now_2 = rows[patch + friction_patch.IMPULSE_2]
        all_1 = rows[patch + friction_patch.TOTAL_1] + now_1
        all_2 = rows[patch + friction_patch.TOTAL_2] + now_2
    else:
        now_1 = rows[first + contact_point.TANGENT_IMPULSE_1]
        now_2 = rows[first + contact_point.TANGENT_IMPULSE_2]
        all_1 = rows[first + contact_point.TOTAL_IMPULSE + LANES] + now_1
        all_2 = rows[first + contact_point.TOTAL_IMPULSE + 2 * LANES] + now_2
    most = rows[lane + constraint.FRICTION] * lasts * substeps
    size = math.sqrt(all_1 * all_1 + all_2 * all_2)
    of_load = most / size if size > most else 1.0
    now, of_tick = (share * now_1, share * now_2), (of_load * all_1, of_load * all_2)
    _add_impulse(lane, solver_bodies.RUBBED, now, rows, bodies)
    _add_impulse(lane, solver_bodies.RUBBED_IN_TICK, of_tick, rows, bodies)


@inline
def _velocity(body: int, sums: int, bodies: Array) -> Any:
    """Velocity that a sum of a body gives."""
    return scale(bodies[body + solver_bodies.INVERSE_MASS], load(bodies, body + sums))


@inline
def _given(lane: int, sums: int, rows: Array, bodies: Array) -> float:
    """Relative normal velocity that sums of the bodies of a constraint give."""
    velocity_a = _velocity(int(rows[lane + constraint.BODY_A]), sums, bodies)
    velocity_b = _velocity(int(rows[lane + constraint.BODY_B]), sums, bodies)
    return dot(wide_lanes.vector(rows, lane + constraint.NORMAL), subtract(velocity_b, velocity_a))


@inline
def _pulled(body: int, arm: Any, since: Any, substep: float, bodies: Array) -> Any:
    """
    Velocity that forces give the surface of a body behind its impact, see the module.

    since : [s] from the beginning of the substep in which it meets, and from when it does
    """
    linear = load(bodies, body + solver_bodies.FREE_ACCELERATION)
    angular = load(bodies, body + solver_bodies.FREE_ANGULAR_ACCELERATION)
    inverse_mass = bodies[body + solver_bodies.INVERSE_MASS]
    held = inverse_mass * bodies[body + solver_bodies.PRESSED]
    weight = math.sqrt(dot(linear, linear)) * substep
    lay = bodies[body + solver_bodies.LAY] > 0.0 and inverse_mass > solver_bodies.HELD
    time = since[0] if lay else since[1]
    if held > 0.0:
        time *= 1.0 - held / weight if held < weight else 0.0
    return scale(time, add(linear, cross(angular, arm)))


@inline
def _leave_slip(
    lane: int, points: int, width: int, since: Any, substep: float, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Tell a constraint that bounces which slip its friction leaves; since: see `_pulled`."""
    place = lane + constraint.SIZE
    arms = place + contact_point.ARM_A, place + contact_point.ARM_B
    if points > 1:
        place += MOST * width
        arms = place + friction_patch.ARM_A, place + friction_patch.ARM_B
    arm_a, arm_b = wide_lanes.vector(rows, arms[0]), wide_lanes.vector(rows, arms[1])
    pulled_a = _pulled(int(rows[lane + constraint.BODY_A]), arm_a, since, substep, bodies)
    pulled_b = _pulled(int(rows[lane + constraint.BODY_B]), arm_b, since, substep, bodies)
    slip = subtract(pulled_b, pulled_a)
    _, tangent_1, tangent_2 = wide_lanes.contact_frame(rows, lane)
    rows[lane + constraint.SLIP_LEFT_1] = dot(tangent_1, slip)
    rows[lane + constraint.SLIP_LEFT_2] = dot(tangent_2, slip)


@inline
def _correct_approach(
    lane: int, points: int, width: int, substep: float, substeps: int, rows: Array, bodies: Array
) -> None:  # fmt: skip
    """Let the points of a constraint bounce by what friction leaves of their approach."""
    restitution = rows[lane + constraint.RESTITUTION]
    of_substep = _given(lane, solver_bodies.RUBBED, rows, bodies)
    of_tick = _given(lane, solver_bodies.RUBBED_IN_TICK, rows, bodies)
    meets = float(substeps)  # all points of a face at once: what is flat is not turned
    first = lane + constraint.SIZE
    for point in range(first, first + points * width, width):
        approach = rows[point + contact_point.APPROACH_VELOCITY]
        if approach < 0.0:
            ahead = max(rows[point + contact_point.INITIAL_SEPARATION], 0.0)
            meets = min(meets, ahead / (-approach * substep) + NEARLY)
    whole = min(int(meets), substeps - 1)
    since = (substeps - whole) * substep, (substeps - meets) * substep
    _leave_slip(lane, points, width, since, substep, rows, bodies)
    behind = (substeps - whole) * of_substep
    # of the substep in which they meet, the part until they do; `behind` has it, if it is last
    rubbed = whole if whole == substeps - 1 else whole + 1
    before = (of_tick - behind) * (meets / rubbed if rubbed > 0 else 0.0)
    more = before - min(behind, 0.0) / restitution
    for point in range(first, first + points * width, width):
        approach = rows[point + contact_point.APPROACH_VELOCITY]
        if approach < 0.0:
            rows[point + contact_point.APPROACH_VELOCITY] = min(approach + more, 0.0)


@inline
def _meet_alone(lane: int, rows: Array) -> bool:
    """Tell whether a lane is one of two balls that move and whose impact is foreseen."""
    return bool(
        rows[lane + constraint.WAITS] > 0.0
        and rows[lane + constraint.INVERSE_MASS_A] > 0.0
        and rows[lane + constraint.INVERSE_MASS_B] > 0.0
    )


@inline
def _count_what_was_given(lane: int, rows: Array) -> None:
    """Let two balls that meet alone bounce by what they have not yet given each other."""
    point = lane + constraint.SIZE
    restitution = rows[lane + constraint.RESTITUTION]
    approach = rows[point + contact_point.APPROACH_VELOCITY]
    given = rows[point + contact_point.TOTAL_IMPULSE] + rows[point + contact_point.NORMAL_IMPULSE]
    left = (1.0 + restitution) * approach + given / rows[point + contact_point.NORMAL_MASS]
    rows[point + contact_point.APPROACH_VELOCITY] = min(left / restitution, 0.0)


@kernel
def heed_friction(
    batch_count: int, width: int, substep: float, substeps: int, touching: Indices,
    batches: Indices, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Correct the velocities of approach of what bounces by what friction has given in the tick.

    width    : numbers of a point
    substep  : [s]
    substeps : how many a tick has
    """
    for index in range(len(touching)):
        body = touching[index] * solver_bodies.SIZE
        for sums in (solver_bodies.RUBBED, solver_bodies.RUBBED_IN_TICK):
            store(bodies, body + sums, (0.0, 0.0, 0.0))
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            rows[lane + constraint.SLIP_LEFT_1] = rows[lane + constraint.SLIP_LEFT_2] = 0.0
            for side in (constraint.BODY_A, constraint.BODY_B):
                body = int(rows[lane + side])
                bodies[body + solver_bodies.PRESSED] = bodies[body + solver_bodies.LAY] = 0.0
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not rows[lane + constraint.BOUNCES] > 0.0 or bounces(lane, points, width, rows):
                continue
            _add_load(lane, points, width, rows, bodies)
            if rows[lane + constraint.FRICTION] > 0.0:
                _add_friction(lane, points, width, substeps, rows, bodies)
    for batch in range(0, batch_count * batch_record.SIZE, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not (rows[lane + constraint.BOUNCES] > 0.0 and bounces(lane, points, width, rows)):
                continue
            if impact_sequence.is_given_at_the_end(lane, rows):
                continue
            if _meet_alone(lane, rows):
                _count_what_was_given(lane, rows)
            else:
                _correct_approach(lane, points, width, substep, substeps, rows, bodies)
