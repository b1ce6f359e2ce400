# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
No ghost contacts: manifolds that would stop what nothing is in the way of are taken out.

Two convex bodies do not meet while some axis separates them, and one axis is enough. The row of a
manifold keeps them apart along the one that separated most at the start of the tick. That is
sufficient, not necessary: a ghost is a row that binds although another axis would have done. So a
manifold whose rows would bind is left out where another axis is proved to separate for as long as
they act, which is the tick and one substep more (the last relaxation still looks one substep
ahead).

    miss      some axis separates in free motion, one after the other:
              `conservative_advancement`
    covered   the normal m of another manifold (X, Z) of the same body keeps X in front of the
              plane m . x = c of Z's surface. If the other collider Y lies wholly behind it,
                  max over Y of m . x <= c + tolerance,
              m separates X and Y whatever the velocities are, and the manifold (X, Y) is redundant

Covering needs no common edge, no list of neighbours and no time of impact: a floor of boxes,
hulls, parts of a union or a plane beside a box is one surface as far as it is flush. A wall, a
step, a ramp stick out of the plane of the floor and cover or are covered never. Only a manifold
that is no ghost itself may cover: first those whose rows do not bind, then those that bind and
that none covers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    manifold_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.bounds_record import smaller_radius
from rigid_body_sim.physics.contact.collision.collider import (
    BOX,
    CAPSULE,
    CYLINDER,
    HULL,
    PLANE,
    SPHERE,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.conservative_advancement import (
    has_cylinder,
    miss_finder,
)
from rigid_body_sim.physics.contact.collision.face_normal import face_beneath
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POSITION,
    SEPARATION,
)
from rigid_body_sim.physics.contact.collision.ground_misses import (
    ground_miss_finder,
    reach_of_manifold,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import RADIUS
from rigid_body_sim.physics.contact.collision.support import is_inside, reach
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    negate,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

FLUSH_STEP = 1e-4  # [-] of the radius of the smaller: surfaces that differ by no more are one
CALM = 1e-7  # [m] closing in a tick that matters to nobody
ONE_FACE = 5e-7  # [-] 1 - cos of an angle of 1e-3: below, two manifolds are supports of one face
SAME_ROUND = 5e-13  # [-] of 1e-6, for what rolls: its normals turn with its place over an edge
HELD = 1e-2  # [-] of the radius of the smaller: within it one point holds another
LEAN = 0.99  # [-] cos: above, two normals may be those of supports of one body that leans
UPRIGHT = 1e-2  # [-] sine of the angle between normal and axis, below which a cylinder stands
WIDE = 1.0 + 1e-9  # [-] of the gap: rounding of closing speeds

# what is known of a manifold, in its record; in this order
CARRIES = 0.0  # its rows do not bind, or nothing is known against them
ASKED = 1.0  # would bind
CERTAIN = 2.0  # would bind, and no other covers it
DOUBTFUL = 3.0  # would bind, and only others that would bind cover it
DROPPED = 4.0
COVERED = 5.0  # dropped, but kept in the list for impacts at their instants: see `_note_covers`
NONE = -1.0  # in place of a manifold

GROUND = slot('[-] whether some collider is ground of triangles')
EVENTS = slot('[-] whether impacts come at their instants')
misses = slot('kernel (a, b, count, horizon, normal, ...): tells whether a pair misses')
ground_misses = slot('kernel (a, b, record, ...): tells whether a body misses ground')


@inline
def _body_of(collider: int, table: Any) -> int:
    """Index of the body of a collider among those that move; below 0: it stands."""
    return table[collider * collider_record.SIZE + collider_record.BODY]


@inline
def _velocity(body: int, bodies: Array) -> Any:
    """Velocity of a solver body, spin of its surface, and its centre of mass."""
    row = body * solver_bodies.SIZE
    velocity = scale(
        bodies[row + solver_bodies.INVERSE_MASS], load(bodies, row + solver_bodies.MOMENTUM)
    )
    return (
        velocity,
        solver_bodies.surface_spin(row, bodies),
        load(bodies, row + solver_bodies.START_POSITION),
    )


@inline
def _is_ball_on_flat(a: int, b: int, table: Any) -> bool:
    """Tell whether a pair is a ball on a polyhedron: it may leave an edge, with its load."""
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    flat_a, flat_b = type_a == BOX or type_a == HULL, type_b == BOX or type_b == HULL
    return bool((type_a == SPHERE and flat_b) or (flat_a and type_b == SPHERE))


@kernel
def _may_bind(
    record: int, a: int, b: int, horizon: float, stretch: float, colliders: ColliderArrays,
    manifolds: Array,
) -> bool:  # fmt: skip
    """
    Tell by bounds whether some row of a manifold may act in the tick: for most it may not.

        stretch : horizon in ticks
    """
    if has_cylinder(a, b, colliders.table):
        return True
    swept, row_a, row_b = colliders.swept_aabbs, a * swept_aabbs.SIZE, b * swept_aabbs.SIZE
    approach = subtract(
        load(swept, row_a + swept_aabbs.VELOCITY), load(swept, row_b + swept_aabbs.VELOCITY)
    )
    fall = stretch * (swept[row_a + swept_aabbs.FALL] + swept[row_b + swept_aabbs.FALL])
    nearer = dot(load(manifolds, record + manifold_record.NORMAL), approach) * horizon - fall
    nearer += stretch * (swept[row_a + swept_aabbs.TURNING] + swept[row_b + swept_aabbs.TURNING])
    flush = FLUSH_STEP * smaller_radius(colliders.local_bounds, a, b)
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        gap = manifolds[record + manifold_record.POINTS + POINT * index + SEPARATION]
        if (nearer > CALM or gap > flush) and (nearer + fall) * WIDE > gap:
            return True
    return False


@kernel
def _would_bind(
    record: int, horizon: float, stretch: float, colliders: ColliderArrays, bodies: Array,
    manifolds: Array,
) -> bool:  # fmt: skip
    """
    Tell whether some row of the manifold that begins at a place would act in the tick: where the
    bodies close by more than the gap, at the velocities of now, and by what forces and the turn of
    the rows add where the gap is none of a contact at rest.
    """
    table = colliders.table
    a = int(manifolds[record + manifold_record.COLLIDER_A])
    b = int(manifolds[record + manifold_record.COLLIDER_B])
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    if type_b == PLANE:
        return False
    if manifolds[record + manifold_record.PIECES] > 1.0:
        return type_b != SURFACE  # of which it is known that it is hit
    if not _may_bind(record, a, b, horizon, stretch, colliders, manifolds):
        return False
    normal = load(manifolds, record + manifold_record.NORMAL)
    row_a, row_b = collider_record.solver_body(a, table), collider_record.solver_body(b, table)
    velocity_a, spin_a, center_a = _velocity(row_a, bodies)
    velocity_b, spin_b, center_b = _velocity(row_b, bodies)
    closing = dot(normal, subtract(velocity_a, velocity_b)) * horizon
    flush = FLUSH_STEP * smaller_radius(colliders.local_bounds, a, b)
    acceleration = solver_bodies.FREE_ACCELERATION
    fall = dot(normal, load(bodies, row_a * solver_bodies.SIZE + acceleration))
    fall -= dot(normal, load(bodies, row_b * solver_bodies.SIZE + acceleration))
    fall = max(0.5 * horizon * horizon * fall, 0.0)
    rate_a, rate_b = math.sqrt(dot(spin_a, spin_a)), math.sqrt(dot(spin_b, spin_b))
    passing = subtract(velocity_a, velocity_b)
    speed = math.sqrt(dot(passing, passing))
    # what rolls leaves the edge behind it by less than that: its load is not for the edge
    near = CALM if has_cylinder(a, b, table) else flush
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        point = load(manifolds, place + POSITION)
        arm_a, arm_b = subtract(point, center_a), subtract(point, center_b)
        turning = dot(normal, cross(spin_a, arm_a)) - dot(normal, cross(spin_b, arm_b))
        bend = rate_a * (speed + 2.0 * rate_a * math.sqrt(dot(arm_a, arm_a)))
        bend += rate_b * (speed + 2.0 * rate_b * math.sqrt(dot(arm_b, arm_b)))
        gap = manifolds[place + SEPARATION]
        nearer = closing + horizon * turning
        # arms turn with the bodies, and end midway between surfaces that pass each other
        more = fall + 0.5 * horizon * horizon * bend
        if (nearer > CALM or gap > near) and (nearer + more) * WIDE > gap:
            return True
        if gap < -CALM and has_cylinder(a, b, table):
            return True
    return False


@inline
def _touches_flat(record: int, colliders: ColliderArrays, manifolds: Array) -> bool:
    """
    Tell whether a manifold is one of a ball that touches a polyhedron. It may be covered though
    its row would not bind: a ball that has gone over an edge onto a flush tile would leave its
    load with the edge behind it, whose normal is no longer that of the surface.
    """
    a = int(manifolds[record + manifold_record.COLLIDER_A])
    b = int(manifolds[record + manifold_record.COLLIDER_B])
    if not _is_ball_on_flat(a, b, colliders.table):
        return False
    gap = manifolds[record + manifold_record.POINTS + SEPARATION]
    return bool(gap <= FLUSH_STEP * smaller_radius(colliders.local_bounds, a, b))


@kernel
def _rank(
    record: int, horizon: float, colliders: ColliderArrays, bodies: Array, manifolds: Array
) -> float:  # fmt: skip
    """
    Return when a manifold that would bind comes: below 0 what touches, first what moves least
    along its normal, which is how what carries differs from edges ahead and behind; then, by the
    share of the horizon, what will be met; last what closes by forces alone.
    """
    a = int(manifolds[record + manifold_record.COLLIDER_A])
    b = int(manifolds[record + manifold_record.COLLIDER_B])
    normal = load(manifolds, record + manifold_record.NORMAL)
    row_a = collider_record.solver_body(a, colliders.table)
    row_b = collider_record.solver_body(b, colliders.table)
    velocity_a, spin_a, center_a = _velocity(row_a, bodies)
    velocity_b, spin_b, center_b = _velocity(row_b, bodies)
    flush = FLUSH_STEP * smaller_radius(colliders.local_bounds, a, b)
    first = math.inf
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        point = load(manifolds, place + POSITION)
        surface_a = add(velocity_a, cross(spin_a, subtract(point, center_a)))
        surface_b = add(velocity_b, cross(spin_b, subtract(point, center_b)))
        nearer = dot(normal, subtract(surface_a, surface_b)) * horizon
        gap = manifolds[place + SEPARATION]
        if gap <= flush:
            first = min(first, abs(nearer) / (abs(nearer) + flush) - 1.0)
        elif nearer > 0.0:
            first = min(first, gap / nearer)
    return first


@kernel
def _nearest_point(record: int, manifolds: Array) -> int:
    """Return where the point of a manifold begins that has the least separation."""
    best = record + manifold_record.POINTS
    for index in range(1, int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        if manifolds[place + SEPARATION] < manifolds[best + SEPARATION]:
            best = place
    return best


@kernel
def _link(length: int, table: Any, bodies: Array, manifolds: Array) -> None:
    """Make the list of the manifolds of each body: the first one, and behind each the next."""
    for index in range(length):
        record = index * manifold_record.SIZE
        for side in range(2):
            collider = int(manifolds[record + manifold_record.COLLIDER_A + side])
            body = _body_of(collider, table)
            if body >= 0:
                bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD] = NONE
    for index in range(length):
        record = index * manifold_record.SIZE
        for side in range(2):
            collider = int(manifolds[record + manifold_record.COLLIDER_A + side])
            body = _body_of(collider, table)
            if body >= 0:
                head = body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD
                manifolds[record + manifold_record.NEXT_OF_A + side] = bodies[head]
                bodies[head] = float(record)


@inline
def _normal_towards(record: int, side: int, manifolds: Array) -> Any:
    """Return the normal of a manifold towards its collider A (0) or B (1)."""
    normal = load(manifolds, record + manifold_record.NORMAL)
    return normal if side == 1 else negate(normal)


@kernel
def _surface(record: int, normal: Any, manifolds: Array) -> Any:
    """
    Return where the plane of a manifold is along its normal towards one side: on the surface of
    the other one; and how deep the one is sunk into it [m].
    """
    height, sunk = -math.inf, 0.0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        place = record + manifold_record.POINTS + POINT * index
        gap = manifolds[place + SEPARATION]
        height = max(height, dot(normal, load(manifolds, place + POSITION)) - 0.5 * gap)
        sunk = max(sunk, -gap)
    return height, sunk


@kernel
def _rise(
    other: int, holder: int, normal: Any, horizon: float, colliders: ColliderArrays, bodies: Array
) -> float:
    """
    Bound how far a collider may rise above a plane of another one within the horizon [m], both at
    the velocities of now.
    """
    table = colliders.table
    body, body_h = _body_of(other, table), _body_of(holder, table)
    if (body < 0 and body_h < 0) or body == body_h:
        return 0.0
    velocity, spin, _ = _velocity(collider_record.solver_body(other, table), bodies)
    velocity_h, spin_h, _ = _velocity(collider_record.solver_body(holder, table), bodies)
    row, row_h = other * swept_aabbs.SIZE, holder * swept_aabbs.SIZE
    radius = colliders.local_bounds[other * bounds_record.SIZE + bounds_record.RADIUS]
    rise = dot(normal, subtract(velocity, velocity_h))
    rise += math.sqrt(dot(spin, spin)) * radius
    if dot(spin_h, spin_h) > 0.0:
        apart = subtract(
            load(colliders.swept_aabbs, row + swept_aabbs.CENTER),
            load(colliders.swept_aabbs, row_h + swept_aabbs.CENTER),
        )
        rise += math.sqrt(dot(spin_h, spin_h)) * (math.sqrt(dot(apart, apart)) + radius)
    return max(rise, 0.0) * horizon


@inline
def _top(
    record: int, other: int, normal: Any, colliders: ColliderArrays, manifolds: Array
) -> float:
    """Return how far the other collider of a manifold, as far as that is of it, reaches [m]."""
    row = other * collider_record.SIZE
    if colliders.table[row + collider_record.TYPE] == SURFACE:
        surface = colliders.table[row + collider_record.PARAMETERS]
        return reach_of_manifold(record, surface, normal, colliders.parameters, manifolds)
    return reach(other, other * pose.SIZE, normal, colliders)


@kernel
def _is_covered_by(
    record: int, side: int, cover: int, side_c: int, horizon: float, colliders: ColliderArrays,
    bodies: Array, manifolds: Array,
) -> bool:  # fmt: skip
    """
    Tell whether a manifold covers another one of the same body.

        side, side_c : which collider of each is of the body: 0: A, 1: B
    """
    own = int(manifolds[record + manifold_record.COLLIDER_A + side])
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    holder = int(manifolds[cover + manifold_record.COLLIDER_A + 1 - side_c])
    held = int(manifolds[cover + manifold_record.COLLIDER_A + side_c])
    towards = _normal_towards(record, side, manifolds)
    normal = _normal_towards(cover, side_c, manifolds)
    kind = colliders.table[own * collider_record.SIZE + collider_record.TYPE]
    same = ONE_FACE if kind == BOX or kind == HULL else SAME_ROUND
    if 1.0 - dot(towards, normal) < same:
        return False
    # flush tiles are seen along their faces, not along that of what leans on one of them
    normal = face_beneath(holder, normal, colliders)
    height, sunk = _surface(cover, normal, manifolds)
    flush = FLUSH_STEP * smaller_radius(colliders.local_bounds, own, other)
    place = record + manifold_record.POINTS
    gap = manifolds[place + SEPARATION]
    on_other = dot(normal, add_scaled(load(manifolds, place + POSITION), -0.5 * gap, towards))
    if on_other > height + flush + abs(gap):
        return False
    top = _top(record, other, normal, colliders, manifolds)
    if top > height + flush:
        return False
    if top + _rise(other, holder, normal, horizon, colliders, bodies) > height + flush:
        return False
    on_ground = colliders.table[holder * collider_record.SIZE + collider_record.TYPE] == SURFACE
    if own != held or on_ground:  # of ground a manifold tells of what lies over its facet alone
        low = -reach(own, own * pose.SIZE, negate(normal), colliders)
        return low >= top - 2.0 * (sunk + flush)
    return True


@kernel
def _find_cover(
    record: int, side: int, least: float, most: float, horizon: float, colliders: ColliderArrays,
    bodies: Array, manifolds: Array,
) -> int:  # fmt: skip
    """
    Find the manifold that covers the one that begins at a place, for its collider A or B (side 0
    or 1), and is nearest to touching; -1: none. Of two of a cylinder that would bind, and that
    cover each other, the one that comes first does: a floor the edge ahead, and the one behind.

        least, most : states that a cover may have
        returns     : twice where it begins, and 1 if its collider B is of the body
    """
    table = colliders.table
    body = _body_of(int(manifolds[record + manifold_record.COLLIDER_A + side]), table)
    if body < 0:
        return -1
    cover = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD])
    best, nearest = -1, math.inf
    own = int(manifolds[record + manifold_record.COLLIDER_A + side])
    ranked = table[own * collider_record.SIZE + collider_record.TYPE] == CYLINDER
    rank = _rank(record, horizon, colliders, bodies, manifolds) if ranked else math.inf
    while cover >= 0:
        first = int(manifolds[cover + manifold_record.COLLIDER_A])
        side_c = 0 if _body_of(first, table) == body else 1
        state = manifolds[cover + manifold_record.STATE]
        if cover != record and least <= state <= most:
            gap = manifolds[_nearest_point(cover, manifolds) + SEPARATION]
            if (
                gap < nearest
                and _is_covered_by(
                    record, side, cover, side_c, horizon, colliders, bodies, manifolds
                )
                and (
                    state == CARRIES
                    or not ranked
                    or _rank(cover, horizon, colliders, bodies, manifolds) <= rank
                    or not _is_covered_by(
                        cover, side_c, record, side, horizon, colliders, bodies, manifolds
                    )
                )
            ):
                best, nearest = 2 * cover + side_c, gap
        cover = int(manifolds[cover + manifold_record.NEXT_OF_A + side_c])
    return best


@inline
def _turned_point(
    own: int, point: Any, towards: Any, normal: Any, colliders: ColliderArrays
) -> Any:
    """
    Return where a collider is nearest along another normal: beside a point of its surface.

    A corner or edge stays where it is; of a capsule or mantle the surface point goes round the
    axis.
    """
    row = own * collider_record.SIZE
    kind = colliders.table[row + collider_record.TYPE]
    if kind == CAPSULE:
        radius = colliders.parameters[colliders.table[row + collider_record.PARAMETERS] + RADIUS]
        return add_scaled(add_scaled(point, radius, towards), -radius, normal)
    if kind == CYLINDER:
        radius = colliders.parameters[colliders.table[row + collider_record.PARAMETERS] + RADIUS]
        axis = pose.axis(colliders.poses, own * pose.SIZE, 2)
        down = add_scaled(negate(normal), dot(normal, axis), axis)
        across = math.sqrt(dot(down, down))
        if across > UPRIGHT:
            middle = load(colliders.poses, own * pose.SIZE + pose.POSITION)
            along = dot(axis, subtract(point, middle))
            return add_scaled(add_scaled(middle, along, axis), radius / across, down)
    return point


@kernel
def _is_held(
    point: Any, normal: Any, near: float, body: int, table: Any, bodies: Array, manifolds: Array
) -> bool:  # fmt: skip
    """
    Tell whether some manifold of a body with the same normal towards it has a point at a place.

        near : distance that is none [m]
    """
    record = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD])
    while record >= 0:
        first = int(manifolds[record + manifold_record.COLLIDER_A])
        side = 0 if _body_of(first, table) == body else 1
        along = dot(normal, _normal_towards(record, side, manifolds))
        if manifolds[record + manifold_record.STATE] != DROPPED and 1.0 - along < ONE_FACE:
            for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
                place = record + manifold_record.POINTS + POINT * index
                way = subtract(load(manifolds, place + POSITION), point)
                if dot(way, way) < near * near:
                    return True
        record = int(manifolds[record + manifold_record.NEXT_OF_A + side])
    return False


@kernel
def _take_out(
    record: int, side: int, cover: int, side_c: int, colliders: ColliderArrays, bodies: Array,
    manifolds: Array,
) -> None:  # fmt: skip
    """
    Take a covered manifold out; but where it has a point that no other holds it is another support
    of a body that leans a little, and turns to the normal of the cover.
    """
    table = colliders.table
    own = int(manifolds[record + manifold_record.COLLIDER_A + side])
    other = int(manifolds[record + manifold_record.COLLIDER_A + 1 - side])
    towards = _normal_towards(record, side, manifolds)
    normal = _normal_towards(cover, side_c, manifolds)
    top = _top(record, other, normal, colliders, manifolds)
    near = HELD * smaller_radius(colliders.local_bounds, own, other)
    points = int(manifolds[record + manifold_record.POINT_COUNT])
    kind = table[own * collider_record.SIZE + collider_record.TYPE]
    if kind == SPHERE or dot(towards, normal) < LEAN:
        points = 0  # the cover holds all that a ball has, and all that is near another side
    store(manifolds, record + manifold_record.NORMAL, normal if side == 1 else negate(normal))
    manifolds[record + manifold_record.POINT_COUNT] = 0.0
    manifolds[record + manifold_record.STATE] = CERTAIN
    found = False
    body = _body_of(own, table)
    for index in range(points):
        place = record + manifold_record.POINTS + POINT * index
        half = 0.5 * manifolds[place + SEPARATION]
        middle = load(manifolds, place + POSITION)
        own_point = add_scaled(middle, half, towards)
        other_point = add_scaled(middle, -half, towards)
        own_point = _turned_point(own, own_point, towards, normal, colliders)
        # the other one lies behind two planes: below the point that counts which is nearer to it
        of_own = dot(towards, subtract(own_point, other_point)) / dot(towards, normal)
        gap = max(dot(normal, own_point) - top, of_own)
        point = add_scaled(own_point, -0.5 * gap, normal)
        store(manifolds, place + POSITION, point)
        manifolds[place + SEPARATION] = gap
        found = found or not _is_held(point, normal, near, body, table, bodies, manifolds)
    manifolds[record + manifold_record.POINT_COUNT] = float(points)
    if not found:
        manifolds[record + manifold_record.STATE] = DROPPED


@kernel
def _note_covers(
    record: int, side: int, normal: Any, nearest: Any, horizon: float, colliders: ColliderArrays,
    bodies: Array, manifolds: Array,
) -> None:  # fmt: skip
    """
    Keep a covered manifold that was taken out in the list, without points, if both colliders are
    convex: the two do not meet as long as one of its covers carries (`events.loaded_pairs`). In
    place of its points behind the first one it names their pairs.

        normal, nearest : normal, place of the first point and its separation before it was
    """
    table = colliders.table
    collider_b = int(manifolds[record + manifold_record.COLLIDER_B])
    if table[collider_b * collider_record.SIZE + collider_record.TYPE] == SURFACE:
        return
    manifolds[record + manifold_record.STATE] = COVERED
    manifolds[record + manifold_record.POINT_COUNT] = 0.0
    manifolds[record + manifold_record.PIECES] = manifold_record.COVERED
    store(manifolds, record + manifold_record.NORMAL, normal)
    store(manifolds, record + manifold_record.POINTS + POSITION, nearest[0])
    manifolds[record + manifold_record.POINTS + SEPARATION] = nearest[1]
    body = _body_of(int(manifolds[record + manifold_record.COLLIDER_A + side]), table)
    cover = int(bodies[body * solver_bodies.SIZE + solver_bodies.FIRST_MANIFOLD])
    count = 0
    while cover >= 0:
        first = int(manifolds[cover + manifold_record.COLLIDER_A])
        side_c = 0 if _body_of(first, table) == body else 1
        if (
            count < manifold_record.MOST_COVERS
            and manifolds[cover + manifold_record.STATE] < DROPPED
            and _is_covered_by(record, side, cover, side_c, horizon, colliders, bodies, manifolds)
        ):
            pair = manifolds[cover + manifold_record.PAIR_ID]
            manifolds[record + manifold_record.COVERS + count] = pair
            count += 1
        cover = int(manifolds[cover + manifold_record.NEXT_OF_A + side_c])
    manifolds[record + manifold_record.COVER_COUNT] = float(count)


@kernel
def _settle(
    length: int, asked: float, least: float, most: float, found: float, none: float,
    horizon: float, colliders: ColliderArrays, bodies: Array, manifolds: Array,
) -> int:  # fmt: skip
    """
    Look for covers of all manifolds of a state, among those of some states; return how many have
    the state that is asked or is doubtful afterwards.

        found, none : new states of what is covered (DROPPED, COVERED: take it out) and what is not
    """
    left = 0
    for index in range(length):
        record = index * manifold_record.SIZE
        if manifolds[record + manifold_record.STATE] != asked:
            continue
        manifolds[record + manifold_record.STATE] = none
        for side in range(2):
            cover = _find_cover(record, side, least, most, horizon, colliders, bodies, manifolds)
            if cover >= 0:
                manifolds[record + manifold_record.STATE] = found
                if found >= DROPPED:
                    normal = load(manifolds, record + manifold_record.NORMAL)
                    place = record + manifold_record.POINTS
                    nearest = load(manifolds, place + POSITION), manifolds[place + SEPARATION]
                    _take_out(record, side, cover // 2, cover % 2, colliders, bodies, manifolds)
                    if found == COVERED and manifolds[record + manifold_record.STATE] == DROPPED:
                        _note_covers(
                            record, side, normal, nearest, horizon, colliders, bodies, manifolds
                        )
                    manifolds[cover // 2 + manifold_record.STATE] = CARRIES
                break
        state = manifolds[record + manifold_record.STATE]
        left += 1 if state == ASKED or state == DOUBTFUL else 0
    return left


@kernel
def _close_up(length: int, manifolds: Array, pieces: Any) -> int:
    """
    Close the gaps in the list, and return how many are left; LANE belongs to the place. pieces[0]
    is set to the most pieces that one of them asks for.
    """
    kept = 0
    for index in range(length):
        record = index * manifold_record.SIZE
        if manifolds[record + manifold_record.STATE] == DROPPED:
            continue
        pieces[0] = max(pieces[0], int(manifolds[record + manifold_record.PIECES]))
        if kept != index:
            for entry in range(manifold_record.LANE):
                manifolds[kept * manifold_record.SIZE + entry] = manifolds[record + entry]
        kept += 1
    return kept


def _drop_ghosts(
    length: int, count: int, h: float, substep: float, colliders: ColliderArrays, found: Array,
    manifolds: Array, bodies: Array, pieces: Any,
) -> int:  # fmt: skip
    """
    Take the manifolds of ghosts out of a list; return how many are left.

        length : of the list;   count : of colliders
        h      : tick [s];   substep : [s]
        found  : scratch of a pair kernel
        pieces : [0] is set to the pieces into which the tick should be cut
    """
    horizon = h + substep
    stretch = horizon / h
    gone = COVERED if EVENTS else DROPPED
    asked = 0
    for index in range(length):
        record = index * manifold_record.SIZE
        manifolds[record + manifold_record.STATE] = CARRIES
        binds = _would_bind(record, horizon, stretch, colliders, bodies, manifolds)
        if not binds and not _touches_flat(record, colliders, manifolds):
            continue
        manifolds[record + manifold_record.STATE] = ASKED
        asked += 1
        a = int(manifolds[record + manifold_record.COLLIDER_A])
        b = int(manifolds[record + manifold_record.COLLIDER_B])
        nearest = _nearest_point(record, manifolds)
        apart = binds and manifolds[nearest + SEPARATION] > 0.0
        if GROUND and colliders.table[b * collider_record.SIZE + collider_record.TYPE] == SURFACE:
            missed = apart and ground_misses(
                a, b, record, count, horizon, colliders, bodies, found, manifolds
            )
        else:
            if not apart and has_cylinder(a, b, colliders.table):
                point = load(manifolds, nearest + POSITION)
                apart = not (
                    is_inside(point, 0.0, a, a * pose.SIZE, colliders)
                    and is_inside(point, 0.0, b, b * pose.SIZE, colliders)
                )
            missed = apart and misses(
                a, b, count, horizon, nearest, record, colliders, manifolds, bodies, found
            )
        if missed:
            manifolds[record + manifold_record.STATE] = DROPPED
            asked -= 1
    if asked > 0:
        _link(length, colliders.table, bodies, manifolds)
        asked = _settle(
            length, ASKED, CARRIES, CARRIES, gone, ASKED, horizon, colliders, bodies, manifolds
        )
    if asked > 0:
        asked = _settle(
            length, ASKED, ASKED, DOUBTFUL, DOUBTFUL, CERTAIN, horizon, colliders, bodies,
            manifolds,
        )  # fmt: skip
    if asked > 0:
        asked = _settle(
            length, DOUBTFUL, CERTAIN, CERTAIN, gone, DOUBTFUL, horizon, colliders, bodies,
            manifolds,
        )  # fmt: skip
    if asked > 0:
        _settle(
            length, DOUBTFUL, CARRIES, DOUBTFUL, gone, CERTAIN, horizon, colliders, bodies,
            manifolds,
        )  # fmt: skip
    return _close_up(length, manifolds, pieces)


def ghost_dropper(
    name: str,
    collide: Callable[..., Any],
    *,
    ground: bool,
    cylinders: bool,
    true_shapes: bool,
    events: bool,
) -> Callable[..., Any]:
    """
    Make the kernel that takes ghosts out, with the pair kernels of a scene.

        ground      : whether some collider is ground of triangles
        cylinders   : whether some is a cylinder
        true_shapes : whether some is a cylinder or a hull
        events      : whether impacts come at their instants
    """
    misses = miss_finder(name, collide, cylinders=cylinders, true_shapes=true_shapes)
    of_ground = misses
    if ground:
        of_ground = ground_miss_finder(name, collide, true_shapes=true_shapes)
    return specialise(
        _drop_ghosts,
        name=name,
        GROUND=ground,
        EVENTS=events,
        misses=misses,
        ground_misses=of_ground,
    )
