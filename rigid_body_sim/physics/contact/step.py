# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Whole ticks with contact: detect once, then substeps of kick, push, drift, relax; then bounce.

    poses, pairs, manifolds, rows; if a list is too short, return: nothing has changed yet
    each substep h:
        p += h/2 F, L += h/2 torque, and half the loads: the contact impulses of the last substep,
                but for what was a blow
        push:   soft normals of all contacts, which do not pull
        drift:  x += h v, q by the drift of the integrator, L fixed; world inertia, omega from L
        p += h/2 F, L += h/2 torque
        follow: points, arms and gaps follow the bodies; the other half of the loads, there
        relax:  normals without push-out, and friction
    bounce, which returns no more energy than the impact took
    take back the energy that a group of bodies has gained

Where islands may sleep, sleepers are left out (`sleeping`): who wakes is known before anything has
changed, who falls asleep at the end of a tick; both return, for memories to be put in order.

So all that acts, acts in two halves about the motion: what is carried, slides or pivots moves to
second order, as what flies does (velocity Verlet). Whom no contact carries moves as without
contact. Force elements are evaluated after each drift: those of then act for the second half.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.compile.kernels import kernel, specialise, unbound
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    collider,
    manifold_record,
    narrow_phase,
    neighbour_list,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.energy import (
    account,
    attribution,
    projection,
    restitution_bound,
)
from rigid_body_sim.physics.contact.solver import (
    cache_record,
    colouring,
    constraint,
    forces_of_state,
    impulse_cache,
    manifold_constraints,
)
from rigid_body_sim.physics.integration.schemes.steps import (
    finite,
    kick,
    kick_and_drift,
    kick_rotation,
    start_evaluation,
)

# settings: numbers of the scene
SUBSTEPS, ZETA, RELAXATIONS, THRESHOLD, SLOP, CAP, MARGIN, RADIUS = range(8)
SETTINGS = 8

# counts: sizes and what is given back
N_COLLIDERS, PLANES, PAIR_ROOM, MANIFOLD_ROOM, ROW_ROOM, BATCH_ROOM, MEMORY_ROOM = range(7)
LANES_AT_ONCE = 7
DONE, PAIRS, MANIFOLDS, BATCHES, SHORT, PIECES, CUT = 8, 9, 10, 11, 12, 13, 14
ASSEMBLED = 15  # 1: batches and rows are those of the manifolds in memory
STALE = 16  # 1: other bodies sleep than in the last call
COUNTS = 17
NOTHING_SHORT, SHORT_OF_PAIRS, SHORT_OF_MANIFOLDS, SHORT_OF_ROWS, SHORT_OF_MEMORY = range(5)
TOO_LONG = 5  # the tick should be cut into counts[PIECES]; counts[CUT]: it has been
WOKEN, FELL_ASLEEP = 6, 7  # sleepers that are marked wake before the tick; some fell asleep in it

# bound for each scene by `specialise`
WIDTH = 144
ANGULAR = False
BOUNCES = False
COUPLED = False
VELOCITY_DEPENDENT = False
SLEEPING = False
FLOWS = False
drift_rotation: Callable[..., Any] = unbound
evaluate: Callable[..., Any] = unbound
find_manifolds: Callable[..., Any] = unbound
prepare: Callable[..., Any] = unbound
solve_normals: Callable[..., Any] = unbound
update_separation: Callable[..., Any] = unbound
relax: Callable[..., Any] = unbound
apply_restitution: Callable[..., Any] = unbound
asleep: Callable[..., Any] = unbound
scale_to_present_mass: Callable[..., Any] = unbound
scale_warm_start: Callable[..., Any] = unbound
keep_still: Callable[..., Any] = unbound
lay_down: Callable[..., Any] = unbound
scale_to_start_mass: Callable[..., Any] = unbound
note_wrenches: Callable[..., Any] = unbound
reached: Callable[..., Any] = unbound
settle: Callable[..., Any] = unbound
stir: Callable[..., Any] = unbound
stirs: Callable[..., Any] = unbound
find_mass_scale: Callable[..., Any] = unbound


@kernel
def _mark_touching(manifolds, n_moving, records, rows, touching, marks):
    """List the bodies that some manifold names, in the order of the core; return how many."""
    for i in range(n_moving + 1):
        marks[i] = 0
    for m in range(manifolds):
        place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
        marks[int(rows[place + constraint.BODY_A]) // solver_bodies.SIZE] = 1
        marks[int(rows[place + constraint.BODY_B]) // solver_bodies.SIZE] = 1
    count = 0
    for i in range(n_moving):
        if marks[i] == 1:
            touching[count] = i
            count += 1
    return count


def _advance(
    ticks, tick, h, n_bodies, n_rigid, translation, rotation, method, workspace, elements, ranges,
    settings, counts, numbers, table, bounds, mounts, materials, poses, reaches, found, bodies,
    rows, records, memory, rooms, grid, heads, kept, keys, batches, colours, open_batches,
    touching, marks, groups, accounts, slumber, limits, ward, flows,
):  # fmt: skip
    """
    Advance over ticks. Return 0, or NaN if a number left the finite ones; counts[DONE] tells how
    many ticks were done, counts[SHORT] which list was too short for the next.
    """
    n = counts[N_COLLIDERS]
    lanes_at_once = counts[LANES_AT_ONCE]
    substeps = int(settings[SUBSTEPS])
    relaxations = int(settings[RELAXATIONS])
    part = h / substeps
    half = 0.5 * part
    counts[DONE] = 0
    counts[SHORT] = NOTHING_SHORT
    status = finite(n_bodies, n_rigid, translation, rotation)
    fresh = False
    colliders = collider.ColliderArrays(numbers, table, bounds, poses, reaches)
    broad_phase = collider.BroadPhase(rooms, grid, heads, kept, keys)
    if SLEEPING and counts[STALE] == 1:
        counts[STALE] = 0
        kept[neighbour_list.AGE] = 0
        lay_down(
            n, n_bodies, n_rigid, translation, rotation, table, mounts, poses, reaches, bodies,
            slumber,
        )  # fmt: skip
    for passed in range(ticks):
        if not status == 0.0:
            return status
        if COUPLED and not fresh:
            start_evaluation(n_bodies, n_rigid, translation, rotation)
            evaluate(0, (tick + passed) * h, translation, rotation, elements, ranges)
            fresh = not VELOCITY_DEPENDENT
        if SLEEPING:
            awake = stir(n_bodies, n_rigid, translation, rotation, slumber, ward)
            if awake < 0:
                counts[SHORT] = WOKEN
                return 0.0
            if awake == 0:
                counts[MANIFOLDS] = 0
                counts[DONE] = passed + 1
                continue
        for i in range(n_bodies):
            if SLEEPING and asleep(i, slumber):
                continue
            solver_bodies.begin_tick(i, n_rigid, translation, rotation, bodies)
            if BOUNCES:
                solver_bodies.find_free_acceleration(i, n_rigid, rotation, bodies)
        for entry in range(solver_bodies.SIZE):
            bodies[n_bodies * solver_bodies.SIZE + entry] = 0.0
        narrow_phase.find_poses(n, n_rigid, translation, rotation, table, mounts, poses)
        swept_aabbs.find_swept_aabbs(n, h, settings[MARGIN], colliders, bodies)
        pairs = neighbour_list.find_pairs(
            n, counts[PLANES], h, settings[RADIUS], counts[PAIR_ROOM], colliders, broad_phase
        )  # fmt: skip
        counts[PAIRS] = pairs
        if pairs > counts[PAIR_ROOM]:
            counts[SHORT] = SHORT_OF_PAIRS
            return 0.0
        manifolds = find_manifolds(
            pairs, n, h, counts[MANIFOLD_ROOM], colliders, keys, found, records, bodies,
            counts[PIECES : PIECES + 1],
        )  # fmt: skip
        counts[MANIFOLDS] = manifolds
        if manifolds > counts[MANIFOLD_ROOM]:
            counts[SHORT] = SHORT_OF_MANIFOLDS
            return 0.0
        if SLEEPING and reached(manifolds, h, table, reaches, records, slumber):
            counts[SHORT] = WOKEN
            return 0.0
        if counts[PIECES] > 1 and counts[CUT] == 0:
            counts[SHORT] = TOO_LONG
            return 0.0
        if (
            cache_record.HEAD
            + manifolds * (cache_record.MANIFOLD_HEAD + manifold.MOST * cache_record.POINT_SIZE)
            > counts[MEMORY_ROOM]
        ):
            counts[SHORT] = SHORT_OF_MEMORY
            return 0.0
        if counts[ASSEMBLED] == 0 or not impulse_cache.holds_same_manifolds(
            manifolds, records, memory
        ):
            counts[BATCHES] = colouring.colour_constraints(
                manifolds, n_bodies, WIDTH, counts[ROW_ROOM], counts[BATCH_ROOM], table, records,
                bodies, colours, open_batches, rows, batches,
            )  # fmt: skip
            counts[ASSEMBLED] = 0
            if counts[BATCHES] < 0:
                counts[SHORT] = SHORT_OF_ROWS
                return 0.0
        count = counts[BATCHES]
        if counts[ASSEMBLED] == 0 or memory[cache_record.SUBSTEP] != part:
            manifold_constraints.prepare_materials(
                manifolds,
                part,
                max(1, counts[CUT]),
                settings[ZETA],
                table,
                bounds,
                materials,
                records,
                rows,
                bodies,
            )
            counts[ASSEMBLED] = 1
        manifold_constraints.prepare_points(
            manifolds, WIDTH, translation, table, poses, records, rows
        )
        impulse_cache.recall(manifolds, WIDTH, part, ANGULAR, bounds, poses, records, memory, rows)
        if FLOWS:
            find_mass_scale((tick + passed) * h + 0.5 * h, flows)
            scale_to_present_mass(flows, bodies)
        prepare(lanes_at_once, count, settings[THRESHOLD], rows, batches, bodies)
        if FLOWS:
            scale_to_start_mass(flows, bodies)
            scale_warm_start(flows, bodies)
        touched = _mark_touching(manifolds, n_bodies, records, rows, touching, marks)
        for i in range(touched):
            account.begin(touching[i], bodies)
            if not COUPLED:
                account.add_half_the_torque(touching[i], n_rigid, h, rotation, bodies)
        for sub in range(substeps):
            if COUPLED and not fresh:
                time = (tick + passed) * h + sub * part
                start_evaluation(n_bodies, n_rigid, translation, rotation)
                evaluate(0, time, translation, rotation, elements, ranges)
            for i in range(touched):
                solver_bodies.kick_and_warm_start(
                    touching[i], n_rigid, part, translation, rotation, bodies
                )
            if FLOWS:
                scale_to_present_mass(flows, bodies)
            solve_normals(
                lanes_at_once,
                count,
                1.0 / part,
                settings[SLOP],
                settings[CAP],
                rows,
                batches,
                bodies,
            )
            if FLOWS:
                scale_to_start_mass(flows, bodies)
            for block in range((n_bodies + 63) // 64):
                if SLEEPING and not stirs(block, n_bodies, ward):
                    continue
                lanes = min(64, n_bodies - 64 * block)
                kick_and_drift(block, lanes, half, part, translation)
                kick(block, lanes, half, translation)
            for i in range(touched):
                solver_bodies.scatter_angular_momentum(
                    touching[i], n_rigid, half, rotation, bodies
                )
            for block in range((n_rigid + 63) // 64):
                if SLEEPING and not stirs(block, n_bodies, ward):
                    continue
                lanes = min(64, n_rigid - 64 * block)
                drift_rotation(block, lanes, half, part, rotation, method)
                kick_rotation(block, lanes, half, rotation)
            for i in range(touched):
                solver_bodies.integrate_position(
                    touching[i], n_rigid, part, translation, rotation, bodies
                )
                if COUPLED:
                    account.add_half_the_work(
                        touching[i], n_rigid, part, translation, rotation, bodies
                    )
            if SLEEPING:
                keep_still(n_bodies, n_rigid, translation, rotation, bodies, ward)
            if COUPLED:
                if VELOCITY_DEPENDENT:
                    for i in range(touched):
                        forces_of_state.add_warm_start(
                            touching[i], n_rigid, 1.0, translation, rotation, bodies
                        )
                forces_of_state.save_wrenches(n_bodies, n_rigid, translation, rotation, workspace)
                time = (tick + passed) * h + (sub + 1) * part
                start_evaluation(n_bodies, n_rigid, translation, rotation)
                evaluate(0, time, translation, rotation, elements, ranges)
                forces_of_state.correct_momenta(
                    n_bodies, n_rigid, half, translation, rotation, workspace
                )
                if VELOCITY_DEPENDENT:
                    for i in range(touched):
                        forces_of_state.add_warm_start(
                            touching[i], n_rigid, -1.0, translation, rotation, bodies
                        )
                fresh = not VELOCITY_DEPENDENT
            for i in range(touched):
                if COUPLED:
                    account.add_half_the_work(
                        touching[i], n_rigid, part, translation, rotation, bodies
                    )
                solver_bodies.gather_body(touching[i], n_rigid, translation, rotation, bodies)
            for i in range(touched):
                solver_bodies.clear_warm_start(touching[i], bodies)
            if FLOWS:
                scale_to_present_mass(flows, bodies)
            update_separation(lanes_at_once, count, rows, batches, bodies)
            for turn in range(relaxations):
                last = turn + 1 == relaxations and sub + 1 < substeps
                relax(
                    lanes_at_once,
                    count,
                    1.0 / part,
                    turn == 0,
                    last,
                    rows,
                    batches,
                    bodies,
                )
            if FLOWS:
                scale_to_start_mass(flows, bodies)
                scale_warm_start(flows, bodies)
            for i in range(touched):
                solver_bodies.scatter_momenta(touching[i], n_rigid, translation, rotation, bodies)
                if not COUPLED and sub + 1 == substeps:
                    account.add_work(touching[i], translation, bodies)
                    account.add_half_the_torque(touching[i], n_rigid, h, rotation, bodies)
        if BOUNCES and count > 0:
            for i in range(touched):
                restitution_bound.before_bounce(touching[i], bodies)
            if FLOWS:
                scale_to_present_mass(flows, bodies)
            apply_restitution(lanes_at_once, count, rows, batches, bodies)
            if FLOWS:
                scale_to_start_mass(flows, bodies)
            restitution_bound.limit(
                manifolds, count, touched, n_bodies, WIDTH, touching, batches, records, rows,
                groups, accounts, bodies,
            )  # fmt: skip
            for i in range(touched):
                solver_bodies.scatter_momenta(touching[i], n_rigid, translation, rotation, bodies)
        if projection.take_back(
            count, touched, n_bodies, WIDTH, part, touching, batches, rows, groups, translation,
            accounts, bodies,
        ):  # fmt: skip
            hung = attribution.hang(
                manifolds, touched, n_bodies, touching, records, rows, groups, accounts
            )
            attribution.charge(hung, n_bodies, WIDTH, records, rows, accounts, bodies)
            for i in range(touched):
                solver_bodies.scatter_momenta(touching[i], n_rigid, translation, rotation, bodies)
        impulse_cache.store_impulses(manifolds, WIDTH, part, ANGULAR, poses, records, rows, memory)
        counts[DONE] = passed + 1
        status = finite(n_bodies, n_rigid, translation, rotation)
        if SLEEPING:
            fell = settle(
                counts[CUT] == 0, touched, manifolds, h, n_bodies, n_rigid, translation, rotation,
                table, reaches, records, memory, bodies, touching, slumber, limits, ward,
            )  # fmt: skip
            if fell > 0:
                if VELOCITY_DEPENDENT:
                    start_evaluation(n_bodies, n_rigid, translation, rotation)
                    evaluate(0, (tick + passed + 1) * h, translation, rotation, elements, ranges)
                note_wrenches(n_bodies, n_rigid, translation, rotation, slumber)
                counts[SHORT] = FELL_ASLEEP
                return status
    return status


def tick_kernel(name: str, **bindings: Any) -> Callable[..., Any]:
    """Make the kernel of one scene; `bindings` are the open names of this module."""
    return specialise(_advance, name=name, **bindings)
