# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A body on ground of triangles: its manifolds with a surface, one for each facet that it touches.

1. The triangles near the body are asked for their facets, and the body for its manifold with the
   whole plane of each (the pair kernel of a plane). Where each of those points lies over the facet
   that is the manifold: all other triangles of the facet lie in that plane, and need not be asked.
   On a flat part of a mesh a body moves to the last digit as on a plane, whatever its triangles.
2. A facet that carries the body with all points of its plane, and which the body touches, covers
   whatever lies wholly behind that plane: nothing there can be touched in this tick.
   The line of a cylinder that lies partly beside a facet is cut off at its border.
3. Triangles of other facets are asked one by one; what they add joins the points that do lie over
   their facet.

A plane goes on behind a concave edge (`near_triangles.lies_over`): what stands in front of a wall
or a ramp feels it before it is there.
What is deeper than DEEP of its own extent is behind the surface, and meets nothing; only where
nothing can be behind, as under a height field, is it pushed out from any depth.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.contact.collision import manifold_record, pose
from rigid_body_sim.physics.contact.collision.aabb import extent
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    FACE_RADIUS,
    FACE_SQUARE,
    FEATURE,
    HELD_COUNT,
    HELD_KEY,
    MOST,
    NEITHER,
    NORMAL,
    POINT,
    POINTS,
    SEPARATION,
    SHAPE_A,
    copy_point,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces import surface_scratch
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    END,
    ROOT,
    corner_of,
    edge_side,
    lies_over,
    list_near,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.results import (
    SAME_NORMAL,
    add_contact,
    least_separation,
    reduce_to_four,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    ASKED,
    CONCAVE,
    EDGE_KIND,
    FACET,
    FACET_HIGH,
    FACET_LOW,
    FACET_OF,
    FLATNESS,
    IS_GRAPH,
    PLANES,
    TRIANGLE,
    TRIANGLES,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    BY_FACES,
    COUNT,
    HELD_ON_FACET,
    KEY,
    KEYS,
    LISTED,
    MOST_SLOTS,
    MOTION,
    NEAR,
    OVERLAP,
    OVERLAP_KEY,
    OVERLAP_NORMAL,
    OVERLAP_POINT,
    QUERY_HIGH,
    QUERY_LOW,
    REST,
    RESULT,
    RESULT_POINTS,
    RESULTS,
    RESULTS_USED,
    SLOT,
    SLOT_AREA,
    SLOT_COUNT,
    SLOT_FACET,
    SLOT_FROM,
    SLOT_MIDDLE,
    SLOT_NORMAL,
    SLOT_OVER,
    SLOT_POINTS,
    SLOT_RADIUS,
    SLOT_SQUARE,
    SLOT_TO,
    SLOTS,
    SLOTS_USED,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL as FACET_NORMAL
from rigid_body_sim.physics.contact.collision.shape_parameters import OFFSET
from rigid_body_sim.physics.vectors import add_scaled, dot, load, negate, store, subtract

Array = NDArray[np.float64]

FLUSH_HEIGHT = 1e-4  # [-] of half the diagonal of the AABB: what stands out by no more is flush
DEEP = 0.5  # [-] of the extent of the body over its middle
NO_SLOT = -1  # in place of the slot of a facet: it has none
LEVEL = 0.02  # [-] slope of a line over a plane, beyond which it stands on its end
SHORT = 1e-6  # [-] of a line: so little of it over a facet is nothing
DIAGONAL = 0.6  # [-] share of the next axis in the direction by which points are chosen: not along
#                 the side of any face

LINES = slot('[-] whether two points on a plane are the ends of a line: of cylinders')
find_reach = slot('kernel (parameters, shape, poses, pose): middle and half edges of its AABB')
collide_plane = slot('kernel (parameters, shape_a, shape_b, ...): the pair kernel with a plane')
collide_triangle = slot(
    'kernel (parameters, shape, poses, pose, surface, row, plane, margin, along, found): adds '
    'the contacts with a triangle'
)
find_axis = slot(
    'kernel (parameters, shape, poses, pose, surface, row, margin, found): the axis between body '
    'and one triangle'
)
ask_plane = slot('kernel (parameters, shape_a, surface, ...): gives a facet its slot')


@inline
def _bodys_diagonal(poses: Array, pose_a: int) -> Any:
    """Return a direction fixed in the body that lies across the sides of its faces."""
    first, second = pose.axis(poses, pose_a, 0), pose.axis(poses, pose_a, 1)
    third = pose.axis(poses, pose_a, 2)
    return add_scaled(add_scaled(first, DIAGONAL, second), DIAGONAL * DIAGONAL, third)


@kernel
def _slot_of(facet: float, found: Array) -> int:
    """Return where the slot of a facet begins; NO_SLOT: it has none, or none yet."""
    end = SLOTS + SLOT * int(found[SLOTS_USED])
    for at in range(SLOTS, end, SLOT):
        if found[at + SLOT_FACET] == facet:
            return at
    return NO_SLOT


@kernel
def _is_far(parameters: Array, plane: int, center: Any, half: Any, found: Array) -> bool:
    """Tell whether a body is too far from a plane; center, half : of its AABB [m]."""
    normal = load(parameters, plane + FACET_NORMAL)
    height = dot(normal, center) - parameters[plane + OFFSET]
    limit = found[NEAR] + max(-dot(normal, load(found, MOTION)), 0.0)
    return height - extent(half, normal) > limit


def _ask_plane(
    parameters, shape_a, surface, plane, facet, poses, pose_a, pose_b, center, found
):  # fmt: skip
    """
    Give a facet a slot, with the manifold of the body and its whole plane; none, if the body does
    not touch that. Return where it begins, or NO_SLOT.
    """
    normal = load(parameters, plane + FACET_NORMAL)
    height = dot(normal, center) - parameters[plane + OFFSET]
    limit = found[NEAR] + max(-dot(normal, load(found, MOTION)), 0.0)
    found[FACE_AREA] = 0.0
    found[HELD_COUNT] = found[HELD_ON_FACET] if found[HELD_KEY] == facet else 0.0
    count = collide_plane(parameters, shape_a, plane, poses, pose_a, pose_b, limit, found)
    found[HELD_COUNT] = 0.0
    if count > 0 and parameters[surface + IS_GRAPH] == 0.0:
        least = found[POINTS + SEPARATION]
        for index in range(1, count):
            least = min(least, found[POINTS + POINT * index + SEPARATION])
        if height < -DEEP * (height - least):
            count = 0
    if count == 0:
        return NO_SLOT
    at = SLOTS + SLOT * int(found[SLOTS_USED])
    found[SLOTS_USED] += 1.0
    found[at + SLOT_FACET], found[at + SLOT_COUNT], found[at + SLOT_OVER] = facet, count, 0.0
    found[at + SLOT_FROM], found[at + SLOT_TO] = 1.0, 0.0
    found[at + SLOT_AREA], found[at + SLOT_RADIUS] = found[FACE_AREA], found[FACE_RADIUS]
    found[at + SLOT_SQUARE] = found[FACE_SQUARE]
    store(found, at + SLOT_MIDDLE, load(found, FACE_MIDDLE))
    store(found, at + SLOT_NORMAL, normal)
    for index in range(count):
        copy_point(found, at + SLOT_POINTS + POINT * index, POINTS + POINT * index)
    return at


@kernel
def _note_points_over(at: int, parameters: Array, surface: int, row: int, found: Array) -> None:
    """
    Note which points of a slot lie over a triangle of its facet, or may be there within the tick.
    """
    over, normal = int(found[at + SLOT_OVER]), load(found, at + SLOT_NORMAL)
    seam, motion = parameters[surface + FLATNESS], load(found, MOTION)
    of_tick = found[NEAR] - found[REST] + seam
    soon = of_tick + max(-dot(normal, motion), 0.0)
    beyond = of_tick + math.sqrt(dot(motion, motion))
    for index in range(int(found[at + SLOT_COUNT])):
        if over >> index & 1:
            continue
        place = at + SLOT_POINTS + POINT * index
        separation = found[place + SEPARATION]
        reach = found[NEAR] if separation < 0.0 else beyond if separation <= soon else seam
        if lies_over(parameters, row, normal, load(found, place), -separation, seam, reach):
            over |= 1 << index
    found[at + SLOT_OVER] = over


@kernel
def _note_line_over(at: int, parameters: Array, surface: int, row: int, found: Array) -> None:
    """Note which part of a level line between the two points of a slot lies over a triangle."""
    normal, seam = load(found, at + SLOT_NORMAL), parameters[surface + FLATNESS]
    first, second = at + SLOT_POINTS, at + SLOT_POINTS + POINT
    start = load(found, first)
    way = subtract(load(found, second), start)
    slope = found[second + SEPARATION] - found[first + SEPARATION]
    if slope * slope > LEVEL * LEVEL * dot(way, way):
        return
    begin, end = 0.0, 1.0
    for edge in range(3):
        side = edge_side(parameters, row, edge, normal)
        free = found[NEAR] if parameters[row + EDGE_KIND + edge] == CONCAVE else seam
        out = dot(side, subtract(start, corner_of(parameters, row, edge)))
        out -= free * math.sqrt(dot(side, side))
        rate = dot(side, way)
        if rate > 0.0:
            end = min(end, -out / rate)
        elif rate < 0.0:
            begin = max(begin, -out / rate)
        elif out > 0.0:
            end = -1.0
    if end - begin > SHORT:
        found[at + SLOT_FROM] = min(found[at + SLOT_FROM], begin)
        found[at + SLOT_TO] = max(found[at + SLOT_TO], end)


@inline
def _has_line(at: int, found: Array) -> bool:
    """Tell whether some of a line between two points lies over the facet."""
    return found[at + SLOT_COUNT] == 2.0 and found[at + SLOT_TO] > found[at + SLOT_FROM]


@kernel
def _cut_line(at: int, found: Array) -> None:
    """Let the two points of a slot be the ends of what lies over the facet of the line."""
    begin, end = found[at + SLOT_FROM], found[at + SLOT_TO]
    over = int(found[at + SLOT_OVER])
    first, second = at + SLOT_POINTS, at + SLOT_POINTS + POINT
    start, stop = load(found, first), load(found, second)
    gap, change = found[first + SEPARATION], found[second + SEPARATION] - found[first + SEPARATION]
    way = subtract(stop, start)
    if not over & 1:
        store(found, first, add_scaled(start, begin, way))
        found[first + SEPARATION] = gap + begin * change
    if not over & 2:
        store(found, second, add_scaled(start, end, way))
        found[second + SEPARATION] = gap + end * change
    found[at + SLOT_OVER] = 3.0


@inline
def _is_done(at: int, found: Array) -> bool:
    """Tell whether all points of the body on a plane lie over the facet."""
    return int(found[at + SLOT_OVER]) == (1 << int(found[at + SLOT_COUNT])) - 1


@kernel
def _note_over(
    at: int, lines: bool, parameters: Array, surface: int, row: int, found: Array
) -> bool:  # fmt: skip
    """
    Note what of a slot lies over a triangle; tell whether there is something to keep of it.

    lines : whether two points are the ends of a line
    """
    if not _is_done(at, found):
        _note_points_over(at, parameters, surface, row, found)
        if lines and found[at + SLOT_COUNT] == 2.0:
            _note_line_over(at, parameters, surface, row, found)
    return found[at + SLOT_OVER] != 0.0 or _has_line(at, found)


@kernel
def _cut_lines(found: Array) -> None:
    """Cut off what lies beside their facets of the lines of all slots."""
    for at in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
        if _has_line(at, found) and not _is_done(at, found):
            _cut_line(at, found)


@kernel
def _carries(at: int, found: Array) -> bool:
    """Tell whether a facet carries the body: all points lie over it, and one touches."""
    least = math.inf
    for index in range(int(found[at + SLOT_COUNT])):
        least = min(least, found[at + SLOT_POINTS + POINT * index + SEPARATION])
    return least <= 0.0 and _is_done(at, found)


@kernel
def _is_covered(
    normal: Any, low: Any, middle: Any, high: Any, flush: float, parameters: Array, planes: int,
    found: Array,
) -> bool:  # fmt: skip
    """
    Tell whether something lies behind the plane of a facet that carries the body.

    normal            : of it; of the same normal both carry
    low, middle, high : points that bound it, in any order [m]
    flush             : [m] so far it may stand out
    """
    for at in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
        if not _carries(at, found):
            continue
        plane = planes + FACET * int(found[at + SLOT_FACET])
        up = load(parameters, plane + FACET_NORMAL)
        top = max(dot(up, low), dot(up, middle), dot(up, high))
        if dot(up, normal) < SAME_NORMAL and top <= parameters[plane + OFFSET] + flush:
            return True
    return False


@kernel
def _take_out_covered(flush: float, parameters: Array, planes: int, found: Array) -> None:
    """Take the points of facets out that lie behind one that carries the body."""
    for at in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
        plane = planes + FACET * int(found[at + SLOT_FACET])
        low, high = load(parameters, plane + FACET_LOW), load(parameters, plane + FACET_HIGH)
        normal = load(found, at + SLOT_NORMAL)
        for carrier in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
            up = load(found, carrier + SLOT_NORMAL)
            if dot(up, normal) >= SAME_NORMAL or not _carries(carrier, found):
                continue
            highest = (
                high[0] if up[0] > 0.0 else low[0],
                high[1] if up[1] > 0.0 else low[1],
                high[2] if up[2] > 0.0 else low[2],
            )
            ground = planes + FACET * int(found[carrier + SLOT_FACET])
            if dot(up, highest) <= parameters[ground + OFFSET] + flush:
                found[at + SLOT_COUNT] = found[at + SLOT_OVER] = 0.0


@kernel
def _write_face(result: int, place: int, found: Array, manifolds: Array) -> None:
    """Write the face of a manifold: that on the plane, where all of it is over the facet."""
    manifolds[place + manifold_record.FACE_AREA] = 0.0
    manifolds[place + manifold_record.RIM] = NEITHER
    at = _slot_of(found[result + KEY], found)
    if at != NO_SLOT and _is_done(at, found):
        manifolds[place + manifold_record.RIM] = SHAPE_A
        manifolds[place + manifold_record.FACE_AREA] = found[at + SLOT_AREA]
        manifolds[place + manifold_record.FACE_RADIUS] = found[at + SLOT_RADIUS]
        manifolds[place + manifold_record.FACE_SQUARE] = found[at + SLOT_SQUARE]
        store(manifolds, place + manifold_record.FACE_MIDDLE, load(found, at + SLOT_MIDDLE))


@kernel
def _take_points_over(along: Any, found: Array) -> None:
    """Add the points on planes that lie over their facets."""
    for at in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
        over = int(found[at + SLOT_OVER])
        for index in range(int(found[at + SLOT_COUNT])):
            if over >> index & 1:
                place = at + SLOT_POINTS + POINT * index
                normal = negate(load(found, at + SLOT_NORMAL))
                add_contact(
                    found[at + SLOT_FACET], normal, load(found, place), found[place + SEPARATION],
                    found[place + FEATURE], along, found,
                )  # fmt: skip


@kernel
def _hold_overlap(along: Any, found: Array) -> None:
    """
    Where a body overlaps the ground and no manifold touches, take the triangle along whose normal
    it overlaps least: deep in an edge no point is nearer to its own face than to the other one.
    """
    if found[OVERLAP] == -math.inf:
        return
    for at in range(RESULTS, RESULTS + RESULT * int(found[RESULTS_USED]), RESULT):
        if least_separation(at, found) <= 0.0:
            return
    add_contact(
        found[OVERLAP_KEY], load(found, OVERLAP_NORMAL), load(found, OVERLAP_POINT),
        found[OVERLAP], found[OVERLAP_POINT + FEATURE], along, found,
    )  # fmt: skip


@kernel
def _write_nearest(along: Any, found: Array) -> int:
    """Reduce all manifolds to four points, and write the nearest as the manifold of a pair."""
    used = int(found[RESULTS_USED])
    best, least = RESULTS, math.inf
    for at in range(RESULTS, RESULTS + RESULT * used, RESULT):
        reduce_to_four(at, along, found)
        separation = least_separation(at, found)
        if separation < least:
            best, least = at, separation
    if used == 0:
        return 0
    store(found, NORMAL, load(found, best + surface_scratch.NORMAL))
    count = int(found[best + COUNT])
    for index in range(count):
        copy_point(found, POINTS + POINT * index, best + RESULT_POINTS + POINT * index)
    return count


def _collide_on_surface(
    parameters, shape_a, shape_b, poses, pose_a, pose_b, margin, found
):  # fmt: skip
    """
    Find the manifolds of a body and a surface: all of them in RESULTS, the nearest as that of the
    pair. MOTION holds what the body moves in the tick [m]; it is part of the margin.

    While one triangle is ASKED, that is the surface: a convex one, seen from all sides, of which
    the axis from the body to it is found, and no points.
    """
    row = int(parameters[shape_b + ASKED])
    if row > 0:
        return find_axis(parameters, shape_a, poses, pose_a, shape_b, row, margin, found)
    motion, along = load(found, MOTION), _bodys_diagonal(poses, pose_a)
    found[HELD_ON_FACET], found[HELD_COUNT] = found[HELD_COUNT], 0.0
    found[NEAR] = margin - math.sqrt(dot(motion, motion))
    center, half = find_reach(parameters, shape_a, poses, pose_a)
    for axis in range(3):
        low, high = center[axis] - half[axis], center[axis] + half[axis]
        found[QUERY_LOW + axis] = low - found[NEAR] + min(motion[axis], 0.0)
        found[QUERY_HIGH + axis] = high + found[NEAR] + max(motion[axis], 0.0)
    found[SLOTS_USED] = found[RESULTS_USED] = 0.0
    found[OVERLAP], found[BY_FACES] = -math.inf, 1.0
    planes = shape_b + int(parameters[shape_b + PLANES])
    triangles = shape_b + int(parameters[shape_b + TRIANGLES])
    asked, node = False, ROOT
    while node != END:
        listed, node = list_near(parameters, shape_b, node, found)
        for entry in range(LISTED, LISTED + listed):
            row = int(found[entry])
            facet = parameters[row + FACET_OF]
            plane = planes + FACET * int(facet)
            if _is_far(parameters, plane, center, half, found):
                continue
            at = _slot_of(facet, found)
            if at == NO_SLOT:
                if found[SLOTS_USED] == MOST_SLOTS:
                    asked = True
                    continue
                at = ask_plane(
                    parameters, shape_a, shape_b, plane, facet, poses, pose_a, pose_b, center,
                    found,
                )  # fmt: skip
            if at == NO_SLOT:
                continue
            if not _note_over(at, LINES, parameters, shape_b, row, found):
                found[SLOTS_USED] -= 1.0
                asked = True
    if LINES:
        _cut_lines(found)
    flush = FLUSH_HEIGHT * math.sqrt(dot(half, half))
    _take_out_covered(flush, parameters, planes, found)
    for at in range(SLOTS, SLOTS + SLOT * int(found[SLOTS_USED]), SLOT):
        asked = asked or not _is_done(at, found)
    _take_points_over(along, found)
    node = ROOT if asked else END
    while node != END:
        listed, node = list_near(parameters, shape_b, node, found)
        for entry in range(LISTED, LISTED + listed):
            row = int(found[entry])
            plane = planes + FACET * int(parameters[row + FACET_OF])
            at = _slot_of(parameters[row + FACET_OF], found)
            if at == NO_SLOT:
                asked = not _is_far(parameters, plane, center, half, found)
            else:
                asked = not _is_done(at, found)
            if asked and not _is_covered(
                load(parameters, plane + FACET_NORMAL), corner_of(parameters, row, 0),
                corner_of(parameters, row, 1), corner_of(parameters, row, 2), flush, parameters,
                planes, found,
            ):  # fmt: skip
                number = float((row - triangles) // TRIANGLE)
                collide_triangle(
                    parameters, shape_a, poses, pose_a, shape_b, row, plane, number, margin, along,
                    found,
                )  # fmt: skip
    _hold_overlap(along, found)
    return _write_nearest(along, found)


def surface_collider(
    name: str, *, find_reach: Callable[..., Any], collide_plane: Callable[..., Any],
    collide_triangle: Callable[..., Any], find_axis: Callable[..., Any], lines: bool = False,
) -> Callable[..., Any]:  # fmt: skip
    """
    Make the pair kernel of a type of shape and ground.

        name             : of the type
        lines            : whether two points on a plane are the ends of a line on which it lies
        find_reach       : kernel (parameters, shape, poses, pose): middle and half edges of the
                           AABB, world [m]
        collide_plane    : pair kernel of the type and a plane
        collide_triangle : kernel (parameters, shape, poses, pose, surface, row, plane, number,
                           margin, along, found): adds the contacts with a triangle
        find_axis        : kernel (parameters, shape, poses, pose, surface, row, margin, found):
                           writes the normal of least distance to a triangle; 0: beyond the margin
    """
    ask = specialise(_ask_plane, name=name, collide_plane=collide_plane)
    return specialise(
        _collide_on_surface, name=name, find_reach=find_reach, ask_plane=ask,
        collide_triangle=collide_triangle, find_axis=find_axis, LINES=lines,
    )  # fmt: skip


@kernel
def write_far_contact(margin: float, found: Array) -> int:
    """
    Write one manifold that never presses, for what hits the ground later in the tick and is near
    nothing yet: it asks for the pieces of the tick. Return the number of its points.
    """
    found[RESULTS_USED] = 1.0
    found[RESULTS + KEY], found[RESULTS + COUNT] = 0.0, 1.0
    store(found, RESULTS + surface_scratch.NORMAL, (0.0, 0.0, -1.0))
    write_point_at(found, RESULTS + RESULT_POINTS, (0.0, 0.0, 0.0), margin, 0.0)
    return 1


@kernel
def write_manifolds(
    pair_id: int, a: int, b: int, pieces: int, length: int, room: int, found: Array,
    manifolds: Array,
) -> int:  # fmt: skip
    """
    Write all manifolds of a pair in the order of their keys; return how many there are then.

        pieces       : into which the tick should be cut, see `manifold_record.PIECES`
        length, room : manifolds that are there, and for how many there is room
    """
    before = -1.0
    for _ in range(int(found[RESULTS_USED])):
        best, least = RESULTS, math.inf
        for at in range(RESULTS, RESULTS + RESULT * int(found[RESULTS_USED]), RESULT):
            if before < found[at + KEY] < least:
                best, least = at, found[at + KEY]
        before = least
        if length < room:
            place = length * manifold_record.SIZE
            count = min(int(found[best + COUNT]), MOST)
            manifolds[place + manifold_record.PAIR_ID] = pair_id + least / KEYS
            manifolds[place + manifold_record.COLLIDER_A] = float(a)
            manifolds[place + manifold_record.COLLIDER_B] = float(b)
            manifolds[place + manifold_record.POINT_COUNT] = float(count)
            _write_face(best, place, found, manifolds)
            manifolds[place + manifold_record.PIECES] = float(pieces)
            manifolds[place + manifold_record.RECYCLED] = -1.0
            store(
                manifolds, place + manifold_record.NORMAL,
                load(found, best + surface_scratch.NORMAL),
            )  # fmt: skip
            for entry in range(POINT * count):
                manifolds[place + manifold_record.POINTS + entry] = found[
                    best + RESULT_POINTS + entry
                ]
        length += 1
    return length
