# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The uniform pressure on a face, as the points of its manifold carry it.

Points r_i of a face of area A and middle c carry the pressure p of all of it by

    N_i = p A u_i,   u_i = (1 + b . (r_i - m)) / n,   sum u_i = 1,   sum u_i r_i = c

m: mean of the points, b: from the last equation; where a point would pull, the other three. The
torque of a uniform friction about c over its force is tau_0 = rho, the mean distance of the face
from c (`geometry.touching_face`), so that in the terms of `patch_friction`

    k = rho^2 / (C(q) tr Sigma) = 1/3 + (k_face - 1/3) q,   Sigma of the u_i
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.contact.collision import manifold_record
from rigid_body_sim.physics.contact.collision.geometry import manifold
from rigid_body_sim.physics.contact.solver import patch_friction
from rigid_body_sim.physics.vectors import dot, load, subtract

Array = NDArray[np.float64]

TRIANGLE = 0.25  # [-] k of a triangle
SLENDER = 0.02  # [-] q of points that are as good as a line
LARGEST = 1.0  # [-] k_face at most


@inline
def way(origin: int, record: int, index: int, manifolds: Array) -> Any:
    """Return the way from a place of the array to a point of a manifold."""
    at = record + manifold_record.POINTS + index * manifold.POINT
    return subtract(load(manifolds, at), load(manifolds, origin))


@inline
def place(record: int, index: int, origin: Any, tangents: Any, manifolds: Array) -> Any:
    """Return where a point of a manifold is from an origin, along two tangents."""
    at = record + manifold_record.POINTS + index * manifold.POINT
    arm = subtract(load(manifolds, at), origin)
    return dot(arm, tangents[0]), dot(arm, tangents[1])


@kernel
def _tilt(record: int, tangents: Any, used: int, manifolds: Array) -> Any:
    """
    Return how the weights of a face that was measured go with the place from its middle: constant
    and slopes; used: bit i: point i has one.
    """
    middle = load(manifolds, record + manifold_record.FACE_MIDDLE)
    count, mean_1, mean_2 = 0.0, 0.0, 0.0
    s_11, s_12, s_22 = 0.0, 0.0, 0.0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        if used >> index & 1:
            x, y = place(record, index, middle, tangents, manifolds)
            count += 1.0
            mean_1 += x
            mean_2 += y
            s_11 += x * x
            s_12 += x * y
            s_22 += y * y
    mean_1, mean_2 = mean_1 / count, mean_2 / count
    s_11 = s_11 / count - mean_1 * mean_1
    s_12 = s_12 / count - mean_1 * mean_2
    s_22 = s_22 / count - mean_2 * mean_2
    determinant = s_11 * s_22 - s_12 * s_12
    if patch_friction.flatness(s_11 + s_22, determinant) < SLENDER:
        return 1.0 / count, 0.0, 0.0
    slope_1 = -(s_22 * mean_1 - s_12 * mean_2) / determinant
    slope_2 = -(s_11 * mean_2 - s_12 * mean_1) / determinant
    constant = 1.0 - slope_1 * mean_1 - slope_2 * mean_2
    return constant / count, slope_1 / count, slope_2 / count


@inline
def _least(record: int, tangents: Any, used: int, tilt: Any, manifolds: Array) -> Any:
    """Return the least weight, and of which point."""
    middle = load(manifolds, record + manifold_record.FACE_MIDDLE)
    least, which = 0.0, 0
    for index in range(int(manifolds[record + manifold_record.POINT_COUNT])):
        if used >> index & 1:
            x, y = place(record, index, middle, tangents, manifolds)
            share = tilt[0] + tilt[1] * x + tilt[2] * y
            if share < least:
                least, which = share, index
    return least, which


@kernel
def weights(record: int, tangents: Any, manifolds: Array) -> Any:
    """
    Return the four weights u of the points of a face; tangents: two.

    A point that would pull has none; of a face that was not measured all are alike.
    """
    count = int(manifolds[record + manifold_record.POINT_COUNT])
    if not (count > 2 and manifolds[record + manifold_record.FACE_AREA] > 0.0):
        alike = 1.0 / count
        return (
            alike, alike if count > 1 else 0.0, alike if count > 2 else 0.0,
            alike if count > 3 else 0.0,
        )  # fmt: skip
    used = (1 << count) - 1
    tilt = _tilt(record, tangents, used, manifolds)
    least, which = _least(record, tangents, used, tilt, manifolds)
    if least < 0.0 and count == manifold.MOST:
        used -= 1 << which
        tilt = _tilt(record, tangents, used, manifolds)
    return (
        _weight(record, 0, tangents, used, tilt, manifolds),
        _weight(record, 1, tangents, used, tilt, manifolds),
        _weight(record, 2, tangents, used, tilt, manifolds),
        _weight(record, 3, tangents, used, tilt, manifolds),
    )


@inline
def _weight(
    record: int, index: int, tangents: Any, used: int, tilt: Any, manifolds: Array
) -> float:
    """Return the weight of a point, not below 0."""
    if not used >> index & 1:
        return 0.0
    middle = load(manifolds, record + manifold_record.FACE_MIDDLE)
    x, y = place(record, index, middle, tangents, manifolds)
    share = tilt[0] + tilt[1] * x + tilt[2] * y
    return share if share > 0.0 else 0.0


@inline
def share_of_unmeasured(count: int) -> Any:
    """Return k_face of a manifold of so many points whose face was not measured."""
    return TRIANGLE if count == 3 else patch_friction.LINE


@kernel
def uniform_share(record: int, shares: Any, tangents: Any, manifolds: Array) -> Any:
    """Return k_face of a manifold from the weights of its points; tangents: two."""
    count = int(manifolds[record + manifold_record.POINT_COUNT])
    if count < 3 or not manifolds[record + manifold_record.FACE_AREA] > 0.0:
        return share_of_unmeasured(count)
    middle = load(manifolds, record + manifold_record.FACE_MIDDLE)
    total, c_1, c_2, s_11, s_12, s_22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for index in range(count):
        x, y = place(record, index, middle, tangents, manifolds)
        share = shares[index]
        total += share
        c_1 += share * x
        c_2 += share * y
        s_11 += share * x * x
        s_12 += share * x * y
        s_22 += share * y * y
    c_1, c_2 = c_1 / total, c_2 / total
    s_11 = s_11 / total - c_1 * c_1
    s_12 = s_12 / total - c_1 * c_2
    s_22 = s_22 / total - c_2 * c_2
    trace = s_11 + s_22
    if not trace > 0.0:  # the points of a sliver may be one
        return patch_friction.LINE
    q = patch_friction.flatness(trace, s_11 * s_22 - s_12 * s_12)
    radius = manifolds[record + manifold_record.FACE_RADIUS]
    return of_face(radius * radius / (patch_friction.shape_factor(q) * trace), q)


@inline
def mean_square(record: int, trace: float, manifolds: Array) -> Any:
    """Return the trace of the second moment of a face; trace: that of its points."""
    if manifolds[record + manifold_record.FACE_AREA] > 0.0:
        return manifolds[record + manifold_record.FACE_SQUARE]
    is_triangle = manifolds[record + manifold_record.POINT_COUNT] == 3.0
    return (TRIANGLE if is_triangle else patch_friction.LINE) * trace


@inline
def of_face(k: float, q: float) -> Any:
    """Return k_face of k."""
    if q < SLENDER:
        return patch_friction.LINE
    return min(max(patch_friction.LINE + (k - patch_friction.LINE) / q, 0.0), LARGEST)
