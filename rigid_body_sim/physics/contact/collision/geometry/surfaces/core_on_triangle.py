# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A ball or a capsule on a triangle of a surface: where the surface is nearest to its core.

The core is a point or a segment; the body touches where its distance from the surface has a local
minimum less than its radius. Such a place lies

    inside a triangle   the direction to the core is the normal
    on a convex edge    it lies between the normals of the two triangles
    on a vertex         no neighbour of the vertex lies higher along it

Anything else is a place beside which the surface is nearer still: no edge between two triangles of
one plane, and none in a valley, is ever touched. Of a segment that lies over a triangle both ends
of that part count.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.line_angles import NO_COMMON_NORMAL
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    SHORTEST,
    write_normal,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.near_triangles import (
    corner_of,
    edge_side,
    lies_over,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.results import add_contact
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_records import (
    BEYOND,
    BORDER,
    CONVEX,
    EDGE_KIND,
    FLATNESS,
    NORMAL,
    OWNS_EDGE,
    OWNS_VERTEX,
    RING,
)
from rigid_body_sim.physics.contact.collision.shape_parameters import NORMAL as FACET_NORMAL
from rigid_body_sim.physics.contact.collision.shape_parameters import OFFSET
from rigid_body_sim.physics.vectors import (
    add_scaled,
    divide,
    dot,
    load,
    negate,
    scale,
    subtract,
)

Array = NDArray[np.float64]

WITHIN = 1e-12  # [-] of an edge: an end that round-off puts beyond
OF_EDGES, OF_VERTICES = 0.125, 0.5  # of the keys of what a triangle owns: below 1
CONE_ROUND_OFF = 1e-9  # [-] sine by which a direction may miss a cone of normals


@inline
def _is_below(normal: Any, point: Any, origin: Any) -> bool:
    """Tell whether a point does not lie above another along a normal."""
    way = subtract(point, origin)
    height = dot(normal, way)
    return height <= 0.0 or height * height <= CONE_ROUND_OFF * CONE_ROUND_OFF * dot(way, way)


@kernel
def core_on_triangle(
    start: Any, end: Any, radius: float, parameters: Array, surface: int, row: int, plane: int,
    key: float, edge_key: float, least_height: float, found: Array,
) -> None:  # fmt: skip
    """
    Add the contacts of a core with a triangle.

    start, end   : [m] of the core, world; the same for a ball
    row, plane   : where the triangle and the plane of its facet begin
    key          : of what touches its face;   edge_key : of what touches an edge or a vertex
    least_height : [m] of the core over the face: what is deeper is behind the surface
    """
    core = subtract(end, start)
    _on_face(
        start, core, radius, parameters, row, plane, parameters[surface + FLATNESS], key,
        least_height, found,
    )  # fmt: skip
    for edge in range(3):
        kind = parameters[row + EDGE_KIND + edge]
        if parameters[row + OWNS_EDGE + edge] != 0.0 and (kind == CONVEX or kind == BORDER):
            own_key = edge_key + OF_EDGES * edge
            _on_edge(start, core, radius, parameters, row, edge, own_key, found)
    for index in range(3):
        if parameters[row + OWNS_VERTEX + index] != 0.0:
            own_key = edge_key + OF_VERTICES + OF_EDGES * index
            _on_vertex(start, core, radius, parameters, surface, row, index, own_key, found)


@kernel
def _on_face(
    start: Any, core: Any, radius: float, parameters: Array, row: int, plane: int, seam: float,
    key: float, least_height: float, found: Array,
) -> None:  # fmt: skip
    """Add the ends of the part of the core that lies over the face."""
    normal, offset = load(parameters, plane + FACET_NORMAL), parameters[plane + OFFSET]
    begin, stop = 0.0, 1.0
    for edge in range(3):
        side = edge_side(parameters, row, edge, normal)
        away = dot(side, subtract(corner_of(parameters, row, edge), start))
        room = away + seam * math.sqrt(dot(side, side))
        rate = dot(side, core)
        if rate > 0.0:
            stop = min(stop, room / rate)
        elif rate < 0.0:
            begin = max(begin, room / rate)
        elif room < 0.0:
            return
    if not begin <= stop:
        return
    for share in (begin, stop):
        point = add_scaled(start, share, core)
        height = dot(normal, point) - offset
        if height < least_height:
            continue
        position = add_scaled(point, -0.5 * (height + radius), normal)
        add_contact(key, negate(normal), position, height - radius, share, core, found)


@kernel
def _on_edge(
    start: Any, core: Any, radius: float, parameters: Array, row: int, edge: int, key: float,
    found: Array,
) -> None:  # fmt: skip
    """
    Add the contacts with an edge where the core is nearest to a place within it: one, or both ends
    of what lies along it.
    """
    origin = corner_of(parameters, row, edge)
    along = subtract(corner_of(parameters, row, edge + 1 if edge < 2 else 0), origin)
    squared, run, both = dot(core, core), dot(along, along), dot(core, along)
    way = subtract(origin, start)
    det = squared * run - both * both
    if squared > 0.0 and not det > NO_COMMON_NORMAL * squared * run:
        for end in (0.0, 1.0):
            share = (dot(core, way) + end * both) / squared
            _at_share(
                start, core, min(max(share, 0.0), 1.0), radius, parameters, row, edge, key, found
            )
        return
    share = 0.0
    if squared > 0.0:
        share = min(max((dot(core, way) * run - dot(along, way) * both) / det, 0.0), 1.0)
        place = dot(along, subtract(add_scaled(start, share, core), origin)) / run
        nearest = add_scaled(origin, min(max(place, 0.0), 1.0), along)
        share = min(max(dot(core, subtract(nearest, start)) / squared, 0.0), 1.0)
    _at_share(start, core, share, radius, parameters, row, edge, key, found)


@kernel
def _at_share(
    start: Any, core: Any, share: float, radius: float, parameters: Array, row: int, edge: int,
    key: float, found: Array,
) -> None:  # fmt: skip
    """Add the contact of a point of the core with an edge, if that is what the surface has."""
    origin = corner_of(parameters, row, edge)
    along = subtract(corner_of(parameters, row, edge + 1 if edge < 2 else 0), origin)
    third = corner_of(parameters, row, edge + 2 if edge < 1 else edge - 1)
    place = dot(along, subtract(add_scaled(start, share, core), origin)) / dot(along, along)
    if not (place > -WITHIN and place < 1.0 + WITHIN):
        return
    on_edge, on_core = add_scaled(origin, place, along), add_scaled(start, share, core)
    away = subtract(on_core, on_edge)
    distance = math.sqrt(dot(away, away))
    if not distance > SHORTEST:
        return
    normal = divide(away, distance)
    if parameters[row + EDGE_KIND + edge] == BORDER:
        if dot(normal, load(parameters, row + NORMAL)) < 0.0:
            return
    elif not _is_below(normal, load(parameters, row + BEYOND + 3 * edge), on_edge):
        return
    if _is_below(normal, third, on_edge):
        position = add_scaled(on_edge, 0.5 * (distance - radius), normal)
        add_contact(key, negate(normal), position, distance - radius, share, core, found)


@kernel
def _on_vertex(
    start: Any, core: Any, radius: float, parameters: Array, surface: int, row: int, index: int,
    key: float, found: Array,
) -> None:  # fmt: skip
    """Add the contact with a vertex, if no neighbour lies higher along its direction."""
    vertex = corner_of(parameters, row, index)
    squared = dot(core, core)
    share = 0.0
    if squared > 0.0:
        share = min(max(dot(core, subtract(vertex, start)) / squared, 0.0), 1.0)
    away = subtract(add_scaled(start, share, core), vertex)
    distance = math.sqrt(dot(away, away))
    if not distance > SHORTEST:
        return
    normal = scale(1.0 / distance, away)
    if is_summit(normal, parameters, surface, row, index, CONE_ROUND_OFF):
        position = add_scaled(vertex, 0.5 * (distance - radius), normal)
        add_contact(key, negate(normal), position, distance - radius, share, core, found)


@kernel
def _nearer(
    start: Any, core: Any, share: float, origin: Any, along: Any, place: float, least: float,
    found: Array,
) -> float:  # fmt: skip
    """Take the way from a point of the core to one of an edge, if it is the shortest so far."""
    way = subtract(add_scaled(origin, place, along), add_scaled(start, share, core))
    distance = math.sqrt(dot(way, way))
    if distance < least and distance > SHORTEST:
        write_normal(found, divide(way, distance))
        return distance
    return least


@kernel
def axis_to_core(
    start: Any, end: Any, radius: float, parameters: Array, row: int, margin: float, found: Array
) -> int:
    """
    Write the normal from a core to a triangle along their least distance; that of the face where
    they touch. Return 0 where that, less the radius, is beyond the margin.
    """
    core, normal = subtract(end, start), load(parameters, row + NORMAL)
    origin = corner_of(parameters, row, 0)
    low, high = dot(normal, subtract(start, origin)), dot(normal, subtract(end, origin))
    write_normal(found, negate(normal))
    if low * high < 0.0:
        through = add_scaled(start, low / (low - high), core)
        if lies_over(parameters, row, normal, through, 0.0, 0.0, 0.0):
            return 1
    least = math.inf
    for height, point in ((low, start), (high, end)):
        if abs(height) < least and lies_over(parameters, row, normal, point, 0.0, 0.0, 0.0):
            least = abs(height)
            write_normal(found, scale(-1.0 if height >= 0.0 else 1.0, normal))
    squared = dot(core, core)
    for edge in range(3):
        origin = corner_of(parameters, row, edge)
        along = subtract(corner_of(parameters, row, edge + 1 if edge < 2 else 0), origin)
        run, both, way = dot(along, along), dot(core, along), subtract(origin, start)
        det = squared * run - both * both
        share = 0.0
        if det > NO_COMMON_NORMAL * squared * run:
            share = min(max((dot(core, way) * run - dot(along, way) * both) / det, 0.0), 1.0)
        place = dot(along, subtract(add_scaled(start, share, core), origin)) / run
        place = min(max(place, 0.0), 1.0)
        if squared > 0.0:
            nearest = subtract(add_scaled(origin, place, along), start)
            share = min(max(dot(core, nearest) / squared, 0.0), 1.0)
        least = _nearer(start, core, share, origin, along, place, least, found)
    return 1 if least - radius <= margin else 0


@kernel
def is_summit(
    normal: Any, parameters: Array, surface: int, row: int, index: int, slack: float
) -> bool:
    """
    Tell whether a corner of a triangle is the highest of its neighbourhood along a normal, seen
    from outside.

    slack : [-] sine by which a neighbour may lie higher
    """
    if not dot(normal, load(parameters, row + NORMAL)) > -slack:
        before = parameters[row + EDGE_KIND + (index - 1 if index > 0 else 2)]
        if before != CONVEX or parameters[row + EDGE_KIND + index] != CONVEX:
            return False
    vertex = corner_of(parameters, row, index)
    ring = surface + int(parameters[row + RING + index])
    for neighbour in range(int(parameters[ring])):
        way = subtract(load(parameters, ring + 1 + 3 * neighbour), vertex)
        height = dot(normal, way)
        if height > 0.0 and height * height > slack * slack * dot(way, way):
            return False
    return True
