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

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.blocks import wide
from rigid_body_sim.physics.contact.solving import (
    bouncing,
    passes,
    preparation,
    resistance,
    warm_start,
)
from rigid_body_sim.physics.contact.solving.assembly import BATCH, KIND, OFFSET, POINTS, USED
from rigid_body_sim.physics.contact.solving.rows import ACTIVE, CHANGE, MANIFOLD, SCRATCH
from rigid_body_sim.physics.kernels import inline, specialise

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SWEEPS = 40  # of the bounce, at most; a stack of that many balls is not yet at rest
SETTLED = 1e-12  # [-] of the largest impulse: a sweep that changes less is the last

# A batch that is struck is visited again until it is calm: what an impact leaves of the approach
# sinks in over the next substep, and what pushes it out again lifts the body.
VISITS = 20  # at most
IMPACT, CALM = 0.02, 1e-4  # [m/s] changes of a normal velocity: a blow; what is left alone

# bound for each scene by `specialise`
WIDTH = 144  # numbers of a point
ANGULAR = False  # whether anything rolls or twists with friction
BOUNCES = False  # whether anything bounces


@inline
def _changes(used: int, g: Array) -> bool:
    """Tell whether a visit has changed more than is calm; let calm lanes stand still then."""
    largest = 0.0
    for k in range(used):
        change = g[k + CHANGE]
        largest = change if change > largest else largest
    if not largest > 0.0:
        return False
    for k in range(used):
        g[k + ACTIVE] = 1.0 if g[k + CHANGE] > 0.0 else 0.0
        g[k + CHANGE] = 0.0
    return True


def _prepare(most: int, count: int, rows: Array, batches: Indices, bodies: Array) -> None:
    """Find tangents, gains and speeds of approach, and what the last tick left to start from."""
    g = rows[0:SCRATCH]
    for batch in range(count):
        points = batches[batch * BATCH + POINTS]
        used = batches[batch * BATCH + USED]
        lanes = min(wide(used), most)
        begin = batches[batch * BATCH + OFFSET]
        s = rows[begin : begin + MANIFOLD]
        begin += MANIFOLD
        preparation.frames(lanes, s)
        warm_start.clear(lanes, g)
        for point in range(points):
            q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
            warm_start.turn(lanes, s, q, g)
            if ANGULAR:
                warm_start.turn_twist(lanes, s, q, g)
        warm_start.hold(used, s, g, bodies)
        passes.gather_inertia(used, s, bodies)
        passes.gather(lanes, used, s, g, bodies)
        for point in range(points):
            q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
            preparation.gains(lanes, s, q, g)
        if ANGULAR:
            preparation.angular_gains(lanes, s, g)
        if BOUNCES:
            preparation.gather_accelerations(used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                preparation.approach(lanes, s, q, g)


def _push(
    most: int, count: int, inverse_h: float, slop: float, cap: float, rows: Array,
    batches: Indices, bodies: Array,
) -> None:  # fmt: skip
    """Visit the normals of all batches, softly."""
    g = rows[0:SCRATCH]
    for batch in range(count):
        points = batches[batch * BATCH + POINTS]
        used = batches[batch * BATCH + USED]
        lanes = min(wide(used), most)
        begin = batches[batch * BATCH + OFFSET]
        s = rows[begin : begin + MANIFOLD]
        begin += MANIFOLD
        passes.gather(lanes, used, s, g, bodies)
        visits = VISITS if points > 1 else 1
        for visit in range(visits):
            calm = IMPACT if visit == 0 else CALM
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                passes.push(lanes, s, q, g, inverse_h, slop, cap, calm)
                if ANGULAR:
                    resistance.release(lanes, s, q, g)
            if visit + 1 < visits and not _changes(used, g):
                break
        passes.scatter(used, s, g, bodies)
        passes.mark_carried(used, s, g, bodies)


def _relax(
    most: int, count: int, inverse_h: float, first: bool, last: bool, rows: Array,
    batches: Indices, bodies: Array,
) -> None:  # fmt: skip
    """
    Visit normals and friction of all batches.

    first : the bodies have moved since the gaps were found
    last  : add up the loads from which the next substep starts
    """
    g = rows[0:SCRATCH]
    for batch in range(count):
        points = batches[batch * BATCH + POINTS]
        used = batches[batch * BATCH + USED]
        lanes = min(wide(used), most)
        begin = batches[batch * BATCH + OFFSET]
        s = rows[begin : begin + MANIFOLD]
        begin += MANIFOLD
        if first:
            passes.gather_inertia(used, s, bodies)
        passes.gather(lanes, used, s, g, bodies)
        if first and batches[batch * BATCH + KIND] > 0:
            passes.gather_way(used, s, g, bodies)
            passes.follow_balls(lanes, s, rows[begin : begin + WIDTH], g)
        elif first:
            passes.gather_motion(used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                passes.follow(lanes, s, q, g)
        visits = VISITS if points > 1 or batches[batch * BATCH + KIND] == 0 else 1
        for visit in range(visits):
            calm = IMPACT if visit == 0 else CALM
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                passes.relax(lanes, s, q, g, inverse_h, calm)
                if ANGULAR:
                    resistance.resist(lanes, s, q, g)
            if visit + 1 < visits and not _changes(used, g):
                break
        passes.scatter(used, s, g, bodies)
        if last:
            warm_start.clear(lanes, g)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                warm_start.carry_on(lanes, s, q, g)
                if ANGULAR:
                    warm_start.carry_twist_on(lanes, s, q, g)
            warm_start.hold(used, s, g, bodies)


def _bounce(
    most: int, count: int, threshold: float, rows: Array, batches: Indices, bodies: Array
) -> Any:
    """Let bounce what bounces, sweep by sweep until nothing changes; return the sweeps."""
    g = rows[0:SCRATCH]
    largest = 0.0
    for sweep in range(SWEEPS):
        change = 0.0
        for batch in range(count):
            points = batches[batch * BATCH + POINTS]
            used = batches[batch * BATCH + USED]
            lanes = min(wide(used), most)
            begin = batches[batch * BATCH + OFFSET]
            s = rows[begin : begin + MANIFOLD]
            begin += MANIFOLD
            passes.gather(lanes, used, s, g, bodies)
            for point in range(points):
                q = rows[begin + point * WIDTH : begin + (point + 1) * WIDTH]
                bouncing.bounce(lanes, s, q, g, threshold)
            passes.scatter(used, s, g, bodies)
            for k in range(used):
                change = max(change, g[CHANGE + k])
        largest = max(largest, change)
        if not change > SETTLED * largest:
            return sweep + 1
    return SWEEPS


def solver(*, width: int, angular: bool, bounces: bool) -> dict[str, Any]:
    """Make the passes of a scene, by name."""
    name = f'{width}'
    bound = {'WIDTH': width, 'ANGULAR': angular, 'BOUNCES': bounces}
    made = {'prepare': _prepare, 'push': _push, 'relax': _relax}
    if bounces:
        made['bounce'] = _bounce
    return {key: specialise(source, name=name, **bound) for key, source in made.items()}
