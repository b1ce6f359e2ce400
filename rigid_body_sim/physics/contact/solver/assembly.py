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
from rigid_body_sim.physics.contact.collision.collider import (
    BOUNDS,
    CORE,
    FRICTION,
    MATERIAL,
    POSE,
    RESTITUTION,
    ROLLING,
    TABLE,
    TORSIONAL,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import FEATURE
from rigid_body_sim.physics.contact.collision.geometry.manifold import GAP as FOUND_GAP
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST as MOST_POINTS
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT as FOUND_POINT
from rigid_body_sim.physics.contact.collision.narrow_phase import (
    BODY_A,
    BODY_B,
    COUNT,
    KEY,
    LANE,
    NORMAL,
    RECORD,
    RECORD_POINTS,
)
from rigid_body_sim.physics.contact.solver.constraint import (
    BN,
    BO,
    BOUNCE,
    BT,
    GAP0,
    JN,
    KEEP,
    LANES,
    LAYER_A,
    LAYER_B,
    MANIFOLD,
    MU,
    POINT,
    RA,
    RATE,
    RB,
    ROLL,
    ROUND_PAIR,
    SCALE,
    SCRATCH,
    SPIN,
    SUM,
    TOUCHED,
    WEIGHT,
    A,
    B,
    N,
)
from rigid_body_sim.physics.contact.solver.surfaces import layer, round_pair, weight
from rigid_body_sim.physics.contact.solver_bodies import BODY
from rigid_body_sim.physics.state.blocks import RX, TRANSLATION, at

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

COLOURS = 60  # beyond these a manifold gets a batch of its own
# of a batch: where it begins in the rows, points, lanes in use, 1: balls among themselves
OFFSET, POINTS, USED, KIND = 0, 1, 2, 3
BATCH = 4

MEMORY = 2  # numbers before the first manifold of the memory: substep, manifolds
FEAT, NORM, SLIP, ANCHOR, TWIST = 0, 1, 2, 5, 8  # of a remembered point
REMEMBERED = 11
NOWHERE = 1e9  # [m] gap of a point that a manifold does not have
SAME_PLACE = 0.2  # [-] of the radius: an anchor that moved less is the same point


@inline
def _first_free(used: int) -> int:
    colour = 0
    while colour < COLOURS and (used >> colour) & 1:
        colour += 1
    return colour


@kernel
def is_same(manifolds: int, records: Array, memory: Array) -> bool:
    """Tell whether the manifolds are those of the memory, with as many points."""
    if memory[1] != float(manifolds):
        return False
    old = MEMORY
    for m in range(manifolds):
        o = m * RECORD
        if memory[old] != records[o + KEY] or memory[old + 1] != records[o + COUNT]:
            return False
        old += 2 + int(memory[old + 1]) * REMEMBERED
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
    for i in range(3 * COLOURS + 3):
        open_batches[i] = -1
    count = 0
    end = SCRATCH
    for m in range(manifolds):
        o = m * RECORD
        a = table[int(records[o + BODY_A]) * TABLE + CORE]
        b = table[int(records[o + BODY_B]) * TABLE + CORE]
        a = a if a >= 0 else n_moving
        b = b if b >= 0 else n_moving
        used = (colours[a] if a < n_moving else 0) | (colours[b] if b < n_moving else 0)
        colour = _first_free(used)
        points = int(records[o + COUNT])
        size = 1 if points == 1 else 4
        kind = int(
            round_pair(int(records[o + BODY_A]), int(records[o + BODY_B]), table, bodies) > 0.0
        )
        slot = 3 * colour + (kind if points == 1 else 2)
        batch = open_batches[slot]
        if batch < 0 or colour == COLOURS or batches[batch * BATCH + USED] == LANES:
            batch = count
            if batch >= most or end + MANIFOLD + size * width > room:
                return -1
            batches[batch * BATCH + OFFSET] = end
            batches[batch * BATCH + POINTS] = 0
            batches[batch * BATCH + USED] = 0
            batches[batch * BATCH + KIND] = kind
            end += MANIFOLD + size * width
            open_batches[slot] = batch
            count += 1
        if colour < COLOURS:
            colours[a] |= 1 << colour
            colours[b] |= 1 << colour
        lane = batches[batch * BATCH + USED]
        batches[batch * BATCH + USED] = lane + 1
        batches[batch * BATCH + POINTS] = max(batches[batch * BATCH + POINTS], points)
        place = batches[batch * BATCH + OFFSET] + lane
        records[o + LANE] = float(place)
        rows[place + A] = float(a * BODY)
        rows[place + B] = float(b * BODY)
    _empty_what_is_left(count, n_moving, width, records, manifolds, rows, batches)
    return count


@kernel
def _empty_what_is_left(count, n_moving, width, records, manifolds, rows, batches):
    """
    Write zeros where a batch has no manifold, and points out of reach where a manifold has fewer
    points than its batch: they push nothing.
    """
    for batch in range(count):
        begin = batches[batch * BATCH + OFFSET]
        end = begin + MANIFOLD + batches[batch * BATCH + POINTS] * width
        for lane in range(batches[batch * BATCH + USED], LANES):
            for row in range(begin + lane, end, LANES):
                rows[row] = 0.0
            rows[begin + lane + A] = float(n_moving * BODY)
            rows[begin + lane + B] = float(n_moving * BODY)
    for m in range(manifolds):
        points = int(records[m * RECORD + COUNT])
        if points > 1:
            place = int(records[m * RECORD + LANE])
            for point in range(points, MOST_POINTS):
                begin = place + MANIFOLD + point * width
                for row in range(begin, begin + width, LANES):
                    rows[row] = 0.0
                rows[begin + GAP0] = NOWHERE


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
        o = m * RECORD
        place = int(records[o + LANE])
        a, b = int(records[o + BODY_A]), int(records[o + BODY_B])
        ma, mb = a * MATERIAL, b * MATERIAL
        rows[place + MU] = math.sqrt(materials[ma + FRICTION] * materials[mb + FRICTION])
        rows[place + BOUNCE] = max(materials[ma + RESTITUTION], materials[mb + RESTITUTION])
        rows[place + ROLL] = max(materials[ma + ROLLING], materials[mb + ROLLING])
        rows[place + SPIN] = max(materials[ma + TORSIONAL], materials[mb + TORSIONAL])
        rows[place + WEIGHT] = weight(a, b, table, bodies)
        rows[place + ROUND_PAIR] = round_pair(a, b, table, bodies)
        rows[place + LAYER_A] = layer(a, bounds)
        rows[place + LAYER_B] = layer(b, bounds)
        still = table[a * TABLE + CORE] < 0 or table[b * TABLE + CORE] < 0
        omega = (math.pi if still else 0.5 * math.pi) / (h * pieces)
        a1 = 2.0 * zeta + h * omega
        a2 = h * omega * a1
        keep = 1.0 / (1.0 + a2)
        rows[place + RATE] = omega / a1
        rows[place + SCALE] = a2 * keep
        rows[place + KEEP] = keep


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
        same = (memory[old + 2 + i * REMEMBERED + FEAT] == feature) & (not (taken >> i) & 1)
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
        anchor = old + 2 + i * REMEMBERED + ANCHOR
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
    old = MEMORY
    for m in range(manifolds):
        o = m * RECORD
        place = int(records[o + LANE])
        nx, ny, nz = records[o + NORMAL], records[o + NORMAL + 1], records[o + NORMAL + 2]
        rows[place + N], rows[place + N + 8], rows[place + N + 16] = nx, ny, nz
        rows[place + TOUCHED] = 0.0
        key = records[o + KEY]
        while left > 0 and memory[old] < key:
            old += 2 + int(memory[old + 1]) * REMEMBERED
            left -= 1
        count = int(memory[old + 1]) if left > 0 and memory[old] == key else 0
        a, b = int(records[o + BODY_A]), int(records[o + BODY_B])
        core_a, core_b = table[a * TABLE + CORE], table[b * TABLE + CORE]
        i, k = a * POSE, b * POSE
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
        radius = min(bounds[a * BOUNDS + 7], bounds[b * BOUNDS + 7])
        near = SAME_PLACE * SAME_PLACE * radius * radius
        taken = 0
        for point in range(int(records[o + COUNT])):
            found = o + RECORD_POINTS + point * FOUND_POINT
            p = place + MANIFOLD + point * width
            gap = records[found + FOUND_GAP]
            x = records[found] + shift * gap * nx
            y = records[found + 1] + shift * gap * ny
            z = records[found + 2] + shift * gap * nz
            rows[p + RA], rows[p + RA + 8], rows[p + RA + 16] = x - ux, y - uy, z - uz
            rows[p + RB], rows[p + RB + 8], rows[p + RB + 16] = x - vx, y - vy, z - vz
            rows[p + GAP0] = gap
            i = _same_feature(records[found + FEATURE], old, count, taken, memory)
            if i < 0 and count > 0:
                i = _nearest(found, old, count, taken, near, a * POSE, poses, records, memory)
            if i >= 0:
                taken |= 1 << i
            _recall(p, old + 2 + i * REMEMBERED if i >= 0 else -1, factor, memory, rows)
            if width > POINT:
                known = old + 2 + i * REMEMBERED if i >= 0 and angular else -1
                _recall_twist(p, known, factor, memory, rows)


@inline
def _recall(p: int, i: int, factor: float, memory: Array, rows: Array) -> None:
    """Give a point the impulses that memory holds at i; -1: none."""
    if i < 0:
        rows[p + JN] = 0.0
        rows[p + SUM], rows[p + SUM + 8], rows[p + SUM + 16] = 0.0, 0.0, 0.0
    else:
        rows[p + JN] = factor * memory[i + NORM]
        rows[p + SUM] = factor * memory[i + SLIP]
        rows[p + SUM + 8] = factor * memory[i + SLIP + 1]
        rows[p + SUM + 16] = factor * memory[i + SLIP + 2]


@inline
def _recall_twist(p: int, i: int, factor: float, memory: Array, rows: Array) -> None:
    """Give a point the angular impulses that memory holds at i; -1: none."""
    if i < 0:
        rows[p + BN], rows[p + BT], rows[p + BO] = 0.0, 0.0, 0.0
    else:
        rows[p + BN] = factor * memory[i + TWIST]
        rows[p + BT] = factor * memory[i + TWIST + 1]
        rows[p + BO] = factor * memory[i + TWIST + 2]
