# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Swept AABBs: how far colliders reach within a tick, and which may touch in it.

A collider reaches as far as its AABB, what it may move in a tick, and its margin. The speculative
margin of a pair is the separation from which the two may still meet in this tick:

    margin = min(m_A, m_B) + h |v_B - v_A| + w_A + w_B

        m : margin of a collider, MARGIN of the row [m]: what counts as near at rest
        v : velocity of its body [m/s];  h : tick [s]
        w : what turning and forces add in a tick [m]: min(|omega| l, 2 l / h) h + |a| h^2, l the
            longest lever of its core, omega that of the surface, which spin about an axis of
            symmetry does not turn (`solver_bodies.surface_spin`), a the acceleration of free
            motion

Contacts within it are speculative: the solver lets the two approach by their separation, no more.
Two boxes, or a box and a plane, that pass the tests here are a pair for the narrow phase;
`neighbour_list` finds them.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import bounds_record, collider_record
from rigid_body_sim.physics.contact.collision.aabb import extent
from rigid_body_sim.physics.contact.collision.collider import ColliderArrays, world_aabb
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET
from rigid_body_sim.physics.vectors import (
    dot,
    load,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

swept_aabb = Record()
CENTER = swept_aabb.vector('m', 'middle of the AABB at the start of the tick')
HALF = swept_aabb.vector('m', 'half edges of the AABB')
VELOCITY = swept_aabb.vector('m/s', 'of the body')
TURNING = swept_aabb.number('m', 'what turning and forces add in a tick')
FALL = swept_aabb.number('m', 'what of it forces add')
MARGIN = swept_aabb.number('m', 'separation that counts as near at rest')
EXPANSION = swept_aabb.number(
    'm', 'how far beyond its AABB another may be that counts as near, if that one does not move'
)
SIZE = swept_aabb.size

MARGIN_SHARE = 0.1  # [-] of its radius: the largest margin of a collider


@kernel
def find_swept_aabbs(
    first: int, last: int, h: float, margin: float, colliders: ColliderArrays, bodies: Array
) -> None:
    """
    Find how far each collider reaches, from a first one to before a last: AABB, velocity, and
    what turning adds in a tick.

        h      : tick [s];   margin : of the scene [m]
        bodies : see `solver_bodies`
    """
    swept = colliders.swept_aabbs
    for collider in range(first, last):
        row = collider * SIZE
        radius = colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.RADIUS]
        if radius == math.inf:
            continue
        center, half = world_aabb(colliders.local_bounds, collider, colliders.poses)
        store(swept, row + CENTER, center)
        store(swept, row + HALF, half)
        near = min(margin, MARGIN_SHARE * radius) if radius > 0.0 else margin
        swept[row + MARGIN] = near
        body = colliders.table[collider * collider_record.SIZE + collider_record.BODY]
        velocity = load(swept, row + VELOCITY)  # of what is driven; else zero
        path = math.sqrt(dot(velocity, velocity)) * h
        if body >= 0:
            place = body * solver_bodies.SIZE
            velocity = scale(
                bodies[place + solver_bodies.INVERSE_MASS],
                load(bodies, place + solver_bodies.MOMENTUM),
            )
            store(swept, row + VELOCITY, velocity)
            path = math.sqrt(dot(velocity, velocity)) * h
            layer = colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.ROUNDING]
            acceleration = load(bodies, place + solver_bodies.FREE_ACCELERATION)
            fall = math.sqrt(dot(acceleration, acceleration)) * h * h
            swept[row + FALL] = fall
            swept[row + TURNING] = _turning(center, radius - layer, h, place, bodies) + fall
        swept[row + EXPANSION] = 0.5 * near + path + swept[row + TURNING]


@inline
def _turning(center: Any, radius: float, h: float, place: int, bodies: Array) -> float:
    """Bound what turning moves of a ball about the middle of a core in a tick [m]."""
    spin = solver_bodies.surface_spin(place, bodies)
    arm = subtract(center, load(bodies, place + solver_bodies.START_POSITION))
    lever = math.sqrt(dot(arm, arm)) + radius
    turn = math.sqrt(dot(spin, spin)) * lever * h
    return min(turn, 2.0 * lever)


@inline
def relative_speed(swept: Array, row_a: int, row_b: int) -> float:
    """Speed at which two colliders move relative to each other [m/s]."""
    velocity = subtract(load(swept, row_b + VELOCITY), load(swept, row_a + VELOCITY))
    return math.sqrt(dot(velocity, velocity))


@inline
def speculative_margin(swept: Array, row_a: int, row_b: int, h: float) -> float:
    """Separation within which two colliders may meet in a tick [m], see the module."""
    return (
        min(swept[row_a + MARGIN], swept[row_b + MARGIN])
        + h * relative_speed(swept, row_a, row_b)
        + (swept[row_a + TURNING] + swept[row_b + TURNING])
    )


@inline
def plane_margin(swept: Array, row: int, normal: Any, h: float) -> float:
    """Give the same of a collider and a plane with this normal, which stands still [m]."""
    approach = -dot(normal, load(swept, row + VELOCITY))
    return swept[row + MARGIN] + max(approach, 0.0) * h + swept[row + TURNING]


@inline
def may_meet(swept: Array, row_a: int, row_b: int, h: float) -> bool:
    """Tell whether the swept AABBs of two colliders overlap, given where their rows begin."""
    margin = speculative_margin(swept, row_a, row_b, h)
    a, b = row_a + CENTER, row_b + CENTER
    half_a, half_b = row_a + HALF, row_b + HALF
    return (
        abs(swept[b] - swept[a]) <= swept[half_a] + swept[half_b] + margin
        and abs(swept[b + 1] - swept[a + 1]) <= swept[half_a + 1] + swept[half_b + 1] + margin
        and abs(swept[b + 2] - swept[a + 2]) <= swept[half_a + 2] + swept[half_b + 2] + margin
    )


@inline
def may_meet_plane(plane: int, collider: int, h: float, colliders: ColliderArrays) -> bool:
    """Tell whether a collider may touch the plane whose parameters begin at a place."""
    normal = load(colliders.parameters, plane + NORMAL)
    swept, row = colliders.swept_aabbs, collider * SIZE
    radius = colliders.local_bounds[collider * bounds_record.SIZE + bounds_record.RADIUS]
    reach = min(extent(load(swept, row + HALF), normal), radius)
    height = dot(normal, load(swept, row + CENTER)) - colliders.parameters[plane + OFFSET]
    return height - reach <= plane_margin(swept, row, normal, h)
