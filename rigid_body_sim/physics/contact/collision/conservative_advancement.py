# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Conservative advancement along separating axes, the continuous collision detection (CCD): whether
two colliders meet within a time.

Two convex bodies do not meet while some axis separates them, and one is enough. Along a fixed axis
n the gap s(t) = min_B n . x - max_A n . x lies, from t1 to t2, nowhere below its chord by more
than

    bend (t2 - t1)^2 / 8,   bend = max(a_n + `bend_within` of A and of B, 0)

because each point moves along n with an acceleration of at most that (a_n: that of the two centres
apart; R: longest lever). While the chord less this room stays positive, n separates; at the time
at which it may not, the pair is put there and asked for the axis of then, and so on until the time
is over, or until no axis gains time: then the two touch. With a cylinder or a hull the axis is
that of the true shapes (`nearest_axis`), else that of the manifold.

Of two that slide or roll past each other the nearest points stay as near and n turns, and a fixed
axis gains what time the gap lasts. So the same is asked of an axis that turns with A, and with B,
where the bend is that of the other one as seen from there (`free_motion.bend_seen_from`); that
which gains most counts. Mirtich's advancement (Impulse-based
dynamic simulation, 1996) has the speed of any point in any direction in place of that along n, and
so crawls past whatever passes near.

The turn of `free_motion` is right to second order. Of a pair fast enough to ask for a finer tick
gaps are taken less what the third order may move, `wander_of` by t^3; a chord from end to end
takes off no less in between. So what tumbles far in a tick is told in the pieces of it.

A pair that misses gets no contact in this tick: the extended planes of far faces would stop what
flies past an edge. One that moves far and hits asks for a finer tick, in pieces in which bodies
move by less than their size; the pieces are ticks like others.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import (
    CYLINDER,
    HULL,
    SPHERE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.free_motion import (
    FreeMotion,
    angle_of,
    bend_seen_from,
    bend_within,
    free_motion,
    move,
    moved_with,
    wander_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    NORMAL,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.nearest_axis import nearest_axis
from rigid_body_sim.physics.contact.collision.support import gap_along, is_inside
from rigid_body_sim.physics.vectors import add_scaled, dot, load, negate, subtract

Array = NDArray[np.float64]

FAST = 0.5  # [-] of the radius of the smaller: motion in a tick from which a pair is advanced
PIECE = 0.25  # [-] of it: motion in a piece of a finer tick
MOST_PIECES = 4096
ADVANCEMENT_STEPS = 48  # of the advancement; a pair still undecided then is taken as a hit
SHARE = 0.5  # [-] of the gap: room that turning may take in one step
PAST = 0.02  # [-] of the time: so long after the gap is used up a hit is looked for
ROUNDING = 1e-9  # [-] of the radius of the smaller: so far outside a point is of a body
STANDSTILL = 1e-6  # [-] of the time: an advance by less is none, the two touch
TOUCHING = 1e-6  # [-] of the radius of the smaller: what comes so near touches

collide = slot(
    'kernel (type of A, type of B, parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, '
    'found): finds the manifold of two shapes'
)
CYLINDERS = slot('[-] whether some collider is a cylinder')
TRUE_SHAPES = slot('[-] whether some collider is a cylinder or a hull')
stays_apart = slot('kernel (a, b, count, horizon, normal, ...): tells whether an axis separates')


@inline
def has_cylinder(a: int, b: int, table: Any) -> bool:
    """Tell whether a cylinder is of a pair: its prism reaches beyond it, and may overlap alone."""
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    return type_a == CYLINDER or table[b * collider_record.SIZE + collider_record.TYPE] == CYLINDER


@inline
def motion_of(swept: Array, a: int, b: int, h: float) -> Any:
    """Bound of what two colliders move relative to each other in a tick [m]."""
    row_a, row_b = a * swept_aabbs.SIZE, b * swept_aabbs.SIZE
    return (
        swept_aabbs.relative_speed(swept, row_a, row_b) * h
        + swept[row_a + swept_aabbs.TURNING]
        + swept[row_b + swept_aabbs.TURNING]
    )


@inline
def pieces_of(motion: float, radius: float) -> int:
    """Count the pieces of a tick in which a pair moves by a share of the smaller one's radius."""
    return int(math.ceil(motion / max(PIECE * radius, motion / MOST_PIECES)))


@inline
def _balls_miss(
    reach: float, horizon: float, colliders: ColliderArrays, a: int, b: int, of_a: FreeMotion,
    of_b: FreeMotion,
) -> bool:  # fmt: skip
    """Tell whether two balls with the same acceleration stay apart: least distance of centres."""
    poses = colliders.poses
    apart = subtract(load(poses, b * pose.SIZE), load(poses, a * pose.SIZE))
    velocity = subtract(of_b.velocity, of_a.velocity)
    approach = -dot(apart, velocity)
    squared = dot(velocity, velocity)
    time = min(approach / squared, horizon) if approach > 0.0 else 0.0
    nearest = (
        apart[0] + time * velocity[0],
        apart[1] + time * velocity[1],
        apart[2] + time * velocity[2],
    )
    return dot(nearest, nearest) > reach * reach


@kernel
def _goes_in(
    a: int, b: int, horizon: float, normal: Any, point: Any, gap: float, of_a: FreeMotion,
    of_b: FreeMotion, colliders: ColliderArrays,
) -> bool:  # fmt: skip
    """
    Tell whether the point of one collider that is nearest to the other one is inside of it when
    the gap between the two is used up: a hit, and no more need be asked.

        point, gap : midway between the two, and their separation there
    """
    on_a = add_scaled(point, -0.5 * gap, normal)
    on_b = add_scaled(point, 0.5 * gap, normal)
    ended = gap - dot(
        normal,
        subtract(moved_with(on_a, horizon, of_a, of_b), on_a),
    )
    if not (ended < 0.0 < gap):
        return False
    time = min(horizon * (gap / (gap - ended) + PAST), horizon)
    angle_a, angle_b = angle_of(of_a, time), angle_of(of_b, time)
    lever = bounds_record.smaller_radius(colliders.local_bounds, a, b)
    margin = (angle_a * angle_a * angle_a + angle_b * angle_b * angle_b) * lever
    return is_inside(
        moved_with(on_a, time, of_a, of_b), margin, b, b * pose.SIZE, colliders
    ) or is_inside(moved_with(on_b, time, of_b, of_a), margin, a, a * pose.SIZE, colliders)


@kernel
def _are_of_both(
    a: int, b: int, normal: Any, point: Any, gap: float, colliders: ColliderArrays
) -> bool:
    """
    Tell whether the nearest points of a manifold are points of the two: not so where those of a
    prism, or of a line beside a mantle, are not those of the cylinder. As of `_goes_in`.
    """
    margin = -ROUNDING * bounds_record.smaller_radius(colliders.local_bounds, a, b)
    on_a = add_scaled(point, -0.5 * gap, normal)
    on_b = add_scaled(point, 0.5 * gap, normal)
    return is_inside(on_a, margin, a, a * pose.SIZE, colliders) and is_inside(
        on_b, margin, b, b * pose.SIZE, colliders
    )


def _misses(
    a: int, b: int, count: int, horizon: float, nearest: int, manifold: int,
    colliders: ColliderArrays, manifolds: Array, bodies: Array, found: Array,
) -> bool:  # fmt: skip
    """
    Tell whether two colliders, neither a plane, that an axis separates now stay apart in free
    motion.

        count    : of colliders; behind their poses there is room for four more
        horizon  : [s]
        manifold : where theirs begins, with that axis;  nearest : where its nearest point does
    """
    row_a, row_b = a * collider_record.SIZE, b * collider_record.SIZE
    table = colliders.table
    type_a, type_b = table[row_a + collider_record.TYPE], table[row_b + collider_record.TYPE]
    shape_a = table[row_a + collider_record.PARAMETERS]
    shape_b = table[row_b + collider_record.PARAMETERS]
    of_a, of_b = free_motion(a, colliders, bodies), free_motion(b, colliders, bodies)
    pull = subtract(of_b.acceleration, of_a.acceleration)
    bend = of_a.bend + of_b.bend
    if type_b == SPHERE and type_a == SPHERE and bend == 0.0 and dot(pull, pull) == 0.0:
        reach = colliders.parameters[shape_a] + colliders.parameters[shape_b]
        return _balls_miss(reach, horizon, colliders, a, b, of_a, of_b)
    normal = load(manifolds, manifold + manifold_record.NORMAL)
    point, gap = load(manifolds, nearest + POSITION), manifolds[nearest + SEPARATION]
    known = True
    if CYLINDERS and has_cylinder(a, b, table):
        known = _are_of_both(a, b, normal, point, gap, colliders)
    if known and _goes_in(a, b, horizon, normal, point, gap, of_a, of_b, colliders):
        return False
    return stays_apart(a, b, count, horizon, normal, of_a, of_b, colliders, found)


@inline
def asks_true_shapes(a: int, b: int, table: Any) -> bool:
    """Tell whether the axes of a pair are those of its true shapes: with a cylinder or a hull."""
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    return type_a == CYLINDER or type_b == CYLINDER or type_a == HULL or type_b == HULL


@kernel
def _turned(normal: Any, begin: int, end: int, poses: Array) -> Any:
    """Return an axis that a collider takes with it from one pose to another."""
    return pose.to_world(poses, end, pose.to_shape(poses, begin, normal))


@inline
def _reach_of(begun: float, horizon: float, gap: float, bend: float) -> float:
    """Return the end of a step whose room is a share of the gap."""
    left = horizon - begun
    if bend * left * left > 8.0 * SHARE * gap:
        return min(begun + math.sqrt(8.0 * SHARE * gap / bend), horizon)
    return horizon


@inline
def _reached(begun: float, until: float, gap: float, last: float, bend: float) -> float:
    """
    Return the time to which an axis separates for sure.

        gap, last : along it, at the start and at the end of a step
    """
    span = until - begun
    room = 0.125 * bend * span * span
    if not gap > room:  # of a bend that did not choose the step: it may close and open in between
        return begun
    return until if last > room else begun + span * (gap - room) / (gap - last)


def _stays_apart(
    a: int, b: int, count: int, horizon: float, normal: Any, of_a: FreeMotion, of_b: FreeMotion,
    colliders: ColliderArrays, found: Array,
) -> bool:  # fmt: skip
    """
    Tell whether two colliders are proved to stay apart in free motion, axis after axis.

        normal : the axis that separates them now, from A to B
    """
    row_a, row_b = a * collider_record.SIZE, b * collider_record.SIZE
    table, poses = colliders.table, colliders.poses
    type_a, type_b = table[row_a + collider_record.TYPE], table[row_b + collider_record.TYPE]
    shape_a = table[row_a + collider_record.PARAMETERS]
    shape_b = table[row_b + collider_record.PARAMETERS]
    pull = subtract(of_b.acceleration, of_a.acceleration)
    bend = bend_within(of_a, horizon) + bend_within(of_b, horizon)
    radius = bounds_record.smaller_radius(colliders.local_bounds, a, b)
    motion = 2.0 * motion_of(colliders.swept_aabbs, a, b, horizon)  # horizon <= 2 ticks
    # what asks for pieces if it hits is told again in them
    wander = wander_of(of_a) + wander_of(of_b) if motion > 4.0 * FAST * radius else 0.0
    begin_a, begin_b = a * pose.SIZE, b * pose.SIZE  # at the start of a step
    end_a, end_b = count * pose.SIZE, (count + 1) * pose.SIZE  # at the end of it
    turns = dot(of_a.spin, of_a.spin) + dot(of_b.spin, of_b.spin) > 0.0
    begun = 0.0
    true_shapes = TRUE_SHAPES and asks_true_shapes(a, b, table)
    if true_shapes and not gap_along(a, begin_a, b, begin_b, normal, colliders) > 0.0:
        normal = nearest_axis(a, begin_a, b, begin_b, normal, colliders, found)
    for _step in range(ADVANCEMENT_STEPS):
        gap = gap_along(a, begin_a, b, begin_b, normal, colliders) - wander * (
            begun * begun * begun
        )
        if not gap > (TOUCHING * radius if begun > 0.0 else 0.0):
            return False
        bent = max(bend + dot(pull, normal), 0.0)
        until = _reach_of(begun, horizon, gap, bent)
        move(a, end_a, until, of_a, poses)
        move(b, end_b, until, of_b, poses)
        last = gap_along(a, end_a, b, end_b, normal, colliders) - wander * (until * until * until)
        reached = _reached(begun, until, gap, last, bent)
        if reached < horizon and turns:
            with_a = bend_seen_from(of_a, of_b, normal, begun, horizon - begun)
            with_b = bend_seen_from(of_b, of_a, negate(normal), begun, horizon - begun)
            until = _reach_of(begun, horizon, gap, min(with_a, with_b))
            move(a, end_a, until, of_a, poses)
            move(b, end_b, until, of_b, poses)
            amiss = wander * (until * until * until)
            axis = _turned(normal, begin_a, end_a, poses)
            last = gap_along(a, end_a, b, end_b, axis, colliders) - amiss
            reached = max(reached, _reached(begun, until, gap, last, with_a))
            axis = _turned(normal, begin_b, end_b, poses)
            last = gap_along(a, end_a, b, end_b, axis, colliders) - amiss
            reached = max(reached, _reached(begun, until, gap, last, with_b))
        if reached >= horizon:
            return True
        if not reached - begun > STANDSTILL * horizon:
            return False
        begun = reached
        begin_a, begin_b = (count + 2) * pose.SIZE, (count + 3) * pose.SIZE
        move(a, begin_a, begun, of_a, poses)
        move(b, begin_b, begun, of_b, poses)
        if true_shapes:
            normal = nearest_axis(a, begin_a, b, begin_b, normal, colliders, found)
            continue
        points = collide(
            type_a, type_b, colliders.parameters, shape_a, shape_b, poses, begin_a, begin_b,
            motion, found,
        )  # fmt: skip
        if points == 0:
            return True
        normal = load(found, NORMAL)
    return False


def miss_finder(
    name: str, collide: Callable[..., Any], *, cylinders: bool, true_shapes: bool
) -> Callable[..., Any]:
    """
    Make the kernel that tells whether a pair misses, with the pair kernels of a scene.

        cylinders   : whether some collider is a cylinder
        true_shapes : whether some is a cylinder or a hull
    """
    stays_apart = stays_apart_finder(name, collide, true_shapes=true_shapes)
    return specialise(_misses, name=name, CYLINDERS=cylinders, stays_apart=stays_apart)


def stays_apart_finder(
    name: str, collide: Callable[..., Any], *, true_shapes: bool
) -> Callable[..., Any]:
    """Make the kernel that proves that a pair stays apart; arguments as of `miss_finder`."""
    return specialise(_stays_apart, name=name, TRUE_SHAPES=true_shapes, collide=collide)
