# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Islands that the usual passes leave unsettled: passes over the whole island, which converge faster.

Sequential impulses pass a blow on from body to body. What they have not yet given after k passes
falls by 1 - m/M in a pass where a heavy body M presses on a light one m, and by some pi^2/n^2 in a
column of n: ten passes end long before a blow has gone through. What is left sinks in over the
substep, and is lifted again with a gain of energy. So such an island is visited as a whole, and
between its passes impulses go ahead, by conjugate gradients (Fletcher and Reeves) for which what a
pass changes stands for the gradient:

    g_k     = pass(x_k) - x_k
    b_k     = |g_k|^2/|g_(k-1)|^2,  0 where that is more than 1: it begins anew
    p_k     = g_k + b_k p_(k-1)
    x_(k+1) = x_k + p_k

x : accumulated impulses, along the normals, which stay positive, and of friction after the motion;
|g|^2 : sum of g^2/m over points and patches, m effective masses. The momenta of the bodies follow.
What is slow are the few ways in which something heavy sinks, slides and tips on what is light: it
takes some passes for each of them, and not the root of M/m, as where impulses go ahead by a share
that only time tells (Nesterov). It ends where no pass changes a normal by more than is left alone,
or has begun anew too often: friction may go in circles.

What a pass changes tells less of what is missing, the more one of the two bodies outweighs the
other. So little is left alone between unlike bodies, and more, as time counts too, between like
ones, and most between balls, whose normals turn nothing. Beyond 1:30 it is less, as (m/M)^2, and
an island may have more passes, by the root of that. One of more than MANY bodies has fewer, by the
root of their number: the way through a heap grows slower than its bodies, and what a crash leaves
to the next substep breaks no law. A thousand boxes crash in two thirds of the time with as little
energy gained, and overlap (looked at every 50 ticks) by 10 mm in the first second and 2.7 mm in
the second, in place of 12 and 1.6; with 30 passes for all, columns of 20 that fall would take
longer to rest.

M. Silcowitz, S. Niebel, K. Erleben, Visual Computer 26 (2010) 893; R. Fletcher, C. M. Reeves,
Computer Journal 7 (1964) 149.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.array_groups import Constraints
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.islands import left_sinking, unsettled_record
from rigid_body_sim.physics.contact.islands.union_find import find, unite
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    contact_point,
    friction_patch,
    lane_scratch,
    patch_friction,
    solve,
    wide_lanes,
)
from rigid_body_sim.physics.contact.touching import bodies_of, moving_body_of
from rigid_body_sim.physics.vectors import subtract

# Change of a velocity along a normal [m/s] that is left alone: between bodies of very unlike mass,
# and times as much between like ones. More lets energy rise, less costs time in heaps. An island
# goes on that is far from settled, until all of it is near.
FAR, OF_LIKE_FAR = 1e-3, 10.0
NEAR, OF_LIKE_NEAR = 1e-4, 30.0
OF_BALLS = 2000.0  # [-] times as much again between balls: else heaps of them cost twice as much
MOST_PASSES = 150  # of an island up to 1:30; a pile of 27 boxes takes all of them, at times
MORE = 1.0 + 1e-6  # times the change before is more: what goes to and fro is no matter of rounding
PARTS, MOST_TIMES = 2.0**32, 2.0**10  # [-] of a change before, in which one is counted
MORE_PASSES = 10.0  # times as many, at most, where masses are unlike
MANY = 40.0  # bodies of an island, beyond which it has fewer passes
RESTARTS = 1.0 / 15.0  # [-] of them: what converges begins anew after more


@inline
def _left_alone(lane: int, speed: float, of_like: float, rows: Array) -> float:
    """
    Change of the velocity of a constraint that is left alone [m/s]: FAR or NEAR, and more between
    bodies that are alike, by the fourth power of the ratio of their masses (of balls of 1 to 10 kg
    lower ones let energy rise, or let heaps of one mass take a quarter more).
    """
    inverse_a = rows[lane + constraint.INVERSE_MASS_A]
    inverse_b = rows[lane + constraint.INVERSE_MASS_B]
    least, most = min(inverse_a, inverse_b), max(inverse_a, inverse_b)
    whose = rows[lane + constraint.ROUNDNESS]
    if whose == constraint.TWO_BALLS or whose == constraint.BALL_ON_FIXED:
        of_like *= OF_BALLS
    if least > 0.0:
        square = (least / most) * (least / most)
        of_like *= square * square
    return speed * max(of_like, 1.0) * solve.share_left_alone(lane, rows)


@inline
def _given(row: int, to_come: float, rows: Array) -> float:
    """Return what a point has given along its normal so far [N s]; to_come: see `go_ahead`."""
    impulse = rows[row + contact_point.NORMAL_IMPULSE]
    return impulse - to_come * rows[row + contact_point.WARM_NORMAL] if impulse > 0.0 else 0.0


@inline
def _island_of(lane: int, static: int, rows: Array, roots: Indices) -> int:
    """Where the record of the island of a constraint begins; roots: as `_begin` leaves them."""
    return int(roots[moving_body_of(lane, static, rows)]) * unsettled_record.SIZE


@inline
def _presses(lane: int, point_count: int, width: int, rows: Array) -> bool:
    """Tell whether some point of a constraint presses."""
    for point in range(point_count):
        row = lane + constraint.SIZE + point * width
        if rows[row + contact_point.NORMAL_IMPULSE] > 0.0:
            return True
    return False


@kernel
def _any_far(batches: Indices, rows: Array) -> bool:
    """Tell whether the usual passes have left some constraint far from settled."""
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            change = rows[lane + constraint.UNSETTLED]
            if change > 0.0 and change > _left_alone(lane, FAR, OF_LIKE_FAR, rows):
                return True
    return False


@inline
def _note_impulses(lane: int, point_count: int, width: int, to_come: float, rows: Array) -> None:
    """Note the impulses of a constraint, from which the first pass begins."""
    for point in range(point_count):
        row = lane + constraint.SIZE + point * width
        impulses = wide_lanes.vector(rows, row + contact_point.NORMAL_IMPULSE)
        impulses = (_given(row, to_come, rows), impulses[1], impulses[2])
        wide_lanes.put_vector(rows, row + contact_point.BEGUN_BEFORE, impulses)
        wide_lanes.put_vector(rows, row + contact_point.BEGUN, impulses)
    if point_count > 1:
        patch = lane + constraint.SIZE + MOST * width
        wrench = wide_lanes.vector(rows, patch + friction_patch.IMPULSE_1)
        wide_lanes.put_vector(rows, patch + friction_patch.BEGUN_BEFORE_1, wrench)
        wide_lanes.put_vector(rows, patch + friction_patch.BEGUN_1, wrench)


@kernel
def _begin(
    static: int, width: int, to_come: float, members: Indices, constraints: Constraints
) -> None:
    """Find the islands, of what presses or is unsettled; note all impulses."""
    batches, rows, roots = constraints.batches, constraints.rows, constraints.roots
    for index in range(len(members)):
        roots[members[index]] = members[index]
        island = members[index] * unsettled_record.SIZE
        for entry in range(unsettled_record.SIZE):
            constraints.unsettled[island + entry] = 0.0
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            body_a, body_b = bodies_of(lane, static, rows)
            if (body_a != static and body_b != static) and (
                rows[lane + constraint.UNSETTLED] > 0.0 or _presses(lane, points, width, rows)
            ):
                unite(body_a, body_b, roots)
            _note_impulses(lane, points, width, to_come, rows)
    for index in range(len(members)):
        root = find(members[index], roots)
        roots[members[index]] = root
        constraints.unsettled[root * unsettled_record.SIZE + unsettled_record.BODIES] += 1.0
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            island = _island_of(lane, static, rows, roots)
            few = min(MANY / constraints.unsettled[island + unsettled_record.BODIES], 1.0)
            share = solve.share_left_alone(lane, rows)
            passes = MOST_PASSES * math.sqrt(few) * min(1.0 / math.sqrt(share), MORE_PASSES)
            place = island + unsettled_record.MOST_PASSES
            constraints.unsettled[place] = max(constraints.unsettled[place], passes)


@inline
def _speed_left(lane: int, point_count: int, width: int, to_come: float, rows: Array) -> float:
    """Velocity along the normal by which the last pass has changed a constraint, at most [m/s]."""
    largest = 0.0
    for point in range(point_count):
        row = lane + constraint.SIZE + point * width
        mass = rows[row + contact_point.NORMAL_MASS]
        change = abs(_given(row, to_come, rows) - rows[row + contact_point.BEGUN])
        largest = max(largest, change / mass if mass > 0.0 else 0.0)
    return largest


@kernel
def _wake(
    number: int, static: int, width: int, to_come: float, members: Indices,
    constraints: Constraints,
) -> bool:  # fmt: skip
    """
    Let all of an island be visited again where the last pass has left some of it unsettled, and
    nothing else; tell whether there is such an island.
    """
    batches, rows, islands = constraints.batches, constraints.rows, constraints.unsettled
    for index in range(len(members)):
        island = members[index] * unsettled_record.SIZE
        islands[island + unsettled_record.GOES_ON] = 0.0
    found = False
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            change = rows[lane + constraint.UNSETTLED]
            if change == 0.0:
                continue
            if number == 0:
                goes_on = change > _left_alone(lane, FAR, OF_LIKE_FAR, rows)
            else:
                change = _speed_left(lane, points, width, to_come, rows)
                goes_on = change > _left_alone(lane, NEAR, OF_LIKE_NEAR, rows)
            if goes_on:
                island = _island_of(lane, static, rows, constraints.roots)
                most = islands[island + unsettled_record.MOST_PASSES]
                restarts = islands[island + unsettled_record.RESTARTS]
                if number < most and restarts <= RESTARTS * most:
                    islands[island + unsettled_record.GOES_ON] = 1.0
                    found = True
                elif to_come == 0.0:
                    left_sinking.note(lane, change, rows)
    for batch in range(0, len(batches) if found else 0, batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            island = _island_of(lane, static, rows, constraints.roots)
            rows[lane + constraint.UNSETTLED] = islands[island + unsettled_record.GOES_ON]
    return found


@inline
def _change_of_point(row: int, to_come: float, rubs: bool, rows: Array) -> float:
    """Return what the last pass has changed of a point [J]; rubs: also of its friction."""
    impulses = wide_lanes.vector(rows, row + contact_point.NORMAL_IMPULSE)
    impulses = (_given(row, to_come, rows), impulses[1], impulses[2])
    change = subtract(impulses, wide_lanes.vector(rows, row + contact_point.BEGUN))
    mass = rows[row + contact_point.NORMAL_MASS]
    total = change[0] * change[0] / mass if mass > 0.0 else 0.0
    mass = rows[row + contact_point.TANGENT_MASS]
    if rubs and mass > 0.0:
        total += (change[1] * change[1] + change[2] * change[2]) / mass
    return total


@inline
def _change_of_patch(patch: int, rows: Array) -> float:
    """Return what the last pass has changed of the friction of a patch [J]."""
    wrench = wide_lanes.vector(rows, patch + friction_patch.IMPULSE_1)
    change = subtract(wrench, wide_lanes.vector(rows, patch + friction_patch.BEGUN_1))
    mass = rows[patch + friction_patch.STEP]
    length_squared = rows[patch + friction_patch.LENGTH_SQUARED]
    turns = change[2] * change[2] / length_squared if length_squared > 0.0 else 0.0
    total = change[0] * change[0] + change[1] * change[1] + turns
    return total / mass if mass > 0.0 else 0.0


@inline
def _change_of(lane: int, points: int, width: int, to_come: float, rows: Array) -> float:
    """Return what the last pass has changed of a constraint [J]."""
    total = 0.0
    for point in range(points):
        row = lane + constraint.SIZE + point * width
        total += _change_of_point(row, to_come, points == 1 and to_come == 0.0, rows)
    if points > 1 and to_come == 0.0:
        total += _change_of_patch(lane + constraint.SIZE + MOST * width, rows)
    return total


@kernel
def _find_steps(
    static: int, width: int, to_come: float, members: Indices, constraints: Constraints
) -> None:
    """
    Find how far the impulses of each island go ahead: not at all where the last pass has changed
    more.

    Changes are added up in whole parts of the one before, which is exact: else sums would round in
    the order of the bodies. The first is the largest alone.
    """
    batches, rows, islands = constraints.batches, constraints.rows, constraints.unsettled
    for index in range(len(members)):
        islands[members[index] * unsettled_record.SIZE + unsettled_record.CHANGE] = 0.0
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        points = batches[batch + batch_record.POINT_COUNT]
        for lane in range(begin, begin + batches[batch + batch_record.LANE_COUNT]):
            if rows[lane + constraint.UNSETTLED] == 0.0:
                continue
            change = _change_of(lane, points, width, to_come, rows)
            island = _island_of(lane, static, rows, constraints.roots)
            before = islands[island + unsettled_record.CHANGE_BEFORE]
            so_far = islands[island + unsettled_record.CHANGE]
            times = change / before if before > 0.0 else 0.0
            parts = math.floor(times * PARTS) if times < MOST_TIMES else MOST_TIMES * PARTS
            islands[island + unsettled_record.CHANGE] = (
                so_far + parts if before > 0.0 else max(so_far, change)
            )
    for index in range(len(members)):
        island = members[index] * unsettled_record.SIZE
        before = islands[island + unsettled_record.CHANGE_BEFORE]
        change = islands[island + unsettled_record.CHANGE]
        change = change * (before / PARTS) if before > 0.0 else change
        converges = 0.0 < change <= MORE * before
        islands[island + unsettled_record.AHEAD] = change / before if converges else 0.0
        islands[island + unsettled_record.RESTARTS] += 0.0 if converges else 1.0
        islands[island + unsettled_record.CHANGE_BEFORE] = change


@kernel
def _extrapolate(
    lanes: int, to_come: float, rubs: bool, constraints: Array, points: Array, scratch: Array
) -> None:
    """Let the impulses of one point of each lane go ahead; rubs: also those of friction."""
    for lane in range(lanes):
        normal, tangent_1, tangent_2 = wide_lanes.contact_frame(constraints, lane)
        arm_a, arm_b = wide_lanes.arms(points, lane)
        old, old_1, old_2 = wide_lanes.vector(points, lane + contact_point.NORMAL_IMPULSE)
        before = wide_lanes.vector(points, lane + contact_point.BEGUN_BEFORE)
        ahead = scratch[lane + lane_scratch.AHEAD]
        ahead_of_friction = ahead if rubs else 0.0
        warm = to_come * points[lane + contact_point.WARM_NORMAL]
        presses = old > 0.0
        given = old - warm if presses else 0.0
        # what presses goes on to press: it ends where a visit ends it
        was, was_1, was_2 = wide_lanes.vector(points, lane + contact_point.BEGUN)
        begun = given + ahead * (was - before[0])
        begun = begun if begun > 0.0 else 0.5 * given
        goes = (ahead > 0.0) & presses
        begun = begun if goes else given
        begun_1 = old_1 + ahead_of_friction * (was_1 - before[1])
        begun_2 = old_2 + ahead_of_friction * (was_2 - before[2])
        points[lane + contact_point.NORMAL_IMPULSE] = begun + warm if goes else old
        points[lane + contact_point.TANGENT_IMPULSE_1] = begun_1
        points[lane + contact_point.TANGENT_IMPULSE_2] = begun_2
        wide_lanes.put_vector(points, lane + contact_point.BEGUN_BEFORE, (was, was_1, was_2))
        wide_lanes.put_vector(points, lane + contact_point.BEGUN, (begun, begun_1, begun_2))
        impulse = wide_lanes.impulse_of(
            begun - given, begun_1 - old_1, begun_2 - old_2, normal, tangent_1, tangent_2
        )
        wide_lanes.apply_impulse(scratch, lane, arm_a, arm_b, impulse)


@kernel
def _limit_shares(lanes: int, to_come: float, points: Array, scratch: Array) -> None:
    """
    Let the impulses of a lane with several points go ahead no farther than to where one of them
    has lost half of itself that would come to nothing: alone, it would turn what moves straight.
    """
    for lane in range(lanes):
        old = points[lane + contact_point.NORMAL_IMPULSE]
        ahead = scratch[lane + lane_scratch.AHEAD]
        given = old - to_come * points[lane + contact_point.WARM_NORMAL]
        loses = points[lane + contact_point.BEGUN_BEFORE] - points[lane + contact_point.BEGUN]
        comes_to_nothing = (old > 0.0) & (given > 0.0) & (given <= ahead * loses)
        share = 0.5 * given / (loses if comes_to_nothing else 1.0)
        scratch[lane + lane_scratch.AHEAD] = share if comes_to_nothing else ahead


@kernel
def _extrapolate_all(
    lanes: int, static: int, width: int, to_come: float, constraints: Constraints, bodies: Array
) -> None:
    """Let the impulses of all islands that go on go ahead."""
    batches, rows, islands = constraints.batches, constraints.rows, constraints.unsettled
    scratch = constraints.scratch
    for batch in range(0, len(batches), batch_record.SIZE):
        begin = batches[batch + batch_record.BEGIN]
        used = batches[batch + batch_record.LANE_COUNT]
        point_count = batches[batch + batch_record.POINT_COUNT]
        own = rows[begin : begin + constraint.SIZE]
        if not solve.any_unsettled(used, own):
            continue
        solve.gather_unsettled(lanes, 1.0, own, scratch, bodies)
        for lane in range(constraint.LANES):
            scratch[lane + lane_scratch.AHEAD] = 0.0
        for lane in range(used):
            if own[lane + constraint.UNSETTLED] > 0.0:
                island = _island_of(begin + lane, static, rows, constraints.roots)
                scratch[lane + lane_scratch.AHEAD] = islands[island + unsettled_record.AHEAD]
        first = begin + constraint.SIZE
        for point in range(point_count if point_count > 1 else 0):
            points = rows[first + point * width : first + (point + 1) * width]
            _limit_shares(lanes, to_come, points, scratch)
        for point in range(point_count):
            points = rows[first + point * width : first + (point + 1) * width]
            rubs = point_count == 1 and to_come == 0.0
            _extrapolate(lanes, to_come, rubs, own, points, scratch)
        if point_count > 1 and to_come == 0.0:
            patch = rows[first + MOST * width : first + MOST * width + friction_patch.SIZE]
            patch_friction.go_ahead(lanes, own, patch, scratch)
        solve.scatter_momenta(own, scratch, bodies)


@kernel
def go_ahead(
    number: int, lanes: int, width: int, to_come: float, members: Indices,
    constraints: Constraints, bodies: Array,
) -> bool:  # fmt: skip
    """
    Let the islands that the last pass has left unsettled be visited once more, as a whole, with
    their impulses gone ahead; tell whether there are any.

    number  : of such passes so far
    lanes   : to go over, of each batch: see `iterations`
    width   : numbers of a point
    to_come : [-] 1 before the motion, where half of the warm start is still to come, and friction
              stands still; else 0
    members : bodies of the group
    """
    static = len(constraints.roots) - 1
    if number == 0:
        if not _any_far(constraints.batches, constraints.rows):
            return False
        _begin(static, width, to_come, members, constraints)
    if not _wake(number, static, width, to_come, members, constraints):
        return False
    if number > 0:
        _find_steps(static, width, to_come, members, constraints)
        _extrapolate_all(lanes, static, width, to_come, constraints, bodies)
    return True
