# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The series by which the discrete Moser–Veselov top follows the true one: coefficients per body.

    j_k = s / I_k + d                       modified inverse moments [1/(kg m^2)]
    s = 1 + s3 + s5 + s7 + s9,   d = d3 + d5 + d7 + d9
    s_n, d_n : homogeneous of degree (n - 1) / 2 in A and H
        A = h^2 |m|^2 / 2   [(kg m^2)^2]    H = h^2 T   [kg m^2]

Order 2 takes s = 1, d = 0; order 4 the terms of index 3; 6 to 5; 8 to 7; 10 to 9.

        D = I1 I2 I3,   S_n = sum I_i^n,   X_n = sum I_i^-n
        C_pq = sum over (a, b, c) cyclic of (a^p + b^p) / c^q

Source: McLachlan & Zanna, Found. Comput. Math. 5 (2005); Hairer & Vilmart, J. Phys. A 39 (2006)
13225, whose closed forms these are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.model.plain_products import power
from rigid_body_sim.physics.state.blocks import LANES

Array = NDArray[np.float64]
Terms = tuple[list[Array], list[Array]]

ORDERS = (2, 4, 6, 8, 10)

# rows of a series in the block of a drift, as far as its order goes: the coefficient of A, of H …
terms = Record(stride=LANES)
A = terms.number('(kg m^2)^-2', '')
H = terms.number('(kg m^2)^-1', '')
AA = terms.number('(kg m^2)^-4', '')
AH = terms.number('(kg m^2)^-3', '')
HH = terms.number('(kg m^2)^-2', '')
AAA = terms.number('(kg m^2)^-6', '')
AAH = terms.number('(kg m^2)^-5', '')
AHH = terms.number('(kg m^2)^-4', '')
HHH = terms.number('(kg m^2)^-3', '')
AAAA = terms.number('(kg m^2)^-8', '')
AAAH = terms.number('(kg m^2)^-7', '')
AAHH = terms.number('(kg m^2)^-6', '')
AHHH = terms.number('(kg m^2)^-5', '')
HHHH = terms.number('(kg m^2)^-4', '')


def series_rows(order: int) -> int:
    """Count the coefficients of s, and those of d, up to an order."""
    return sum(range(2, order // 2 + 1))


@np.errstate(all='ignore')  # absurd moments: the run diverges by name
def series(moments: Array, order: int) -> Array:
    """
    Coefficients of s and d, for each body.

        moments : (n, 3) [kg m^2]
        returns : (n, 2 series_rows): s of A, H; A^2, A H, H^2; A^3, A^2 H, …; then d of the same
    """
    # in units of a power of two near the middle moment: the same bits, and no overflow of D^4
    exponent = np.frexp(np.sort(moments, axis=1)[:, 1])[1]  # the middle one
    sums = _sums(*np.ldexp(moments, -exponent[:, None]).T)
    of_s, of_d = [], []
    for degree, coefficients in enumerate(_DEGREES[: order // 2 - 1], start=1):
        s, d = coefficients(sums)
        for place, (one, other) in enumerate(zip(s, d)):
            power = 2 * degree - place  # of the unit: A^(degree - place) H^place
            of_s.append(np.ldexp(one, -exponent * power))
            of_d.append(np.ldexp(other, -exponent * (power + 1)))
    return np.array(of_s + of_d, dtype=np.float64).reshape(2 * series_rows(order), len(moments)).T


class _Sums(NamedTuple):
    """
    What the coefficients are made of: D = `product`, S_n = s1 …, X_n = x1 …, C_pq = q11 ….
    """

    product: Array
    s1: Array
    s2: Array
    s3: Array
    s4: Array
    x1: Array
    x2: Array
    x3: Array
    x4: Array
    q11: Array
    q12: Array
    q13: Array
    q21: Array
    q31: Array
    q22: Array


def _sums(i1: Array, i2: Array, i3: Array) -> _Sums:
    def cyclic(p: int, q: int) -> Array:
        of_p, of_q = [[power(x, n) for x in (i1, i2, i3)] for n in (p, q)]
        (p1, p2, p3), (q1, q2, q3) = of_p, of_q
        return (p1 + p2) / q3 + (p2 + p3) / q1 + (p3 + p1) / q2

    s1 = i1 + i2 + i3
    x1 = 1 / i1 + 1 / i2 + 1 / i3
    return _Sums(
        product=i1 * i2 * i3,
        s1=s1,
        s2=i1 * i1 + i2 * i2 + i3 * i3,
        s3=power(i1, 3) + power(i2, 3) + power(i3, 3),
        s4=power(i1, 4) + power(i2, 4) + power(i3, 4),
        x1=x1,
        x2=1 / (i1 * i1) + 1 / (i2 * i2) + 1 / (i3 * i3),
        x3=1 / power(i1, 3) + 1 / power(i2, 3) + 1 / power(i3, 3),
        x4=1 / power(i1, 4) + 1 / power(i2, 4) + 1 / power(i3, 4),
        q11=s1 * x1 - 3,
        q12=cyclic(1, 2),
        q13=cyclic(1, 3),
        q21=cyclic(2, 1),
        q31=cyclic(3, 1),
        q22=cyclic(2, 2),
    )


def _third(of: _Sums) -> Terms:
    """Give the coefficients of s3 and d3, of A and H."""
    product = of.product
    s1 = of.s1
    x1 = of.x1
    return (
        [s1 / (6 * product), -x1 / 3],
        [-1 / (3 * product), s1 / (6 * product)],
    )


def _fifth(of: _Sums) -> Terms:
    """Give the coefficients of s5 and d5, of A^2, A H, H^2."""
    product = of.product
    s1, s2 = of.s1, of.s2
    x1, x2 = of.x1, of.x2
    q11 = of.q11
    return (
        [
            (s2 - product * x1) / (30 * product**2),
            (1 - q11) / (30 * product),
            (3 * s1 + 2 * product * x2) / (60 * product),
        ],
        [
            -s1 / (60 * product**2),
            (6 * product * x1 - s2) / (60 * product**2),
            -(9 + q11) / (60 * product),
        ],
    )


def _seventh(of: _Sums) -> Terms:
    """Give the coefficients of s7 and d7, of A^3, A^2 H, A H^2, H^3."""
    product = of.product
    s1, s2, s3 = of.s1, of.s2, of.s3
    x1, x2, x3 = of.x1, of.x2, of.x3
    q11, q12, q21 = of.q11, of.q12, of.q21
    return (
        [
            (17 * s3 - 15 * product * q11 + 4 * product) / (2520 * power(product, 3)),
            (9 * s1 + 10 * product * x2 - 6 * q21) / (420 * product**2),
            (53 * s2 - 100 * product * x1 + 6 * product * q12) / (2520 * product**2),
            (15 - product * x3 - 2 * q11) / (630 * product),
        ],
        [
            (34 * product * x1 - 19 * s2) / (2520 * power(product, 3)),
            (s3 + 2 * product * q11 - 85 * product) / (1260 * power(product, 3)),
            (47 * s1 + 13 * q21 - 38 * product * x2) / (2520 * product**2),
            (9 * product * x1 + product * q12 - 11 * s2) / (1260 * product**2),
        ],
    )


def _ninth(of: _Sums) -> Terms:
    """Give the coefficients of s9 and d9, of A^4, A^3 H, A^2 H^2, A H^3, H^4."""
    product = of.product
    s1, s2, s3, s4 = of.s1, of.s2, of.s3, of.s4
    x1, x2, x3, x4 = of.x1, of.x2, of.x3, of.x4
    q11, q12, q13, q21, q31, q22 = of.q11, of.q12, of.q13, of.q21, of.q31, of.q22
    return (
        [
            (62 * s4 - 94 * product * q21 + 66 * product**2 * x2 + 81 * product * s1)
            / (45360 * power(product, 4)),
            (-77 * q31 + 75 * product * q12 + 214 * s2 - 240 * product * x1)
            / (22680 * power(product, 3)),
            (
                26 * product * q22
                + 55 * s3
                + 204 * product
                - 50 * product**2 * x3
                - 59 * product * q11
            )
            / (7560 * power(product, 3)),
            (137 * product * x2 - product * q13 + 3 * s1 - 69 * q21) / (11340 * product**2),
            (2 * product**2 * x4 + 5 * product * q12 - 171 * product * x1 + 159 * s2)
            / (45360 * product**2),
        ],
        [
            (60 * product * q11 - 61 * s3 - 247 * product) / (45360 * power(product, 4)),
            (54 * product * s1 - s4 + 218 * product * q21 - 426 * product**2 * x2)
            / (45360 * power(product, 4)),
            (125 * product * x1 - 5 * q31 - 130 * s2 + 4 * product * q12)
            / (7560 * power(product, 3)),
            (
                67 * s3
                - 735 * product
                - 15 * product * q22
                + 87 * product * q11
                + 34 * product**2 * x3
            )
            / (22680 * power(product, 3)),
            (165 * s1 - product * q13 - 9 * q21 - 145 * product * x2) / (45360 * product**2),
        ],
    )


_DEGREES = (_third, _fifth, _seventh, _ninth)
