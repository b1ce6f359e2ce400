# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Islands that sleep: who falls asleep, who wakes, and how a sleeper keeps still.

An island falls asleep at the end of a tick if something that cannot move holds it and each of its
bodies has, for `sleep_time` without a break,

    touched something        |v| < sleep_speed,  |omega| r < sleep_speed
    felt the same wrench     |F - F'| <= STEADY |F|,  |T - T'| <= STEADY (|T| + |F| r)
    kept its mass

    r      : [m] radius of the ball about the centre of mass that holds its shape
    F, T   : all but contacts; F', T' when the time began to count

Its momenta become zero: what was left of them is lost, at most m sleep_speed a body. To detection
and solver a sleeper is like what cannot move; its contacts with sleepers and with what cannot move
are neither looked for nor solved.

An island wakes, as a whole and before anything else happens in a tick, if momentum or wrench of a
body are no longer those it fell asleep with, to the bit (impulses, commands, forces that begin or
end), or if something awake may touch it within the tick. Its contacts then go on with the impulses
they had.

Limits: whatever creeps more slowly than `sleep_speed` is stopped, a ball that rolls without
resistance too. An island wakes and sleeps as one, however large it is.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.array_groups import Constraints, Motion
from rigid_body_sim.physics.contact.collision import (
    collider_record,
    manifold_record,
    narrow_phase,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.collider_record import STATIC
from rigid_body_sim.physics.contact.islands import sleep_record
from rigid_body_sim.physics.contact.islands.islands import find_islands, may_touch
from rigid_body_sim.physics.contact.islands.sleep_record import AWAKE
from rigid_body_sim.physics.contact.solver import variable_mass
from rigid_body_sim.physics.state import blocks
from rigid_body_sim.physics.vectors import (
    apply_symmetric,
    dot,
    load,
    load_strided,
    load_symmetric,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

STEADY = 1e-5  # [-] change of a wrench that drives a body; springs at rest jitter by less

NOBODY = -1  # ends the list of the restless
SOME_WAKES = -1  # in place of a count


class SleepState(NamedTuple):
    """
    What is known of sleep.

    sleep_states     : of each body, see `sleep_record`
    radii            : [m] of each body, r above
    element_groups   : of each body, some body, the same for all that force elements join
    island_roots     : of each body, the first of its island: see `islands`
    supported        : 1 for roots of islands that something which cannot move pushes
    restless         : sleepers that share a block with what moves, ended by NOBODY
    awake_in_blocks  : how many bodies of each block are awake
    """

    sleep_states: Array
    radii: Array
    element_groups: Indices
    island_roots: Indices
    supported: Indices
    restless: Indices
    awake_in_blocks: Indices


def make_sleep_state(radii: Array, element_groups: Indices) -> SleepState:
    """Make the state of bodies of which all are awake."""
    count = len(radii)
    return SleepState(
        sleep_states=np.zeros(count * sleep_record.SIZE),
        radii=radii,
        element_groups=element_groups,
        island_roots=np.zeros(count, dtype=np.int64),
        supported=np.zeros(count, dtype=np.int64),
        restless=np.full(count + 1, NOBODY, dtype=np.int64),
        awake_in_blocks=np.zeros(blocks.blocks(count), dtype=np.int64),
    )


@inline
def asleep(body: int, sleep: Array) -> bool:
    """Tell whether a body sleeps."""
    return sleep[body * sleep_record.SIZE + sleep_record.ISLAND] != AWAKE


@inline
def _mark_woken(body: int, sleep: Array) -> None:
    """Mark the island of a sleeper: it wakes."""
    island = body * sleep_record.SIZE + sleep_record.ISLAND
    sleep[island] = -abs(sleep[island])


@inline
def _asleep_in_table(core: int) -> int:
    """How the table names a body that sleeps, and back: below STATIC."""
    return -2 - core


@inline
def _core_of(named: int) -> int:
    """Core index of a body that sleeps or not, as the table names it; STATIC stays so."""
    return named if named >= STATIC else _asleep_in_table(named)


@inline
def stirs(block: int, state: SleepState) -> Any:
    """Tell whether some body of a block is awake."""
    return state.awake_in_blocks[block] > 0


@kernel
def place_sleepers(
    collider_count: int,
    motion: Motion,
    colliders: ColliderArrays,
    local_poses: Array,
    bodies: Array,
    sleep: Array,
) -> None:
    """Give sleepers the poses they keep, and let the table say who sleeps."""
    table, swept = colliders.table, colliders.swept_aabbs
    for index in range(collider_count):
        entry = index * collider_record.SIZE + collider_record.BODY
        table[entry] = _core_of(table[entry])
    narrow_phase.find_poses(
        0, collider_count, motion.rigid_count, motion.translation, motion.rotation, table,
        local_poses, colliders.poses,
    )  # fmt: skip
    for index in range(collider_count):
        core = table[index * collider_record.SIZE + collider_record.BODY]
        if core >= 0 and asleep(core, sleep):
            table[index * collider_record.SIZE + collider_record.BODY] = _asleep_in_table(core)
            row = index * swept_aabbs.SIZE
            store(swept, row + swept_aabbs.VELOCITY, (0.0, 0.0, 0.0))
            swept[row + swept_aabbs.TURNING] = 0.0
    for body in range(motion.body_count):
        if asleep(body, sleep):
            solver_bodies.begin_tick(
                body, motion.rigid_count, motion.translation, motion.rotation, bodies
            )


@inline
def _force(body: int, motion: Motion) -> Any:
    """Force upon a body without contacts [N]."""
    place = blocks.at(body, blocks.TRANSLATION) + blocks.FX
    return load_strided(motion.translation, place, blocks.LANES)


@inline
def _torque(body: int, motion: Motion) -> Any:
    """Torque upon a rigid body without contacts [N m]."""
    place = blocks.at(body, blocks.ROTATION) + blocks.TX
    return load_strided(motion.rotation, place, blocks.LANES)


@inline
def _equal(first: Any, second: Any) -> bool:
    return first[0] == second[0] and first[1] == second[1] and first[2] == second[2]


@inline
def _same_wrench(body: int, motion: Motion, sleep: Array) -> bool:
    row = body * sleep_record.SIZE
    same = _equal(_force(body, motion), load(sleep, row + sleep_record.FORCE))
    if body < motion.rigid_count:
        same = same and _equal(_torque(body, motion), load(sleep, row + sleep_record.TORQUE))
    return same


@inline
def _still(body: int, motion: Motion) -> bool:
    at_rest = (0.0, 0.0, 0.0)
    place = blocks.at(body, blocks.TRANSLATION) + blocks.PX
    still = _equal(load_strided(motion.translation, place, blocks.LANES), at_rest)
    if body < motion.rigid_count:
        place = blocks.at(body, blocks.ROTATION) + blocks.LX
        still = still and _equal(load_strided(motion.rotation, place, blocks.LANES), at_rest)
    return still


@inline
def _list_restless(motion: Motion, state: SleepState) -> None:
    count = 0
    for block in range((motion.body_count + blocks.LANES - 1) // blocks.LANES):
        if stirs(block, state):
            first = blocks.LANES * block
            for body in range(first, min(first + blocks.LANES, motion.body_count)):
                if asleep(body, state.sleep_states):
                    state.restless[count] = body
                    count += 1
    state.restless[count] = NOBODY


@kernel
def count_awake(motion: Motion, state: SleepState) -> int:
    """Count the bodies that are awake; SOME_WAKES: some sleeper, now marked, wakes."""
    awake = 0
    woken = False
    for block in range((motion.body_count + blocks.LANES - 1) // blocks.LANES):
        here = 0
        first = blocks.LANES * block
        for body in range(first, min(first + blocks.LANES, motion.body_count)):
            if not asleep(body, state.sleep_states):
                here += 1
            elif not (_still(body, motion) and _same_wrench(body, motion, state.sleep_states)):
                _mark_woken(body, state.sleep_states)
                woken = True
        state.awake_in_blocks[block] = here
        awake += here
    if woken:
        return SOME_WAKES
    _list_restless(motion, state)
    return awake


@kernel
def wake_touched(
    manifold_count: int, h: float, colliders: ColliderArrays, manifolds: Array, sleep: Array
) -> bool:
    """Tell whether something awake may touch a sleeper within the tick, and mark whom."""
    some = False
    table = colliders.table
    for manifold in range(manifold_count):
        record = manifold * manifold_record.SIZE
        collider_a = int(manifolds[record + manifold_record.COLLIDER_A])
        collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
        least = min(
            table[collider_a * collider_record.SIZE + collider_record.BODY],
            table[collider_b * collider_record.SIZE + collider_record.BODY],
        )
        if least < STATIC and may_touch(manifold, h, colliders.swept_aabbs, manifolds):
            _mark_woken(_core_of(least), sleep)
            some = True
    return some


@kernel
def keep_still(motion: Motion, state: SleepState, bodies: Array) -> None:
    """Put the sleepers of blocks that moved back to the bit."""
    index = 0
    while state.restless[index] != NOBODY:
        body = state.restless[index]
        index += 1
        row = body * solver_bodies.SIZE
        _stop(body, motion)
        place = blocks.at(body, blocks.TRANSLATION)
        position = load(bodies, row + solver_bodies.START_POSITION)
        residual = load(bodies, row + solver_bodies.START_RESIDUAL)
        store_strided(motion.translation, place + blocks.RX, blocks.LANES, position)
        store_strided(motion.translation, place + blocks.EX, blocks.LANES, residual)
        if body < motion.rigid_count:
            place = blocks.at(body, blocks.ROTATION) + blocks.QX
            for entry in range(4):
                motion.rotation[place + blocks.LANES * entry] = bodies[
                    row + solver_bodies.START_ORIENTATION + entry
                ]


@inline
def _stop(body: int, motion: Motion) -> None:
    """Take all momentum."""
    nothing = (0.0, 0.0, 0.0)
    place = blocks.at(body, blocks.TRANSLATION)
    store_strided(motion.translation, place + blocks.PX, blocks.LANES, nothing)
    store_strided(motion.translation, place + blocks.GX, blocks.LANES, nothing)
    if body < motion.rigid_count:
        place = blocks.at(body, blocks.ROTATION) + blocks.LX
        store_strided(motion.rotation, place, blocks.LANES, nothing)


@inline
def _is_slow(body: int, radius: float, limit: float, bodies: Array) -> bool:
    row = body * solver_bodies.SIZE
    momentum = load(bodies, row + solver_bodies.MOMENTUM)
    speed = bodies[row + solver_bodies.INVERSE_MASS] * math.sqrt(dot(momentum, momentum))
    angular_velocity = apply_symmetric(
        load_symmetric(bodies, row + solver_bodies.INVERSE_INERTIA),
        load(bodies, row + solver_bodies.ANGULAR_MOMENTUM),
    )
    return speed < limit and radius * math.sqrt(dot(angular_velocity, angular_velocity)) < limit


@inline
def _note_wrench(body: int, motion: Motion, sleep: Array) -> None:
    row = body * sleep_record.SIZE
    store(sleep, row + sleep_record.FORCE, _force(body, motion))
    if body < motion.rigid_count:
        store(sleep, row + sleep_record.TORQUE, _torque(body, motion))


@inline
def _is_steady(body: int, radius: float, motion: Motion, sleep: Array) -> bool:
    row = body * sleep_record.SIZE
    force = _force(body, motion)
    change = subtract(force, load(sleep, row + sleep_record.FORCE))
    size = dot(force, force)
    steady = dot(change, change) <= STEADY * STEADY * size
    if body < motion.rigid_count:
        torque = _torque(body, motion)
        change = subtract(torque, load(sleep, row + sleep_record.TORQUE))
        size *= radius * radius
        size = size + torque[0] * torque[0] + torque[1] * torque[1] + torque[2] * torque[2]
        steady = steady and dot(change, change) <= STEADY * STEADY * size
    return steady


@inline
def _is_tired(timer: float, sleep_time: float) -> bool:
    """Tell whether a body has rested long enough, and in this tick."""
    return timer >= sleep_time and timer > 0.0


@inline
def _count_time(
    h: float, sleep_speed: float, touching: Indices, motion: Motion, state: SleepState,
    bodies: Array,
) -> None:  # fmt: skip
    """Count the time that bodies rest: a timer that does not count in this tick becomes zero."""
    sleep = state.sleep_states
    for index in range(len(touching)):
        body = touching[index]
        timer = body * sleep_record.SIZE + sleep_record.TIMER
        radius = state.radii[body]
        if not _is_steady(body, radius, motion, sleep):
            _note_wrench(body, motion, sleep)
        elif _is_slow(body, radius, sleep_speed, bodies):
            sleep[timer] = -(sleep[timer] + h)  # the sign: in this tick
    for body in range(motion.body_count):
        timer = body * sleep_record.SIZE + sleep_record.TIMER
        rested = -sleep[timer]
        sleep[timer] = rested if rested > 0.0 else 0.0


@inline
def _some_are_tired(sleep_time: float, body_count: int, sleep: Array) -> bool:
    for body in range(body_count):
        if _is_tired(sleep[body * sleep_record.SIZE + sleep_record.TIMER], sleep_time):
            return True
    return False


@kernel
def keep_awake(start: float, flows: Array, sleep: Array) -> None:
    """Let nothing whose mass changes after a time [s] grow tired: each tick has another weight."""
    for row in range(0, len(flows), variable_mass.SIZE):
        if start < flows[row + variable_mass.END]:
            body = int(flows[row + variable_mass.BODY])
            sleep[body * sleep_record.SIZE + sleep_record.TIMER] = 0.0


@kernel
def update_sleep(
    h: float, sleep_speed: float, sleep_time: float, whole: bool, manifold_count: int,
    touching: Indices, motion: Motion, colliders: ColliderArrays,
    constraints: Constraints, state: SleepState, bodies: Array,
) -> int:  # fmt: skip
    """
    Count the time that bodies rest, and let islands fall asleep; return how many bodies did.

    whole    : not a piece of a tick: in the middle of one nobody falls asleep
    touching : the bodies with contacts in this tick, whose rows in `bodies` are current
    """
    sleep, roots, supported = state.sleep_states, state.island_roots, state.supported
    _count_time(h, sleep_speed, touching, motion, state, bodies)
    if not (whole and _some_are_tired(sleep_time, motion.body_count, sleep)):
        return 0
    find_islands(
        manifold_count, motion.body_count, h, colliders.table, colliders.swept_aabbs,
        constraints.manifolds, constraints.impulse_cache, state.element_groups, roots, supported,
    )  # fmt: skip
    for body in range(motion.body_count):
        timer = sleep[body * sleep_record.SIZE + sleep_record.TIMER]
        if not _is_tired(timer, sleep_time):
            supported[roots[body]] = 0
    fell = 0
    for body in range(motion.body_count):
        if supported[roots[body]] == 1:
            sleep[body * sleep_record.SIZE + sleep_record.ISLAND] = float(1 + roots[body])
            _stop(body, motion)
            fell += 1
    return fell


@kernel
def note_wrenches(motion: Motion, sleep: Array) -> None:
    """Note the wrenches with which bodies fell asleep in this tick."""
    for body in range(motion.body_count):
        timer = body * sleep_record.SIZE + sleep_record.TIMER
        if sleep[timer] > 0.0 and asleep(body, sleep):
            sleep[timer] = 0.0
            _note_wrench(body, motion, sleep)
