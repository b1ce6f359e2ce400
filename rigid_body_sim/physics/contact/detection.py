# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The detection of contacts of a tick: poses, swept AABBs, pairs (broad phase), manifolds (narrow
phase), without ghosts; then impacts at their instants, where a scene has them (`events`).

Bodies, colliders and pairs are looked at in parts, by whoever is there (`crew`). Where a tick
cannot go on (a list is too short, sleepers wake, it is too long) nothing has changed yet.
"""

from __future__ import annotations

from rigid_body_sim.physics.compile.kernels import slot
from rigid_body_sim.physics.contact import (
    crew,
    prescribed_bodies,
    solver_bodies,
    tick_counts,
    tick_settings,
)
from rigid_body_sim.physics.contact.collision import (
    deep_overlaps,
    ignored_pairs,
    narrow_phase,
    neighbour_list,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.recycling import Recycling
from rigid_body_sim.physics.contact.events import flight_record
from rigid_body_sim.physics.contact.islands import sleep
from rigid_body_sim.physics.contact.solver import impulse_cache, pivots

PAIRS_OF_PART = 64  # [-] of the narrow phase: see `crew.BODIES_OF_PART`

BOUNCES = slot('[-] whether anything bounces')
EVENTS = slot('[-] whether impacts come at their instants')
SLEEPING = slot('[-] whether islands may sleep')
IGNORES = slot('[-] whether some pairs do not meet')
HOLDS = slot('[-] whether points of some pairs depend on those of the last tick')
RECYCLES = slot('[-] whether manifolds of some pairs follow their bodies')
find_manifolds = slot('kernel (first, last, count, h, ...): the narrow phase of some pairs')
drop_ghosts = slot('kernel (length, count, h, ...): takes out manifolds of ghosts')
gather_body = slot('kernel (body, motion, bodies): a body as it is at the start')
gather_some_bodies = slot('kernel (world): some bodies as they are at the start')
gather_bodies = slot('kernel (world): bodies as they are at the start')
find_some_reaches = slot('kernel (h, world): poses and swept AABBs of some colliders')
find_pairs = slot('kernel (h, world): the broad phase; tells whether there was room')
find_some_manifolds = slot('kernel (h, world): parts of the narrow phase')
find_impacts = slot('kernel (tick, h, ...): impacts at their instants; tells whether to go on')


def _gather_body(body, motion, bodies):
    """Give the solver a body as it is at the start of the tick."""
    solver_bodies.begin_tick(body, motion.rigid_count, motion.translation, motion.rotation, bodies)
    if BOUNCES:
        solver_bodies.find_free_acceleration(body, motion.rigid_count, motion.rotation, bodies)


def _gather_some_bodies(world):
    """Give the solver some bodies as they are at the start of the tick, until none is left."""
    motion = world.motion
    part = crew.take(crew.BODIES, world.crew)
    while part != crew.NO_PART:
        first = part * crew.BODIES_OF_PART
        for body in range(first, min(first + crew.BODIES_OF_PART, motion.body_count)):
            if SLEEPING and sleep.asleep(body, world.sleep.sleep_states):
                continue
            gather_body(body, motion, world.bodies)
        crew.finish(world.crew)
        part = crew.take(crew.BODIES, world.crew)


def _gather_bodies(world):
    """Give the solver the bodies as they are at the start of the tick."""
    parts = crew.parts_of(world.motion.body_count)
    crew.post(crew.BODIES, parts, world.crew)
    gather_some_bodies(world)
    crew.wait_for_parts(parts, world.crew)
    pivots.hold(world.motion.pivoted, world.bodies)
    solver_bodies.clear(world.motion.body_count, world.bodies)


def _find_some_reaches(h, world):
    """Find where some colliders are, and how far they reach in a tick, until none is left."""
    motion, colliders, count = world.motion, world.colliders, world.counts[tick_counts.COLLIDERS]
    part = crew.take(crew.COLLIDERS, world.crew)
    while part != crew.NO_PART:
        first = part * crew.BODIES_OF_PART
        last = min(first + crew.BODIES_OF_PART, count)
        narrow_phase.find_poses(
            first, last, motion.rigid_count, motion.translation, motion.rotation,
            colliders.table, world.detection.local_poses, colliders.poses,
        )  # fmt: skip
        swept_aabbs.find_swept_aabbs(
            first, last, h, world.settings[tick_settings.MARGIN], colliders, world.bodies
        )
        crew.finish(world.crew)
        part = crew.take(crew.COLLIDERS, world.crew)


def _find_pairs(h, world):
    """Find who may meet in a tick [s]; tell whether there was room, else counts[STATUS] does."""
    colliders, detection, counts = world.colliders, world.detection, world.counts
    parts = crew.parts_of(counts[tick_counts.COLLIDERS])
    crew.post(crew.COLLIDERS, parts, world.crew)
    find_some_reaches(h, world)
    crew.wait_for_parts(parts, world.crew)
    pairs = neighbour_list.find_pairs(
        counts[tick_counts.COLLIDERS], counts[tick_counts.PLANES], h,
        world.settings[tick_settings.USUAL_RADIUS], counts[tick_counts.PAIR_ROOM], colliders,
        detection.broad_phase,
    )  # fmt: skip
    counts[tick_counts.PAIRS] = pairs
    if pairs > counts[tick_counts.PAIR_ROOM]:
        counts[tick_counts.STATUS] = tick_counts.SHORT_OF_PAIRS
        return False
    pair_ids = detection.broad_phase.pair_ids
    if IGNORES:
        pairs = ignored_pairs.without_ignored(pairs, detection.ignored, pair_ids)
        counts[tick_counts.PAIRS] = pairs
    cache = world.constraints.impulse_cache
    if HOLDS and len(detection.held) > 0:
        impulse_cache.find_held(pairs, pair_ids, cache, detection.held)
    if RECYCLES and len(detection.records) > 0:
        impulse_cache.find_recycled(pairs, pair_ids, cache, detection.places)
    return True


def _find_some_manifolds(h, world):
    """Do parts of the narrow phase, until none is left: see `narrow_phase`."""
    counts, detection = world.counts, world.detection
    recycling = Recycling(
        world.constraints.impulse_cache, detection.places, detection.records, detection.held
    )
    part = crew.take(crew.MANIFOLDS, world.crew)
    while part != crew.NO_PART:
        pairs, of_part = counts[tick_counts.PAIRS], counts[tick_counts.PAIRS_OF_PART]
        detection.of_parts[part] = find_manifolds(
            part * of_part, min(pairs, (part + 1) * of_part), counts[tick_counts.COLLIDERS], h,
            h / world.settings[tick_settings.SUBSTEPS], counts[tick_counts.MANIFOLD_ROOM],
            world.colliders, detection.broad_phase.pair_ids, detection.found,
            world.constraints.manifolds, world.bodies, recycling,
        )  # fmt: skip
        crew.finish(world.crew)
        part = crew.take(crew.MANIFOLDS, world.crew)


def _detect_contacts(number, h, world):
    """
    Find poses, swept AABBs, pairs and manifolds of a tick [s], the tick of a number. Tell whether
    it can go on; else counts[STATUS] tells why.
    """
    colliders, detection, counts = world.colliders, world.detection, world.counts
    manifolds = world.constraints.manifolds
    gather_bodies(world)
    if not find_pairs(h, world):
        return False
    pairs = counts[tick_counts.PAIRS]
    parts, of_part = 1, pairs
    several = counts[tick_counts.SURFACES] > 0  # of one pair
    if not (several or crew.is_alone(world.crew) or pairs > counts[tick_counts.MANIFOLD_ROOM]):
        parts, of_part = max(1, (pairs + PAIRS_OF_PART - 1) // PAIRS_OF_PART), PAIRS_OF_PART
    counts[tick_counts.PAIRS_OF_PART] = of_part
    crew.post(crew.MANIFOLDS, parts, world.crew)
    find_some_manifolds(h, world)
    crew.wait_for_parts(parts, world.crew)
    manifold_count = narrow_phase.close_up(parts, of_part, detection.of_parts, manifolds)
    counts[tick_counts.PIECES] = 1
    if manifold_count <= counts[tick_counts.MANIFOLD_ROOM]:
        manifold_count = drop_ghosts(
            manifold_count, counts[tick_counts.COLLIDERS], h,
            h / world.settings[tick_settings.SUBSTEPS], colliders, detection.found, manifolds,
            world.bodies,
            counts[tick_counts.PIECES : tick_counts.PIECES + 1],
        )  # fmt: skip
    counts[tick_counts.MANIFOLDS] = manifold_count
    if manifold_count > counts[tick_counts.MANIFOLD_ROOM]:
        counts[tick_counts.STATUS] = tick_counts.SHORT_OF_MANIFOLDS
        return False
    if EVENTS and not find_impacts(
        number, h, world.constraints.impulse_cache, detection.broad_phase.pair_ids, manifolds,
        world.flights, counts,
    ):  # fmt: skip
        return False
    if EVENTS and world.flights.views[flight_record.UNDECIDED] > 0.0:
        deep_overlaps.list_pair(
            int(world.flights.views[flight_record.UNDECIDED + 1]),
            int(world.flights.views[flight_record.UNDECIDED + 2]), 0.0, 0.0, 0.0, 1.0,
            colliders.table, world.overlaps,
        )  # fmt: skip
    if SLEEPING and sleep.wake_touched(
        manifold_count, h, colliders, manifolds, world.sleep.sleep_states
    ):
        counts[tick_counts.STATUS] = tick_counts.WOKEN
        return False
    if counts[tick_counts.PIECES] > 1 and counts[tick_counts.FINE] == 0:
        counts[tick_counts.STATUS] = tick_counts.TOO_LONG
        return False
    return True


def _drive(now, driven, colliders, bodies, state, counts):
    """
    Put what is moved as told where it is at the start of the tick; tell whether nobody wakes by
    it, else counts[STATUS] does.
    """
    prescribed_bodies.begin_tick(now.start, now.h, driven, colliders, bodies)
    if SLEEPING and prescribed_bodies.wake_touched(
        counts[tick_counts.COLLIDERS], now.h, driven.drives, colliders, state.sleep_states
    ):
        counts[tick_counts.STATUS] = tick_counts.WOKEN
        return False
    return True


# in the order in which `step` makes them
STAGES = (
    _gather_body, _gather_some_bodies, _gather_bodies, _find_some_reaches, _find_pairs,
    _find_some_manifolds, _detect_contacts, _drive,
)  # fmt: skip
