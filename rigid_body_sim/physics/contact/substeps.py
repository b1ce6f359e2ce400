# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The substeps of a group of islands: soft normals, motion, separations, relaxation with friction.

    each substep h:
        p += h/2 F, L += h/2 torque, and half the warm-start impulses
        solve:    soft normals of all contacts, which do not pull
        integrate: x += h v, q by the free rotation of the integrator, L fixed
        p += h/2 F, L += h/2 torque
        update separation, and the other half of the warm-start impulses, there
        relax:    normals without push-out, and friction

So all that acts, acts in two halves about the motion: what is carried, slides or pivots moves to
second order, as what flies does (velocity Verlet). Whom no contact carries moves as without
contact. Force elements are evaluated after each motion: those of then act for the second half.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, slot
from rigid_body_sim.physics.contact import (
    crew,
    packed_bodies,
    prescribed_bodies,
    solver_bodies,
    tick_counts,
    tick_settings,
    works_of_drives,
)
from rigid_body_sim.physics.contact.array_groups import Group
from rigid_body_sim.physics.contact.assembly import batch_count_of
from rigid_body_sim.physics.contact.energy import account
from rigid_body_sim.physics.contact.islands import jammed, sleep
from rigid_body_sim.physics.contact.islands.unsettled import NEAR, go_ahead
from rigid_body_sim.physics.contact.solver import forces_of_state, pivots, variable_mass
from rigid_body_sim.physics.contact.solver.iterations import PASSES
from rigid_body_sim.physics.contact.solver.solve import STRUCK
from rigid_body_sim.physics.integration.schemes import steps
from rigid_body_sim.physics.state import blocks

Array = NDArray[np.float64]

# Passes over the constraints, before and after the motion, PASSES at most: after the first, of
# what the last one has changed by more than STRUCK. Islands left unsettled go on as a whole
# (`islands.unsettled`): what is left of an impact, or of a heavy load, sinks in over a substep,
# and is lifted again with a gain of energy.
STIRRED = 1e-4  # [m/s] the same after the motion; with ten times more heaps tremble so much more
STEP = 1.7  # [-] over-relaxation of those passes where balls meet (SOR)
REST = 1e-7  # [m/s] the same for the first `relaxations` passes; more lets stacks tremble

WIDTH = slot('[-] numbers of a contact point')
ANGULAR = slot('[-] whether anything rolls or twists with friction')
COUPLED = slot('[-] whether a force depends on the state')
APART = slot('[-] whether islands may pass their substeps one after the other')
VELOCITY_DEPENDENT = slot('[-] whether a force depends on velocity')
SLEEPING = slot('[-] whether islands may sleep')
FLOWS = slot('[-] whether the mass of a body that touches changes')
DRIVES = slot('[-] whether some bodies are moved as told, or have a belt')
drift_rotation = slot('kernel (block, lanes, kick, h, rotation, method): kicks L and turns q')
evaluate = slot('kernel (place, time, translation, rotation, elements, ranges): adds wrenches')
solve_normals = slot('kernel (lanes, batches, 1/h, slop, cap, rows, ...): solves soft normals')
update_separation = slot('kernel (lanes, batches, rows, ...): lets points follow the bodies')
relax = slot('kernel (lanes, batches, 1/h, first, rows, ...): relaxes normals, and friction')
start_substep = slot('kernel (lanes, batches, rows, ...): warm start of the next substep')
evaluate_forces = slot('kernel (time, motion, forces)')
find_works_of_drives = slot('kernel (when, ...): of driven bodies on others')
solve_contacts = slot('kernel (index, now, group, ...): warm start and soft normals')
move_block = slot('kernel (block, count, ...): moves bodies of a block over a substep')
move_all = slot('kernel (now, group, bodies, state): moves all bodies over a substep')
move_group = slot('kernel (now, group, bodies, packed): moves the bodies of a group')
correct_forces = slot('kernel (time, now, touching, ...): forces of after the motion')
gather_moved_bodies = slot('kernel (group, bodies)')
follow_and_relax = slot('kernel (index, now, group, ...): separations, then relaxation')
end_substep = slot('kernel (index, now, group, ...): motion of a substep, and what follows')


def _evaluate_forces(time, motion, forces):
    """Evaluate all force elements at a time [s]."""
    translation, rotation = motion.translation, motion.rotation
    steps.start_evaluation(motion.body_count, motion.rigid_count, translation, rotation)
    evaluate(0, time, translation, rotation, forces.elements, forces.ranges)


def _find_works_of_drives(when, motion, driven, colliders, constraints, bodies, counts):
    """Find what driven bodies did on others: see `works_of_drives.find_works`."""
    works_of_drives.find_works(
        when, counts[tick_counts.MANIFOLDS], motion.body_count, WIDTH, ANGULAR, colliders, driven,
        constraints, bodies,
    )  # fmt: skip


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
    of_part = crew.BODIES_OF_PART // blocks.LANES
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


def _gather_moved_bodies(group, bodies):
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
    gather_moved_bodies(group, bodies)
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
            works_of_drives.SUBSTEP, motion, driven, colliders, constraints, bodies, counts
        )
        works_of_drives.add_works(touching, driven, bodies)
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


# in the order in which `step` makes them
STAGES = (
    _evaluate_forces, _find_works_of_drives, _begin_energy_balance, _solve_contacts, _move_block,
    _move_all, _move_group, _move_free, _correct_forces, _gather_moved_bodies, _follow_and_relax,
    _end_substep, _pass_substeps,
)  # fmt: skip
