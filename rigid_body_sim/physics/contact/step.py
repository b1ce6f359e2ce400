# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The recipe of a tick with contact, by sequential impulses: detect once, then substeps of integrate,
solve, update separation, relax (TGS-Soft); then restitution, energy, and what is stored.

    detect:    poses, swept AABBs, pairs (broad phase), manifolds (narrow phase)
    events:    in scenes with impacts at their instants, who flies and meets (`events`): they and
               their manifolds are taken out
    prepare:   constraints, coloured into batches, with the impulses of the last tick (warm start)
               if a list is too short, return: nothing has changed yet
               before the first tick: the loads of what stands
    each substep h:
        p += h/2 F, L += h/2 torque, and half the warm-start impulses: the contact impulses of the
                  last substep, but for what was a blow
        solve:    soft normals of all contacts, which do not pull
        integrate: x += h v, q by the free rotation of the integrator, L fixed
        p += h/2 F, L += h/2 torque
        update separation: points, anchors and separations follow the bodies; the other half of the
                  warm-start impulses, there
        relax:    normals without push-out, and friction
    restitution:  which returns no more energy than the impact took
    energy:    what contact gave by its errors is taken back
    store:     impulses, for the next tick
    sleep:     islands that are at rest

What has nothing to do with each other is done in parts, by whoever is there (`crew`): the narrow
phase some pairs at a time (`_find_some_manifolds`), what is before it some bodies and colliders
(`_gather_some_bodies`, `_find_some_reaches`), from `prepare` on groups of islands (`_pass_groups`)
and bodies that touch nobody, and what is stored (`_store_some_impulses`).

Where islands may sleep, sleepers are left out (`islands.sleep`): who wakes is known before
anything has changed, who falls asleep at the end of a tick; both return to Python, for impulse
caches to be put in order.

So all that acts, acts in two halves about the motion: what is carried, slides or pivots moves to
second order, as what flies does (velocity Verlet). Whom no contact carries moves as without
contact. Force elements are evaluated after each motion: those of then act for the second half.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.contact import (
    crew,
    packed_bodies,
    prescribed_bodies,
    solver_bodies,
    tick_counts,
    tick_settings,
)
from rigid_body_sim.physics.contact.array_groups import Constraints, Forces, Group, Motion
from rigid_body_sim.physics.contact.collision import (
    deep_overlaps,
    ignored_pairs,
    narrow_phase,
    neighbour_list,
    recycled_record,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import BroadPhase, ColliderArrays
from rigid_body_sim.physics.contact.collision.recycling import Recycling
from rigid_body_sim.physics.contact.crew import Crew
from rigid_body_sim.physics.contact.energy import account, gain_bound, restitution_bound
from rigid_body_sim.physics.contact.energy.scratch import EnergyScratch
from rigid_body_sim.physics.contact.events import flight, flight_record
from rigid_body_sim.physics.contact.events.flight import Flights
from rigid_body_sim.physics.contact.islands import (
    first_loads,
    jammed,
    left_sinking,
    sleep,
    waiting,
)
from rigid_body_sim.physics.contact.islands.bouncing import mark_bouncing
from rigid_body_sim.physics.contact.islands.sleep import SleepState
from rigid_body_sim.physics.contact.islands.solver_groups import find_groups, sort_touching
from rigid_body_sim.physics.contact.islands.unsettled import NEAR, go_ahead
from rigid_body_sim.physics.contact.packed_bodies import PackedBodies
from rigid_body_sim.physics.contact.prescribed_bodies import PrescribedBodies
from rigid_body_sim.physics.contact.solver import (
    ball_impacts,
    batch_record,
    cache_record,
    colouring,
    common_pressure,
    forces_of_state,
    group_record,
    impact_sequence,
    impulse_cache,
    lane_scratch,
    manifold_constraints,
    pivots,
    surface_chain,
    variable_mass,
)
from rigid_body_sim.physics.contact.solver.iterations import PASSES
from rigid_body_sim.physics.contact.solver.softness import Softness
from rigid_body_sim.physics.contact.touching import list_touching
from rigid_body_sim.physics.integration.schemes import steps
from rigid_body_sim.physics.state import blocks

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# Passes over the constraints, before and after the motion, PASSES at most: after the first, of
# what the last one has changed by more than STRUCK. Islands left unsettled go on as a whole
# (`islands.unsettled`): what is left of an impact, or of a heavy load, sinks in over a substep,
# and is lifted again with a gain of energy.
STRUCK = 1e-3  # [m/s] more lets heaps gain energy, less costs time
STIRRED = 1e-4  # [m/s] the same after the motion; with ten times more heaps tremble so much more
STEP = 1.7  # [-] over-relaxation of those passes where balls meet (SOR)
REST = 1e-7  # [m/s] the same for the first `relaxations` passes after the motion; more lets stacks
# tremble

# parts of a tick: fewer wait for each other longer, more cost calls, and lists with gaps
PAIRS_OF_PART = 64  # [-]
BODIES_OF_PART = 2 * blocks.LANES  # [-] whole blocks; as many colliders

# bound for each scene
WIDTH = slot('[-] numbers of a contact point')
ANGULAR = slot('[-] whether anything rolls or twists with friction')
BOUNCES = slot('[-] whether anything bounces')
CURVED = slot('[-] whether layers about cores may meet: `solver.curved_cores`')
BALLS_MEET = slot('[-] whether two balls may meet: `solver.ball_impacts`')
COUPLED = slot('[-] whether a force depends on the state')
APART = slot('[-] whether islands may pass their substeps one after the other')
EVENTS = slot('[-] whether impacts come at their instants')
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
SLEEPING = slot('[-] whether islands may sleep')
FLOWS = slot('[-] whether the mass of a body that touches changes')
DRIVES = slot('[-] whether some bodies are moved as told, or have a belt')
IGNORES = slot('[-] whether some pairs do not meet')
HOLDS = slot('[-] whether points of some pairs depend on those of the last tick')
RECYCLES = slot('[-] whether manifolds of some pairs follow their bodies')
drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and turns q')
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')
find_manifolds = slot('kernel (first, last, count, h, ...): the narrow phase of some pairs')
drop_ghosts = slot('kernel (length, count, h, ...): takes out manifolds of ghosts')
prepare = slot('kernel (lanes, batches, threshold, rows, ...): effective masses and warm start')
solve_normals = slot('kernel (lanes, batches, 1/h, slop, cap, rows, ...): solves soft normals')
update_separation = slot('kernel (lanes, batches, rows, ...): lets points follow the bodies')
relax = slot('kernel (lanes, batches, 1/h, first, rows, ...): relaxes normals, and friction')
start_substep = slot('kernel (lanes, batches, rows, ...): warm start of the next substep')
spread_friction = slot('kernel (lanes, batches, rows, ...): friction of patches to points')
apply_restitution = slot('kernel (lanes, batches, rows, ...): lets bounce what bounces')
# the stages, of this module
evaluate_forces = slot('kernel (time, motion, forces)')
gather_body = slot('kernel (body, motion, bodies): a body as it is at the start')
gather_some_bodies = slot('kernel (world): some bodies as they are at the start')
gather_bodies = slot('kernel (world): bodies as they are at the start')
find_some_reaches = slot('kernel (h, world): poses and swept AABBs of some colliders')
find_pairs = slot('kernel (h, world): the broad phase; tells whether there was room')
find_some_manifolds = slot('kernel (h, world): parts of the narrow phase')
detect_contacts = slot('kernel (number, h, world): tells whether the manifolds are there')
find_impacts = slot('kernel (tick, h, ...): impacts at their instants; tells whether to go on')
meet_now = slot('kernel (strikes, cache, flights, counts): impacts at the present instant')
land = slot('kernel (h, flights): takes who was struck to the end of the tick')
drive = slot('kernel (now, ...): puts driven bodies where they are; tells whether nobody wakes')
find_works_of_drives = slot('kernel (when, ...): of driven bodies on others')
colour_constraints = slot('kernel (body_count, ...): tells whether there was room')
arrange_constraints = slot('kernel (now, ...): tells whether there is room for constraints')
prepare_group = slot('kernel (now, constraints, ...): makes the constraints of a group')
find_first_loads = slot('kernel (now, touching, ...): what is carried when the scene begins')
begin_energy_balance = slot('kernel (h, touching, motion, bodies)')
solve_contacts = slot('kernel (index, now, group, ...): warm start and soft normals')
move_block = slot('kernel (block, count, ...): moves bodies of a block over a substep')
move_all = slot('kernel (now, group, bodies, state): moves all bodies over a substep')
move_group = slot('kernel (now, group, bodies, packed): moves the bodies of a group')
move_free = slot('kernel (part, now, world): moves over the tick who touches nobody')
correct_forces = slot('kernel (time, now, touching, ...): forces of after the motion')
gather_moved_bodies = slot('kernel (now, group, bodies)')
follow_and_relax = slot('kernel (index, now, group, ...): separations, then relaxation')
end_substep = slot('kernel (index, now, group, ...): motion of a substep, and what follows')
pass_substeps = slot('kernel (now, group, constraints, world): all substeps of a tick')
pass_group = slot('kernel (number, now, world): a group, from its constraints to the last substep')
pass_groups = slot('kernel (tick, h, world): parts of a tick that are groups, or bodies')
give_impacts = slot('kernel (motion, touching, ...): impulses of impacts that were followed')
catch_up_balls = slot('kernel (now, ...): balls that met; tells whether there are any')
take_back_gains = slot('kernel (h, touching, ...): of contact; tells whether it changed any')
bound_bounces = slot('kernel (touching, ...): restitution')
store_some_impulses = slot('kernel (substep, world): parts of the impulse cache')
store_impulses = slot('kernel (now, world): fills the impulse cache')
give_a_hand = slot('kernel (tick, h, world): does parts of ticks, until the call is over')
put_to_sleep = slot('kernel (h, end, ...): tells whether some body fell asleep')
meet_at_instant = slot('kernel (time, world): looks at an impact, or lets it happen')


class Detection(NamedTuple):
    """
    What the detection of contacts needs beside the colliders.

    local_poses : of the shapes in the axes of their bodies: see `collision.pose`
    found       : what a pair kernel writes, and its scratch: see `geometry.manifold`
    ignored     : pairs that do not meet: see `collision.ignored_pairs`
    places      : of the records of pairs: see `collision.recycling`
    records     : of the tick under way: see there
    held        : what pairs have held: see `collision.held_features`
    of_parts    : how many manifolds each part of the narrow phase has found
    """

    local_poses: Array
    broad_phase: BroadPhase
    found: Array
    ignored: Indices
    places: Indices
    records: Array
    held: Array
    of_parts: Indices


class World(NamedTuple):
    """
    All arrays of a scene with contact: what Python hands over (`world_arrays`).

    settings, counts : see `tick_settings`, `tick_counts`; counts[DONE] tells how many ticks were
                       done, counts[STATUS] why no more
    materials        : see `model.material`
    bodies           : see `solver_bodies`
    touching, marks  : see `touching`
    flows            : bodies whose mass changes: see `solver.variable_mass`
    pair_materials   : pairs with a material of their own, the same
    driven           : see `prescribed_bodies`
    overlap_limits, overlaps : see `collision.deep_overlaps`
    flights          : of bodies between impacts: see `events.flight`
    packed           : room for the bodies of a group: see `packed_bodies`
    crew             : see `crew`

    Each thread has its own `found`, `packed` and `constraints.scratch`, and its place in the crew.
    """

    motion: Motion
    forces: Forces
    settings: Array
    counts: Indices
    colliders: ColliderArrays
    materials: Array
    detection: Detection
    bodies: Array
    constraints: Constraints
    touching: Indices
    marks: Indices
    energy: EnergyScratch
    sleep: SleepState
    flows: Array
    pair_materials: Array
    driven: PrescribedBodies
    overlap_limits: Array
    overlaps: Array
    flights: Flights
    packed: PackedBodies
    crew: Crew


class Tick(NamedTuple):
    """
    The tick under way.

    start     : [s] since the start of the scene
    end       : [s] where the next one begins, to the bit
    h         : [s] its length
    substep   : [s]
    substeps  : how many
    """

    start: float
    end: float
    h: float
    substep: float
    substeps: int


def _advance(ticks, tick, h, world):
    """Let ticks pass: the recipe, which Python calls; NaN: no number left; helpers do parts."""
    if crew.helps(world.crew):
        give_a_hand(tick, h, world)
        return 0.0
    motion, forces, settings, counts = world.motion, world.forces, world.settings, world.counts
    colliders, constraints, bodies = world.colliders, world.constraints, world.bodies
    energy, state, flows, driven = world.energy, world.sleep, world.flows, world.driven
    substeps = int(settings[tick_settings.SUBSTEPS])
    substep = h / substeps
    counts[tick_counts.DONE] = 0
    counts[tick_counts.STATUS] = tick_counts.COMPLETE
    status = finite(motion)
    evaluated = False
    if EVENTS:
        meet_at_instant(tick * h, world)
    if SLEEPING and counts[tick_counts.SLEEP_CHANGED] == 1:
        place_sleepers(motion, colliders, world.detection, bodies, state, counts)
    for passed in range(ticks):
        if not status == 0.0:
            return status
        now = Tick((tick + passed) * h, (tick + passed + 1) * h, h, substep, substeps)
        if COUPLED and not evaluated:
            evaluate_forces(now.start, motion, forces)
            evaluated = not VELOCITY_DEPENDENT
        if DRIVES and not drive(now, driven, colliders, bodies, state, counts):
            return 0.0
        if SLEEPING:
            awake = sleep.count_awake(motion, state)
            if awake == sleep.SOME_WAKES:
                counts[tick_counts.STATUS] = tick_counts.WOKEN
                return 0.0
            if awake == 0:
                counts[tick_counts.MANIFOLDS] = 0
                counts[tick_counts.DONE] = passed + 1
                evaluated = False  # nobody moves, but time does, and what it tells forces
                continue
        impacts = counts[tick_counts.IMPACTS]
        if not detect_contacts(tick + passed, h, world) or not arrange_constraints(
            now, motion.body_count, colliders, constraints, bodies, driven, counts
        ):
            counts[tick_counts.IMPACTS] = impacts  # the tick is made anew, with its impacts
            return 0.0
        deep_overlaps.list_deep_overlaps(
            tick + passed == 0, counts[tick_counts.MANIFOLDS], colliders.table,
            world.overlap_limits, constraints.manifolds, world.overlaps,
        )  # fmt: skip
        count = count_touching(motion, constraints, world.marks, world.touching, counts)
        touching = world.touching[0:count]
        parts = counts[tick_counts.GROUPS] + (parts_of(motion.body_count) if APART else 0)
        crew.post(crew.GROUPS, parts, world.crew)
        pass_groups(tick, h, world)
        crew.wait_for_parts(parts, world.crew)
        left_sinking.list_left(
            passed + 1 == ticks, substeps, WIDTH, counts[tick_counts.MANIFOLDS], colliders.table,
            world.overlap_limits, constraints.manifolds, constraints.rows, world.overlaps,
        )  # fmt: skip
        evaluated = COUPLED and not VELOCITY_DEPENDENT
        give_impacts(motion, touching, constraints, bodies, flows, counts)
        if BOUNCES and counts[tick_counts.BATCHES] > 0:
            bound_bounces(
                now, touching, motion, colliders, constraints, energy, bodies, flows, driven,
                counts,
            )  # fmt: skip
        if BALLS_MEET and catch_up_balls(now, motion, constraints, bodies, flows, counts):
            evaluated = False  # they are elsewhere
        if take_back_gains(
            h, touching, motion, constraints, energy, bodies, flows, driven, settings, counts
        ):
            evaluated = False  # it may have moved bodies
        store_impulses(now, world)
        counts[tick_counts.DONE] = passed + 1
        status = finite(motion)
        if SLEEPING and put_to_sleep(
            now, touching, motion, forces, colliders, constraints, bodies, state, flows,
            driven, settings, counts,
        ):  # fmt: skip
            counts[tick_counts.STATUS] = tick_counts.FELL_ASLEEP
            return status
    return status


@inline
def finite(motion: Motion) -> Any:
    """Return 0 if every number of the state is finite, else NaN."""
    return steps.finite(motion.body_count, motion.rigid_count, motion.translation, motion.rotation)


@inline
def place_sleepers(
    motion: Motion, colliders: ColliderArrays, detection: Detection, bodies: Array,
    state: SleepState, counts: Indices,
) -> None:  # fmt: skip
    """Let the colliders say who sleeps, and forget the neighbour list."""
    counts[tick_counts.SLEEP_CHANGED] = 0
    detection.broad_phase.neighbours[neighbour_list.AGE] = neighbour_list.NO_LIST
    sleep.place_sleepers(
        counts[tick_counts.COLLIDERS], motion, colliders, detection.local_poses, bodies,
        state.sleep_states,
    )  # fmt: skip


def _evaluate_forces(time, motion, forces):
    """Evaluate all force elements at a time [s]."""
    translation, rotation = motion.translation, motion.rotation
    steps.start_evaluation(motion.body_count, motion.rigid_count, translation, rotation)
    evaluate(0, time, translation, rotation, forces.elements, forces.ranges)


def _gather_body(body, motion, bodies):
    """Give the solver a body as it is at the start of the tick."""
    solver_bodies.begin_tick(body, motion.rigid_count, motion.translation, motion.rotation, bodies)
    if BOUNCES:
        solver_bodies.find_free_acceleration(body, motion.rigid_count, motion.rotation, bodies)


@inline
def parts_of(count: int) -> int:
    """Count the parts of so many bodies or colliders."""
    return (count + BODIES_OF_PART - 1) // BODIES_OF_PART


def _gather_some_bodies(world):
    """Give the solver some bodies as they are at the start of the tick, until none is left."""
    motion = world.motion
    part = crew.take(crew.BODIES, world.crew)
    while part != crew.NO_PART:
        first = part * BODIES_OF_PART
        for body in range(first, min(first + BODIES_OF_PART, motion.body_count)):
            if SLEEPING and sleep.asleep(body, world.sleep.sleep_states):
                continue
            gather_body(body, motion, world.bodies)
        crew.finish(world.crew)
        part = crew.take(crew.BODIES, world.crew)


def _gather_bodies(world):
    """Give the solver the bodies as they are at the start of the tick."""
    parts = parts_of(world.motion.body_count)
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
        first = part * BODIES_OF_PART
        last = min(first + BODIES_OF_PART, count)
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
    parts = parts_of(counts[tick_counts.COLLIDERS])
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


def _find_works_of_drives(when, motion, driven, colliders, constraints, bodies, counts):
    """Find what driven bodies did on others: see `prescribed_bodies.find_works`."""
    prescribed_bodies.find_works(
        when, counts[tick_counts.MANIFOLDS], motion.body_count, WIDTH, ANGULAR, colliders, driven,
        constraints, bodies,
    )  # fmt: skip


def _colour_constraints(body_count, colliders, constraints, bodies, counts):
    """
    Find the places of the constraints in the cache, and colour them into batches if others than
    those of the last tick; tell whether there was room.
    """
    count = counts[tick_counts.MANIFOLDS]
    counts[tick_counts.HAS_LOST] = 0
    if counts[tick_counts.ASSEMBLED] == 1 and impulse_cache.holds_same_manifolds(
        count, constraints.manifolds, constraints.impulse_cache, constraints.places
    ):
        return True
    impulse_cache.find_places(
        count, constraints.manifolds, constraints.impulse_cache, constraints.places
    )
    if impulse_cache.link_lost(
        count, colliders.table, constraints.manifolds, constraints.impulse_cache, bodies
    ):
        counts[tick_counts.HAS_LOST] = 1
    counts[tick_counts.GROUPS] = find_groups(
        count, body_count, APART, colliders.table, constraints.manifolds, constraints.colours,
        constraints.group_of, constraints.groups, constraints.order,
    )  # fmt: skip
    counts[tick_counts.BATCHES] = colouring.colour_constraints(
        count, counts[tick_counts.GROUPS], body_count, WIDTH, counts[tick_counts.ROW_ROOM],
        counts[tick_counts.BATCH_ROOM], CURVED, colliders.table, colliders.local_bounds,
        constraints, bodies,
    )  # fmt: skip
    counts[tick_counts.ASSEMBLED] = 0
    counts[tick_counts.LANES] = colouring.lanes_in_use(
        counts[tick_counts.BATCHES], constraints.batches
    )
    colouring.empty_lanes_behind(counts[tick_counts.LANES], constraints.scratch)
    return counts[tick_counts.BATCHES] != colouring.NO_ROOM


def _arrange_constraints(now, body_count, colliders, constraints, bodies, driven, counts):
    """
    Give the constraints of a tick their places, in groups, and find where those of the last one
    are. Tell whether there was room; else counts[STATUS] tells for what not.
    """
    cache = constraints.impulse_cache
    count = counts[tick_counts.MANIFOLDS]
    behind = recycled_record.SIZE if RECYCLES else 0
    if (
        cache_record.HEAD + count * (cache_record.MOST_OF_MANIFOLD + behind)
        > counts[tick_counts.CACHE_ROOM]
    ):
        counts[tick_counts.STATUS] = tick_counts.SHORT_OF_CACHE
        return False
    if not colour_constraints(body_count, colliders, constraints, bodies, counts):
        counts[tick_counts.STATUS] = tick_counts.SHORT_OF_ROWS
        return False
    if DRIVES:
        prescribed_bodies.choose_belts(
            count,
            body_count,
            driven.drives,
            colliders.table,
            constraints.manifolds,
            constraints.rows,
        )
    is_assembled = counts[tick_counts.ASSEMBLED] == 1
    is_renewed = not is_assembled or cache[cache_record.SUBSTEP] != now.substep
    counts[tick_counts.RENEWED] = 1 if is_renewed else 0
    counts[tick_counts.ASSEMBLED] = 1
    return True


@inline
def softness_of(now: Tick, settings: Array) -> Softness:
    """How soft contacts are in a tick."""
    return Softness(
        now.substep, settings[tick_settings.WHOLE_TICK] / now.substeps,
        settings[tick_settings.DAMPING_RATIO],
    )  # fmt: skip


def _prepare_group(
    now, is_renewed, motion, colliders, materials, of_pairs, constraints, bodies, flows, settings,
    counts,
):  # fmt: skip
    """Make the constraints of a group, with the impulses of the last tick."""
    manifolds, rows, order = constraints.manifolds, constraints.rows, constraints.order
    softness = softness_of(now, settings)
    if is_renewed:
        manifold_constraints.prepare_materials(
            softness, CURVED, colliders.table, colliders.local_bounds, materials, of_pairs, order,
            manifolds, rows, bodies,
        )  # fmt: skip
    manifold_constraints.prepare_points(
        WIDTH, CURVED, order, motion.translation, colliders, manifolds, rows, bodies
    )
    impulse_cache.recall(
        WIDTH, now.substep, ANGULAR, colliders.local_bounds, colliders.poses, order,
        constraints.places, manifolds, constraints.impulse_cache, rows,
    )  # fmt: skip
    has_lost = counts[tick_counts.HAS_LOST] == 1
    recalls = common_pressure.WITH_LOST if has_lost else common_pressure.RECALLED
    common_pressure.share_pressure(WIDTH, softness, recalls, colliders, constraints, bodies)
    if FLOWS:
        variable_mass.find_mass_scale(now.start + 0.5 * now.h, flows)
        variable_mass.scale_to_present_mass(flows, bodies)
    prepare(
        counts[tick_counts.LANES], batch_count_of(constraints),
        settings[tick_settings.RESTITUTION_THRESHOLD], rows, constraints.scratch,
        constraints.batches, bodies,
    )  # fmt: skip
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
        variable_mass.scale_warm_start(flows, bodies)


@inline
def constraints_of(number: int, constraints: Constraints) -> Constraints:
    """Those of a group: its manifolds and batches."""
    row = number * group_record.SIZE
    row_behind = row + group_record.SIZE
    first = constraints.groups[row + group_record.FIRST_MANIFOLD]
    last = constraints.groups[row_behind + group_record.FIRST_MANIFOLD]
    begin = constraints.groups[row + group_record.FIRST_BATCH] * batch_record.SIZE
    end = constraints.groups[row_behind + group_record.FIRST_BATCH] * batch_record.SIZE
    return Constraints(
        constraints.manifolds, constraints.rows, constraints.batches[begin:end],
        constraints.colours, constraints.open_batches, constraints.impulse_cache,
        constraints.groups, constraints.group_of, constraints.order[first:last],
        constraints.places, constraints.roots, constraints.unsettled,
        constraints.members[first:last], constraints.scratch,
    )  # fmt: skip


@inline
def batch_count_of(constraints: Constraints) -> int:
    """Count the batches of a group."""
    return len(constraints.batches) // batch_record.SIZE


@inline
def count_touching(
    motion: Motion, constraints: Constraints, marks: Indices, touching: Indices, counts: Indices
) -> int:
    """List the bodies that some manifold names, group after group; return how many."""
    count = list_touching(
        counts[tick_counts.MANIFOLDS], motion.body_count, constraints.manifolds, constraints.rows,
        constraints.order, marks, touching,
    )  # fmt: skip
    sort_touching(
        count, counts[tick_counts.GROUPS], constraints.group_of, constraints.groups,
        constraints.colours, touching,
    )  # fmt: skip
    return count


def _find_first_loads(
    now, touching, motion, colliders, constraints, energy, bodies, flows, driven, settings, counts
):  # fmt: skip
    """Find what a group carries when the scene begins, and start from it."""
    if now.start != 0.0:
        return
    if constraints.impulse_cache[cache_record.SUBSTEP] != 0.0:
        return  # restored at tick 0, with what it carries
    rows, batches, scratch = constraints.rows, constraints.batches, constraints.scratch
    lanes, batch_count = counts[tick_counts.LANES], batch_count_of(constraints)
    roots, sizes = energy.roots, constraints.colours
    solver_bodies.kick_and_warm_start(2.0 * now.substep, Group(touching, False, motion), bodies)
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    if DRIVES:
        prescribed_bodies.end_substep(now.start + now.substep, driven, bodies)
    first_loads.find_islands(batch_count, motion.body_count, touching, batches, rows, roots, sizes)
    goes_on, passes = True, 0
    while goes_on:
        relax(
            lanes, batch_count, 1.0 / now.substep, min(passes, 1), first_loads.REST, 1.0, rows,
            scratch, batches, bodies,
        )  # fmt: skip
        passes += 1
        goes_on = first_loads.wake_islands(
            passes, batch_count, motion.body_count, touching, batches, rows, roots, sizes
        )
    spread_friction(lanes, batch_count, rows, scratch, batches)
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
    if DRIVES:
        prescribed_bodies.end_substep(now.start, driven, bodies)  # as the tick begins
    for index in range(len(touching)):
        gather_body(touching[index], motion, bodies)
    pivots.hold(motion.pivoted, bodies)
    first_loads.recall_loads(
        WIDTH, motion.body_count, now.substep, constraints, roots, sizes, bodies
    )
    common_pressure.share_pressure(
        WIDTH, softness_of(now, settings), common_pressure.AS_FOUND, colliders, constraints, bodies
    )
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    prepare(
        lanes, batch_count, settings[tick_settings.RESTITUTION_THRESHOLD], rows, scratch, batches,
        bodies,
    )  # fmt: skip
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
        variable_mass.scale_warm_start(flows, bodies)


def _begin_energy_balance(h, touching, motion, bodies):
    """Start the energy balance of the bodies that touch."""
    account.begin(touching, bodies)
    if not COUPLED:
        account.add_half_the_torque(h, Group(touching, False, motion), bodies)


def _solve_contacts(
    index, now, group, constraints, bodies, flows, driven, settings, counts
):  # fmt: skip
    """
    Let half of forces and warm start act, then solve the soft normals; index: of the substep.
    """
    if DRIVES:
        prescribed_bodies.begin_substep(
            now.start + index * now.substep, now.substep, driven, bodies
        )
    solver_bodies.kick_and_warm_start(now.substep, group, bodies)
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    goes_on, further, iteration = True, 0, 0
    while goes_on:
        changed = solve_normals(
            counts[tick_counts.LANES], batch_count_of(constraints), 1.0 / now.substep,
            settings[tick_settings.SLOP], settings[tick_settings.PUSH_OUT_SPEED], iteration,
            STRUCK if further == 0 else NEAR, STEP if further == 0 else 1.0, constraints.rows,
            constraints.scratch, constraints.batches, bodies,
        )  # fmt: skip
        iteration += 1
        goes_on = changed and iteration < PASSES
        if not goes_on and iteration > 1:
            goes_on = go_ahead(
                further, counts[tick_counts.LANES], WIDTH, 1.0, group.members, constraints, bodies
            )
            iteration = PASSES
            further += 1
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)


def _move_block(block, count, first, member_count, substep, group, bodies):
    """
    Move so many bodies of a block over a substep [s], and let the other half of the forces act;
    those of the group among them, from the first member on, as contacts want it.
    """
    motion = group.motion
    half = 0.5 * substep
    steps.kick_and_drift(block, count, half, substep, motion.translation)
    steps.kick(block, count, half, motion.translation)
    lanes = min(count, motion.rigid_count - blocks.LANES * block)
    if lanes > 0:
        solver_bodies.scatter_angular_momentum(first, member_count, half, group, bodies)
        drift_rotation(block, lanes, half, substep, motion.rotation, motion.method)
        steps.kick_rotation(block, lanes, half, motion.rotation)
    solver_bodies.integrate_position(first, member_count, substep, group, bodies)


def _move_all(now, group, bodies, state):
    """Move all bodies of the scene over a substep; group: all that touch."""
    motion, members = group.motion, group.members
    first = 0
    for block in range((motion.body_count + blocks.LANES - 1) // blocks.LANES):
        if SLEEPING and not sleep.stirs(block, state):
            continue
        begin = blocks.LANES * block
        end = min(begin + blocks.LANES, motion.body_count)
        last = first
        while last < len(members) and members[last] < end:
            last += 1
        move_block(block, end - begin, first, last - first, now.substep, group, bodies)
        first = last
    if SLEEPING:
        sleep.keep_still(motion, state, bodies)


def _move_group(now, group, bodies, packed):
    """Move the bodies of a group over a substep, block after block, and nobody else."""
    motion, members = group.motion, group.members
    first = 0
    while first < len(members):
        last = packed_bodies.end_of_block(first, group)
        count = last - first
        own, where = members[first:last], group
        block, place = first // blocks.LANES, first
        alone = group.is_packed
        if not alone:
            block = members[first] // blocks.LANES
            alone = packed_bodies.fill_a_block(own, motion.body_count)
        if not alone:
            where = Group(own, True, packed_bodies.pack(own, motion, packed))
            block, place = 0, 0
        move_block(block, count, place, count, now.substep, where, bodies)
        if not alone:
            packed_bodies.unpack(own, where.motion, motion)
        first = last


def _move_free(part, now, world):
    """Move the bodies of a part that touch nobody over the whole tick, substep after substep."""
    motion, packed, bodies = world.motion, world.packed, world.bodies
    of_part = BODIES_OF_PART // blocks.LANES
    block_count = (motion.body_count + blocks.LANES - 1) // blocks.LANES
    for block in range(part * of_part, min((part + 1) * of_part, block_count)):
        count = 0
        begin = blocks.LANES * block
        for body in range(begin, min(begin + blocks.LANES, motion.body_count)):
            if world.marks[body] == 0 and not (
                SLEEPING and sleep.asleep(body, world.sleep.sleep_states)
            ):
                packed.chosen[count] = body
                count += 1
        if count == 0:
            continue
        chosen = packed.chosen[0:count]
        group = Group(chosen, False, motion)
        place = block
        alone = packed_bodies.fill_a_block(chosen, motion.body_count)
        if not alone:
            group = Group(chosen, True, packed_bodies.pack(chosen, motion, packed))
            place = 0
        for _ in range(now.substeps):
            move_block(place, count, 0, 0, now.substep, group, bodies)
        if not alone:
            packed_bodies.unpack(chosen, group.motion, motion)


def _correct_forces(time, now, touching, motion, forces, bodies):
    """
    Evaluate the forces of after the motion, at a time [s], and let them act in place of those of
    before it for its second half. Those that depend on velocity see the second half of the warm
    start too.
    """
    translation, rotation = motion.translation, motion.rotation
    if VELOCITY_DEPENDENT:
        for index in range(len(touching)):
            forces_of_state.add_warm_start(
                touching[index], motion.rigid_count, 1.0, translation, rotation, bodies
            )
    forces_of_state.save_wrenches(
        motion.body_count, motion.rigid_count, translation, rotation, forces.saved
    )
    evaluate_forces(time, motion, forces)
    forces_of_state.correct_momenta(
        motion.body_count,
        motion.rigid_count,
        0.5 * now.substep,
        translation,
        rotation,
        forces.saved,
    )
    if VELOCITY_DEPENDENT:
        for index in range(len(touching)):
            forces_of_state.add_warm_start(
                touching[index], motion.rigid_count, -1.0, translation, rotation, bodies
            )


def _gather_moved_bodies(now, group, bodies):
    """Give the solver the bodies as they are after the motion."""
    solver_bodies.gather_moved(group, bodies)
    if COUPLED:
        account.end_motion(group.members, bodies)
    solver_bodies.clear_warm_start(group.members, bodies)


def _pass_substeps(now, group, constraints, world):
    """Let a group pass the substeps of the tick."""
    for index in range(now.substeps + 1):
        if index > 0:
            end_substep(index - 1, now, group, constraints, world)
        if index < now.substeps:
            if VELOCITY_DEPENDENT:
                evaluate_forces(now.start + index * now.substep, world.motion, world.forces)
            solve_contacts(
                index, now, group, constraints, world.bodies, world.flows, world.driven,
                world.settings, world.counts,
            )  # fmt: skip


def _pass_group(number, now, world):
    """
    Let a group of islands pass the tick: its constraints, what it carries when the scene begins,
    and all substeps. Where forces depend on the state, masses flow or something is driven, all
    that touch are one group.
    """
    motion, bodies, counts = world.motion, world.bodies, world.counts
    groups, own = world.constraints.groups, constraints_of(number, world.constraints)
    row = number * group_record.SIZE
    first = groups[row + group_record.FIRST_BODY]
    last = groups[row + group_record.SIZE + group_record.FIRST_BODY]
    members = world.touching[first:last]
    if number > 0:
        solver_bodies.clear(motion.body_count + number, bodies)
    if crew.helps(world.crew):
        colouring.empty_lanes_behind(counts[tick_counts.LANES], own.scratch)
    prepare_group(
        now, counts[tick_counts.RENEWED] == 1 or groups[row + group_record.SHARED] == 1, motion,
        world.colliders, world.materials, world.pair_materials, own, bodies, world.flows,
        world.settings, counts,
    )  # fmt: skip
    find_first_loads(
        now, members, motion, world.colliders, own, world.energy, bodies, world.flows,
        world.driven, world.settings, counts,
    )  # fmt: skip
    if BALLS_MEET:
        ball_impacts.foresee(
            counts[tick_counts.LANES], WIDTH, now.h, now.substep,
            world.settings[tick_settings.RESTITUTION_THRESHOLD], members, own, bodies,
        )  # fmt: skip
    groups[row + group_record.SHARED] = int(own.scratch[lane_scratch.SHARED])
    groups[row + group_record.SURFACES] = int(own.scratch[lane_scratch.SURFACES])
    begin_energy_balance(now.h, members, motion, bodies)
    if APART and packed_bodies.fit(members, motion, world.packed):
        packed = packed_bodies.pack(members, motion, world.packed)
        group = Group(members, True, packed)
    else:
        group = Group(members, False, motion)
    pass_substeps(now, group, own, world)
    if group.is_packed:
        packed_bodies.unpack(members, group.motion, motion)


def _pass_groups(tick, h, world):
    """
    Do parts of a tick, until none is left: let groups pass it, or move who touches nobody; tick:
    number of the first of the call.
    """
    counts = world.counts
    part = crew.take(crew.GROUPS, world.crew)
    while part != crew.NO_PART:
        substeps = int(world.settings[tick_settings.SUBSTEPS])
        passed = tick + counts[tick_counts.DONE]
        now = Tick(passed * h, (passed + 1) * h, h, h / substeps, substeps)
        if part < counts[tick_counts.GROUPS]:
            pass_group(part, now, world)
        elif APART:
            move_free(part - counts[tick_counts.GROUPS], now, world)
        crew.finish(world.crew)
        part = crew.take(crew.GROUPS, world.crew)


def _end_substep(index, now, group, constraints, world):
    """Let the bodies of a group move, and contacts follow; index: of the substep."""
    if APART:
        move_group(now, group, world.bodies, world.packed)
    else:
        if COUPLED:
            account.begin_motion(0.5 * now.substep, group, world.bodies)
        move_all(now, group, world.bodies, world.sleep)
    if COUPLED:
        last = index + 1 == now.substeps
        time = now.end if last else now.start + (index + 1) * now.substep
        correct_forces(time, now, group.members, world.motion, world.forces, world.bodies)
    follow_and_relax(
        index, now, group, world.colliders, constraints, world.bodies, world.flows,
        world.driven, world.settings, world.counts,
    )  # fmt: skip


def _follow_and_relax(
    index, now, group, colliders, constraints, bodies, flows, driven, settings, counts
):  # fmt: skip
    """
    Update separations, with the second half of the warm start; then relax; index: of the substep.
    """
    last = index + 1 == now.substeps
    touching, motion = group.members, group.motion
    if DRIVES:  # another group may have begun the next substep
        prescribed_bodies.begin_substep(
            now.start + index * now.substep, now.substep, driven, bodies
        )
        prescribed_bodies.end_substep(now.start + (index + 1) * now.substep, driven, bodies)
    rows, scratch, batches = constraints.rows, constraints.scratch, constraints.batches
    lanes, batch_count = counts[tick_counts.LANES], batch_count_of(constraints)
    relaxations = int(settings[tick_settings.RELAXATIONS])
    gather_moved_bodies(now, group, bodies)
    if FLOWS:
        variable_mass.scale_to_present_mass(flows, bodies)
    if DRIVES:
        prescribed_bodies.turn_faces(
            counts[tick_counts.MANIFOLDS], motion.body_count, driven, colliders, constraints,
            bodies,
        )  # fmt: skip
    update_separation(lanes, batch_count, rows, scratch, batches, bodies)
    if DRIVES:
        prescribed_bodies.turn_faces(
            counts[tick_counts.MANIFOLDS], motion.body_count, driven, colliders, constraints,
            bodies,
        )  # fmt: skip
    goes_on, further, iteration = True, 0, 0
    while goes_on:
        rest = REST if iteration + 1 < relaxations else (STIRRED if further == 0 else NEAR)
        step = 1.0 if iteration < relaxations or further > 0 else STEP
        changed = relax(
            lanes, batch_count, 1.0 / now.substep, iteration, rest, step, rows, scratch, batches,
            bodies,
        )  # fmt: skip
        iteration += 1
        goes_on = changed and iteration < max(relaxations, PASSES)
        if not goes_on and iteration > max(1, relaxations):
            goes_on = go_ahead(further, lanes, WIDTH, 0.0, group.members, constraints, bodies)
            iteration = max(relaxations, PASSES)
            further += 1
    if last:
        jammed.hold(1.0 / now.substep, group.members, constraints, bodies)
    if DRIVES:
        find_works_of_drives(
            prescribed_bodies.SUBSTEP, motion, driven, colliders, constraints, bodies, counts
        )
        prescribed_bodies.add_works(touching, driven, bodies)
    if not last:
        start_substep(lanes, batch_count, rows, scratch, batches, bodies)
    if FLOWS:
        variable_mass.scale_to_start_mass(flows, bodies)
        variable_mass.scale_warm_start(flows, bodies)
    scatter_momenta(group, bodies)
    if last and not COUPLED:
        account.add_work(group, bodies)
        account.add_half_the_torque(now.h, group, bodies)


@inline
def scatter_momenta(group: Group, bodies: Array) -> None:
    """Give the momenta of the solver back to the bodies."""
    solver_bodies.scatter_momenta(group, bodies)
    pivots.stand_still(group.motion.pivoted, group.motion.translation)


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
            prescribed_bodies.BOUNCE, motion, driven, colliders, constraints, bodies, counts
        )
    restitution_bound.bound_restitution(
        counts[tick_counts.MANIFOLDS], batch_count, motion.body_count, WIDTH, touching,
        constraints, energy, driven.of_bodies, bodies,
    )  # fmt: skip
    if DRIVES:
        find_works_of_drives(
            prescribed_bodies.BOUNCE, motion, driven, colliders, constraints, bodies, counts
        )
        prescribed_bodies.add_works(touching, driven, bodies)
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


def _give_a_hand(tick, h, world):
    """Help with parts of ticks, until the call is over; tick: number of the first of the call."""
    kind = crew.wait_for_post(world.crew)
    while kind != crew.NOTHING:
        if kind == crew.BODIES:
            gather_some_bodies(world)
        elif kind == crew.COLLIDERS:
            find_some_reaches(h, world)
        elif kind == crew.MANIFOLDS:
            find_some_manifolds(h, world)
        elif kind == crew.GROUPS:
            pass_groups(tick, h, world)
        else:
            store_some_impulses(h / world.settings[tick_settings.SUBSTEPS], world)
        kind = crew.wait_for_post(world.crew)


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


def _meet_at_instant(time, world):
    """Look at an impact at a time [s], with the bodies as they are, or let it happen; if told."""
    motion, colliders, counts = world.motion, world.colliders, world.counts
    if counts[tick_counts.INSTANT] == tick_counts.NOTHING:
        return
    if DRIVES:
        now = Tick(time, time, 0.0, 0.0, 1)
        drive(now, world.driven, colliders, world.bodies, world.sleep, counts)
    gather_bodies(world)
    if FLOWS:
        variable_mass.find_mass_scale(time, world.flows)
        flight.take_mass_scales(world.flows, world.flights)
    narrow_phase.find_poses(
        0, counts[tick_counts.COLLIDERS], motion.rigid_count, motion.translation, motion.rotation,
        colliders.table, world.detection.local_poses, colliders.poses,
    )  # fmt: skip
    strikes = counts[tick_counts.INSTANT] == tick_counts.STRIKES
    meet_now(strikes, world.constraints.impulse_cache, world.flights, counts)
    pivots.stand_still(motion.pivoted, motion.translation)


_STAGES = (
    _evaluate_forces, _gather_body, _gather_some_bodies, _gather_bodies, _find_some_reaches,
    _find_pairs, _find_some_manifolds, _detect_contacts, _drive,
    _find_works_of_drives, _colour_constraints, _arrange_constraints, _prepare_group,
    _find_first_loads, _begin_energy_balance, _solve_contacts, _move_all, _move_group, _move_free,
    _correct_forces, _gather_moved_bodies, _follow_and_relax, _end_substep, _pass_substeps,
    _pass_group, _pass_groups, _bound_bounces, _give_impacts, _catch_up_balls, _take_back_gains,
    _store_some_impulses, _store_impulses, _give_a_hand, _put_to_sleep, _meet_at_instant,
)  # fmt: skip
# named twice, or more often
_OF_THE_CREW = (
    _gather_some_bodies, _find_some_reaches, _find_some_manifolds, _pass_groups,
    _store_some_impulses,
)  # fmt: skip


def tick_kernel(name: str, **bindings: Any) -> Callable[..., Any]:
    """Make the kernel of one scene; `bindings` are the slots that others than the stages fill."""
    offered = dict(bindings)
    offered['move_block'] = specialise(_move_block, name=name, offered=offered)
    for stage in _STAGES:
        inlined = stage not in _OF_THE_CREW
        offered[stage.__name__[1:]] = specialise(
            stage, name=name, inlined=inlined, offered=offered
        )
    return specialise(_advance, name=name, widest=False, offered=offered)
