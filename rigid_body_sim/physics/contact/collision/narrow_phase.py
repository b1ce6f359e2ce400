# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The narrow phase: from pairs that may meet to contact manifolds, by way of poses and pair kernels.

A pair gets the points whose separation is within its speculative margin (`swept_aabbs`). A
manifold is written as `manifold_record` says; those that would stop what nothing is in the way of
are taken out again (`ghosts`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import (
    bounds_record,
    collider_record,
    held_features,
    manifold_record,
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.bounds_record import smaller_radius
from rigid_body_sim.physics.contact.collision.collider import (
    CYLINDER,
    HULL,
    SURFACE,
    ColliderArrays,
)
from rigid_body_sim.physics.contact.collision.conservative_advancement import (
    FAST,
    motion_of,
    pieces_of,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    FACE_RADIUS,
    FACE_SQUARE,
    HELD_COUNT,
    MOST,
    NEITHER,
    NOBODYS,
    NORMAL_OWNER,
    POINT,
    POINTS,
    RIM,
    SHIFT,
    TURN,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.on_surface import (
    write_far_contact,
    write_manifolds,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import MOTION, REST
from rigid_body_sim.physics.contact.collision.ghosts import ghost_dropper
from rigid_body_sim.physics.contact.collision.ground_misses import ALL, ground_miss_finder
from rigid_body_sim.physics.contact.collision.recycling import (
    NONE,
    Recycling,
    keep_pair,
    recall_pair,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL
from rigid_body_sim.physics.state.blocks import (
    LANES,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    RX,
    TRANSLATION,
    at,
)
from rigid_body_sim.physics.vectors import (
    add,
    cross,
    dot,
    load,
    load_strided,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TYPE_A, TYPE_B = slot('[-] type of A of a pair kernel'), slot('[-] type of B')
collide_this = slot(
    'kernel (parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found): finds the '
    'manifold of a pair of these types'
)
collide_others = slot('kernel (type of A, type of B, ...): answers for pairs of other types')
collide = slot('kernel (type of A, type of B, ...): finds the manifold of any pair of the scene')
GROUND = slot('[-] whether some collider is a surface')
HOLDS = slot('[-] whether points of some pairs depend on those of the last tick')
RECYCLES = slot('[-] whether manifolds of some pairs follow their bodies')
ground_misses = slot('kernel (a, b, record, ...): tells whether a body misses ground')


BOTH = 2  # colliders that stand back


@inline
def _rotation_matrix(rotation: Array, place: int) -> Any:
    """Return the rows of R(q), q the quaternion of a body at a place of the blocks."""
    x, y, z, w = (
        rotation[place + QX],
        rotation[place + QY],
        rotation[place + QZ],
        rotation[place + QW],
    )
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


@kernel
def find_poses(
    first: int, last: int, n_rigid: int, translation: Array, rotation: Array, table: Indices,
    local_poses: Array, poses: Array,
) -> None:  # fmt: skip
    """
    Find the poses of the shapes that move, from a first one to before a last: R = R(q) M,
    x = r - R c, see `pose`.
    """
    stride = pose.ROW_Y - pose.ROW_X
    for collider in range(first, last):
        body = table[collider * collider_record.SIZE + collider_record.BODY]
        if body < 0:
            continue
        place = collider * pose.SIZE
        lane = at(body, TRANSLATION)
        store(poses, place + pose.POSITION, load_strided(translation, lane + RX, LANES))
        if body >= n_rigid:
            continue
        row_x, row_y, row_z = _rotation_matrix(rotation, at(body, ROTATION))
        for column in range(3):
            axis = pose.axis(local_poses, place, column)
            turned = dot(row_x, axis), dot(row_y, axis), dot(row_z, axis)
            store_strided(poses, place + pose.ROW_X + column, stride, turned)
        center = load(local_poses, place + pose.POSITION)
        for row in range(3):
            poses[place + pose.POSITION + row] -= dot(
                load(poses, place + pose.ROW_X + stride * row), center
            )


@inline
def _no_pair(
    type_a, type_b, parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
):  # fmt: skip
    """End the chain."""
    return 0


def _collide(
    type_a, type_b, parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
):  # fmt: skip
    """Let the kernel of a pair of types answer, or pass on."""
    if type_a == TYPE_A and type_b == TYPE_B:
        return collide_this(parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found)
    return collide_others(
        type_a, type_b, parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
    )


def collider_of_pairs(
    kernels: Sequence[tuple[int, int, Callable[..., Any]]],
) -> Callable[..., Any]:
    """
    Join the pair kernels of a scene.

        kernels : (type of A, type of B, kernel)
        returns : kernel (type of A, type of B, parameters, shape_a, shape_b, poses, pose_a,
                  pose_b, margin, found)
    """
    chain, name = _no_pair, ''
    for type_a, type_b, one in reversed(kernels):
        name = f'{type_a}{type_b}_{name}'
        chain = specialise(
            _collide, name=name, TYPE_A=type_a, TYPE_B=type_b, collide_this=one,
            collide_others=chain,
        )  # fmt: skip
    return chain


@kernel
def _write_manifold(
    place: int, pair_id: int, a: int, b: int, points: int, pieces: int, found: Array,
    manifolds: Array,
) -> None:  # fmt: skip
    """Write what a pair kernel has found as a manifold that begins at a place; pieces: see it."""
    manifolds[place + manifold_record.PAIR_ID] = float(pair_id)
    manifolds[place + manifold_record.COLLIDER_A] = float(a)
    manifolds[place + manifold_record.COLLIDER_B] = float(b)
    manifolds[place + manifold_record.POINT_COUNT] = float(points)
    manifolds[place + manifold_record.PIECES] = float(pieces)
    manifolds[place + manifold_record.RECYCLED] = float(NONE)
    manifolds[place + manifold_record.RIM] = found[RIM]
    manifolds[place + manifold_record.FACE_AREA] = found[FACE_AREA]
    if found[FACE_AREA] > 0.0:
        manifolds[place + manifold_record.FACE_RADIUS] = found[FACE_RADIUS]
        manifolds[place + manifold_record.FACE_SQUARE] = found[FACE_SQUARE]
        store(manifolds, place + manifold_record.FACE_MIDDLE, load(found, FACE_MIDDLE))
    for entry in range(3):
        manifolds[place + manifold_record.NORMAL + entry] = found[entry]
    for entry in range(POINT * min(points, MOST)):
        manifolds[place + manifold_record.POINTS + entry] = found[POINTS + entry]


@inline
def _stand_back(a: int, b: int, table: Indices) -> Any:
    """Tell whether a pair is not looked for."""
    stands_a = table[a * collider_record.SIZE + collider_record.STANDS_BACK]
    stands_b = table[b * collider_record.SIZE + collider_record.STANDS_BACK]
    return stands_a + stands_b == BOTH


@inline
def _in_order(a: int, b: int, table: Indices) -> Any:
    """Return two colliders as A and B of their pair kernel, and their types."""
    type_a = table[a * collider_record.SIZE + collider_record.TYPE]
    type_b = table[b * collider_record.SIZE + collider_record.TYPE]
    if type_a > type_b or (type_a == type_b and a > b):
        return b, a, type_b, type_a
    return a, b, type_a, type_b


@inline
def _forget(found: Array) -> None:
    """Let pair kernels know of no motion, and of nothing that was held."""
    found[HELD_COUNT] = 0.0
    store(found, SHIFT, (0.0, 0.0, 0.0))
    store(found, TURN, (0.0, 0.0, 0.0))


@inline
def _tell_motion(
    number: int, h: float, colliders: ColliderArrays, bodies: Array, found: Array
) -> None:
    """Tell a pair kernel how a hull moves in the tick, where its axes begin."""
    row = number * collider_record.SIZE
    body = colliders.table[row + collider_record.BODY]
    if colliders.table[row + collider_record.TYPE] == HULL and body >= 0:
        place = body * solver_bodies.SIZE
        turn = scale(h, solver_bodies.surface_spin(place, bodies))
        start = load(bodies, place + solver_bodies.START_POSITION)
        arm = subtract(load(colliders.poses, number * pose.SIZE + pose.POSITION), start)
        velocity = load(colliders.swept_aabbs, number * swept_aabbs.SIZE + swept_aabbs.VELOCITY)
        store(found, SHIFT, add(scale(h, velocity), cross(turn, arm)))
        store(found, TURN, turn)


@inline
def _tell_motions(
    a: int, b: int, h: float, colliders: ColliderArrays, bodies: Array, found: Array
) -> None:
    """Tell a pair kernel how the one of two moves in the tick beside what is fixed."""
    if colliders.table[b * collider_record.SIZE + collider_record.BODY] < 0:
        _tell_motion(a, h, colliders, bodies, found)
    elif colliders.table[a * collider_record.SIZE + collider_record.BODY] < 0:
        _tell_motion(b, h, colliders, bodies, found)


@inline
def _tell_ground(row_a: int, row_b: int, h: float, swept: Array, found: Array) -> None:
    """Tell the kernel of a surface how a body moves in the tick, and what counts as near."""
    store(found, MOTION, scale(h, load(swept, row_a + swept_aabbs.VELOCITY)))
    found[REST] = min(swept[row_a + swept_aabbs.MARGIN], swept[row_b + swept_aabbs.MARGIN])


def _find_manifolds(
    first: int, last: int, count: int, h: float, substep: float, room: int,
    colliders: ColliderArrays, pair_ids: Indices, found: Array, manifolds: Array, bodies: Array,
    recycling: Recycling,
) -> int:  # fmt: skip
    """
    Write the manifolds of pairs that are within their speculative margins, at the place of the
    first pair and behind it; return how many, also beyond the room.

        first, last : of the pairs, those of `neighbour_list.find_pairs`, and the one behind
        count       : of colliders;   h : tick [s];   substep : [s]
        room        : manifolds for which there is room, from the start of the list
        found       : scratch of a pair kernel
        manifolds   : written, see `manifold_record`
        recycling   : what is known from the last tick
    """
    table, swept = colliders.table, colliders.swept_aabbs
    length = first
    for index in range(first, last):
        pair_id = pair_ids[index]
        a, b = pair_id // count, pair_id % count
        if _stand_back(a, b, table):
            continue
        a, b, type_a, type_b = _in_order(a, b, table)
        shape_a = table[a * collider_record.SIZE + collider_record.PARAMETERS]
        shape_b = table[b * collider_record.SIZE + collider_record.PARAMETERS]
        row_a, row_b = a * swept_aabbs.SIZE, b * swept_aabbs.SIZE
        margin, wanted = 0.0, 1
        if colliders.local_bounds[b * bounds_record.SIZE + bounds_record.RADIUS] == math.inf:
            normal = load(colliders.parameters, shape_b + NORMAL)
            margin = swept_aabbs.plane_margin(swept, row_a, normal, h)
        else:
            margin = swept_aabbs.speculative_margin(swept, row_a, row_b, h)
            radius = smaller_radius(colliders.local_bounds, a, b)
            motion = motion_of(swept, a, b, h)
            if motion > FAST * radius:
                wanted = pieces_of(motion, radius)
                if (
                    GROUND
                    and type_b == SURFACE
                    and ground_misses(
                        a, b, ALL, count, h + substep, colliders, bodies, found, manifolds
                    )
                ):
                    continue
        found[FACE_AREA] = 0.0
        found[NORMAL_OWNER], found[RIM] = NOBODYS, NEITHER
        if GROUND and type_b == SURFACE:
            _tell_ground(row_a, row_b, h, swept, found)
        _tell_motions(a, b, h, colliders, bodies, found)
        if HOLDS:
            held_features.tell(index, type_a, type_b, recycling.held, found)
        known, points = NONE, 0
        if RECYCLES:
            known, points = recall_pair(index, a, b, margin, colliders, recycling, found)
        if points == 0:
            known = NONE
            points = collide(
                type_a, type_b, colliders.parameters, shape_a, shape_b, colliders.poses,
                a * pose.SIZE, b * pose.SIZE, margin, found,
            )  # fmt: skip
        _forget(found)
        if GROUND and type_b == SURFACE and wanted > 1 and points == 0:
            points = write_far_contact(margin, found)
        if points == 0:
            continue
        if GROUND and type_b == SURFACE:
            length = write_manifolds(pair_id, a, b, wanted, length, room, found, manifolds)
            continue
        if length < room:
            place = length * manifold_record.SIZE
            _write_manifold(place, pair_id, a, b, points, wanted, found, manifolds)
            if RECYCLES:
                manifolds[place + manifold_record.RECYCLED] = keep_pair(
                    length, known, a, b, points, margin, colliders, recycling, found
                )
        length += 1
    return length - first


@kernel
def close_up(parts: int, pairs_of_part: int, counts: Indices, manifolds: Array) -> int:
    """
    Put the manifolds of parts of the pairs behind each other; return how many there are. LANE
    belongs to the place.

    counts : how many each part has
    """
    length = counts[0]
    for part in range(1, parts):
        begin = part * pairs_of_part
        for index in range(begin, begin + counts[part]):
            if length != index:
                for entry in range(manifold_record.LANE):
                    manifolds[length * manifold_record.SIZE + entry] = manifolds[
                        index * manifold_record.SIZE + entry
                    ]
            length += 1
    return length


def manifold_finder(
    kernels: Sequence[tuple[int, int, Callable[..., Any]]],
    *,
    holds: bool,
    recycles: bool,
    events: bool,
) -> dict[str, Any]:
    """
    Make what finds the manifolds of a scene with these pair kernels, by name.

    holds    : whether points of some pairs depend on those of the last tick
    recycles : whether manifolds of some pairs follow their bodies
    events   : whether impacts come at their instants
    """
    name = '_'.join(f'{type_a}{type_b}' for type_a, type_b, _ in kernels)
    collide = collider_of_pairs(kernels)
    ground = any(type_b == SURFACE for _, type_b, _ in kernels)
    cylinders = any(CYLINDER in (type_a, type_b) for type_a, type_b, _ in kernels)
    true_shapes = cylinders or any(HULL in (type_a, type_b) for type_a, type_b, _ in kernels)
    ground_misses = collide
    if ground:
        ground_misses = ground_miss_finder(name, collide, true_shapes=true_shapes)
    return {
        'find_manifolds': specialise(
            _find_manifolds, name=name, GROUND=ground, HOLDS=holds, RECYCLES=recycles,
            collide=collide, ground_misses=ground_misses,
        ),
        'drop_ghosts': ghost_dropper(
            name, collide, ground=ground, cylinders=cylinders, true_shapes=true_shapes,
            events=events,
        ),
    }  # fmt: skip
