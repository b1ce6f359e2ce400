# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The principal axes of a symmetric tensor, by one rule that gives the same bits everywhere.

    I = V diag(moments) V^T
        moments : (3,) [kg m^2]
        V       : (3, 3) [-]  columns are the axes in the given axes; det V = +1

1. Diagonal: where no element off the diagonal exceeds ROUND_OFF of the trace, V = 1 and the
   moments are the diagonal, bit for bit.
2. All moments equal to within EQUAL of the largest: the same, for every direction will do.
3. Two moments equal: V is the shortest turn that brings one of the given axes onto the axis of
   symmetry, the axis nearest to it (of two as near, the earlier one); the two moments become
   their mean.
4. Else V is, of the 24 ways to number and direct the three axes, the one nearest to 1, with the
   largest sum of |V_ii| (of several, the first order of columns) and V_ii > 0: a small tilt of
   the body is a small turn of its axes.

Axes come from rotations of Jacobi, in cyclic order, of numbers divided by a power of two: nothing
but + - * / and sqrt, which IEEE 754 makes equal on every machine, where LAPACK returns for equal
moments whatever its build finds first.

Source: Golub & Van Loan, Matrix Computations, 4th ed., section 8.5.2.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rigid_body_sim.physics.errors import InvalidModel

Array = NDArray[np.float64]
Rows = list[list[float]]

EPS = float(np.finfo(np.float64).eps)
ROUND_OFF = 32 * EPS  # [-] of the trace: products of inertia below this are what rounding left
# [-] of the largest moment. Turning a tensor leaves a few eps; larger, and a body that is not
# symmetric would be given axes that are wrong by as much.
EQUAL = 64 * EPS
TIE = 1e-9  # [-] components of unit vectors nearer than this are the same: the first one counts
SETTLED = 1e-25  # [-] of the largest element: what is left off the diagonal adds nothing
SWEEPS = 60  # [-] at most; five or six are usual, each squares what is left


def principal_axes(inertia: ArrayLike) -> tuple[Array, Array]:
    """
    Return the principal moments (3,) and the principal axes V (3, 3): see the module.

    inertia : (3, 3) [kg m^2]  symmetric, any axes; InvalidModel where it is not finite
    """
    inertia = np.asarray(inertia, dtype=np.float64)
    if not np.all(np.isfinite(inertia)):
        raise InvalidModel('the inertia tensor holds NaN or infinity [kg m^2]')
    given = inertia.tolist()
    if is_diagonal(given):
        return np.diag(inertia).copy(), np.eye(3)
    moments, axes = _jacobi(given)
    low, middle, high = sorted(range(3), key=lambda k: moments[k])
    equal = EQUAL * max(abs(moments[low]), abs(moments[high]))
    if moments[high] - moments[low] <= equal:
        return np.diag(inertia).copy(), np.eye(3)
    gap_below, gap_above = moments[middle] - moments[low], moments[high] - moments[middle]
    if min(gap_below, gap_above) <= equal:
        odd = high if gap_below <= gap_above else low
        pair = 0.5 * (moments[middle] + moments[low if odd == high else high])
        return _about(axes[odd], odd=moments[odd], pair=pair)
    return _nearest(moments, axes)


def moments_of(given: Rows) -> list[float]:
    """Return the eigenvalues of a symmetric tensor given as rows, smallest first."""
    if is_diagonal(given):
        return sorted(given[i][i] for i in range(3))
    return sorted(_jacobi(given)[0])


def is_diagonal(given: Rows) -> bool:
    """Tell whether a tensor is diagonal in its axes, but for round-off: rule 1 of the module."""
    off = max(abs(given[0][1]), abs(given[0][2]), abs(given[1][2]))
    return off <= ROUND_OFF * (abs(given[0][0]) + abs(given[1][1]) + abs(given[2][2]))


def _jacobi(given: Rows) -> tuple[list[float], Rows]:
    """Give the moments, in no order, and the unit vectors that go with them, as rows."""
    exponent = math.frexp(max(abs(x) for row in given for x in row))[1]
    a = [[math.ldexp(x, -exponent) for x in row] for row in given]
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for _ in range(SWEEPS):
        if max(abs(a[0][1]), abs(a[0][2]), abs(a[1][2])) <= SETTLED:
            break
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            if a[p][q] != 0.0:
                _rotate(a, axes, p, q, r)
    return [math.ldexp(a[i][i], exponent) for i in range(3)], axes


def _rotate(a: Rows, axes: Rows, p: int, q: int, r: int) -> None:
    """Turn the axes p and q so far that a[p][q] vanishes; r is the third."""
    tangent, cosine, sine = rotation_that_annuls(a[p][p], a[q][q], a[p][q])
    a[p][p] -= tangent * a[p][q]
    a[q][q] += tangent * a[p][q]
    a[p][q] = a[q][p] = 0.0
    of_p, of_q = a[r][p], a[r][q]
    a[r][p] = a[p][r] = cosine * of_p - sine * of_q
    a[r][q] = a[q][r] = sine * of_p + cosine * of_q
    for k in range(3):
        of_p, of_q = axes[p][k], axes[q][k]
        axes[p][k] = cosine * of_p - sine * of_q
        axes[q][k] = sine * of_p + cosine * of_q


def rotation_that_annuls(pp: float, qq: float, pq: float) -> tuple[float, float, float]:
    """
    Return tangent, cosine and sine of the smaller turn that annuls the element pq.

    t^2 + 2 theta t - 1 = 0,   theta = (a_qq - a_pp) / (2 a_pq)
    """
    theta = (qq - pp) / (2.0 * pq)
    if abs(theta) > 1e150:  # its square overflows, and 1 is nothing beside it
        tangent = 0.5 / theta
    else:
        tangent = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
    cosine = 1.0 / math.sqrt(tangent * tangent + 1.0)
    return tangent, cosine, tangent * cosine


def spread_axes(points: Array) -> Array:
    """
    Return the directions (columns) along which points (n, 3) spread, about their mean at zero.

    One-sided rotations of Jacobi: of the points, not of the sums of their squares, so that the
    directions across a needle are found as well as its own. The given axes where the points are
    balanced about them already.
    """
    columns = [points[:, k].copy() for k in range(3)]
    axes = [np.eye(3)[k] for k in range(3)]
    for _ in range(SWEEPS):
        settled = True
        for p, q in ((0, 1), (0, 2), (1, 2)):
            pp, qq, pq = (
                float(np.sum(columns[a] * columns[b])) for a, b in ((p, p), (q, q), (p, q))
            )
            if abs(pq) <= ROUND_OFF * math.sqrt(pp) * math.sqrt(qq):
                continue
            settled = False
            _, cosine, sine = rotation_that_annuls(pp, qq, pq)
            for of in (columns, axes):
                of[p], of[q] = cosine * of[p] - sine * of[q], sine * of[p] + cosine * of[q]
        if settled:
            break
    return np.array(axes).T


def _about(axis: Sequence[float], *, odd: float, pair: float) -> tuple[Array, Array]:
    """
    Give the axes of a body with an axis of symmetry n.

    V = 1 + [v]x + [v]x [v]x / (1 + c),   v = e_k x n,   c = n_k > 0
    """
    largest = max(abs(component) for component in axis)
    k = next(i for i in range(3) if abs(axis[i]) >= largest - TIE)
    n = [math.copysign(1.0, axis[k]) * component for component in axis]
    i, j = (k + 1) % 3, (k + 2) % 3
    share = 1.0 / (1.0 + n[k])
    turn = np.zeros((3, 3))
    turn[:, k] = n
    turn[i, i], turn[j, j] = 1.0 - share * n[i] * n[i], 1.0 - share * n[j] * n[j]
    turn[i, j] = turn[j, i] = -share * n[i] * n[j]
    turn[k, i], turn[k, j] = -n[i], -n[j]
    moments = np.full(3, pair)
    moments[k] = odd
    return moments, turn


def _nearest(moments: Sequence[float], axes: Rows) -> tuple[Array, Array]:
    """Number and direct the axes by rule 4."""
    orders = list(itertools.permutations(range(3)))
    sums = [abs(axes[a][0]) + abs(axes[b][1]) + abs(axes[c][2]) for a, b, c in orders]
    best = max(sums)
    order = next(o for o, total in zip(orders, sums, strict=True) if total >= best - TIE)
    turn = np.array([axes[row] for row in order]).T
    # det = +1 then: an improper matrix has a trace of at most 1, the best order of columns more
    return (
        np.array([moments[row] for row in order]),
        turn * np.where(np.diag(turn) < 0.0, -1.0, 1.0),
    )
