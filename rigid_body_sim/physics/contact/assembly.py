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

from rigid_body_sim.physics.blocks import RX, TRANSLATION, at
from rigid_body_sim.physics.contact.collider import (
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
from rigid_body_sim.physics.contact.detection import (
    BODY_A,
    BODY_B,
    COUNT,
    KEY,
    LANE,
    NORMAL,
    RECORD,
    RECORD_POINTS,
)
from rigid_body_sim.physics.contact.geometry.manifold import FEATURE
from rigid_body_sim.physics.contact.geometry.manifold import GAP as FOUND_GAP
from rigid_body_sim.physics.contact.geometry.manifold import POINT as FOUND_POINT
from rigid_body_sim.physics.contact.rows import (
    BOUNCE,
    GAP,
    GAP0,
    JN,
    JO,
    JQ,
    JR,
    JS,
    JT,
    KEEP,
    LANES,
    MANIFOLD,
    MU,
    RA,
    RATE,
    RB,
    ROLL,
    SCALE,
    SCRATCH,
    SPIN,
    SUM,
    T2,
    A,
    B,
    N,
    T,
)
from rigid_body_sim.physics.contact.touching_bodies import BODY, L_HELD, P_HELD
from rigid_body_sim.physics.kernels import inline, kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

COLOURS = 60  # beyond these a manifold gets a batch of its own
OFFSET, POINTS, USED = 0, 1, 2  # of a batch: where it begins in the rows, points, lanes in use
BATCH = 4

MEMORY = 2  # numbers before the first manifold of the memory: substep, manifolds
FEAT, NORM, SLIP, ANCHOR, TWIST = 0, 1, 2, 5, 8  # of a remembered point
REMEMBERED = 11
NOWHERE = 1e9  # [m] gap of a point that a lane does not have
SAME_PLACE = 0.2  # [-] of the radius: an anchor that moved less is the same point


@inline
def _first_free(used: int) -> int:
    colour = 0
    while colour < COLOURS and (used >> colour) & 1:
        colour += 1
    return colour


@kernel
def _new_batch(
    batch: int, offset: int, points: int, width: int, nothing: int, rows: Array, batches: Indices
) -> int:
    """Empty a batch; return where the next one begins."""
    end = offset + MANIFOLD + points * width
    for i in range(offset, end):
        rows[i] = 0.0
    for point in range(points):  # a lane with fewer points than its neighbours must not feel these
        for k in range(LANES):
            at_point = offset + MANIFOLD + point * width + k
            rows[at_point + GAP0] = NOWHERE
            rows[at_point + GAP] = NOWHERE
    for k in range(LANES):
        rows[offset + A + k] = float(nothing)
        rows[offset + B + k] = float(nothing)
    batches[batch * BATCH + OFFSET] = offset
    batches[batch * BATCH + POINTS] = 0
    batches[batch * BATCH + USED] = 0
    return end


@kernel
def make_batches(
    manifolds: int, n_moving: int, width: int, room: int, most: int, table: Indices,
    records: Array, colours: Indices, open_batches: Indices, rows: Array, batches: Indices,
) -> int:  # fmt: skip
    """
    Give each manifold a lane; return the number of batches, or -1 without room.

    width : numbers of a point
    """
    for i in range(n_moving + 1):
        colours[i] = 0
    for i in range(2 * COLOURS + 2):
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
        slot = 2 * colour + (0 if points == 1 else 1)
        batch = open_batches[slot]
        if batch < 0 or colour == COLOURS or batches[batch * BATCH + USED] == LANES:
            batch = count
            if batch >= most or end + MANIFOLD + size * width > room:
                return -1
            end = _new_batch(batch, end, size, width, n_moving * BODY, rows, batches)
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
    return count


@inline
def _tangent(nx: float, ny: float, nz: float) -> Any:
    """Return a unit vector across the normal."""
    if abs(nz) < 0.7:
        length = math.sqrt(nx * nx + ny * ny)
        return ny / length, -nx / length, 0.0
    length = math.sqrt(nz * nz + ny * ny)
    return 0.0, nz / length, -ny / length


@kernel
def _fill_manifold(
    o: int, place: int, h: float, zeta: float, table: Indices, materials: Array, records: Array,
    rows: Array,
) -> None:  # fmt: skip
    """Write normal, tangents, material and softness of a manifold into its lane."""
    a, b = int(records[o + BODY_A]), int(records[o + BODY_B])
    nx, ny, nz = records[o + NORMAL], records[o + NORMAL + 1], records[o + NORMAL + 2]
    tx, ty, tz = _tangent(nx, ny, nz)
    rows[place + N] = nx
    rows[place + N + 8] = ny
    rows[place + N + 16] = nz
    rows[place + T] = tx
    rows[place + T + 8] = ty
    rows[place + T + 16] = tz
    rows[place + T2] = ny * tz - nz * ty
    rows[place + T2 + 8] = nz * tx - nx * tz
    rows[place + T2 + 16] = nx * ty - ny * tx
    ma, mb = a * MATERIAL, b * MATERIAL
    rows[place + MU] = math.sqrt(materials[ma + FRICTION] * materials[mb + FRICTION])
    rows[place + BOUNCE] = max(materials[ma + RESTITUTION], materials[mb + RESTITUTION])
    rows[place + ROLL] = max(materials[ma + ROLLING], materials[mb + ROLLING])
    rows[place + SPIN] = max(materials[ma + TORSIONAL], materials[mb + TORSIONAL])
    still = table[a * TABLE + CORE] < 0 or table[b * TABLE + CORE] < 0
    omega = (math.pi if still else 0.5 * math.pi) / h
    a1 = 2.0 * zeta + h * omega
    a2 = h * omega * a1
    rows[place + RATE] = omega / a1
    rows[place + SCALE] = a2 / (1.0 + a2)
    rows[place + KEEP] = 1.0 / (1.0 + a2)


@inline
def anchor_of(poses: Array, p: int, x: float, y: float, z: float) -> Any:
    """Return a point in the axes of a shape."""
    x, y, z = x - poses[p], y - poses[p + 1], z - poses[p + 2]
    return (
        poses[p + 3] * x + poses[p + 6] * y + poses[p + 9] * z,
        poses[p + 4] * x + poses[p + 7] * y + poses[p + 10] * z,
        poses[p + 5] * x + poses[p + 8] * y + poses[p + 11] * z,
    )


@kernel
def _remembered_as(
    point: int, record: int, old: int, taken: int, near: float, pose: int, poses: Array,
    records: Array, memory: Array,
) -> int:  # fmt: skip
    """Find a point among those of a manifold in memory that are not taken; -1: it is new."""
    count = int(memory[old + 1])
    feature = records[point + FEATURE]
    for i in range(count):
        if not (taken >> i) & 1 and memory[old + 2 + i * REMEMBERED + FEAT] == feature:
            return i
    x, y, z = anchor_of(poses, pose, records[point], records[point + 1], records[point + 2])
    best, least = -1, near
    for i in range(count):
        at_anchor = old + 2 + i * REMEMBERED + ANCHOR
        dx, dy, dz = (
            x - memory[at_anchor],
            y - memory[at_anchor + 1],
            z - memory[at_anchor + 2],
        )
        distance = dx * dx + dy * dy + dz * dz
        if not (taken >> i) & 1 and distance < least:
            best, least = i, distance
    return best


@kernel
def fill_rows(
    manifolds: int, n_moving: int, width: int, h: float, zeta: float, angular: bool,
    translation: Array, table: Indices, materials: Array, bounds: Array, poses: Array,
    records: Array, memory: Array, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """Write the rows of all manifolds, with the impulses that memory holds for them."""
    before = memory[0]
    factor = h / before if before > 0.0 and before != h else 1.0
    left = int(memory[1])
    old = MEMORY
    for m in range(manifolds):
        o = m * RECORD
        place = int(records[o + LANE])
        _fill_manifold(o, place, h, zeta, table, materials, records, rows)
        key = records[o + KEY]
        while left > 0 and memory[old] < key:
            old += 2 + int(memory[old + 1]) * REMEMBERED
            left -= 1
        known = left > 0 and memory[old] == key
        a, b = int(records[o + BODY_A]), int(records[o + BODY_B])
        core_a, core_b = table[a * TABLE + CORE], table[b * TABLE + CORE]
        radius = min(bounds[a * BOUNDS + 7], bounds[b * BOUNDS + 7])
        near = SAME_PLACE * SAME_PLACE * radius * radius
        taken = 0
        batch = place - place % LANES
        lane = place - batch
        for point in range(int(records[o + COUNT])):
            at_point = o + RECORD_POINTS + point * FOUND_POINT
            p = batch + MANIFOLD + point * width + lane
            x, y, z = records[at_point], records[at_point + 1], records[at_point + 2]
            if core_a < 0 or core_b < 0:
                # on the surface of the body that moves: the point midway serves the balance of
                # angular momentum, which what cannot move does not keep
                half = 0.5 * records[at_point + FOUND_GAP]
                half = -half if core_b < 0 else half
                x += half * rows[place + N]
                y += half * rows[place + N + 8]
                z += half * rows[place + N + 16]
            if core_a >= 0:
                k = at(core_a, TRANSLATION)
                rows[p + RA] = x - translation[k + RX]
                rows[p + RA + 8] = y - translation[k + RX + 64]
                rows[p + RA + 16] = z - translation[k + RX + 128]
            if core_b >= 0:
                k = at(core_b, TRANSLATION)
                rows[p + RB] = x - translation[k + RX]
                rows[p + RB + 8] = y - translation[k + RX + 64]
                rows[p + RB + 16] = z - translation[k + RX + 128]
            rows[p + GAP0] = records[at_point + FOUND_GAP]
            rows[p + GAP] = records[at_point + FOUND_GAP]
            if not known:
                continue
            i = _remembered_as(at_point, o, old, taken, near, a * POSE, poses, records, memory)
            if i < 0:
                continue
            taken |= 1 << i
            _warm_start(
                place, p, old + 2 + i * REMEMBERED, factor, core_a, core_b, angular, memory,
                rows, bodies,
            )  # fmt: skip


@kernel
def _warm_start(
    place: int, p: int, i: int, factor: float, core_a: int, core_b: int, angular: bool,
    memory: Array, rows: Array, bodies: Array,
) -> None:  # fmt: skip
    """Give a point the impulses that memory holds for it, and its bodies what they add up to."""
    normal = factor * memory[i + NORM]
    if not normal > 0.0:
        return
    rows[p + JN] = normal
    x, y, z = memory[i + SLIP], memory[i + SLIP + 1], memory[i + SLIP + 2]
    t = factor * (rows[place + T] * x + rows[place + T + 8] * y + rows[place + T + 16] * z)
    o = factor * (rows[place + T2] * x + rows[place + T2 + 8] * y + rows[place + T2 + 16] * z)
    limit = rows[place + MU] * normal
    size = math.sqrt(t * t + o * o)
    if size > limit:
        t *= limit / size
        o *= limit / size
    rows[p + JT] = t
    rows[p + JO] = o
    # what the first substep starts from is not of this tick
    rows[p + SUM] = -normal
    rows[p + SUM + 8] = -t
    rows[p + SUM + 16] = -o
    x = normal * rows[place + N] + (t * rows[place + T] + o * rows[place + T2])
    y = normal * rows[place + N + 8] + (t * rows[place + T + 8] + o * rows[place + T2 + 8])
    z = normal * rows[place + N + 16] + (t * rows[place + T + 16] + o * rows[place + T2 + 16])
    u, v, w = 0.0, 0.0, 0.0
    if angular:
        u, v, w = memory[i + TWIST], memory[i + TWIST + 1], memory[i + TWIST + 2]
        r = factor * (rows[place + T] * u + rows[place + T + 8] * v + rows[place + T + 16] * w)
        q = factor * (rows[place + T2] * u + rows[place + T2 + 8] * v + rows[place + T2 + 16] * w)
        s = factor * (rows[place + N] * u + rows[place + N + 8] * v + rows[place + N + 16] * w)
        rows[p + JR] = r
        rows[p + JQ] = q
        rows[p + JS] = s
        u = r * rows[place + T] + q * rows[place + T2] + s * rows[place + N]
        v = r * rows[place + T + 8] + q * rows[place + T2 + 8] + s * rows[place + N + 8]
        w = r * rows[place + T + 16] + q * rows[place + T2 + 16] + s * rows[place + N + 16]
    for side in range(2):
        core = core_b if side == 1 else core_a
        if core < 0:
            continue
        sign = 1.0 if side == 1 else -1.0
        arm = p + RB if side == 1 else p + RA
        b = core * BODY
        bodies[b + P_HELD] += sign * x
        bodies[b + P_HELD + 1] += sign * y
        bodies[b + P_HELD + 2] += sign * z
        ax, ay, az = rows[arm], rows[arm + 8], rows[arm + 16]
        bodies[b + L_HELD] += sign * (ay * z - az * y + u)
        bodies[b + L_HELD + 1] += sign * (az * x - ax * z + v)
        bodies[b + L_HELD + 2] += sign * (ax * y - ay * x + w)
