# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Surfaces of several manifolds, as chains of lanes: what they carry together.

All manifolds of one body on one other with one normal (`surface_members`) are a surface. SURFACE
and NEXT_OF_SURFACE of `constraint` chain their lanes, NEXT_SURFACE links the surfaces of a group,
in the order of their manifolds. `whole_surface` solves them; where one of them is a face they have
one spring, and one load, as long as they lie alone or are struck flat (`face_spring`,
`static_sink`), else springs that share one (`surface_springs`).
"""

from __future__ import annotations

from typing import Any

from rigid_body_sim.physics.arrays import Array, Indices
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    constraint,
    contact_point,
    face_spring,
    lane_scratch,
    static_sink,
    warm_start,
)
from rigid_body_sim.physics.contact.solver.softness import DEEP


@inline
def is_alone(count: int, first: int, rows: Array) -> Any:
    """Tell whether the bodies of a surface of so many manifolds have no others."""
    return rows[first + constraint.MANIFOLDS] == float(count)


@inline
def chain(
    count: int, members: Indices, one_spring: bool, h: float, manifolds: Array, rows: Array,
    bodies: Array,
) -> None:  # fmt: skip
    """
    Note that manifolds are one surface.

        members    : where their records begin
        one_spring : they have one, and one load: see `face_spring`
        h          : [s] substep
    """
    first = int(manifolds[members[0] + manifold_record.LANE])
    mass, most = 0.0, 0.0
    alone = is_alone(count, first, rows)
    if one_spring:
        body_a, body_b = int(rows[first + constraint.BODY_A]), int(rows[first + constraint.BODY_B])
        mass = face_spring.mass_of(
            bodies[body_a + solver_bodies.INVERSE_MASS]
            + bodies[body_b + solver_bodies.INVERSE_MASS]
        )
        for place in range(count):
            lane = int(manifolds[members[place] + manifold_record.LANE])
            most = max(most, rows[lane + constraint.LOAD])
    following = 0.0
    for place in range(count - 1, -1, -1):
        lane = int(manifolds[members[place] + manifold_record.LANE])
        is_point = manifolds[members[place] + manifold_record.POINT_COUNT] == 1.0
        rows[lane + constraint.SURFACE_POINTS] = 1.0 if is_point else float(manifold.MOST)
        rows[lane + constraint.SURFACE] = (
            constraint.FIRST_OF_SURFACE if place == 0 else constraint.OF_SURFACE
        )
        rows[lane + constraint.NEXT_OF_SURFACE] = following
        rows[lane + constraint.ALONE] = 1.0 if alone else 0.0
        rows[lane + constraint.SPRING_MASS] = mass
        if mass > 0.0:
            static_sink.recall(lane, h, rows[lane + constraint.DEEP] / DEEP, most, rows)
        following = float(lane)


@kernel
def link(order: Indices, manifolds: Array, rows: Array, scratch: Array) -> None:
    """
    Link the surfaces of some manifolds in their order, which no others change: bodies may have
    part in several.
    """
    scratch[lane_scratch.WHOLE_SURFACES] = 0.0
    last = 0
    for index in range(len(order)):
        lane = int(manifolds[order[index] * manifold_record.SIZE + manifold_record.LANE])
        if rows[lane + constraint.SURFACE] != constraint.FIRST_OF_SURFACE:
            continue
        rows[lane + constraint.NEXT_SURFACE] = 0.0
        if last == 0:
            scratch[lane_scratch.WHOLE_SURFACES] = float(lane)
        else:
            rows[last + constraint.NEXT_SURFACE] = float(lane)
        last = lane


@inline
def leave_alone(lane: int, rows: Array) -> None:
    """Begin a tick: a manifold is of no surface."""
    rows[lane + constraint.SURFACE] = constraint.OF_NO_SURFACE
    rows[lane + constraint.ALONE] = 1.0 if is_alone(1, lane, rows) else 0.0
    rows[lane + constraint.NEXT_OF_SURFACE] = 0.0
    rows[lane + constraint.SURFACE_POINTS] = float(manifold.MOST)
    face_spring.leave_points_alone(lane, rows)


@inline
def any_whole(scratch: Array) -> bool:
    """Tell whether some manifolds of the group are one surface in this tick."""
    return bool(scratch[lane_scratch.WHOLE_SURFACES] > 0.0)


@kernel
def impulse_of(first: int, width: int, rows: Array, scratch: Array) -> float:
    """Return by which impulse the one spring of a surface is pressed."""
    total = 0.0
    lane = first
    while lane > 0:
        count = int(rows[lane + constraint.SURFACE_POINTS])
        total += face_spring.impulse_of_lane(
            lane + constraint.SIZE, count, width, False, rows, scratch
        )
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    return total


@kernel
def note_impulses_of(first: int, width: int, rows: Array, scratch: Array) -> None:
    """Note of each lane of a surface by which impulse the others press their one spring."""
    if not rows[first + constraint.SPRING_MASS] > 0.0:
        return
    total = impulse_of(first, width, rows, scratch)
    lane = first
    while lane > 0:
        count = int(rows[lane + constraint.SURFACE_POINTS])
        rows[lane + constraint.OTHERS_IMPULSE] = total - face_spring.impulse_of_lane(
            lane + constraint.SIZE, count, width, False, rows, scratch
        )
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])


@kernel
def note_lasting_share(first: int, width: int, rows: Array) -> None:
    """Note of all lanes of a surface which share of their impulses lasts: `warm_start`."""
    impulse, warm = 0.0, 0.0
    lane = first
    while lane > 0:
        begin = lane + constraint.SIZE
        count = int(rows[lane + constraint.SURFACE_POINTS])
        for row in range(begin, begin + count * width, width):
            impulse += rows[row + contact_point.NORMAL_IMPULSE]
            warm += rows[row + contact_point.WARM_NORMAL]
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])
    share = warm_start.share_of_load(impulse, warm, rows[first + constraint.SPRING_MASS])
    lane = first
    while lane > 0:
        rows[lane + constraint.LASTS] = share
        lane = int(rows[lane + constraint.NEXT_OF_SURFACE])


@kernel
def note_lasting_shares(width: int, rows: Array, scratch: Array) -> None:
    """Do the same for all linked surfaces."""
    first = int(scratch[lane_scratch.WHOLE_SURFACES])
    while first > 0:
        note_lasting_share(first, width, rows)
        first = int(rows[first + constraint.NEXT_SURFACE])


@kernel
def note_impulses(width: int, rows: Array, scratch: Array) -> None:
    """Note of all lanes of linked surfaces by which impulse the others press their one spring."""
    first = int(scratch[lane_scratch.WHOLE_SURFACES])
    while first > 0:
        note_impulses_of(first, width, rows, scratch)
        first = int(rows[first + constraint.NEXT_SURFACE])
