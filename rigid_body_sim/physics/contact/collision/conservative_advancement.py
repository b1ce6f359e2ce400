# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Conservative advancement, the continuous collision detection (CCD) of bodies that move farther in a
tick than they are large: whether and where they hit.

At distance d and with a speed of approach of at most b, nothing can touch before d/b (Mirtich,
Impulse-based dynamic simulation, 1996). The pair is moved on by that time, its distance found
again, and so on until it touches, or the tick is over. A pair that misses gets no contact in this
tick: the extended planes of far faces cannot stop what flies past an edge. A pair that hits asks
for a finer tick, in pieces in which bodies move by less than their size; the pieces are ticks like
others.
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
    pose,
    swept_aabbs,
)
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT, POINTS, SEPARATION
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    apply_symmetric,
    cross,
    dot,
    load,
    load_symmetric,
    scale,
    store,
    store_strided,
    subtract,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FAST = 0.5  # [-] of the radius of the smaller: motion in a tick from which a pair is advanced
PIECE = 0.25  # [-] of it: motion in a piece of a finer tick
MOST_PIECES = 4096
STEPS = 48  # of the advancement; a pair still undecided then is taken as a hit
TOUCH = 1e-3  # [-] of the radius: distance that counts as touching

collide = slot(
    'kernel (type of A, type of B, parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, '
    'found): finds the manifold of two shapes'
)


@inline
def smaller_radius(local_bounds: Array, a: int, b: int) -> Any:
    """Radius of the smaller of two colliders that has one [m]."""
    radius_a = local_bounds[a * bounds_record.SIZE + bounds_record.RADIUS]
    radius_b = local_bounds[b * bounds_record.SIZE + bounds_record.RADIUS]
    if radius_a <= 0.0:
        return radius_b
    if radius_b <= 0.0:
        return radius_a
    return min(radius_a, radius_b)


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
def _turn(vector_part: Any, scalar_part: float, v: Any) -> Any:
    """Turn a vector by a unit quaternion."""
    twice = scale(2.0, cross(vector_part, v))
    return add(add_scaled(v, scalar_part, twice), cross(vector_part, twice))


@kernel
def _move(
    collider: int, target: int, time: float, colliders: ColliderArrays, bodies: Array
) -> None:
    """Write the pose of a collider after free motion over a time; target: where it begins."""
    poses, place = colliders.poses, collider * pose.SIZE
    for entry in range(pose.SIZE):
        poses[target + entry] = poses[place + entry]
    index = colliders.table[collider * collider_record.SIZE + collider_record.BODY]
    if index < 0:
        return
    body = index * solver_bodies.SIZE
    spin = apply_symmetric(
        load_symmetric(bodies, body + solver_bodies.INVERSE_INERTIA),
        load(bodies, body + solver_bodies.ANGULAR_MOMENTUM),
    )
    rate = math.sqrt(dot(spin, spin))
    sine, cosine = 0.0, 1.0
    if rate > 0.0:
        half_turn = 0.5 * rate * time
        sine, cosine = math.sin(half_turn) / rate, math.cos(half_turn)
    turn = scale(sine, spin)
    for column in range(3):
        turned = _turn(turn, cosine, pose.axis(poses, place, column))
        store_strided(poses, target + pose.ROW_X + column, pose.ROW_Y - pose.ROW_X, turned)
    center = load(bodies, body + solver_bodies.START_POSITION)
    arm = _turn(turn, cosine, subtract(load(poses, place + pose.POSITION), center))
    velocity = load(colliders.swept_aabbs, collider * swept_aabbs.SIZE + swept_aabbs.VELOCITY)
    store(poses, target + pose.POSITION, add(center, add_scaled(arm, time, velocity)))


def _hits(
    a: int, b: int, count: int, h: float, motion: float, colliders: ColliderArrays, bodies: Array,
    found: Array,
) -> bool:  # fmt: skip
    """
    Tell whether two colliders touch within a tick, or may.

        count  : of colliders; behind their poses there is room for two more
        motion : bound of what the two move relative to each other in the tick [m]
    """
    touching = TOUCH * smaller_radius(colliders.local_bounds, a, b)
    row_a, row_b = a * collider_record.SIZE, b * collider_record.SIZE
    type_a = colliders.table[row_a + collider_record.TYPE]
    type_b = colliders.table[row_b + collider_record.TYPE]
    shape_a = colliders.table[row_a + collider_record.PARAMETERS]
    shape_b = colliders.table[row_b + collider_record.PARAMETERS]
    pose_a, pose_b = count * pose.SIZE, (count + 1) * pose.SIZE
    time = 0.0
    for _step in range(STEPS):
        _move(a, pose_a, time, colliders, bodies)
        _move(b, pose_b, time, colliders, bodies)
        reach = motion * (1.0 - time / h) + touching
        points = collide(
            type_a, type_b, colliders.parameters, shape_a, shape_b, colliders.poses, pose_a,
            pose_b, reach, found,
        )  # fmt: skip
        if points == 0:
            return False
        separation = found[POINTS + SEPARATION]
        for point in range(1, points):
            separation = min(separation, found[POINTS + point * POINT + SEPARATION])
        if not separation > touching:
            return True
        time += separation / motion * h
        if not time < h:
            return False
    return True


def hit_finder(name: str, collide: Callable[..., Any]) -> Callable[..., Any]:
    """Make the kernel that tells whether a fast pair hits, with the pair kernels of a scene."""
    return specialise(_hits, name=name, collide=collide)
