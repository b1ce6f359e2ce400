# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Reference solutions by Taylor series in decimal arithmetic, independent of the closed forms.

Flows with a right-hand side of degree two at most,
    y_i' = sum over terms (i, c, j, k) of c y_j y_k     (index 0 stands for the constant 1),
have the Taylor coefficients
    Y_i[n+1] = 1/(n+1) sum c sum_s Y_j[s] Y_k[n-s].
Rotations, tops, oscillators, drag and rockets are all of this kind. Truncation below 1e-20.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from operator import mul

import numpy as np

from rigid_body_sim.exact.motion import Array

DIGITS = 34
ORDER = 30

Number = float | Decimal
Term = tuple[int, Number, int, int]
ExactTerm = tuple[int, Decimal, int, int]


def solution(
    terms: Sequence[Term], start: Sequence[Number], times: Sequence[float], *, step: float
) -> Array:
    """
    State at the given ascending times, rounded to double precision.

    terms : (i, c, j, k) with 1 <= i <= len(start)
    start : y_1, y_2, … at time 0; floats are taken at their exact value
    step  : longest step; (step times the fastest rate) below 0.5 keeps ORDER terms exact to 1e-20
    """
    with localcontext() as context:
        context.prec = DIGITS
        exact_terms = [(i, Decimal(c), j, k) for i, c, j, k in terms]
        y, now, rows = [Decimal(1), *map(Decimal, start)], Decimal(0), []
        for time in map(Decimal, times):
            count = int((time - now) / Decimal(step)) + 1
            h = (time - now) / count
            for _ in range(count):
                y = _advance(exact_terms, y, h)
            now = time
            rows.append([float(value) for value in y[1:]])
    return np.array(rows)


def _advance(terms: Sequence[ExactTerm], y: list[Decimal], h: Decimal) -> list[Decimal]:
    series = [[value] for value in y]
    pairs = {(j, k) for _, _, j, k in terms if j}
    for n in range(ORDER):
        products = {
            (j, k): sum(map(mul, series[j], reversed(series[k])), Decimal(0))
            for j, k in pairs
            if k
        }
        rates = [Decimal(0)] * len(y)
        for i, c, j, k in terms:
            if j and k:
                rates[i] += c * products[j, k]
            elif j or n == 0:
                rates[i] += c * series[j][n]
        for coefficients, rate in zip(series, rates, strict=True):
            coefficients.append(rate / (n + 1))
    return [_horner(coefficients, h) for coefficients in series]


def _horner(coefficients: list[Decimal], h: Decimal) -> Decimal:
    value = Decimal(0)
    for coefficient in reversed(coefficients):
        value = value * h + coefficient
    return value


def rotation_terms(w: int, q: int) -> list[Term]:
    """Terms of q' = q (w, 0)/2: body rates in y[w:w+3], quaternion xyzw in y[q:q+4]."""
    half = Decimal('0.5')
    x, y, z, s = q, q + 1, q + 2, q + 3
    a, b, c = w, w + 1, w + 2
    return [
        *((x, half, s, a), (x, half, y, c), (x, -half, z, b)),
        *((y, half, s, b), (y, half, z, a), (y, -half, x, c)),
        *((z, half, s, c), (z, half, x, b), (z, -half, y, a)),
        *((s, -half, x, a), (s, -half, y, b), (s, -half, z, c)),
    ]


def euler_terms(inertia: Sequence[float]) -> list[Term]:
    """Terms of I_1 w_1' = (I_2 - I_3) w_2 w_3 and cyclic, rates in y[1:4]."""
    with localcontext() as context:
        context.prec = DIGITS
        moments = [Decimal(float(moment)) for moment in inertia]
        return [
            (1 + i, (moments[(i + 1) % 3] - moments[(i + 2) % 3]) / moments[i],
             1 + (i + 1) % 3, 1 + (i + 2) % 3)
            for i in range(3)
        ]  # fmt: skip
