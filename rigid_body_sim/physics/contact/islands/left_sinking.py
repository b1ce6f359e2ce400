# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Heavy on light that sinks in although the solver has done what it may: a warning before it shows.

An island that has had all its passes (`islands.unsettled`) is left with what the next one would
still change,

    v = |dJ|/m

the speed with which what is heavy goes on into what is light: a pass gives it the momentum that
the light one has at its speed. After a blow that is so for a substep; where the load is more than
the passes bring through, in every one. So a tick warns of a constraint between bodies beyond
1:100 (HEAVY) if all its substeps have left it with

    v > SINKS r          r : [m] radius of the smaller of the two

And what presses at the end of a call, and then lies too deep, is listed there and then: in the
next tick, which may never come, `collision.deep_overlaps` would find it.
"""

from __future__ import annotations

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import (
    deep_overlaps,
    manifold_record,
)
from rigid_body_sim.physics.contact.solver import constraint, contact_point, static_sink
from rigid_body_sim.physics.contact.solver.softness import DEEP
from rigid_body_sim.physics.contact.solver.solve import ratio_of_masses
from rigid_body_sim.physics.contact.touching import lane_of

# [1/s] a tenth of a body in four seconds: what goes through goes on faster. At a tenth of it what
# stands is warned of where friction goes in circles
SINKS = 0.05
HEAVY = 100.0  # [-] ratio of masses


@inline
def note(lane: int, speed: float, rows: Array) -> None:
    """Note that the passes of a substep have left a constraint with a speed [m/s]."""
    heavy = ratio_of_masses(lane, rows) > HEAVY
    if heavy and speed > SINKS / DEEP * rows[lane + constraint.DEEP]:
        count = rows[lane + constraint.LEFT_SUBSTEPS]
        least = rows[lane + constraint.LEFT_SPEED]
        rows[lane + constraint.LEFT_SPEED] = min(speed, least) if count > 0.0 else speed
        rows[lane + constraint.LEFT_SUBSTEPS] = count + 1.0


@inline
def _overlap(lane: int, point_count: int, width: int, rows: Array) -> float:
    """Depth of the deepest point of a constraint that presses now [m]."""
    least = 0.0
    for point in range(point_count):
        row = lane + constraint.SIZE + point * width
        if rows[row + contact_point.NORMAL_IMPULSE] > 0.0:
            sink = static_sink.of_point(lane, row, rows, rows)
            least = min(least, rows[row + contact_point.SEPARATION] + sink)
    return -least


@kernel
def _presses(lane: int, point_count: int, width: int, rows: Array) -> bool:
    """Tell whether a constraint has pressed in the tick."""
    for point in range(point_count):
        row = lane + constraint.SIZE + point * width
        if rows[row + contact_point.TOTAL_IMPULSE] > 0.0:
            return True
        if rows[row + contact_point.NORMAL_IMPULSE] > 0.0:
            return True
    return False


@kernel
def list_left(
    ends: bool, substeps: int, width: int, manifold_count: int, table: Indices, limits: Array,
    manifolds: Array, rows: Array, overlaps: Array,
) -> None:  # fmt: skip
    """
    List the pairs that all substeps of a tick have left sinking in, or, where the call ends with
    it, overlapping too deeply; note the first time that anything presses.

    ends   : whether it does
    width  : numbers of a point
    limits : of the overlaps of colliders: `deep_overlaps.overlap_limits`
    """
    for m in range(manifold_count):
        lane, record = lane_of(m, manifolds), m * manifold_record.SIZE
        a = int(manifolds[record + manifold_record.COLLIDER_A])
        b = int(manifolds[record + manifold_record.COLLIDER_B])
        if rows[lane + constraint.LEFT_SUBSTEPS] == substeps:
            speed = rows[lane + constraint.LEFT_SPEED]
            deep_overlaps.list_pair(a, b, 0.0, speed, 0.0, 0.0, table, overlaps)
        points = int(manifolds[record + manifold_record.POINT_COUNT])
        if overlaps[deep_overlaps.DEEPEST] < 0.0 and _presses(lane, points, width, rows):
            overlaps[deep_overlaps.DEEPEST] = 0.0
        if ends:
            depth = _overlap(lane, points, width, rows)
            if depth > min(limits[a], limits[b]):
                deep_overlaps.list_pair(a, b, depth, 0.0, 0.0, 0.0, table, overlaps)
