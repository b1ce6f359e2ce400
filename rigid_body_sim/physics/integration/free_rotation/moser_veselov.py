# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation by the preprocessed discrete Moser–Veselov map.

The discrete top of Moser & Veselov (1991) turns the attitude by the Cayley rotation with
vector c = tan(angle/2) axis:

    c1 = alpha b1 + a1 c2 c3  (cyclic),   alpha = 1 + |c|^2
    q <- q (c, 1) / |(c, 1)|

        j_k = s / I_k + d             modified inverse moments of inertia [1/(kg m^2)]
        i_k = 1 / j_k,  a1 = (i2 - i3) j1  (cyclic)
        b_k = (h/2) m_k j_k,  m = R^T L    angular momentum, principal axes [kg m^2/s]

With s = 1, d = 0 the map has order 2. McLachlan & Zanna (2005) found, and Hairer & Vilmart, J.
Phys. A 39 (2006) 13225, gave in closed form, the series s and d in A = h^2 |m|^2 / 2 and H = h^2 T
with which the discrete orbit follows the exact one to any even order at the same cost. The map is
symmetric; it keeps the energy and the angular momentum to rounding, and since L is not touched
here, L to the last bit.

Limits: the equation has a solution that iteration finds up to about h |omega| = 1; beyond, the
step is halved until it does. Angle error [rad] over 100 rad on I = (1, 2, 3) at h |omega| = 0.4
and 0.1: order 2: all, 0.2; order 4: 2e-2, 8e-5; order 6: 9e-5, 2e-8; order 8: 2e-7, 3e-12; order
10: 3e-10, round-off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, slot, specialise
from rigid_body_sim.physics.integration.free_rotation.moser_veselov_series import (
    AA,
    AAA,
    AAAA,
    AAAH,
    AAH,
    AAHH,
    AH,
    AHH,
    AHHH,
    HH,
    HHH,
    HHHH,
    A,
    H,
    series,
    series_rows,
)
from rigid_body_sim.physics.state.blocks import (
    I1,
    I2,
    I3,
    J1,
    J2,
    J3,
    LANES,
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
    rotated_back,
    select,
    wide,
)
from rigid_body_sim.physics.vectors import dot

CONVERGED = 1e-14  # [-] change of c in the last sweep over |c|; a hundredth of it is left
LOST = 1e9  # [-] |c| from which iteration runs away
MORE_SWEEPS = 60  # of the careful pass, before the step is halved
HALVINGS = 10  # beyond h |omega| = 1000 rad a step has no meaning left

ORDER = slot('[-] 2, 4, 6, 8 or 10')
SERIES_D = slot('[-] place of the series d in a block, behind the series s')
MISSED = slot('[-] place of the row that is 1 where no pass has converged yet')
LATE = slot('[-] place of the number: whether the fast pass failed some lane in the step before')
METHOD = slot('[-] numbers in a block')
patiently = slot(
    'kernel (lanes, h, s, method): turns the lanes marked in MISSED, see `_patiently`'
)
carefully = slot('kernel (k, h, s, method): turns one body, see `_carefully`')


@inline
def _series(order, a, h, method, k):
    """Sum the terms of a series in a = A and h = H that an order takes."""
    if order == 2:
        return 0.0
    if order == 4:
        return a * method[k + A] + h * method[k + H]
    low = a * (method[k + A] + a * method[k + AA] + h * method[k + AH]) + h * (
        method[k + H] + h * method[k + HH]
    )
    if order == 6:
        return low
    aa = a * a
    hh = h * h
    high = aa * (a * method[k + AAA] + h * method[k + AAH]) + hh * (
        a * method[k + AHH] + h * method[k + HHH]
    )
    if order == 8:
        return low + high
    ah = a * h
    highest = aa * (aa * method[k + AAAA] + ah * method[k + AAAH] + hh * method[k + AAHH]) + hh * (
        ah * method[k + AHHH] + hh * method[k + HHHH]
    )
    return low + (high + highest)


@inline
def _size(c):
    """Sum of the sizes of the components."""
    return abs(c[0]) + abs(c[1]) + abs(c[2])


@inline
def _sweep(c, a, b):
    """Renew c once, each component with the newest of the others (Gauss–Seidel)."""
    c1, c2, c3 = c
    alpha = 1.0 + (c1 * c1 + c2 * c2 + c3 * c3)
    n1 = alpha * b[0] + a[0] * c2 * c3
    n2 = alpha * b[1] + a[1] * c3 * n1
    n3 = alpha * b[2] + a[2] * n1 * n2
    return (n1, n2, n3), abs(n1 - c1) + abs(n2 - c2) + abs(n3 - c3)


@inline
def _five_sweeps(c, a, b):
    """Renew c five times; give the last change too."""
    c, _ = _sweep(c, a, b)
    c, _ = _sweep(c, a, b)
    c, _ = _sweep(c, a, b)
    c, _ = _sweep(c, a, b)
    return _sweep(c, a, b)


@inline
def _settle(c, good, a, b):
    """Sweep once more, unless c is good."""
    n, change = _sweep(c, a, b)
    size = _size(n)
    settled = good | ((change <= 0.1 * CONVERGED * size) & (size < LOST))
    return (
        c[0] if good else n[0],
        c[1] if good else n[1],
        c[2] if good else n[2],
    ), settled


@inline
def _equation(order, series_d, m, h, moments, inverses, method, k):
    """
    Set up a and b, and guess c; of the modified inverse moments also the least.

        m                 : (3,) [kg m^2/s]  angular momentum
        moments, inverses : (3,)             I and 1/I; all of them principal axes
    """
    m1, m2, m3 = m
    i1, i2, i3 = moments
    v1, v2, v3 = inverses
    half = 0.5 * h * h
    of_momentum = half * dot(m, m)
    of_energy = half * (m1 * m1 * v1 + m2 * m2 * v2 + m3 * m3 * v3)
    scale = 1.0 + _series(order, of_momentum, of_energy, method, k)
    shift = _series(order, of_momentum, of_energy, method, k + series_d)
    j1 = scale * v1 + shift
    j2 = scale * v2 + shift
    j3 = scale * v3 + shift
    # a1 = (1/j2 - 1/j3) j1 with j3 - j2 = scale (1/I3 - 1/I2): no cancellation between s and d
    over = scale / (j1 * j2 * j3)
    a1 = (i2 - i3) * (v2 * v3) * j1 * j1 * over
    a2 = (i3 - i1) * (v3 * v1) * j2 * j2 * over
    a3 = (i1 - i2) * (v1 * v2) * j3 * j3 * over
    b1 = 0.5 * h * m1 * j1
    b2 = 0.5 * h * m2 * j2
    b3 = 0.5 * h * m3 * j3
    b = b1 * b1 + b2 * b2 + b3 * b3
    alpha = 1.0 + b * (1.0 + b * (2.0 + 5.0 * b))  # alpha = 1 + alpha^2 b, as a series
    c1 = alpha * (b1 + a1 * b2 * b3 * alpha)
    c2 = alpha * (b2 + a2 * c1 * b3)
    c3 = alpha * b3 + a3 * c1 * c2
    return (a1, a2, a3), (b1, b2, b3), (c1, c2, c3), min(j1, j2, j3)


@inline
def _turned(q, c):
    """Attitude q (c, 1), normalised."""
    x, y, z, w = q
    c1, c2, c3 = c
    n = 1.0 / math.sqrt(1.0 + (c1 * c1 + c2 * c2 + c3 * c3))
    u = (x + (w * c1 + (y * c3 - z * c2))) * n
    v = (y + (w * c2 + (z * c1 - x * c3))) * n
    t = (z + (w * c3 + (x * c2 - y * c1))) * n
    r = (w - (x * c1 + y * c2 + z * c3)) * n
    f = 1.5 - 0.5 * (u * u + v * v + t * t + r * r)
    return u * f, v * f, t * f, r * f


def _carefully(k, h, s, method):
    """Turn one body with as many sweeps as it takes, and in as many equal pieces."""
    momentum = s[k + LX], s[k + LY], s[k + LZ]
    moments = s[k + I1], s[k + I2], s[k + I3]
    inverses = s[k + J1], s[k + J2], s[k + J3]
    pieces = 1
    for _halving in range(HALVINGS + 1):
        q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        done = 0
        while done < pieces:
            m = rotated_back(q, momentum)
            a, b, c, least = _equation(
                ORDER, SERIES_D, m, h / pieces, moments, inverses, method, k
            )
            converged = False
            sweeps = 0
            while least > 0.0 and not converged and sweeps < MORE_SWEEPS:
                c, change = _sweep(c, a, b)
                size = _size(c)
                if not size < LOST:
                    break
                converged = change <= 0.1 * CONVERGED * size
                sweeps += 1
            if not converged:
                break
            q = _turned(q, c)
            done += 1
        if done == pieces:
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = q
            return
        pieces *= 2
    s[k + QW] = math.nan  # the check at the end of the call reports it


def _patiently(lanes, h, s, method):
    """
    Turn the lanes that are marked in MISSED: fifteen sweeps, in which a settled lane stands still.

    returns : (lanes that five sweeps do not serve, those that fifteen do not); these stay marked
    """
    late = 0
    missed = 0
    for k in range(lanes):
        q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        m = rotated_back(q, (s[k + LX], s[k + LY], s[k + LZ]))
        moments = s[k + I1], s[k + I2], s[k + I3]
        inverses = s[k + J1], s[k + J2], s[k + J3]
        a, b, c, least = _equation(ORDER, SERIES_D, m, h, moments, inverses, method, k)
        c, change = _five_sweeps(c, a, b)
        size = _size(c)
        early = (change <= CONVERGED * size) & (size < LOST) & (least > 0.0)
        good = early
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        c, good = _settle(c, good, a, b)
        good = good & (least > 0.0)
        waiting = method[k + MISSED] > 0.0
        taken = good & waiting
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = select(taken, _turned(q, c), q)
        method[k + MISSED] = 0.0 if good else method[k + MISSED]
        late += 0 if early else 1
        missed += 0 if good else 1
    return late, missed


def _drift(block, lanes, kick, h, rotation, method):
    """
    Kick the angular momentum, then let one block of bodies turn freely.

        L <- L + kick * torque
        q <- attitude after free rotation over h

    A fast pass of five sweeps without branches serves every lane to h |omega| = 0.03. Lanes that
    it did not bring to convergence go to a patient one of up to fifteen (to h |omega| = 0.4), and
    what that leaves is done one by one. Where the step before had such lanes the patient pass goes
    first. It gives a lane the bits of the fast pass where that one converges, so neither this
    choice nor the neighbours of a body can be seen in the result.
    """
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    own = method[block * METHOD : block * METHOD + METHOD]
    missed = 0
    full = wide(lanes)
    if own[LATE] > 0.0:
        for k in range(full):
            s[k + LX] = s[k + LX] + kick * s[k + TX]
            s[k + LY] = s[k + LY] + kick * s[k + TY]
            s[k + LZ] = s[k + LZ] + kick * s[k + TZ]
            own[k + MISSED] = 1.0
        late, missed = patiently(full, h, s, own)
        own[LATE] = 1.0 if late > 0 else 0.0
    else:
        for k in range(full):
            q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
            l1 = s[k + LX] + kick * s[k + TX]
            l2 = s[k + LY] + kick * s[k + TY]
            l3 = s[k + LZ] + kick * s[k + TZ]
            m = rotated_back(q, (l1, l2, l3))
            moments = s[k + I1], s[k + I2], s[k + I3]
            inverses = s[k + J1], s[k + J2], s[k + J3]
            a, b, c, least = _equation(ORDER, SERIES_D, m, h, moments, inverses, own, k)
            c, change = _five_sweeps(c, a, b)
            size = _size(c)
            good = (change <= CONVERGED * size) & (size < LOST) & (least > 0.0)
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = select(good, _turned(q, c), q)
            s[k + LX] = l1
            s[k + LY] = l2
            s[k + LZ] = l3
            own[k + MISSED] = 0.0 if good else 1.0
            missed += 0 if good else 1
        if missed > 0:
            own[LATE] = 1.0
            _late, missed = patiently(full, h, s, own)
    if missed > 0:
        for k in range(lanes):
            if own[k + MISSED] > 0.0:
                carefully(k, h, s, own)


def drift(order: int) -> Callable[..., Any]:
    """Make the drift kernel of an order: 2, 4, 6, 8 or 10."""
    half = LANES * series_rows(order)
    offered: dict[str, Any] = {
        'ORDER': order,
        'SERIES_D': half,
        'MISSED': 2 * half,
        'LATE': 2 * half + LANES,
        'METHOD': 2 * half + 2 * LANES,
    }
    name = f'dmv{order}'
    return specialise(
        _drift,
        name=name,
        offered=offered,
        patiently=specialise(_patiently, name=name, offered=offered),
        carefully=specialise(_carefully, name=name, offered=offered),
    )


def coefficients(order: int) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Make the function that gives the numbers which the drift of an order keeps for each body."""

    def rows(moments: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.hstack([series(moments, order), np.zeros((len(moments), 2))])

    return rows
