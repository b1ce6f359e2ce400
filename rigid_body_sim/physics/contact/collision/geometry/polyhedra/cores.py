# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball or a capsule against a convex polyhedron: a core, a point or a segment, with a layer around.

gap = distance of the core from the polyhedron - radius

Where the core itself overlaps the polyhedron, the axis of least overlap takes the place of the
nearest points: a face normal of the polyhedron or the cross product of core and edge (`EDGE_GAIN`,
`EDGE_SHARE` of `polyhedra`). A capsule that lies on a face touches at both ends of the part of its
core that is over the face.

The polyhedron is A of `relative_pose`, the core B: the manifold's own normal is the opposite one.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import POINT, TINY
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import keep_four
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import (
    STEEP,
    facing,
    side_of,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.gjk import FAR, GAP, closest
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    COUNT,
    EDGE_LIST,
    EDGES,
    FACES,
    HALF,
    LOOP,
    LOOPS,
    PLANES,
    RADIUS,
    VERTICES,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.relative_pose import (
    AXIS,
    FRAME,
    POINTS,
    farthest,
    near_of,
    place,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.separating_axes import PARALLEL
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.two_polyhedra import (
    EDGE_GAIN,
    EDGE_SHARE,
    EXACT,
    LARGEST,
    nearest_to_axis,
    to_world,
)

CORE = POINTS + 64  # where the ends of the core are kept, axes of B, then of A


@kernel
def collide_core(
    radius: float,
    half_length: float,
    numbers,
    h: int,
    poses,
    pc: int,
    ph: int,
    margin: float,
    found,
) -> int:
    """
    Find the manifold of a core and a record of `hull_records`.

    radius, half_length : [m]  of the core along its z axis; half_length 0: a ball
    h                   : where the record begins in `numbers`
    pc, ph              : where the poses of core and polyhedron begin
    Normal from the core to the polyhedron; else see `manifold`.
    """
    k = h + CENTER
    cx, cy, cz = numbers[k], numbers[k + 1], numbers[k + 2]
    place(cx, cy, cz, 0.0, 0.0, 0.0, poses, ph, pc, found)
    x, y, z = found[FRAME], found[FRAME + 1], found[FRAME + 2]
    size = numbers[h + RADIUS] + half_length + radius
    reach = size + margin
    if not (x * x + y * y + z * z <= reach * reach and size < LARGEST):
        return 0
    for i in range(2):
        sign = 1.0 - 2.0 * i
        found[CORE + 3 * i], found[CORE + 3 * i + 1] = 0.0, 0.0
        found[CORE + 3 * i + 2] = sign * half_length
        for c in range(3):
            found[CORE + 6 + 3 * i + c] = (
                found[FRAME + c] + sign * half_length * found[FRAME + 5 + 3 * c]
            )
    state, _ = closest(
        numbers,
        h + VERTICES,
        int(numbers[h + COUNT]),
        near_of(numbers, h),
        found,
        CORE + 0 * h,  # a number known when compiling would make numba compile `closest` again
        2 if half_length > 0.0 else 1,
        0 * h,
        margin + radius,
        size,
        found,
    )
    if state == FAR:
        return 0
    s = nearest_to_axis(found) if state == GAP else _overlap(numbers, h, half_length > 0.0, found)
    gap = s - radius
    if not gap <= margin:
        return 0
    x, y, z = found[AXIS], found[AXIS + 1], found[AXIS + 2]
    count, least = 0, math.inf
    if half_length > 0.0:
        count, least = _part_over_face(numbers, h, radius, s, margin, found)
    if not least <= gap + EXACT * size:
        to = POINTS + POINT * count
        out = radius + 0.5 * gap
        found[to] = found[AXIS + 6] - out * x
        found[to + 1] = found[AXIS + 7] - out * y
        found[to + 2] = found[AXIS + 8] - out * z
        found[to + 3], found[to + 4] = gap, -1.0
        count += 1
    found[0], found[1], found[2] = -x, -y, -z
    count = keep_four(found, POINTS + 0 * h, count)
    to_world(cx, cy, cz, poses, ph, found, count)
    return count


@kernel
def _overlap(numbers, h: int, is_segment: bool, work) -> float:
    """Write to AXIS the normal of least overlap and, behind, the core's point; return s."""
    px, py, pz = work[CORE + 6], work[CORE + 7], work[CORE + 8]
    qx, qy, qz = work[CORE + 9], work[CORE + 10], work[CORE + 11]
    most, end = -math.inf, 0.0
    x = y = z = 0.0
    planes = h + int(numbers[h + PLANES])
    for f in range(int(numbers[h + FACES])):
        k = planes + 4 * f
        mx, my, mz, c = numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3]
        p, q = mx * px + my * py + mz * pz - c, mx * qx + my * qy + mz * qz - c
        if min(p, q) > most:
            most, end = min(p, q), (0.5 if p == q else 0.0 if p < q else 1.0)
            x, y, z = mx, my, mz
    if is_segment:
        floor = most + EDGE_GAIN * numbers[h + HALF] + EDGE_SHARE * abs(most)
        ux, uy, uz = qx - px, qy - py, qz - pz
        uu = ux * ux + uy * uy + uz * uz
        edges = h + int(numbers[h + EDGE_LIST])
        for e in range(edges, edges + 4 * int(numbers[h + EDGES]), 4):
            k, m = planes + 4 * int(numbers[e + 2]), planes + 4 * int(numbers[e + 3])
            left = ux * numbers[k] + uy * numbers[k + 1] + uz * numbers[k + 2]
            right = ux * numbers[m] + uy * numbers[m + 1] + uz * numbers[m + 2]
            if not left * right < 0.0:  # no normal between the two faces is across the core
                continue
            # The normal between them that is: the combination without a part along the core.
            mx = numbers[k] * abs(right) + numbers[m] * abs(left)
            my = numbers[k + 1] * abs(right) + numbers[m + 1] * abs(left)
            mz = numbers[k + 2] * abs(right) + numbers[m + 2] * abs(left)
            size = math.sqrt(mx * mx + my * my + mz * mz)
            if not size * size > max(PARALLEL * uu, TINY):
                continue
            mx, my, mz = mx / size, my / size, mz / size
            s = min(px * mx + py * my + pz * mz, qx * mx + qy * my + qz * mz)
            a, b = h + VERTICES + 3 * int(numbers[e]), h + VERTICES + 3 * int(numbers[e + 1])
            dx, dy, dz = numbers[a] - px, numbers[a + 1] - py, numbers[a + 2] - pz
            if not s - (numbers[a] * mx + numbers[a + 1] * my + numbers[a + 2] * mz) > floor:
                continue
            highest = int(numbers[e])
            highest = farthest(
                numbers,
                h + VERTICES,
                int(numbers[h + COUNT]),
                near_of(numbers, h),
                mx,
                my,
                mz,
                highest,
            )
            highest = h + VERTICES + 3 * highest
            s -= numbers[highest] * mx + numbers[highest + 1] * my + numbers[highest + 2] * mz
            if s > floor:
                most = floor = s
                x, y, z = mx, my, mz
                vx, vy = numbers[b] - numbers[a], numbers[b + 1] - numbers[a + 1]
                vz = numbers[b + 2] - numbers[a + 2]
                vv, uv = vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
                det = uu * vv - uv * uv
                end = 0.5
                if det > PARALLEL * uu * vv:
                    ud, vd = ux * dx + uy * dy + uz * dz, vx * dx + vy * dy + vz * dz
                    end = min(max((ud * vv - vd * uv) / det, 0.0), 1.0)
    work[AXIS], work[AXIS + 1], work[AXIS + 2] = x, y, z
    work[AXIS + 6] = px + end * (qx - px)
    work[AXIS + 7] = py + end * (qy - py)
    work[AXIS + 8] = pz + end * (qz - pz)
    return most


@kernel
def _part_over_face(
    numbers, h: int, radius: float, s: float, margin: float, work
) -> tuple[int, float]:
    """Write the ends of the part of the core over the face that looks along AXIS."""
    x, y, z = work[AXIS], work[AXIS + 1], work[AXIS + 2]
    px, py, pz = work[CORE + 6], work[CORE + 7], work[CORE + 8]
    ux, uy, uz = work[CORE + 9] - px, work[CORE + 10] - py, work[CORE + 11] - pz
    face = facing(numbers, h, x, y, z)
    k = h + int(numbers[h + PLANES]) + 4 * face
    mx, my, mz, c = numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3]
    steep = mx * x + my * y + mz * z
    if not steep > STEEP:
        return 0, math.inf
    begin, end = 0.0, 1.0
    begin_name, end_name = -1, -2
    loop = h + int(numbers[h + LOOPS]) + int(numbers[h + LOOP]) * face
    sides = int(numbers[loop])
    for side in range(sides):
        sx, sy, sz, out = side_of(numbers, h, loop, sides, side, False, x, y, z, work)
        room = out - (sx * px + sy * py + sz * pz)
        rate = sx * ux + sy * uy + sz * uz
        if rate > 0.0:
            if room < end * rate:
                end, end_name = room / rate, side
        elif rate < 0.0:
            if room < begin * rate:
                begin, begin_name = room / rate, side
        elif room < 0.0:
            return 0, math.inf
    if not begin <= end:
        return 0, math.inf
    kept, least = 0, math.inf
    for i in range(2):
        t = begin if i == 0 else end
        tx, ty, tz = px + t * ux, py + t * uy, pz + t * uz
        gap = max((mx * tx + my * ty + mz * tz - c) / steep, s) - radius
        if gap <= margin:
            to = POINTS + POINT * kept
            out = radius + 0.5 * gap
            work[to], work[to + 1], work[to + 2] = tx - out * x, ty - out * y, tz - out * z
            work[to + 3] = gap
            work[to + 4] = float(face) * 64.0 + float((begin_name if i == 0 else end_name) + 2)
            kept += 1
            least = min(least, gap)
    return kept, least
