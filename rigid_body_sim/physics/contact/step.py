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
    balls:     are given the impulses of impacts that were followed (`solver.impact_sequence`)
    restitution:  which returns no more energy than the impact took; balls catch up with the way
               that they have missed
    energy:    what contact gave by its errors is taken back
    store:     impulses, for the next tick
    sleep:     islands that are at rest

The stages are in files of their own: `detection` (with events), `assembly` (what is prepared),
`substeps`, and `tick_end` (from restitution on).

What has nothing to do with each other is done in parts, by whoever is there (`crew`): what is
before the narrow phase some bodies and colliders at a time, the narrow phase some pairs, from
`prepare` on groups of islands (`_pass_groups`) and bodies that touch nobody, and what is stored.

Where islands may sleep, sleepers are left out (`islands.sleep`): who wakes is known before
anything has changed, who falls asleep at the end of a tick; both return to Python, for impulse
caches to be put in order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.contact import (
    assembly,
    crew,
    detection,
    packed_bodies,
    solver_bodies,
    tick_counts,
    tick_end,
    tick_settings,
)
from rigid_body_sim.physics.contact.array_groups import Group, Motion
from rigid_body_sim.physics.contact.assembly import constraints_of, count_touching
from rigid_body_sim.physics.contact.collision import (
    deep_overlaps,
    narrow_phase,
    neighbour_list,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.events import flight
from rigid_body_sim.physics.contact.islands import (
    left_sinking,
    sleep,
)
from rigid_body_sim.physics.contact.islands.sleep import SleepState
from rigid_body_sim.physics.contact.solver import (
    ball_impacts,
    colouring,
    group_record,
    lane_scratch,
    pivots,
    variable_mass,
)
from rigid_body_sim.physics.contact.substeps import STAGES as STAGES_OF_SUBSTEPS
from rigid_body_sim.physics.contact.tick_world import Detection, Tick
from rigid_body_sim.physics.integration.schemes import steps

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# bound for each scene
WIDTH = slot('[-] numbers of a contact point')
BOUNCES = slot('[-] whether anything bounces')
BALLS_MEET = slot('[-] whether two balls may meet: `solver.ball_impacts`')
COUPLED = slot('[-] whether a force depends on the state')
APART = slot('[-] whether islands may pass their substeps one after the other')
EVENTS = slot('[-] whether impacts come at their instants')
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
SLEEPING = slot('[-] whether islands may sleep')
FLOWS = slot('[-] whether the mass of a body that touches changes')
DRIVES = slot('[-] whether some bodies are moved as told, or have a belt')
# the stages
evaluate_forces = slot('kernel (time, motion, forces)')
gather_some_bodies = slot('kernel (world): some bodies as they are at the start')
gather_bodies = slot('kernel (world): bodies as they are at the start')
find_some_reaches = slot('kernel (h, world): poses and swept AABBs of some colliders')
find_some_manifolds = slot('kernel (h, world): parts of the narrow phase')
detect_contacts = slot('kernel (number, h, world): tells whether the manifolds are there')
meet_now = slot('kernel (strikes, cache, flights, counts): impacts at the present instant')
drive = slot('kernel (now, ...): puts driven bodies where they are; tells whether nobody wakes')
arrange_constraints = slot('kernel (now, ...): tells whether there is room for constraints')
prepare_group = slot('kernel (now, constraints, ...): makes the constraints of a group')
find_first_loads = slot('kernel (now, touching, ...): what is carried when the scene begins')
begin_energy_balance = slot('kernel (h, touching, motion, bodies)')
move_free = slot('kernel (part, now, world): moves over the tick who touches nobody')
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
        parts = counts[tick_counts.GROUPS] + (crew.parts_of(motion.body_count) if APART else 0)
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
    *detection.STAGES, *assembly.STAGES, *STAGES_OF_SUBSTEPS, *tick_end.STAGES,
    _pass_group, _pass_groups, _give_a_hand, _meet_at_instant,
)  # fmt: skip
_NAMED_OFTEN = {
    'gather_some_bodies', 'find_some_reaches', 'find_some_manifolds', 'move_block', 'pass_groups',
    'store_some_impulses',
}  # fmt: skip


def tick_kernel(name: str, **bindings: Any) -> Callable[..., Any]:
    """Make the kernel of one scene; `bindings` are the slots that others than the stages fill."""
    offered = dict(bindings)
    for stage in _STAGES:
        slot_name = stage.__name__[1:]
        offered[slot_name] = specialise(
            stage, name=name, inlined=slot_name not in _NAMED_OFTEN, offered=offered
        )
    return specialise(_advance, name=name, widest=False, offered=offered)
