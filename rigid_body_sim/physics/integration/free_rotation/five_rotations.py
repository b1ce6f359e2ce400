# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation split into rotations about the principal axes: explicit, symplectic, of any even
order by composition.

The kinetic energy is a sum of three parts, T = sum m_i^2 / (2 I_i), m = R^T L. Each part alone
turns the body about one axis at a constant rate, R_i(t): by theta = t m_i / I_i,

    q <- q (e_i sin theta/2, cos theta/2)
    (m_j, m_k) <- (m_j cos theta + m_k sin theta, m_k cos theta - m_j sin theta)     i, j, k cyclic

    S(h) = R_1(h/2) R_2(h/2) R_3(h) R_2(h/2) R_1(h/2)         order 2, symmetric
    S(g_1 h) S(g_2 h) … S(g_9 h)                              order 6, weights of Kahan & Li

L is not touched and so kept to the last bit; the energy error is bounded. Sine and cosine are
rational and lie on the unit circle to rounding: the angle theta is right to 4e-17 at 0.5 rad,
1e-13 at 1, 2e-10 at 2, 2e-8 at 3, and beyond that the map is still a rotation. A thin rod has a
rate theta about its axis that m hardly determines: h |omega| <= 0.5 there.

Sources: McLachlan, Phys. Rev. Lett. 71 (1993); Reich, Physica D 76 (1994); Dullweber, Leimkuhler &
McLachlan, J. Chem. Phys. 107 (1997); Kahan & Li, Math. Comp. 66 (1997).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rigid_body_sim.physics.compile.kernels import inline, kernel, slot, specialise
from rigid_body_sim.physics.state.blocks import (
    J1,
    J2,
    J3,
    LX,
    LY,
    LZ,
    QW,
    QX,
    QY,
    QZ,
    ROTATION,
    TX,
    TY,
    TZ,
    rotate,
    wide,
)

# [-] shares of the step, sum 1: order six in nine symmetric stages
KAHAN_LI_6 = (
    0.39216144400731413928,
    0.33259913678935943860,
    -0.70624617255763935981,
    0.08221359629355080023,
    0.79854399093482996340,
    0.08221359629355080023,
    -0.70624617255763935981,
    0.33259913678935943860,
    0.39216144400731413928,
)

SHARES = slot('[-] shares of the step, one for each stage')


@inline
def _half_angle(a):
    """
    Sine and cosine of a, half the angle of a rotation [rad].

    With x = a/2, y = x^2, N = x (945 - 105 y + y^2), D = 945 - 420 y + 15 y^2, the (5, 4) Padé
    approximant N/D of tan x:
        cos a = (D^2 - N^2) / (D^2 + N^2),   sin a = 2 N D / (D^2 + N^2)
    """
    x = 0.5 * a
    y = x * x
    n = x * (945.0 + y * (y - 105.0))
    d = 945.0 + y * (15.0 * y - 420.0)
    nn = n * n
    dd = d * d
    over = 1.0 / (dd + nn)
    return 2.0 * n * d * over, (dd - nn) * over


@inline
def _turn(s, c, x, y, z, w, m2, m3):
    """
    Turn about one body axis by an angle whose half has sine s and cosine c.

        x, y, z, w : q, its parts along this axis and the two that follow
        m2, m3     : momentum along the two that follow
    """
    sine = 2.0 * s * c
    versine = 2.0 * s * s
    return (
        x * c + w * s,
        y * c + z * s,
        z * c - y * s,
        w * c - x * s,
        m2 + (m3 * sine - m2 * versine),
        m3 - (m2 * sine + m3 * versine),
    )


@kernel
def drift(block, lanes, kick, h, rotation, method):
    """
    Kick the angular momentum, then let one block of bodies turn freely.

        L <- L + kick * torque
        q <- attitude after S(h)
    """
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    for k in range(wide(lanes)):
        x = s[k + QX]
        y = s[k + QY]
        z = s[k + QZ]
        w = s[k + QW]
        l1 = s[k + LX] + kick * s[k + TX]
        l2 = s[k + LY] + kick * s[k + TY]
        l3 = s[k + LZ] + kick * s[k + TZ]
        m1, m2, m3 = rotate(-x, -y, -z, w, l1, l2, l3)
        quarter1 = 0.25 * h * s[k + J1]  # half of the angle, half of the step
        quarter2 = 0.25 * h * s[k + J2]
        sine, cosine = _half_angle(quarter1 * m1)
        x, y, z, w, m2, m3 = _turn(sine, cosine, x, y, z, w, m2, m3)
        sine, cosine = _half_angle(quarter2 * m2)
        y, z, x, w, m3, m1 = _turn(sine, cosine, y, z, x, w, m3, m1)
        sine, cosine = _half_angle(0.5 * h * s[k + J3] * m3)
        z, x, y, w, m1, m2 = _turn(sine, cosine, z, x, y, w, m1, m2)
        sine, cosine = _half_angle(quarter2 * m2)
        y, z, x, w, m3, m1 = _turn(sine, cosine, y, z, x, w, m3, m1)
        sine, cosine = _half_angle(quarter1 * m1)
        x, y, z, w, m2, m3 = _turn(sine, cosine, x, y, z, w, m2, m3)
        f = 1.5 - 0.5 * (x * x + y * y + z * z + w * w)
        s[k + QX] = x * f
        s[k + QY] = y * f
        s[k + QZ] = z * f
        s[k + QW] = w * f
        s[k + LX] = l1
        s[k + LY] = l2
        s[k + LZ] = l3


def _compose(block, lanes, kick, h, rotation, method):
    """Kick the angular momentum, then turn one block of bodies by S(g_1 h) S(g_2 h) …."""
    for stage in range(len(SHARES)):
        drift(block, lanes, kick if stage == 0 else 0.0, SHARES[stage] * h, rotation, method)


def composed(shares: tuple[float, ...], *, name: str) -> Callable[..., Any]:
    """Make the drift kernel of a composition: shares of the step, sum 1."""
    return specialise(_compose, name=name, SHARES=shares)
