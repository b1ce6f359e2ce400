# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The face in which two shapes touch: how large it is, where its middle is, and how far its points
are from there in the mean.

A manifold keeps at most four points of it. What acts on all of the face, as friction does, is that
of the polygon from which they were chosen: its area A, its middle c, the mean of |r - c|^2, and
the mean distance

    rho = 1/A integral |r - c| dA

which is the torque of a uniform friction about the middle over its force. In the triangle of an
edge and the middle |r| grows along each ray, so that only the edge is left:

    integral |r| dA = 1/3 sum over edges p q of |p x q| integral_0^1 |p + s (q - p)| ds
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision.geometry.manifold import (
    FACE_AREA,
    FACE_MIDDLE,
    FACE_RADIUS,
    FACE_SQUARE,
)
from rigid_body_sim.physics.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    load,
    scale,
    store,
    subtract,
)

Array = NDArray[np.float64]

# Gauss and Legendre with four points on (0, 1): |r| along an edge to 1e-4
NEAR, FAR = 0.5 - 0.5 * 0.3399810435848563, 0.5 - 0.5 * 0.8611363115940526
NEAR_WEIGHT, FAR_WEIGHT = 0.5 * 0.6521451548625461, 0.5 * 0.3478548451374538


@inline
def _mean_length(p: Any, q: Any) -> float:
    """Mean of |r| along an edge."""
    way = subtract(q, p)
    near, far = add_scaled(p, NEAR, way), add_scaled(p, FAR, way)
    near_end, far_end = add_scaled(q, -NEAR, way), add_scaled(q, -FAR, way)
    return NEAR_WEIGHT * (math.sqrt(dot(near, near)) + math.sqrt(dot(near_end, near_end))) + (
        FAR_WEIGHT * (math.sqrt(dot(far, far)) + math.sqrt(dot(far_end, far_end)))
    )


@kernel
def measure_face(found: Array, first: int, stride: int, count: int) -> None:
    """
    Measure a convex polygon of corners in order, either way round, in one plane or nearly so.

        first, stride : where the corners begin in `found`, and how far they are apart
    """
    found[FACE_AREA] = 0.0
    if count < 3:
        return
    origin = load(found, first)
    last = first + stride * (count - 1)
    twice = (0.0, 0.0, 0.0)
    for place in range(first, last, stride):
        p, q = load(found, place), load(found, place + stride)
        twice = add(twice, cross(subtract(p, origin), subtract(q, origin)))
    doubled = math.sqrt(dot(twice, twice))
    if not doubled > 0.0:
        return
    normal = scale(1.0 / doubled, twice)
    middle = origin
    for place in range(first, last, stride):
        p, q = subtract(load(found, place), origin), subtract(load(found, place + stride), origin)
        share = dot(normal, cross(p, q)) / (3.0 * doubled)
        middle = add_scaled(middle, share, add(p, q))
    total, square = 0.0, 0.0
    p = subtract(load(found, last), middle)
    for place in range(first, last + stride, stride):
        q = subtract(load(found, place), middle)
        spanned = abs(dot(normal, cross(p, q)))
        total += spanned * _mean_length(p, q)
        square += spanned * (dot(p, p) + dot(p, q) + dot(q, q))
        p = q
    found[FACE_AREA] = 0.5 * doubled
    found[FACE_RADIUS] = 2.0 * total / (3.0 * doubled)
    found[FACE_SQUARE] = square / (6.0 * doubled)
    store(found, FACE_MIDDLE, middle)


@inline
def write_disc(found: Array, radius: float, middle: Any) -> None:
    """Write the end of a cylinder."""
    found[FACE_AREA] = math.pi * radius * radius
    found[FACE_RADIUS] = 2.0 / 3.0 * radius
    found[FACE_SQUARE] = 0.5 * radius * radius
    store(found, FACE_MIDDLE, middle)
