# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What ends a tick: the impulses of balls that were followed, restitution and its bound, gains taken
back, what the next tick starts from, and who falls asleep.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import slot
from rigid_body_sim.physics.contact import (
    crew,
    prescribed_bodies,
    tick_counts,
    tick_settings,
    works_of_drives,
)
from rigid_body_sim.physics.contact.array_groups import Group
from rigid_body_sim.physics.contact.assembly import batch_count_of, constraints_of
from rigid_body_sim.physics.contact.energy import gain_bound, restitution_bound
from rigid_body_sim.physics.contact.islands import sleep, waiting
from rigid_body_sim.physics.contact.islands.bouncing import mark_bouncing
from rigid_body_sim.physics.contact.solver import (
    ball_impacts,
    group_record,
    impact_sequence,
    impulse_cache,
    lane_scratch,
    surface_chain,
    variable_mass,
)
from rigid_body_sim.physics.contact.substeps import scatter_momenta

WIDTH = slot('[-] numbers of a contact point')
ANGULAR = slot('[-] whether anything rolls or twists with friction')
BOUNCES = slot('[-] whether anything bounces')
BALLS_MEET = slot('[-] whether two balls may meet: `solver.ball_impacts`')
EVENTS = slot('[-] whether impacts come at their instants')
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
FLOWS = slot('[-] whether the mass of a body that touches changes')
DRIVES = slot('[-] whether some bodies are moved as told, or have a belt')
spread_friction = slot('kernel (lanes, batches, rows, ...): friction of patches to points')
apply_restitution = slot('kernel (lanes, batches, rows, ...): lets bounce what bounces')
evaluate_forces = slot('kernel (time, motion, forces)')
land = slot('kernel (h, flights): takes who was struck to the end of the tick')
find_works_of_drives = slot('kernel (when, ...): of driven bodies on others')
store_some_impulses = slot('kernel (substep, world): parts of the impulse cache')


def _bound_bounces(
    now, touching, motion, colliders, constraints, energy, bodies, flows, driven, counts
):  # fmt: skip
    """Apply restitution, and bound what it returns."""
    batch_count = counts[tick_counts.BATCHES]
    if not mark_bouncing(
        batch_count, motion.body_count, WIDTH, touching, constraints.batches, constraints.rows,
        energy.roots, constraints.colours,
    ):  # fmt: skip
        return
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    waiting.heed_friction(
        batch_count, WIDTH, now.substep, now.substeps, touching, constraints.batches,
        constraints.rows, bodies,
    )  # fmt: skip
    surface_chain.link(
        constraints.order[: counts[tick_counts.MANIFOLDS]], constraints.manifolds,
        constraints.rows, constraints.scratch,
    )  # fmt: skip
    restitution_bound.keep_momenta(touching, bodies)
    apply_restitution(
        counts[tick_counts.LANES], batch_count, constraints.rows, constraints.scratch,
        constraints.batches, bodies,
    )  # fmt: skip
    if DRIVES:
        find_works_of_drives(
            works_of_drives.BOUNCE, motion, driven, colliders, constraints, bodies, counts
        )
    restitution_bound.bound_restitution(
        counts[tick_counts.MANIFOLDS], batch_count, motion.body_count, WIDTH, touching,
        constraints, energy, driven.of_bodies, bodies,
    )  # fmt: skip
    if DRIVES:
        find_works_of_drives(
            works_of_drives.BOUNCE, motion, driven, colliders, constraints, bodies, counts
        )
        works_of_drives.add_works(touching, driven, bodies)
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
    scatter_momenta(Group(touching, False, motion), bodies)


def _give_impacts(motion, touching, constraints, bodies, flows, counts):
    """Give balls the impulses of impacts that were followed before the tick."""
    if not BALLS_MEET:
        return
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    found = impact_sequence.give(
        counts[tick_counts.BATCHES], constraints.batches, constraints.rows, bodies
    )
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
    if found:
        scatter_momenta(Group(touching, False, motion), bodies)


def _catch_up_balls(now, motion, constraints, bodies, flows, counts):
    """Take balls that met to where they would be at once; tell whether there are any."""
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    found = ball_impacts.catch_up(
        counts[tick_counts.BATCHES], WIDTH, now.substep, BOUNCES, motion, constraints.batches,
        constraints.rows, bodies,
    )  # fmt: skip
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
    return found


def _take_back_gains(
    h, touching, motion, constraints, energy, bodies, flows, driven, settings, counts
):  # fmt: skip
    """Take back what contact gave by its errors; tell whether anything was changed."""
    group = Group(touching, False, motion)
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    found = gain_bound.bound_gains(
        h, settings[tick_settings.WHOLE_TICK], counts[tick_counts.MANIFOLDS],
        counts[tick_counts.BATCHES], motion.body_count, WIDTH, group, constraints, energy,
        driven.works, bodies,
    )  # fmt: skip
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
    if found:
        scatter_momenta(group, bodies)
    return found


def _store_impulses(now, world):
    """Store what the next tick starts from; take who was struck to the end of this one."""
    if EVENTS:
        land(now.h, world.flights)
    constraints, parts = world.constraints, world.counts[tick_counts.GROUPS]
    impulse_cache.begin_cache(
        world.counts[tick_counts.MANIFOLDS], now.substep, constraints.manifolds,
        world.detection.records, constraints.places, constraints.impulse_cache,
    )  # fmt: skip
    crew.post(crew.IMPULSES, parts, world.crew)
    store_some_impulses(now.substep, world)
    crew.wait_for_parts(parts, world.crew)


def _store_some_impulses(substep, world):
    """Give the points of groups their friction and store their impulses, until none is left."""
    counts = world.counts
    part = crew.take(crew.IMPULSES, world.crew)
    while part != crew.NO_PART:
        own = constraints_of(part, world.constraints)
        shared = own.groups[part * group_record.SIZE + group_record.SURFACES]
        own.scratch[lane_scratch.SURFACES] = float(shared)
        spread_friction(
            counts[tick_counts.LANES], batch_count_of(own), own.rows, own.scratch, own.batches
        )
        impulse_cache.store_impulses(
            WIDTH, substep, ANGULAR, world.colliders, own.order, own.places, own.manifolds,
            own.rows, world.detection.records, own.impulse_cache,
        )  # fmt: skip
        crew.finish(world.crew)
        part = crew.take(crew.IMPULSES, world.crew)


def _put_to_sleep(
    now, touching, motion, forces, colliders, constraints, bodies, state, flows, driven, settings,
    counts,
):  # fmt: skip
    """
    Let islands fall asleep that are at rest, at the end of a tick; tell whether some body did.
    """
    if FLOWS:
        sleep.keep_awake(now.start, flows, state.sleep_states)
    if DRIVES:
        prescribed_bodies.keep_awake(
            counts[tick_counts.MANIFOLDS], motion.body_count, driven.drives,
            constraints.manifolds, constraints.rows, state.sleep_states,
        )  # fmt: skip
    fell = sleep.update_sleep(
        now.h, settings[tick_settings.SLEEP_SPEED], settings[tick_settings.SLEEP_TIME],
        counts[tick_counts.PIECE] == 0, counts[tick_counts.MANIFOLDS], touching, motion,
        colliders, constraints, state, bodies,
    )  # fmt: skip
    if fell == 0:
        return False
    if VELOCITY_DEPENDENT:
        evaluate_forces(now.end, motion, forces)
    sleep.note_wrenches(motion, state.sleep_states)
    return True


# in the order in which `step` makes them
STAGES = (
    _bound_bounces, _give_impacts, _catch_up_balls, _take_back_gains, _store_some_impulses,
    _store_impulses, _put_to_sleep,
)  # fmt: skip
