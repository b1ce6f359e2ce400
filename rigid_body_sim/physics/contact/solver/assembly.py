# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
From manifolds to the rows of the solver, and back to what the next tick starts from.

The memory of contacts is one list, in the order of the keys of the pairs: substep [s] and number
of manifolds; then for each manifold its key, its number of points, and REMEMBERED numbers a point.
Both lists are in order, so that old and new meet in one walk. A point is the same as before if its
feature is, else if its anchor lies within a fifth of the radius. Impulses are remembered as
vectors of the world and given to the new tangents; if the substep changed they change with it.

Manifolds go into batches of eight that share no moving body: each takes the first colour that
neither of its bodies has yet, and the open batch of this colour.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact import solver_bodies
from rigid_body_sim.physics.contact.collision import collider, manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import (
    batch_record,
    cache_record,
    constraint,
    contact_point,
    lane_scratch,
)
from rigid_body_sim.physics.contact.solver.surfaces import layer, round_pair, weight
from rigid_body_sim.physics.state.blocks import RX, TRANSLATION, at

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NOWHERE = 1e9  # [m] gap of a point that a manifold does not have
SAME_PLACE = 0.2  # [-] of the radius: an anchor that moved less is the same point


@inline
def _first_free(used: int) -> int:
    colour = 0
    while colour < batch_record.COLOURS and (used >> colour) & 1:
        colour += 1
    return colour


@kernel
def is_same(manifolds: int, records: Array, memory: Array) -> bool:
    """Tell whether the manifolds are those of the memory, with as many points."""
    if memory[1] != float(manifolds):
        return False
    old = cache_record.HEAD
    for m in range(manifolds):
        o = m * manifold_record.SIZE
        if (
            memory[old] != records[o + manifold_record.PAIR_ID]
            or memory[old + 1] != records[o + manifold_record.POINT_COUNT]
        ):
            return False
        old += 2 + int(memory[old + 1]) * cache_record.POINT_SIZE
    return True


@kernel
def make_batches(
    manifolds: int, n_moving: int, width: int, room: int, most: int, table: Indices,
    records: Array, bodies: Array, colours: Indices, open_batches: Indices, rows: Array,
    batches: Indices,
) -> int:  # fmt: skip
    """
    Give each manifold a lane; return the number of batches, or -1 without room.

    width : numbers of a point
    """
    for i in range(n_moving + 1):
        colours[i] = 0
    for i in range(3 * batch_record.COLOURS + 3):
        open_batches[i] = -1
    count = 0
    end = lane_scratch.SIZE
    for m in range(manifolds):
        o = m * manifold_record.SIZE
        a = table[int(records[o + manifold_record.COLLIDER_A]) * collider.TABLE + collider.CORE]
        b = table[int(records[o + manifold_record.COLLIDER_B]) * collider.TABLE + collider.CORE]
        a = a if a >= 0 else n_moving
        b = b if b >= 0 else n_moving
        used = (colours[a] if a < n_moving else 0) | (colours[b] if b < n_moving else 0)
        colour = _first_free(used)
        points = int(records[o + manifold_record.POINT_COUNT])
        size = 1 if points == 1 else 4
        kind = int(
            round_pair(
                int(records[o + manifold_record.COLLIDER_A]),
                int(records[o + manifold_record.COLLIDER_B]),
                table,
                bodies,
            )
            > 0.0
        )
        slot = 3 * colour + (kind if points == 1 else 2)
        batch = open_batches[slot]
        if (
            batch < 0
            or colour == batch_record.COLOURS
            or batches[batch * batch_record.SIZE + batch_record.LANE_COUNT] == constraint.LANES
        ):
            batch = count
            if batch >= most or end + constraint.SIZE + size * width > room:
                return -1
            batches[batch * batch_record.SIZE + batch_record.BEGIN] = end
            batches[batch * batch_record.SIZE + batch_record.POINT_COUNT] = 0
            batches[batch * batch_record.SIZE + batch_record.LANE_COUNT] = 0
            batches[batch * batch_record.SIZE + batch_record.KIND] = kind
            end += constraint.SIZE + size * width
            open_batches[slot] = batch
            count += 1
        if colour < batch_record.COLOURS:
            colours[a] |= 1 << colour
            colours[b] |= 1 << colour
        lane = batches[batch * batch_record.SIZE + batch_record.LANE_COUNT]
        batches[batch * batch_record.SIZE + batch_record.LANE_COUNT] = lane + 1
        batches[batch * batch_record.SIZE + batch_record.POINT_COUNT] = max(
            batches[batch * batch_record.SIZE + batch_record.POINT_COUNT], points
        )
        place = batches[batch * batch_record.SIZE + batch_record.BEGIN] + lane
        records[o + manifold_record.LANE] = float(place)
        rows[place + constraint.BODY_A] = float(a * solver_bodies.SIZE)
        rows[place + constraint.BODY_B] = float(b * solver_bodies.SIZE)
    _empty_what_is_left(count, n_moving, width, records, manifolds, rows, batches)
    return count


@kernel
def _empty_what_is_left(count, n_moving, width, records, manifolds, rows, batches):
    """
    Write zeros where a batch has no manifold, and points out of reach where a manifold has fewer
    points than its batch: they push nothing.
    """
    for batch in range(count):
        begin = batches[batch * batch_record.SIZE + batch_record.BEGIN]
        end = (
            begin
            + constraint.SIZE
            + batches[batch * batch_record.SIZE + batch_record.POINT_COUNT] * width
        )
        for lane in range(
            batches[batch * batch_record.SIZE + batch_record.LANE_COUNT], constraint.LANES
        ):
            for row in range(begin + lane, end, constraint.LANES):
                rows[row] = 0.0
            rows[begin + lane + constraint.BODY_A] = float(n_moving * solver_bodies.SIZE)
            rows[begin + lane + constraint.BODY_B] = float(n_moving * solver_bodies.SIZE)
    for m in range(manifolds):
        points = int(records[m * manifold_record.SIZE + manifold_record.POINT_COUNT])
        if points > 1:
            place = int(records[m * manifold_record.SIZE + manifold_record.LANE])
            for point in range(points, manifold.MOST):
                begin = place + constraint.SIZE + point * width
                for row in range(begin, begin + width, constraint.LANES):
                    rows[row] = 0.0
                rows[begin + contact_point.INITIAL_SEPARATION] = NOWHERE


@kernel
def fill_materials(
    manifolds: int, h: float, pieces: int, zeta: float, table: Indices, bounds: Array,
    materials: Array, records: Array, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """
    Write material and softness of all manifolds, and whose surface their points follow.

    h      : [s] substep
    pieces : into which the tick is cut; contacts stay as soft as in a whole one, or what rests
             would be thrown up by the overlap with which it rests
    """
    for m in range(manifolds):
        o = m * manifold_record.SIZE
        place = int(records[o + manifold_record.LANE])
        a, b = (
            int(records[o + manifold_record.COLLIDER_A]),
            int(records[o + manifold_record.COLLIDER_B]),
        )
        ma, mb = a * collider.MATERIAL, b * collider.MATERIAL
        rows[place + constraint.FRICTION] = math.sqrt(
            materials[ma + collider.FRICTION] * materials[mb + collider.FRICTION]
        )
        rows[place + constraint.RESTITUTION] = max(
            materials[ma + collider.RESTITUTION], materials[mb + collider.RESTITUTION]
        )
        rows[place + constraint.ROLLING_FRICTION] = max(
            materials[ma + collider.ROLLING], materials[mb + collider.ROLLING]
        )
        rows[place + constraint.TORSIONAL_FRICTION] = max(
            materials[ma + collider.TORSIONAL], materials[mb + collider.TORSIONAL]
        )
        rows[place + constraint.SURFACE_WEIGHT] = weight(a, b, table, bodies)
        rows[place + constraint.ROUNDNESS] = round_pair(a, b, table, bodies)
        rows[place + constraint.RADIUS_A] = layer(a, bounds)
        rows[place + constraint.RADIUS_B] = layer(b, bounds)
        still = (
            table[a * collider.TABLE + collider.CORE] < 0
            or table[b * collider.TABLE + collider.CORE] < 0
        )
        omega = (math.pi if still else 0.5 * math.pi) / (h * pieces)
        a1 = 2.0 * zeta + h * omega
        a2 = h * omega * a1
        keep = 1.0 / (1.0 + a2)
        rows[place + constraint.BIAS_RATE] = omega / a1
        rows[place + constraint.MASS_SCALE] = a2 * keep
        rows[place + constraint.IMPULSE_SCALE] = keep


@inline
def anchor_of(poses: Array, p: int, x: float, y: float, z: float) -> Any:
    """Return a point in the axes of a shape."""
    x, y, z = x - poses[p], y - poses[p + 1], z - poses[p + 2]
    return (
        poses[p + 3] * x + poses[p + 6] * y + poses[p + 9] * z,
        poses[p + 4] * x + poses[p + 7] * y + poses[p + 10] * z,
        poses[p + 5] * x + poses[p + 8] * y + poses[p + 11] * z,
    )


@inline
def _same_feature(feature: float, old: int, count: int, taken: int, memory: Array) -> int:
    """Find a feature among the points in memory that are not taken; -1: it is new."""
    best = -1
    for i in range(count):
        same = (
            memory[old + 2 + i * cache_record.POINT_SIZE + cache_record.FEATURE] == feature
        ) & (not (taken >> i) & 1)
        best = i if same else best
    return best


@kernel
def _nearest(
    point: int, old: int, count: int, taken: int, near: float, pose: int, poses: Array,
    records: Array, memory: Array,
) -> int:  # fmt: skip
    """Find the nearest point of a manifold in memory that is not taken; -1: none is near."""
    x, y, z = anchor_of(poses, pose, records[point], records[point + 1], records[point + 2])
    best, least = -1, near
    for i in range(count):
        anchor = old + 2 + i * cache_record.POINT_SIZE + cache_record.ANCHOR
        dx, dy, dz = x - memory[anchor], y - memory[anchor + 1], z - memory[anchor + 2]
        distance = dx * dx + dy * dy + dz * dz
        if not (taken >> i) & 1 and distance < least:
            best, least = i, distance
    return best


@kernel
def fill_rows(
    manifolds: int, width: int, h: float, angular: bool, translation: Array, table: Indices,
    bounds: Array, poses: Array, records: Array, memory: Array, rows: Array,
) -> None:  # fmt: skip
    """
    Write normals, arms and gaps of all manifolds, and the impulses that memory holds for them, as
    vectors of the world: `preparation` turns them to the new tangents.
    """
    before = memory[0]
    factor = h / before if before > 0.0 and before != h else 1.0
    left = int(memory[1])
    old = cache_record.HEAD
    for m in range(manifolds):
        o = m * manifold_record.SIZE
        place = int(records[o + manifold_record.LANE])
        nx, ny, nz = (
            records[o + manifold_record.NORMAL],
            records[o + manifold_record.NORMAL + 1],
            records[o + manifold_record.NORMAL + 2],
        )
        (
            rows[place + constraint.NORMAL],
            rows[place + constraint.NORMAL + 8],
            rows[place + constraint.NORMAL + 16],
        ) = nx, ny, nz
        rows[place + constraint.TOUCHED] = 0.0
        key = records[o + manifold_record.PAIR_ID]
        while left > 0 and memory[old] < key:
            old += 2 + int(memory[old + 1]) * cache_record.POINT_SIZE
            left -= 1
        count = int(memory[old + 1]) if left > 0 and memory[old] == key else 0
        a, b = (
            int(records[o + manifold_record.COLLIDER_A]),
            int(records[o + manifold_record.COLLIDER_B]),
        )
        core_a, core_b = (
            table[a * collider.TABLE + collider.CORE],
            table[b * collider.TABLE + collider.CORE],
        )
        i, k = a * collider.POSE, b * collider.POSE
        ux, uy, uz, vx, vy, vz = (
            poses[i], poses[i + 1], poses[i + 2], poses[k], poses[k + 1], poses[k + 2],
        )  # fmt: skip
        if core_a >= 0:
            k = at(core_a, TRANSLATION)
            ux, uy, uz = translation[k + RX], translation[k + RX + 64], translation[k + RX + 128]
        if core_b >= 0:
            k = at(core_b, TRANSLATION)
            vx, vy, vz = translation[k + RX], translation[k + RX + 64], translation[k + RX + 128]
        # on the surface of the body that moves: the point midway serves the balance of angular
        # momentum, which what cannot move does not keep
        shift = -0.5 if core_b < 0 else (0.5 if core_a < 0 else 0.0)
        radius = min(bounds[a * collider.BOUNDS + 7], bounds[b * collider.BOUNDS + 7])
        near = SAME_PLACE * SAME_PLACE * radius * radius
        taken = 0
        for point in range(int(records[o + manifold_record.POINT_COUNT])):
            found = o + manifold_record.POINTS + point * manifold.POINT
            p = place + constraint.SIZE + point * width
            gap = records[found + manifold.SEPARATION]
            x = records[found] + shift * gap * nx
            y = records[found + 1] + shift * gap * ny
            z = records[found + 2] + shift * gap * nz
            (
                rows[p + contact_point.ARM_A],
                rows[p + contact_point.ARM_A + 8],
                rows[p + contact_point.ARM_A + 16],
            ) = x - ux, y - uy, z - uz
            (
                rows[p + contact_point.ARM_B],
                rows[p + contact_point.ARM_B + 8],
                rows[p + contact_point.ARM_B + 16],
            ) = x - vx, y - vy, z - vz
            rows[p + contact_point.INITIAL_SEPARATION] = gap
            i = _same_feature(records[found + manifold.FEATURE], old, count, taken, memory)
            if i < 0 and count > 0:
                i = _nearest(
                    found, old, count, taken, near, a * collider.POSE, poses, records, memory
                )
            if i >= 0:
                taken |= 1 << i
            _recall(
                p, old + 2 + i * cache_record.POINT_SIZE if i >= 0 else -1, factor, memory, rows
            )
            if width > contact_point.SIZE:
                known = old + 2 + i * cache_record.POINT_SIZE if i >= 0 and angular else -1
                _recall_twist(p, known, factor, memory, rows)


@inline
def _recall(p: int, i: int, factor: float, memory: Array, rows: Array) -> None:
    """Give a point the impulses that memory holds at i; -1: none."""
    if i < 0:
        rows[p + contact_point.NORMAL_IMPULSE] = 0.0
        (
            rows[p + contact_point.TOTAL_IMPULSE],
            rows[p + contact_point.TOTAL_IMPULSE + 8],
            rows[p + contact_point.TOTAL_IMPULSE + 16],
        ) = 0.0, 0.0, 0.0
    else:
        rows[p + contact_point.NORMAL_IMPULSE] = factor * memory[i + cache_record.NORMAL_IMPULSE]
        rows[p + contact_point.TOTAL_IMPULSE] = factor * memory[i + cache_record.FRICTION_IMPULSE]
        rows[p + contact_point.TOTAL_IMPULSE + 8] = (
            factor * memory[i + cache_record.FRICTION_IMPULSE + 1]
        )
        rows[p + contact_point.TOTAL_IMPULSE + 16] = (
            factor * memory[i + cache_record.FRICTION_IMPULSE + 2]
        )


@inline
def _recall_twist(p: int, i: int, factor: float, memory: Array, rows: Array) -> None:
    """Give a point the angular impulses that memory holds at i; -1: none."""
    if i < 0:
        (
            rows[p + contact_point.RESTITUTION_NORMAL],
            rows[p + contact_point.RESTITUTION_TANGENT_1],
            rows[p + contact_point.RESTITUTION_TANGENT_2],
        ) = 0.0, 0.0, 0.0
    else:
        rows[p + contact_point.RESTITUTION_NORMAL] = (
            factor * memory[i + cache_record.ANGULAR_IMPULSE]
        )
        rows[p + contact_point.RESTITUTION_TANGENT_1] = (
            factor * memory[i + cache_record.ANGULAR_IMPULSE + 1]
        )
        rows[p + contact_point.RESTITUTION_TANGENT_2] = (
            factor * memory[i + cache_record.ANGULAR_IMPULSE + 2]
        )
