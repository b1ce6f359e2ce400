# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The manifolds of a body on a surface, while they are collected.

All points of one facet are one manifold, whatever triangles they came from; its key is the number
of the facet, so that the solver knows it again when the body has slid to other triangles. What
touches elsewhere, at an edge or a vertex, is joined where the normal is the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    POINT,
    POINTS,
    SEPARATION,
    copy_point,
    write_normal,
    write_point_at,
)
from rigid_body_sim.physics.contact.collision.geometry.polyhedra.extreme_points import (
    keep_extremes,
)
from rigid_body_sim.physics.contact.collision.geometry.surfaces.surface_scratch import (
    COUNT,
    FREE,
    KEY,
    MOST_POINTS,
    MOST_RESULTS,
    MOTION,
    NEAR,
    NORMAL,
    RESULT,
    RESULT_POINTS,
    RESULTS,
    RESULTS_USED,
)
from rigid_body_sim.physics.vectors import dot, load, store, subtract

Array = NDArray[np.float64]

SAME_NORMAL = 1.0 - 5e-7  # [-] cosine: normals within 1e-3 rad are of one manifold
SAME_PLACE = 1e-6  # [-] of the separation that counts as near: points nearer are one


@inline
def limit_along(normal: Any, found: Array) -> float:
    """Return the separation [m] that counts as near along a normal from the body to the ground."""
    return found[NEAR] + max(dot(normal, load(found, MOTION)), 0.0)


@kernel
def least_separation(at: int, found: Array) -> float:
    """Return the least separation [m] of a manifold."""
    least = found[at + RESULT_POINTS + SEPARATION]
    for index in range(1, int(found[at + COUNT])):
        least = min(least, found[at + RESULT_POINTS + POINT * index + SEPARATION])
    return least


@kernel
def _place_for(key: float, normal: Any, separation: float, found: Array) -> int:
    """Return where the manifold of a contact begins, maybe a new one; -1: there is no room."""
    used = int(found[RESULTS_USED])
    for at in range(RESULTS, RESULTS + RESULT * used, RESULT):
        if found[at + KEY] == key:
            return at
        is_free = key >= FREE and found[at + KEY] >= FREE
        if is_free and dot(normal, load(found, at + NORMAL)) > SAME_NORMAL:
            return at
    at = RESULTS + RESULT * used
    if used == MOST_RESULTS:
        at, most = -1, separation
        for one in range(RESULTS, RESULTS + RESULT * used, RESULT):
            least = least_separation(one, found)
            if least > most:
                at, most = one, least
        if at < 0:
            return at
    else:
        found[RESULTS_USED] = used + 1
    found[at + KEY] = key
    found[at + COUNT] = 0.0
    store(found, at + NORMAL, normal)
    return at


@kernel
def add_contact(
    key: float, normal: Any, position: Any, separation: float, feature: float, along: Any,
    found: Array,
) -> None:  # fmt: skip
    """
    Add a contact to the manifolds, if it is near enough.

    key    : of its manifold
    normal : from the body to the ground
    along  : a direction fixed in the body, by which points are chosen where there are many
    """
    if not separation <= limit_along(normal, found):
        return
    at = _place_for(key, normal, separation, found)
    if at < 0:
        return
    count = int(found[at + COUNT])
    close = SAME_PLACE * found[NEAR] * (SAME_PLACE * found[NEAR])
    for index in range(count):
        place = at + RESULT_POINTS + POINT * index
        way = subtract(position, load(found, place))
        if dot(way, way) <= close:
            if separation < found[place + SEPARATION]:
                found[place + SEPARATION] = separation
            return
    if count == MOST_POINTS:
        count = reduce_to_four(at, along, found)
    place = at + RESULT_POINTS + POINT * count
    write_point_at(found, place, position, separation, feature)
    found[at + COUNT] = count + 1


@kernel
def reduce_to_four(at: int, along: Any, found: Array) -> int:
    """Keep up to four points of a manifold; return how many are left."""
    count = int(found[at + COUNT])
    if count > manifold.MOST:
        write_normal(found, load(found, at + NORMAL))
        count = keep_extremes(found, at + RESULT_POINTS, count, along)
        for index in range(count):
            copy_point(found, at + RESULT_POINTS + POINT * index, POINTS + POINT * index)
        found[at + COUNT] = count
    return count
