# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The passes of the solver over all batches of constraints, and how often a batch is visited.

Sequential impulses (projected Gauss-Seidel): batch after batch, point after point, each visit sees
the velocities that the last one left. The equations are those of `prepare`, `warm_start`, `solve`,
`separation`, `rolling_friction` and `restitution`, for the eight lanes of a batch at once.

`lanes` are one, four or eight (`colouring.lanes_in_use`), in use or not. How many must not be
known to the compiler: it would go over the lanes of a loop one by one, at five times the cost. So
`lanes_at_once` comes from outside, also where it is always the same.
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.solver import (
    approach,
    batch_record,
    bends,
    common_impulse,
    constraint,
    contact_point,
    core_pair,
    curved_cores,
    face_spring,
    far_points,
    friction_patch,
    lane_scratch,
    patch_friction,
    prepare,
    restitution,
    rolling_frame,
    rolling_friction,
    separation,
    solve,
    surface_chain,
    surface_friction,
    warm_start,
    whole_manifold,
    whole_surface,
)

STARTING_ITERATIONS = 20  # at most, of a batch on which friction of a face starts
PASSES = 10  # at most, before unsettled islands are visited as a whole: `islands.unsettled`
BALL_PASSES = 4  # at most, over normals of balls: they turn nothing, and settle sooner
RESTITUTION_ITERATIONS = 40  # at most; a stack of that many balls is not yet at rest

WIDTH = slot('[-] numbers of a point')
ANGULAR = slot('[-] whether anything rolls or twists with friction')
BOUNCES = slot('[-] whether anything bounces')
CURVED = slot('[-] whether layers about cores may meet: `curved_cores`')
TURNS = slot('[-] whether the inertia of anything turns with it, or changes')
RIMS = slot('[-] whether a cylinder may touch')
BENDS = slot('[-] whether anything turns but balls about their centres')
LAYERED = slot('[-] whether anything is a ball or a capsule')
PATCHES = slot('[-] whether anything may touch at several points')
SURFACES = slot('[-] whether a body may touch another with several manifolds')
# of one point of each lane, in batches of one point; where there are several, without friction
solve_point = slot('kernel (lanes, constraints, points, ...): solves normals, soft')
solve_normal = slot('kernel (lanes, constraints, points, ...): the same without friction')
relax_point = slot('kernel (lanes, constraints, points, ...): relaxes normals, and friction')
relax_normal = slot('kernel (lanes, constraints, points, ...): the same without friction')
start_point = slot('kernel (lanes, constraints, points, scratch): starts a substep')
start_normal = slot('kernel (lanes, constraints, points, scratch): the same without friction')
restore_point = slot('kernel (lanes, constraints, points, scratch): applies restitution')
restore_normal = slot('kernel (lanes, constraints, points, scratch): the same without friction')
relax_friction = slot('kernel (lanes, constraints, patch, scratch): relaxes friction of patches')
solve_all_in_common = slot('kernel (lanes, used, ...): soft normals, what is common')
relax_all_in_common = slot('kernel (lanes, used, ...): the same after the motion')
restore_all_in_common = slot('kernel (lanes, used, ...): the same of restitution')
solve_as_a_whole = slot('kernel (lanes, used, ...): soft normals of whole manifolds')
relax_as_a_whole = slot('kernel (lanes, used, ...): the same after the motion')
restore_as_a_whole = slot('kernel (lanes, used, ...): the same of restitution')
sum_up = slot('kernel (lanes, near, ...): sums of what points have in common')
give_in_common = slot('kernel (lanes, constraints, ...): gives it to them')
sum_up_whole = slot('kernel (lanes, constraints, ...): sums of the points of whole manifolds')
give_as_a_whole = slot('kernel (lanes, constraints, ...): gives them their impulses')
solve_surfaces = slot('kernel (number_of_pass, ...): soft normals of surfaces')
relax_surfaces = slot('kernel (number_of_pass, ...): the same after the motion')
restore_surfaces = slot('kernel (number_of_pass, ...): the same of restitution')
visit_normals = slot('kernel (number, lanes, near, ...): soft normals, point by point')
visit_relaxing = slot('kernel (number, lanes, near, ...): the same after the motion')
update_points = slot('kernel (lanes, constraints, points, scratch): update separation and arms')
update_normals = slot('kernel (lanes, constraints, points, scratch): the same without friction')


@inline
def _lanes(number: int, lanes_at_once: int, batches: Indices) -> Any:
    """Lanes of a batch: in use, and to visit."""
    used = batches[number * batch_record.SIZE + batch_record.LANE_COUNT]
    return used, lanes_at_once


@inline
def _points(number: int, batches: Indices) -> Any:
    """Points of each manifold of a batch: how many, and where the first begins in the rows."""
    batch = number * batch_record.SIZE
    first = batches[batch + batch_record.BEGIN] + constraint.SIZE
    return batches[batch + batch_record.POINT_COUNT], first


@inline
def _goes_on(
    number: int, used: int, number_of_pass: int, constraints: Array, batches: Indices
) -> bool:
    """Tell whether a batch is visited in a pass after the first."""
    kind = batches[number * batch_record.SIZE + batch_record.KIND]
    if kind == batch_record.BALLS and BALL_PASSES <= number_of_pass < PASSES:
        return False
    return solve.any_unsettled(used, constraints)


@inline
def _is_curved(number: int, batches: Indices) -> bool:
    """Tell whether a batch is one of layers about cores that meet at one point."""
    return batches[number * batch_record.SIZE + batch_record.KIND] == batch_record.CURVED and (
        batches[number * batch_record.SIZE + batch_record.POINT_COUNT] == 1
    )


@inline
def _is_whole(number: int, batches: Indices) -> bool:
    """Tell whether a batch is one of manifolds that are solved as a whole."""
    return batches[number * batch_record.SIZE + batch_record.KIND] == batch_record.WHOLE


@inline
def _point_and_cores(first: int, width: int, rows: Array) -> Any:
    """Rows of the point of a batch of curved pairs, and of its cores: `core_pair`."""
    end = first + width
    return rows[first:end], rows[end : end + core_pair.SIZE]


@inline
def _face(first: int, width: int) -> Any:
    """Where the friction of a batch of several points begins and ends: see `friction_patch`."""
    begin = first + MOST * width
    return begin, begin + friction_patch.SIZE


def _all_in_common(
    lanes: int, used: int, near: int, constraints: Array, points: Array, scratch: Array,
    inverse_h: float, slop: float, cap: float,
) -> None:  # fmt: skip
    """
    Solve what the points of a batch have in common, once: where an impulse is clamped, visits of
    the points do the rest. To go on until none is takes a heap of hulls that crashes a third as
    much time again.

    near : points of each lane that are asked
    """
    sum_up(lanes, near, constraints, points, scratch, inverse_h, slop, cap)
    if common_impulse.any_stirs(used, scratch):
        give_in_common(lanes, constraints, points, scratch)


def _as_a_whole(
    lanes: int, used: int, constraints: Array, points: Array, scratch: Array, inverse_h: float,
    slop: float, cap: float,
) -> None:  # fmt: skip
    """Solve the normals of whole manifolds: `whole_manifold`."""
    whole_manifold.begin(lanes, WIDTH, points, scratch)
    for _ in range(whole_manifold.ROUNDS):
        sum_up_whole(lanes, constraints, points, scratch, inverse_h, slop, cap)
        if not whole_manifold.any_stirs(used, scratch):
            break
        give_as_a_whole(lanes, constraints, points, scratch)
        if not whole_manifold.any_stirs(used, scratch):
            break


@kernel
def _start_patch(
    lanes: int, point_count: int, first: int, width: int, rows: Array, scratch: Array
) -> None:
    """Start the friction of a batch of several points from what its points recall."""
    begin, end = _face(first, width)
    patch = rows[begin:end]
    constraints = rows[first - constraint.SIZE : first]
    patch_friction.clear_center(lanes, patch)
    patch_friction.clear_wrench(lanes, patch)
    patch_friction.clear_moments(lanes, scratch)
    for point in range(point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        patch_friction.add_press(lanes, points, scratch)
    for point in range(point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        weight = begin + friction_patch.WEIGHTS + point * constraint.LANES
        weights = rows[weight : weight + constraint.LANES]
        patch_friction.weigh(lanes, weights, points, scratch)
        patch_friction.add_to_center(lanes, weights, points, patch)
    for point in range(point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        patch_friction.take_recalled(lanes, constraints, points, patch)
    patch_friction.start_tick(lanes, constraints, patch, scratch)


@kernel
def _measure_patch(
    lanes: int, used: int, point_count: int, first: int, width: int, field: int, wrench: int,
    all_lanes: bool, rows: Array, scratch: Array,
) -> None:  # fmt: skip
    """Find size and steps of the friction of a batch from what presses: `patch_friction`."""
    begin, end = _face(first, width)
    patch = rows[begin:end]
    constraints = rows[first - constraint.SIZE : first]
    patch_friction.clear_moments(lanes, scratch)
    for point in range(point_count):
        points = rows[first + point * width : first + (point + 1) * width]
        patch_friction.add_moments(lanes, field, constraints, points, patch, scratch)
    if field == contact_point.NORMAL_IMPULSE and surface_friction.any_surface(scratch):
        surface_friction.add_moments_of_others(used, first, width, rows, patch, scratch)
    patch_friction.measure(lanes, wrench, all_lanes, patch, scratch)


@inline
def _measure_anew(
    lanes: int, used: int, near: int, first: int, width: int, rows: Array, scratch: Array
) -> None:
    """Find what presses on the patches of a batch, and measure those that are stale."""
    begin, end = _face(first, width)
    patch = rows[begin:end]
    if surface_friction.any_surface(scratch):
        surface_friction.add_press_of_others(used, width, rows, patch, scratch)
    if patch_friction.any_stale(used, patch, scratch):
        _measure_patch(
            lanes, used, near, first, width, contact_point.NORMAL_IMPULSE,
            friction_patch.IMPULSE_1, False, rows, scratch,
        )  # fmt: skip


def _prepare(
    lanes_at_once: int, count: int, threshold: float, rows: Array, scratch: Array,
    batches: Indices, bodies: Array,
) -> None:  # fmt: skip
    """
    Find effective masses and velocities of approach, and the warm start that the last tick left.

        count     : batches
        threshold : [m/s] slower impacts do not bounce
    """
    for number in range(count):
        used, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        constraints = rows[first - constraint.SIZE : first]
        begin, end = _face(first, WIDTH)
        patch = rows[begin:end]
        warm_start.clear(lanes, scratch)
        if PATCHES and point_count > 1:
            _start_patch(lanes, point_count, first, WIDTH, rows, scratch)
        for point in range(point_count):
            points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
            warm_start.start_tick(lanes, constraints, points, scratch)
            if ANGULAR:
                warm_start.start_tick_angular(lanes, constraints, points, scratch)
        points = rows[first:end]
        near = far_points.points_to_visit(used, point_count, WIDTH, ANGULAR, constraints, points)
        batches[number * batch_record.SIZE + batch_record.NEAR_COUNT] = near
        far_points.begin(lanes, used, near, point_count, first, WIDTH, rows)
        warm_start.scatter(solver_bodies.WARM_IMPULSE, constraints, scratch, bodies)
        solve.gather_inverse_masses(constraints, bodies)
        solve.find_shares_left_alone(used, point_count, constraints)
        solve.gather_momenta(lanes, constraints, scratch, bodies)
        for point in range(point_count):
            points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
            prepare.effective_masses(lanes, constraints, points)
        if PATCHES and _is_whole(number, batches):
            points = rows[first : first + MOST * WIDTH]
            face_spring.find_masses(lanes, WIDTH, constraints, points)
            face_spring.keep_for_blows(used, WIDTH, constraints, points, bodies)
        if PATCHES and point_count > 1:
            patch_friction.find_rates(lanes, constraints, patch)
            _measure_patch(
                lanes, used, point_count, first, WIDTH, contact_point.NORMAL_IMPULSE,
                friction_patch.IMPULSE_1, True, rows, scratch,
            )  # fmt: skip
        if ANGULAR:
            prepare.angular_effective_masses(lanes, constraints)
        if BOUNCES:
            approach.gather_accelerations(used, constraints, scratch, bodies)
            if CURVED and _is_curved(number, batches):
                _, cores = _point_and_cores(first, WIDTH, rows)
                curved_cores.gather_lines(lanes, constraints, cores, scratch)
            else:
                curved_cores.clear_lines(lanes, scratch)
            for point in range(point_count):
                points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
                approach.approach_velocities(lanes, threshold, constraints, points, scratch)


def _visit_normals(
    number: int, lanes: int, near: int, inverse_h: float, slop: float, cap: float, rows: Array,
    scratch: Array, batches: Indices,
) -> None:  # fmt: skip
    """Solve the soft normals of the points of a batch, one after the other; near: asked so far."""
    point_count, first = _points(number, batches)
    constraints = rows[first - constraint.SIZE : first]
    if PATCHES and (_is_whole(number, batches) or surface_chain.any_whole(scratch)):
        count = MOST if point_count > 1 else 1
        points = rows[first : first + count * WIDTH]
        face_spring.find_impulses(lanes, count, WIDTH, RIMS, constraints, points, scratch)
    point = 0
    while point < near:
        points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
        if PATCHES and point_count > 1:
            solve_normal(lanes, constraints, points, scratch, inverse_h, slop, cap)
        else:
            solve_point(lanes, constraints, points, scratch, inverse_h, slop, cap)
        if ANGULAR:
            rolling_friction.limit(lanes, constraints, points, scratch)
        point += 1
        if point == near:
            near = far_points.points_asked(
                number, lanes, inverse_h, TURNS, constraints, scratch, batches
            )


def _solve_normals(
    lanes_at_once: int, count: int, inverse_h: float, slop: float, cap: float, number_of_pass: int,
    rest: float, step: float, rows: Array, scratch: Array, batches: Indices, bodies: Array,
) -> bool:  # fmt: skip
    """
    Solve the soft normals of all batches, before the motion; tell whether something has changed.

    number_of_pass : of the first, 0: visit all; else those in which the last pass has changed
                     something, of balls only BALL_PASSES times
    rest : [m/s] change of a velocity that is left alone
    step : [-] see `solve.gather_unsettled`; of passes after the first
    """
    any_changed = False
    surfaces = SURFACES and surface_chain.any_whole(scratch)
    if SURFACES and surfaces:
        solve_surfaces(number_of_pass, inverse_h, slop, cap, rows, scratch, bodies)
    for number in range(count):
        used, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        constraints = rows[first - constraint.SIZE : first]
        if number_of_pass > 0 and not _goes_on(number, used, number_of_pass, constraints, batches):
            continue
        if number_of_pass == 0:
            solve.gather_momenta(lanes, constraints, scratch, bodies)
        else:
            solve.gather_unsettled(lanes, step, constraints, scratch, bodies)
        near = far_points.points_asked(
            number, lanes, inverse_h, TURNS, constraints, scratch, batches
        )
        if near == 0:
            solve.leave_settled(used, constraints)
            continue
        is_whole = PATCHES and _is_whole(number, batches)
        points = rows[first : first + MOST * WIDTH]
        if PATCHES and near > 1 and not is_whole:
            solve_all_in_common(
                lanes, used, near, constraints, points, scratch, inverse_h, slop, cap
            )
        if BENDS:
            bends.find_bends(lanes, TURNS, LAYERED, inverse_h, constraints, scratch)
        if RIMS:
            rolling_frame.find_bends(used, inverse_h, constraints, scratch, bodies)
        if is_whole:
            solve_as_a_whole(lanes, used, constraints, points, scratch, inverse_h, slop, cap)
            near = far_points.points_pressed(number, near, used, WIDTH, points, batches)
            whole_manifold.rest(lanes, WIDTH, False, constraints, points, scratch)
        if is_whole and not whole_manifold.any_active(lanes, scratch):
            far_points.points_asked(number, lanes, inverse_h, TURNS, constraints, scratch, batches)
            whole_manifold.note_presses(lanes, WIDTH, points, scratch)
        else:
            visit_normals(number, lanes, near, inverse_h, slop, cap, rows, scratch, batches)
        if is_whole:
            whole_manifold.resume(lanes, scratch)
        if surfaces:
            whole_surface.note_changes(lanes, constraints, scratch)
        if PATCHES and point_count > 1:
            begin, end = _face(first, WIDTH)
            patch = rows[begin:end]
            if patch_friction.any_lets_go(used, patch, scratch):
                patch_friction.take_back(lanes, constraints, patch, scratch)
        points = rows[first : first + WIDTH]
        any_changed = solve.mark_unsettled(used, rest, constraints, points, scratch) or any_changed
        solve.scatter_momenta(constraints, scratch, bodies)
        solve.mark_carried(used, constraints, scratch, bodies)
    return any_changed


def _update_separation(
    lanes_at_once: int, count: int, rows: Array, scratch: Array, batches: Indices, bodies: Array
) -> None:
    """
    Move points, arms and separations of all batches with the bodies; give the second half of the
    warm start.
    """
    for number in range(count):
        used, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        constraints = rows[first - constraint.SIZE : first]
        if TURNS:
            solve.gather_inverse_masses(constraints, bodies)
        warm_start.clear(lanes, scratch)
        separation.gather_motion(constraints, scratch, bodies)
        if batches[number * batch_record.SIZE + batch_record.KIND] == batch_record.BALLS:
            points = rows[first : first + WIDTH]
            separation.update_balls(lanes, constraints, points, scratch)
            if ANGULAR:
                rolling_friction.apply_second_half(lanes, constraints, points, scratch)
        elif CURVED and _is_curved(number, batches):
            points, cores = _point_and_cores(first, WIDTH, rows)
            curved_cores.update_cores(lanes, constraints, points, cores, scratch)
            if ANGULAR:
                rolling_friction.apply_second_half(lanes, constraints, points, scratch)
        else:
            if RIMS:
                rolling_frame.turn_rims(used, constraints, scratch, bodies)
            begin, end = _face(first, WIDTH)
            patch = rows[begin:end]
            several = PATCHES and point_count > 1
            if several:
                patch_friction.clear_center(lanes, patch)
            for point in range(point_count):
                points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
                if several:
                    update_normals(lanes, constraints, points, scratch)
                    weight = begin + friction_patch.WEIGHTS + point * constraint.LANES
                    weights = rows[weight : weight + constraint.LANES]
                    patch_friction.add_to_center(lanes, weights, points, patch)
                else:
                    update_points(lanes, constraints, points, scratch)
                if ANGULAR:
                    rolling_friction.apply_second_half(lanes, constraints, points, scratch)
            if several:
                patch_friction.apply_second_half(lanes, constraints, patch, scratch)
        near = batches[number * batch_record.SIZE + batch_record.NEAR_COUNT]
        far_points.follow(lanes, used, near, point_count, first, WIDTH, rows)
        warm_start.scatter(solver_bodies.MOMENTUM, constraints, scratch, bodies)


def _visit_relaxing(
    number: int, lanes: int, near: int, inverse_h: float, rows: Array, scratch: Array,
    batches: Indices,
) -> Any:  # fmt: skip
    """
    Relax the points of a batch, one after the other; near: asked so far. Return how many were.
    """
    point_count, first = _points(number, batches)
    constraints = rows[first - constraint.SIZE : first]
    point = 0
    while point < near:
        points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
        if PATCHES and point_count > 1:
            relax_normal(lanes, constraints, points, scratch, inverse_h)
        else:
            relax_point(lanes, constraints, points, scratch, inverse_h)
        if ANGULAR:
            rolling_friction.solve(lanes, constraints, points, scratch)
        point += 1
        if point == near:
            near = far_points.points_asked(
                number, lanes, inverse_h, TURNS, constraints, scratch, batches
            )
    return near


def _relax(
    lanes_at_once: int, count: int, inverse_h: float, number_of_pass: int, rest: float,
    step: float, rows: Array, scratch: Array, batches: Indices, bodies: Array,
) -> bool:  # fmt: skip
    """
    Relax normals and friction of all batches, after the motion; tell whether it has changed
    something.

    number_of_pass : of the first, 0: visit all; else those in which the last pass has changed
                     something, of balls only BALL_PASSES times
    rest : [m/s] change of a velocity that is left alone
    step : [-] see `solve.gather_unsettled`; of passes after the first
    """
    any_changed = False
    surfaces = SURFACES and surface_chain.any_whole(scratch)
    if SURFACES and surfaces:
        relax_surfaces(number_of_pass, inverse_h, 0.0, 0.0, rows, scratch, bodies)
    for number in range(count):
        used, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        constraints = rows[first - constraint.SIZE : first]
        if number_of_pass > 0 and not _goes_on(number, used, number_of_pass, constraints, batches):
            continue
        if number_of_pass == 0:
            solve.gather_momenta(lanes, constraints, scratch, bodies)
        else:
            solve.gather_unsettled(lanes, step, constraints, scratch, bodies)
        begin, end = _face(first, WIDTH)
        patch = rows[begin:end]
        several = PATCHES and point_count > 1
        near = far_points.points_asked(
            number, lanes, inverse_h, TURNS, constraints, scratch, batches
        )
        if near == 0:
            solve.leave_settled(used, constraints)
            continue
        is_whole = several and _is_whole(number, batches)
        points = rows[first : first + MOST * WIDTH]
        if several and near > 1 and not is_whole:
            relax_all_in_common(
                lanes, used, near, constraints, points, scratch, inverse_h, 0.0, 0.0
            )
        for _ in range(STARTING_ITERATIONS if several else 1):
            if several:
                patch_friction.find_slide(lanes, constraints, patch, scratch)
            if is_whole:
                points = rows[first : first + MOST * WIDTH]
                relax_as_a_whole(lanes, used, constraints, points, scratch, inverse_h, 0.0, 0.0)
                near = far_points.points_pressed(number, near, used, WIDTH, points, batches)
                whole_manifold.rest(lanes, WIDTH, True, constraints, points, scratch)
            if is_whole and not whole_manifold.any_active(lanes, scratch):
                near = far_points.points_asked(
                    number, lanes, inverse_h, TURNS, constraints, scratch, batches
                )
                whole_manifold.add_press(lanes, WIDTH, points, scratch)
            else:
                near = visit_relaxing(number, lanes, near, inverse_h, rows, scratch, batches)
            if is_whole:
                whole_manifold.resume(lanes, scratch)
            if several:
                _measure_anew(lanes, used, near, first, WIDTH, rows, scratch)
                relax_friction(lanes, constraints, patch, scratch)
                if not patch_friction.any_starts(used, scratch):
                    break
        if surfaces:
            whole_surface.note_changes(lanes, constraints, scratch)
        points = rows[first : first + WIDTH]
        any_changed = solve.mark_unsettled(used, rest, constraints, points, scratch) or any_changed
        solve.mark_touched(used, constraints)
        solve.scatter_momenta(constraints, scratch, bodies)
    return any_changed


def _start_substep(
    lanes_at_once: int, count: int, rows: Array, scratch: Array, batches: Indices, bodies: Array
) -> None:
    """Add up the warm start of the next substep."""
    if SURFACES:
        surface_chain.note_lasting_shares(WIDTH, rows, scratch)
    for number in range(count):
        _, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        near = batches[number * batch_record.SIZE + batch_record.NEAR_COUNT]
        if near == 0:
            continue
        constraints = rows[first - constraint.SIZE : first]
        warm_start.clear(lanes, scratch)
        if PATCHES and point_count > 1:
            patch_friction.clear_moments(lanes, scratch)
        if PATCHES and _is_whole(number, batches):
            points = rows[first : first + MOST * WIDTH]
            face_spring.find_lasting_shares(lanes, WIDTH, constraints, points)
        points = rows[first : first + point_count * WIDTH]
        warm_start.find_shares_that_go_on(lanes, near, WIDTH, constraints, points)
        for point in range(near):
            points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
            if PATCHES and point_count > 1:
                start_normal(lanes, constraints, points, scratch)
            else:
                start_point(lanes, constraints, points, scratch)
            if ANGULAR:
                warm_start.start_substep_angular(lanes, constraints, points, scratch)
        if PATCHES and point_count > 1:
            begin, end = _face(first, WIDTH)
            patch = rows[begin:end]
            patch_friction.start_substep(lanes, constraints, patch, scratch)
        warm_start.scatter(solver_bodies.WARM_IMPULSE, constraints, scratch, bodies)


def _apply_restitution(
    lanes_at_once: int, count: int, rows: Array, scratch: Array, batches: Indices, bodies: Array
) -> None:
    """Apply restitution to all batches until nothing changes, or to the last what holds."""
    change = 0.0
    for _ in range(RESTITUTION_ITERATIONS):
        change = 0.0
        if SURFACES:
            restore_surfaces(0, 0.0, 0.0, 0.0, rows, scratch, bodies)
        for number in range(count):
            used, lanes = _lanes(number, lanes_at_once, batches)
            point_count, first = _points(number, batches)
            constraints = rows[first - constraint.SIZE : first]
            solve.gather_momenta(lanes, constraints, scratch, bodies)
            if PATCHES and point_count > 1:
                points = rows[first : first + MOST * WIDTH]
                if _is_whole(number, batches):
                    restore_as_a_whole(lanes, used, constraints, points, scratch, 0.0, 0.0, 0.0)
                else:
                    restore_all_in_common(
                        lanes, used, point_count, constraints, points, scratch, 0.0, 0.0, 0.0
                    )
            for point in range(point_count):
                points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
                if PATCHES and point_count > 1:
                    restore_normal(lanes, constraints, points, scratch)
                else:
                    restore_point(lanes, constraints, points, scratch)
            if PATCHES and point_count > 1:
                begin, end = _face(first, WIDTH)
                patch = rows[begin:end]
                _measure_patch(
                    lanes, used, point_count, first, WIDTH, contact_point.RESTITUTION_NORMAL,
                    friction_patch.RESTITUTION_1, True, rows, scratch,
                )  # fmt: skip
                patch_friction.apply_restitution(lanes, constraints, patch, scratch)
            if SURFACES:
                whole_surface.note_changes(lanes, constraints, scratch)
            solve.scatter_momenta(constraints, scratch, bodies)
            for lane in range(used):
                change = max(change, scratch[lane_scratch.LARGEST_CHANGE + lane])
        if not change > 0.0:
            break
    if change > 0.0:
        _hold(lanes_at_once, count, WIDTH, rows, scratch, batches, bodies)


@kernel
def _hold(
    lanes_at_once: int, count: int, width: int, rows: Array, scratch: Array, batches: Indices,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Let what does not bounce hold, see `restitution`: at single points, for one point of a face
    after the other would turn what is flat.
    """
    for _ in range(RESTITUTION_ITERATIONS):
        change = 0.0
        for number in range(count):
            used, lanes = _lanes(number, lanes_at_once, batches)
            point_count, first = _points(number, batches)
            if point_count > 1:
                continue
            constraints = rows[first - constraint.SIZE : first]
            solve.gather_momenta(lanes, constraints, scratch, bodies)
            restitution.hold(lanes, constraints, rows[first : first + width], scratch)
            solve.scatter_momenta(constraints, scratch, bodies)
            for lane in range(used):
                change = max(change, scratch[lane_scratch.LARGEST_CHANGE + lane])
        if not change > 0.0:
            break


def _without_patches(
    _lanes_at_once: int, _count: int, _rows: Array, _scratch: Array, _batches: Indices
) -> None:
    """Stand for the friction of patches where nothing touches at several points."""


def _spread_friction(
    lanes_at_once: int, count: int, rows: Array, scratch: Array, batches: Indices
) -> None:
    """Let the points of all batches have their parts of the friction of their patches."""
    for number in range(count):
        _, lanes = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        if point_count == 1:
            continue
        constraints = rows[first - constraint.SIZE : first]
        begin, end = _face(first, WIDTH)
        patch = rows[begin:end]
        patch_friction.clear_moments(lanes, scratch)
        for field in (contact_point.TOTAL_IMPULSE, contact_point.NORMAL_IMPULSE):
            for point in range(point_count):
                points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
                patch_friction.add_moments(lanes, field, constraints, points, patch, scratch)
        for point in range(point_count):
            points = rows[first + point * WIDTH : first + (point + 1) * WIDTH]
            patch_friction.spread(lanes, constraints, points, patch, scratch)
    if not surface_friction.any_surface(scratch):
        return
    for number in range(count):
        used, _ = _lanes(number, lanes_at_once, batches)
        point_count, first = _points(number, batches)
        if point_count > 1:
            surface_friction.spread(used, first, WIDTH, rows)


def solver(
    *, width: int, angular: bool, bounces: bool, turns: bool, arcs: bool, on_rims: bool,
    layered: bool, patches: bool, surfaces: bool, curved: bool,
) -> dict[str, Any]:  # fmt: skip
    """
    Make the passes of a scene, by name.

        width    : numbers of a point
        angular  : whether anything rolls or twists with friction
        bounces  : whether anything bounces
        turns    : whether some inertia changes with the attitude: not of balls and cubes alone
        arcs     : whether anything turns but balls about their centres: `bends`
        on_rims  : whether a cylinder may touch: `rolling_frame`
        layered  : whether anything is a ball or a capsule
        patches  : whether anything may touch at several points
        surfaces : whether a body may touch another with several manifolds
        curved   : whether layers about cores may meet: `curved_cores`
    """
    offered = {
        'WIDTH': width,
        'ANGULAR': angular,
        'BOUNCES': bounces,
        'TURNS': turns,
        'RIMS': on_rims,
        'PATCHES': patches,
        'SURFACES': surfaces,
        'CURVED': curved,
        'BENDS': arcs,
        'LAYERED': layered,
    }
    for rubs, kind in ((True, 'point'), (False, 'normal')):
        solve_one, relax_one = solve.visits(
            rubs=rubs, on_rims=on_rims, turns=turns, arcs=arcs, layered=layered
        )
        offered |= {
            f'solve_{kind}': solve_one,
            f'relax_{kind}': relax_one,
            f'start_{kind}': warm_start.substep_starter(rubs=rubs),
            f'update_{kind}s': separation.update_kernel(layered=layered, rubs=rubs),
            f'restore_{kind}': restitution.visit(rubs=rubs),
        }
    for kind in ('solve', 'relax', 'restore'):
        sums, gives = common_impulse.visit(kind, width, turns=turns)
        offered[f'{kind}_all_in_common'] = specialise(
            _all_in_common, name=f'{kind}_{width}', sum_up=sums, give_in_common=gives,
        )  # fmt: skip
        sums, gives = whole_manifold.visit(
            kind, width, turns=turns, arcs=arcs, layered=layered, on_rims=on_rims
        )
        offered[f'{kind}_surfaces'] = whole_surface.visit(
            kind, width, turns=turns, arcs=arcs, layered=layered, on_rims=on_rims
        )
        offered[f'{kind}_as_a_whole'] = specialise(
            _as_a_whole, name=f'{kind}_{width}', sum_up_whole=sums, give_as_a_whole=gives,
            WIDTH=width,
        )  # fmt: skip
    offered['relax_friction'] = patch_friction.relaxation(turns=turns)
    for slot_name, source in {
        'visit_normals': _visit_normals,
        'visit_relaxing': _visit_relaxing,
    }.items():
        offered[slot_name] = specialise(source, name=f'{width}', inlined=True, offered=offered)
    passes = {
        'prepare': _prepare,
        'solve_normals': _solve_normals,
        'update_separation': _update_separation,
        'relax': _relax,
        'start_substep': _start_substep,
    }
    if bounces:
        passes['apply_restitution'] = _apply_restitution
    passes['spread_friction'] = _spread_friction if patches else _without_patches
    return {
        name: specialise(source, name=f'{width}', offered=offered)
        for name, source in passes.items()
    }
