# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Passes over all batches of contacts: what the equations of `passes` are visited for, and in which
order.

    g : scratch at the head of the rows; s : manifolds of one batch; q : one point of each

`lanes` are eight, or four where a batch has no more, which must not be known to the compiler: it
would unroll the loops over the lanes and lose SIMD, which is five times faster. So `most`, always
eight, comes from outside.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, specialise, unbound
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    constraint,
    lane_scratch,
    prepare,
    restitution,
    rolling_frame,
    rolling_friction,
    separation,
    solve,
    warm_start,
)
from rigid_body_sim.physics.state.blocks import wide

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SWEEPS = 40  # of the bounce, at most; a stack of that many balls is not yet at rest

# A batch that is struck is visited again until it is calm: what an impact leaves of the approach
# sinks in over the next substep, and what pushes it out again lifts the body.
VISITS = 20  # at most
# [m/s] changes of a normal velocity: a blow to what moves on, to what is about to move (what it
# sinks in is lifted again); what is left alone
IMPACT, KNOCK, CALM = 0.02, 0.002, 1e-4
REST = 1e-7  # [m/s] what a pass has changed by less gets no second pass

# bound for each scene by `specialise`
WIDTH = 144  # numbers of a point
ANGULAR = False  # whether anything rolls or twists with friction
TURNS = True  # whether the inertia of anything turns with it, or changes
RIMS = False  # whether a cylinder may touch a plane or a box
follow_points: Callable[..., Any] = unbound
BOUNCES = False  # whether anything bounces


@inline
def _changes(used: int, g: Array) -> bool:
    """Tell whether a visit has changed more than is calm; let calm lanes stand still then."""
    largest = 0.0
    for k in range(used):
        change = g[k + lane_scratch.NORMAL_CHANGE]
        largest = change if change > largest else largest
    if not largest > 0.0:
        return False
    for k in range(used):
        g[k + lane_scratch.ACTIVE] = 1.0 if g[k + lane_scratch.NORMAL_CHANGE] > 0.0 else 0.0
        g[k + lane_scratch.NORMAL_CHANGE] = 0.0
    return True


def _prepare(
    most: int, count: int, threshold: float, rows: Array, batches: Indices, bodies: Array
) -> None:  # fmt: skip
    """
    Find tangents, gains and speeds of approach, and what the last tick left to start from.

    threshold : [m/s] slower impacts do not bounce
    """
    g = rows[0 : lane_scratch.SIZE]
    for batch in range(count):
        points = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT]
        used = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        lanes = min(wide(used), most)
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        s = rows[begin : begin + constraint.SIZE]
        begin += constraint.SIZE
        warm_start.clear(lanes, g)
        for point in range(points):
            q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
            warm_start.turn(lanes, s, q, g)
            if ANGULAR:
                warm_start.turn_twist(lanes, s, q, g)
        warm_start.give(used, solver_bodies.WARM_IMPULSE, s, g, bodies)
        solve.gather_inertia(used, s, bodies)
        solve.gather(lanes, used, s, g, bodies)
        for point in range(points):
            q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
            prepare.gains(lanes, s, q, g)
        if ANGULAR:
            prepare.angular_gains(lanes, s, g)
        if BOUNCES:
            prepare.gather_accelerations(used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                prepare.approach(lanes, threshold, s, q, g)


def _solve_normals(
    most: int, count: int, inverse_h: float, slop: float, cap: float, rows: Array,
    batches: Indices, bodies: Array,
) -> None:  # fmt: skip
    """Visit the normals of all batches, softly."""
    g = rows[0 : lane_scratch.SIZE]
    for batch in range(count):
        points = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT]
        used = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        lanes = min(wide(used), most)
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        s = rows[begin : begin + constraint.SIZE]
        begin += constraint.SIZE
        solve.gather(lanes, used, s, g, bodies)
        visits = VISITS if points > 1 else 1
        for visit in range(visits):
            calm = KNOCK if visit == 0 else CALM
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                solve.push(lanes, s, q, g, inverse_h, slop, cap, calm)
                if ANGULAR:
                    rolling_friction.release(lanes, s, q, g)
            if visit + 1 < visits and not _changes(used, g):
                break
        solve.scatter(used, s, g, bodies)
        solve.mark_carried(used, s, g, bodies)


def _update_separation(
    most: int, count: int, rows: Array, batches: Indices, bodies: Array
) -> None:
    """Move points, arms and gaps of all batches with the bodies; give the second half of loads."""
    g = rows[0 : lane_scratch.SIZE]
    for batch in range(count):
        points = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT]
        used = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        lanes = min(wide(used), most)
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        s = rows[begin : begin + constraint.SIZE]
        begin += constraint.SIZE
        if TURNS:
            solve.gather_inertia(used, s, bodies)
        warm_start.clear(lanes, g)
        if batches[batch * batch_record.SIZE + batch_record.KIND] > 0:
            separation.gather_way(used, s, g, bodies)
            separation.follow_balls(lanes, s, rows[begin : begin + WIDTH], g)
            if ANGULAR:
                rolling_friction.load(lanes, s, rows[begin : begin + WIDTH], g)
        else:
            separation.gather_motion(used, s, g, bodies)
            if RIMS:
                rolling_frame.go_round(used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                follow_points(lanes, s, q, g)
                if ANGULAR:
                    rolling_friction.load(lanes, s, q, g)
        warm_start.give(used, solver_bodies.MOMENTUM, s, g, bodies)


def _relax(
    most: int, count: int, inverse_h: float, first: bool, last: bool, rows: Array,
    batches: Indices, bodies: Array,
) -> None:  # fmt: skip
    """
    Visit normals and friction of all batches.

    first : visit all; else those in which the last pass has changed something
    last  : add up the loads from which the next substep starts
    """
    g = rows[0 : lane_scratch.SIZE]
    for batch in range(count):
        points = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT]
        used = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        lanes = min(wide(used), most)
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        s = rows[begin : begin + constraint.SIZE]
        begin += constraint.SIZE
        visits = (
            VISITS
            if points > 1 or batches[batch * batch_record.SIZE + batch_record.KIND] == 0
            else 1
        )
        solve.gather(lanes, used, s, g, bodies)
        if not first and not solve.wait(used, s, g):
            visits = 0
        for visit in range(visits):
            calm = IMPACT if visit == 0 else CALM
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                solve.relax(lanes, s, q, g, inverse_h, calm, REST)
                if ANGULAR:
                    rolling_friction.resist(lanes, s, q, g)
            if visit + 1 < visits and not _changes(used, g):
                break
        if visits > 0:
            solve.note_unrest(used, s, g)
            solve.scatter(used, s, g, bodies)
        if last:
            warm_start.clear(lanes, g)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                warm_start.carry_on(lanes, s, q, g)
                if ANGULAR:
                    warm_start.carry_twist_on(lanes, s, q, g)
            warm_start.give(used, solver_bodies.WARM_IMPULSE, s, g, bodies)


def _apply_restitution(most: int, count: int, rows: Array, batches: Indices, bodies: Array) -> Any:
    """Let bounce what bounces, sweep by sweep until nothing changes; return the sweeps."""
    g = rows[0 : lane_scratch.SIZE]
    for sweep in range(SWEEPS):
        change = 0.0
        for batch in range(count):
            points = batches[batch * batch_record.SIZE + batch_record.POINT_COUNT]
            used = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
            lanes = min(wide(used), most)
            begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
            s = rows[begin : begin + constraint.SIZE]
            begin += constraint.SIZE
            solve.gather(lanes, used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                restitution.bounce(lanes, s, q, g)
            solve.scatter(used, s, g, bodies)
            for k in range(used):
                change = max(change, g[lane_scratch.NORMAL_CHANGE + k])
        if not change > 0.0:
            return sweep + 1
    return SWEEPS


def solver(
    *, width: int, angular: bool, bounces: bool, turns: bool, on_rims: bool, layered: bool
) -> dict[str, Any]:
    """
    Make the passes of a scene, by name.

        width   : numbers of a point
        turns   : whether some inertia changes with the attitude: not of balls and cubes alone
        on_rims : whether a cylinder may touch a plane or a box
        layered : whether anything is a ball or a capsule
    """
    name = f'{width}'
    bound: dict[str, Any] = {'WIDTH': width, 'ANGULAR': angular, 'BOUNCES': bounces}
    bound |= {
        'TURNS': turns,
        'RIMS': on_rims,
        'follow_points': separation.follower(layered=layered),
    }
    made = {
        'prepare': _prepare,
        'solve_normals': _solve_normals,
        'update_separation': _update_separation,
        'relax': _relax,
    }
    if bounces:
        made['apply_restitution'] = _apply_restitution
    return {key: specialise(source, name=name, **bound) for key, source in made.items()}
