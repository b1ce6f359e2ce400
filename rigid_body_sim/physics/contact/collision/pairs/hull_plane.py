# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A convex hull on a plane: s = m . x - offset for each vertex x, m the normal out of the plane, s
the separation.

Of more than four vertices within the margin the manifold holds those that come down first: with
the displacement and the turn of the tick (free motion), a vertex reaches

    e = min(s, s'),   s' the separation after them

Those with an e up to SKIN of the size above the least count, and above the plane, or else the four
of the least e: of a face that is still apart no four on one side, by rounding. Of more than four
the manifold holds those of the last tick, or else those that lie farthest along four directions
fixed in the hull, and those of the least e, as in `extreme_points`, but from the vertices where
they stand: a mesh may have thousands below the margin. Where all four lie on one side, one of them
gives way to one across, if a blow could bring that down in this tick: not of what stands. As
there, of those of the last tick one gives way only to what is DEEPER than all of them, or is
needed beyond the side that bears the load (`loaded_side`).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import pose
from rigid_body_sim.physics.contact.collision.geometry.loaded_side import (
    NONE,
    TIPS,
    bear,
    gives_way,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    HELD,
    HELD_COUNT,
    LEAD,
    MOST,
    SCRATCH,
    SHIFT,
    TIE,
    TURN,
    write_normal,
    write_point,
)
from rigid_body_sim.physics.contact.collision.geometry.manifold_reduction import DEEPER
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import BESIDE
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.face_clipping import facing
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.hull_records import (
    CENTER,
    CLIP,
    COUNT,
    RADIUS,
    VERTICES,
    Hull,
    loop_of,
    vertex,
)
from rigid_body_sim.physics.contact.collision.geometry.touching_face import measure_face
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL, OFFSET
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

scratch = Record(begin=SCRATCH)
CHOSEN = scratch.numbers(MOST, '-', 'where the chosen vertices begin among the shape parameters')
FACE = scratch.numbers(3 * CLIP, 'm', 'corners of the face on the plane, axes of the hull')

VERTEX = 3  # numbers of a vertex
SKIN = 1e-3  # [-] of the size: what a vertex may be above the plane that touches in this tick
THROWN = 2.0  # times the way of the fastest vertex: so far a blow may throw another (1.6 on a rim)
SKEW = 0.6  # [-] of one axis to the other: along an axis two corners of a box are as far


@kernel
def collide(
    parameters: Array, shape_a: int, shape_b: int, poses: Array, pose_a: int, pose_b: int,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Find up to four vertices of a hull above a plane, or in it."""
    out = load(parameters, shape_b + NORMAL)
    return on_plane(
        parameters, shape_a, poses, pose_a, out, parameters[shape_b + OFFSET], margin, found
    )


@kernel
def on_plane(
    parameters: Array, shape: int, poses: Array, place: int, out: Any, offset: float,
    margin: float, found: Array,
) -> int:  # fmt: skip
    """Do so on the plane out . x = offset, out its unit normal in world axes."""
    center = load(parameters, shape + CENTER)
    up = 0.0, 0.0, 0.0  # m in the axes of the hull
    height = -offset
    for row in range(3):
        component = out[row]
        height += component * poses[place + row]
        axes = load(poses, place + pose.ROW_X + (pose.ROW_Y - pose.ROW_X) * row)
        up = add_scaled(up, component, axes)
    height += dot(up, center)
    radius = parameters[shape + RADIUS]
    if not height - radius <= margin:
        return 0
    first = shape + VERTICES
    last = first + VERTEX * int(parameters[shape + COUNT])
    after = _after_the_tick(out, height, up, center, poses, place, found)
    count = choose(parameters, first, last, (height, up), after, margin, radius, found)
    write_normal(found, negate(out))
    origin = load(poses, place)
    for index in range(count):
        at = int(found[CHOSEN + index])
        vertex = load(parameters, at)
        separation = height + dot(up, vertex)
        position = add(origin, pose.to_world(poses, place, add(vertex, center)))
        position = subtract(position, scale(0.5 * separation, out))
        write_point(found, index, position, separation, float(at - first))
    if count > 2:
        _measure_face(parameters, shape, height, up, margin, found)
        if found[FACE_AREA] > 0.0:
            middle = pose.to_world(poses, place, add(load(found, FACE_MIDDLE), center))
            store(found, FACE_MIDDLE, add(origin, middle))
    return count


@kernel
def _measure_face(
    parameters: Array, shape: int, height: float, up: Any, margin: float, found: Array
) -> None:
    """Measure the face that looks at the plane, as far as it is within the margin."""
    hull = Hull(parameters, shape)
    loop = loop_of(hull, facing(hull, negate(up)))
    corners = 0
    for index in range(int(parameters[loop])):
        corner = vertex(hull, int(parameters[loop + 1 + index]))
        if height + dot(up, corner) <= margin:
            store(found, FACE + VERTEX * corners, corner)
            corners += 1
    measure_face(found, FACE, VERTEX, corners)


@inline
def _first_direction(up: Any) -> Any:
    """
    Return a direction across the normal: two axes of the hull, skewed; the one that leans most is
    left out.
    """
    x, y, z = abs(up[0]), abs(up[1]), abs(up[2])
    if x > y and x > z:
        return 0.0, SKEW, 1.0
    if y > z:
        return SKEW, 0.0, 1.0
    return 1.0, SKEW, 0.0


@inline
def _after_the_tick(
    out: Any, height: float, up: Any, center: Any, poses: Array, place: int, found: Array
) -> Any:  # fmt: skip
    """
    Return height and m in the axes of the hull after the displacement and the turn of the tick.

    The hull turns by theta, so m in its axes by -theta: Cayley's form of that, exact to theta^3,
    is a rotation for every theta.
    """
    turn = pose.to_shape(poses, place, load(found, TURN))
    half = scale(-0.5, turn)
    share = 2.0 / (1.0 + dot(half, half))
    across = cross(half, up)
    after = add_scaled(up, share, add(across, cross(half, across)))
    of_center = dot(subtract(after, up), center)
    return height + dot(out, load(found, SHIFT)) + of_center, after


@inline
def _lowest(parameters: Array, place: int, now: Any, after: Any) -> Any:
    """Return the separation of a vertex now, and the least one of the tick."""
    vertex = load(parameters, place)
    separation = now[0] + dot(now[1], vertex)
    return separation, min(separation, after[0] + dot(after[1], vertex))


@kernel
def _next_lowest(
    parameters: Array, first: int, last: int, now: Any, after: Any, margin: float, kept: int,
    found: Array,
) -> Any:  # fmt: skip
    """Return the lowest vertex that is not among those kept, and its separation."""
    best, least = -1, math.inf
    for place in range(first, last, VERTEX):
        separation, low = _lowest(parameters, place, now, after)
        fresh = separation <= margin and low < least
        for index in range(kept):
            fresh = fresh and found[CHOSEN + index] != place
        if fresh:
            best, least = place, low
    return best, least


@kernel
def _choose_extremes(
    parameters: Array, first: int, last: int, now: Any, after: Any, margin: float, limit: float,
    radius: float, found: Array,
) -> float:  # fmt: skip
    """
    Choose the vertices that lie farthest along four directions, and the lowest in what places are
    left; return the least height of one of them [m].
    """
    direction = _first_direction(now[1])
    kept, shallow = 0, math.inf
    for _ in range(MOST):
        best, top, height_of_best = -1, -math.inf, math.inf
        for place in range(first, last, VERTEX):
            separation, low = _lowest(parameters, place, now, after)
            if separation <= margin and low <= limit:
                reach = dot(direction, load(parameters, place))
                if reach > top + LEAD * radius:
                    best, top, height_of_best = place, reach, low
        fresh = True
        for index in range(kept):
            fresh = fresh and found[CHOSEN + index] != best
        if fresh:
            found[CHOSEN + kept] = best
            kept += 1
            shallow = min(shallow, height_of_best)
        direction = cross(now[1], direction)
    for free in range(kept, MOST):
        best, height_of_best = _next_lowest(
            parameters, first, last, now, after, margin, free, found
        )
        found[CHOSEN + free] = best
        shallow = min(shallow, height_of_best)
    return shallow


@kernel
def choose(
    parameters: Array, first: int, last: int, now: Any, after: Any, margin: float, radius: float,
    found: Array,
) -> int:  # fmt: skip
    """
    List up to four vertices whose separation is within the margin; return their number.

        first, last : where the vertices begin, and where they end
        now, after  : height and m at the start of the tick and at its end: s = height + m . x
    """
    count, least, deepest, way = 0, math.inf, 0, 0.0
    second, third, fourth = math.inf, math.inf, math.inf
    for place in range(first, last, VERTEX):
        separation, low = _lowest(parameters, place, now, after)
        if separation <= margin:
            if count < MOST:
                found[CHOSEN + count] = place
            count += 1
            way = max(way, separation - low)
            fourth = min(fourth, max(third, low))
            third = min(third, max(second, low))
            second = min(second, max(least, low))
            if low < least:
                least, deepest = low, place
    if count <= MOST:
        return count
    limit = max(fourth, max(least, 0.0) + SKIN * radius)
    shallow = _held(parameters, first, last, now, after, margin, limit, TIPS * radius, found)
    deeper = TIE if shallow == math.inf else DEEPER
    if shallow == math.inf:
        shallow = _choose_extremes(
            parameters, first, last, now, after, margin, limit, radius, found
        )
    if least < shallow - deeper * radius:
        found[CHOSEN + _neighbour(parameters, deepest, now, after, found)] = deepest
    if way > SKIN * radius or not bear(found):
        reach = min(THROWN * way + SKIN * radius, margin)
        _keep_across(parameters, first, last, now, after, deepest, reach, found)
    return MOST


@inline
def _keep_across(
    parameters: Array, first: int, last: int, now: Any, after: Any, deepest: int, reach: float,
    found: Array,
) -> None:  # fmt: skip
    """
    Let the highest of the four give way to the lowest vertex across from the deepest, if it is
    within reach and all four lie on one side: what strikes there throws down the other side.
    """
    toward = load(parameters, deepest)
    toward = add_scaled(toward, -dot(now[1], toward), now[1])
    for index in range(MOST):
        if dot(toward, load(parameters, int(found[CHOSEN + index]))) < 0.0:
            return
    best, least = -1, reach
    for place in range(first, last, VERTEX):
        if dot(toward, load(parameters, place)) < 0.0:
            separation, _ = _lowest(parameters, place, now, after)
            if separation < least:
                best, least = place, separation
    if best < 0:
        return
    gives_way, highest = -1, -math.inf
    for index in range(MOST):
        chosen = int(found[CHOSEN + index])
        _, low = _lowest(parameters, chosen, now, after)
        if chosen != deepest and low > highest:
            gives_way, highest = index, low
    found[CHOSEN + gives_way] = best


@inline
def _held(
    parameters: Array, first: int, last: int, now: Any, after: Any, margin: float, limit: float,
    tips: float, found: Array,
) -> float:  # fmt: skip
    """
    Choose the four vertices of the last tick, if all of them are low, and what takes the place of
    one that bears no load (`loaded_side`), if it is deeper by `tips`; return the least height of
    one of them [m], infinity if they are not.
    """
    count, least = int(found[HELD_COUNT]), math.inf
    for index in range(count):
        place = first + int(found[HELD + index])
        if not first <= place < last:
            return math.inf
        separation, low = _lowest(parameters, place, now, after)
        if not (separation <= margin and low <= limit):
            return math.inf
        found[CHOSEN + index] = place
        least = min(least, low)
    if count != MOST:
        return math.inf
    a, b = int(found[CHOSEN]), int(found[CHOSEN + 1])
    c, d = int(found[CHOSEN + 2]), int(found[CHOSEN + 3])
    index, out, height, lead = gives_way(found, parameters, a, b, c, d, now[1])
    if index == NONE:
        return least
    deep = least - tips
    for place in range(first, last, VERTEX):
        beyond = dot(out, load(parameters, place))
        separation, low = _lowest(parameters, place, now, after)
        if beyond > height + lead and separation <= margin and low < deep:
            found[CHOSEN + index], height = place, beyond
            least = min(least, low)
    return least


@inline
def _neighbour(parameters: Array, deepest: int, now: Any, after: Any, found: Array) -> int:
    """Return which of the four gives way to a vertex: of its neighbours the highest."""
    nearest = math.inf
    origin = load(parameters, deepest)
    for index in range(MOST):
        away = subtract(load(parameters, int(found[CHOSEN + index])), origin)
        nearest = min(nearest, dot(away, away))
    best, highest = 0, -math.inf
    for index in range(MOST):
        chosen = int(found[CHOSEN + index])
        away = subtract(load(parameters, chosen), origin)
        _, low = _lowest(parameters, chosen, now, after)
        if dot(away, away) <= BESIDE * nearest and low > highest:
            best, highest = index, low
    return best
