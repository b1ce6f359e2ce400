# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The constraints of a tick, made of its manifolds: coloured into batches, in groups of islands, with
the impulses of the last tick (warm start) and effective masses; before the first tick the loads of
what stands.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.contact import (
    prescribed_bodies,
    solver_bodies,
    tick_counts,
    tick_settings,
)
from rigid_body_sim.physics.contact.array_groups import Constraints, Group, Motion
from rigid_body_sim.physics.contact.collision import recycled_record
from rigid_body_sim.physics.contact.islands import first_loads
from rigid_body_sim.physics.contact.islands.solver_groups import find_groups, sort_touching
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    cache_record,
    colouring,
    common_pressure,
    group_record,
    impulse_cache,
    manifold_constraints,
    pivots,
    variable_mass,
)
from rigid_body_sim.physics.contact.solver.softness import Softness
from rigid_body_sim.physics.contact.tick_world import Tick
from rigid_body_sim.physics.contact.touching import list_touching

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


WIDTH = slot('[-] numbers of a contact point')
ANGULAR = slot('[-] whether anything rolls or twists with friction')
CURVED = slot('[-] whether layers about cores may meet: `solver.curved_cores`')
APART = slot('[-] whether islands may pass their substeps one after the other')
FLOWS = slot('[-] whether the mass of a body that touches changes')
DRIVES = slot('[-] whether some bodies are moved as told, or have a belt')
RECYCLES = slot('[-] whether manifolds of some pairs follow their bodies')
prepare = slot('kernel (lanes, batches, threshold, rows, ...): effective masses and warm start')
relax = slot('kernel (lanes, batches, 1/h, first, rows, ...): relaxes normals, and friction')
spread_friction = slot('kernel (lanes, batches, rows, ...): friction of patches to points')
gather_body = slot('kernel (body, motion, bodies): a body as it is at the start')
colour_constraints = slot('kernel (body_count, ...): tells whether there was room')


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
        constraints.colours, constraints.partners, constraints.open_batches,
        constraints.impulse_cache, constraints.groups, constraints.group_of,
        constraints.order[first:last], constraints.places, constraints.roots,
        constraints.unsettled, constraints.members[first:last], constraints.scratch,
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


# in the order in which `step` makes them
STAGES = (
    _colour_constraints, _arrange_constraints, _prepare_group, _find_first_loads,
)  # fmt: skip
