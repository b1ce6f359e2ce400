# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Jacobi's elliptic functions sn, cn, dn of real argument, for kernels: Bulirsch's form of the
arithmetic-geometric mean.

The means depend on the modulus alone and are made once; each argument then costs one sine, one
cosine and a few divisions. The complementary modulus k' is given, so that a modulus near one keeps
its digits.

Source: Bulirsch, Numer. Math. 7 (1965); DLMF 22.20.
"""

from __future__ import annotations

import math

from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.state.blocks import LANES

PAIR = 2 * LANES  # numbers from a row of means to the next: a, then b
PAIRS = 10  # of means at most: nine from k' = SEPARATRIX
MEET = 1e-8  # [-] relative distance of the means at which to stop; the error is its square
SEPARATRIX = 1e-12  # [-] k' below which sn = tanh, cn = dn = 1/cosh: an error of k'^2 exp(2 u)
FARTHEST = 350.0  # [-] argument of cosh; its square stays finite


@kernel
def means(k_c, pairs, k):
    """
    Make the means for a complementary modulus and keep them in rows from `pairs[k]` on.

        returns : (count of pairs, 0 near the separatrix; their limit)
    """
    if k_c < SEPARATRIX:
        return 0, 1.0
    a = 1.0
    b = k_c
    count = 0
    while True:
        pairs[k + PAIR * count] = a
        pairs[k + PAIR * count + LANES] = b
        count += 1
        limit = 0.5 * (a + b)
        if not abs(a - b) > MEET * a or count == PAIRS:
            return count, limit
        b = math.sqrt(a * b)
        a = limit


@kernel
def jacobi(u, count, limit, pairs, k):
    """Give sn u, cn u, dn u from the means."""
    if count == 0:
        u = min(max(u, -FARTHEST), FARTHEST)
        over = 1.0 / math.cosh(u)
        return math.tanh(u), over, over
    sine = math.sin(limit * u)
    cosine = math.cos(limit * u)
    if abs(sine) < 1e-100:  # its inverse squared would overflow
        return sine / limit, cosine, 1.0
    a = cosine / sine
    c = limit * a
    d = 1.0
    for j in range(count - 1, -1, -1):
        mean = pairs[k + PAIR * j]
        a = c * a
        c = d * c
        d = (pairs[k + PAIR * j + LANES] + a) / (mean + a)
        a = c / mean
    sn = math.copysign(1.0 / math.sqrt(c * c + 1.0), sine)
    return sn, c * sn, d


@inline
def of_sum(first, second, k2):
    """Give sn, cn, dn of a sum of two arguments from those of each; k2 = k^2."""
    s0, c0, d0 = first
    s, c, d = second
    over = 1.0 / (c0 * c0 + s0 * s0 * d * d)  # 1 - k^2 s0^2 s^2, free of cancellation
    return (
        (s0 * c * d + s * c0 * d0) * over,
        (c0 * c - s0 * s * d0 * d) * over,
        (d0 * d - k2 * s0 * s * c0 * c) * over,
    )
