# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Balls that are jammed: friction of two contacts presses each on the other.

Where by more than it got, no pass settles them (mu_1 mu_2 > 1); where by less, a contact that was
at rest is not asked again. So a ball that touches nobody else who moves could end a tick going
into a wall or the ground, at 0.8 m/s where it came at 5. When all passes of a tick are over, what
cannot move has the last word (`hold`).
"""

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.islands.unsettled import FAR
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    wide_lanes,
)
from rigid_body_sim.physics.contact.touching import bodies_of, moving_body_of
from rigid_body_sim.physics.vectors import add_scaled, dot, load, scale, store, subtract

PASSES, HELD = 40, 1e-9  # over what is jammed, at most; [m/s] is left


@inline
def _may_be_jammed(lane: int, rows: Array) -> bool:
    """
    Tell whether a constraint is one of a ball on what cannot move, beside others, with friction:
    what each gives there the others have to hold, and may answer.
    """
    return bool(
        rows[lane + constraint.ROUNDNESS] == constraint.BALL_ON_FIXED
        and rows[lane + constraint.FRICTION] > 0.0
        and rows[lane + constraint.MANIFOLDS] > 1.0
    )


@inline
def _approach(lane: int, inverse_h: float, rows: Array, bodies: Array) -> float:
    """
    Speed with which a ball goes into what cannot move, beyond what is still apart [m/s]; 0: what
    waits to bounce, or comes no nearer.
    """
    point = lane + constraint.SIZE
    separation = rows[point + contact_point.SEPARATION]
    waits = rows[lane + constraint.RESTITUTION] > 0.0 and separation > 0.0
    if waits and not rows[point + contact_point.NORMAL_IMPULSE] > 0.0:
        return 0.0
    body_a, body_b = int(rows[lane + constraint.BODY_A]), int(rows[lane + constraint.BODY_B])
    apart = subtract(
        scale(
            bodies[body_b + solver_bodies.INVERSE_MASS],
            load(bodies, body_b + solver_bodies.MOMENTUM),
        ),
        scale(
            bodies[body_a + solver_bodies.INVERSE_MASS],
            load(bodies, body_a + solver_bodies.MOMENTUM),
        ),
    )
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    return max(-dot(normal, apart) - max(separation, 0.0) * inverse_h, 0.0)


@inline
def _hold_once(lane: int, speed: float, rows: Array, bodies: Array) -> None:
    """Let what cannot move take a speed of a ball, along the normal."""
    point = lane + constraint.SIZE
    normal = wide_lanes.vector(rows, lane + constraint.NORMAL)
    press = rows[point + contact_point.NORMAL_MASS] * speed
    rows[point + contact_point.TOTAL_IMPULSE] += press
    for side, sign in ((constraint.BODY_A, -1.0), (constraint.BODY_B, 1.0)):
        body = int(rows[lane + side])
        if bodies[body + solver_bodies.INVERSE_MASS] > 0.0:
            momentum = add_scaled(
                load(bodies, body + solver_bodies.MOMENTUM), sign * press, normal
            )
            store(bodies, body + solver_bodies.MOMENTUM, momentum)


@kernel
def _hold_all(
    inverse_h: float, more: float, hold: bool, constraints: Constraints, bodies: Array
) -> float:
    """
    Hold the balls that touch nobody who moves, where they go in faster than so much more [m/s], or
    only look; return how fast the fastest does.
    """
    batches, rows = constraints.batches, constraints.rows
    static, largest = len(constraints.roots) - 1, 0.0
    for batch in range(0, len(batches), batch_record.SIZE):
        if batches[batch + batch_record.KIND] != batch_record.BALLS:
            continue
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if not _may_be_jammed(lane, rows):
                continue
            speed = _approach(lane, inverse_h, rows, bodies)
            if not speed > more:
                continue
            if hold and constraints.roots[moving_body_of(lane, static, rows)] == static:
                _hold_once(lane, speed, rows, bodies)
                largest = max(largest, speed)
            elif not hold:
                largest = max(largest, speed)
    return largest


@kernel
def hold(inverse_h: float, members: Indices, constraints: Constraints, bodies: Array) -> None:
    """
    Let what cannot move have the last word on balls that touch nobody else who moves, when all
    passes of a tick are over: by normal impulses alone, which take energy.

    inverse_h : of a substep [1/s]
    members   : bodies of the islands that pass it
    """
    if not _hold_all(inverse_h, FAR, False, constraints, bodies) > 0.0:
        return
    batches, rows, roots = constraints.batches, constraints.rows, constraints.roots
    static = len(roots) - 1
    for index in range(len(members)):
        roots[members[index]] = static
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if body_a != static and body_b != static:
                roots[body_a] = body_a
                roots[body_b] = body_b
    for _ in range(PASSES):
        if not _hold_all(inverse_h, HELD, True, constraints, bodies) > 0.0:
            break
