# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation by Taylor series in time, any order.

With omega = sum W[n] (t/h)^n in body axes and q = sum Q[n] (t/h)^n, Euler's equations and
q' = q (omega, 0) / 2 give

    W_1[n+1] = h/(n+1) (I2 - I3)/I1 sum_j W_2[j] W_3[n-j]        and cyclic
    Q[n+1]   = h/(2(n+1)) sum_j Q[j] (W[n-j], 0)

from Q[0] = q and W[0] = I^-1 R^T L; the new q is the sum of all Q[n],
normalised. L is not touched and so kept to the last bit.

A series reaches no farther than the nearest pole of the motion in the complex plane of time. The
components of omega are elliptic functions of lambda t with modulus k, whose poles lie at
i K'(k) / lambda from the real axis, and with K' = pi / (2 agm(1, k))

    rho = pi / (2 agm(sqrt p, sqrt q)),   k1 = (I2 - I3) / I1 and cyclic
    p = |k3 k1| omega2^2 + |k1 k2| omega3^2,   q = |k2 k3| omega1^2 + |k3 k1| omega2^2

        rho : [s]       radius of convergence at the worst phase of the motion
        p, q : [1/s^2]  lambda^2 and k^2 lambda^2, with 2 the axis of the middle moment

agm is the arithmetic-geometric mean, so that no digit is lost and only square roots are taken. At
order 16 a step leaves (h / rho)^17. A step is divided into pieces of at most NEAREST rho (1e-15 at
the worst phase of the worst of 400 bodies) and of at most LONGEST / |omega|, or LONGEST over the
rate at which omega changes where that is greater.

Limits: what is left is rounding. L is kept in world axes, and a rounding of q turns it in body
axes: |L| / I_min times 1e-16 in omega each piece, which on a rod of I = (0.01, 1, 1) counts a
hundredfold.

Source: Moore, Interval Analysis (1966), chapter 11; Corliss & Chang, ACM TOMS 8 (1982); the poles:
Landau & Lifshitz, Mechanics, 37; NIST Digital Library of Mathematical Functions, 22.4 and 19.8.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import kernel, slot, specialise
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
)

LONGEST = 0.52  # [rad] of one series, a longer step is divided; 1 costs all but six digits
NEAREST = 0.12  # [rho] of one series, likewise; 0.2 costs two digits, 0.33 six
MEANS = 6  # of the arithmetic-geometric mean: to 1 % where q / p = 1e-24, to rounding at 1e-3
FARTHEST = 1000.0  # [rad] beyond it a step has no meaning left
ROOM = 2  # rows of the method block: the coefficients of one body, one body at a time
METHOD = LANES * ROOM
LENGTH = 18  # numbers of a coefficient series in that room: orders to 17

room_of_body = Record()
W1 = room_of_body.numbers(LENGTH, 'rad/s', 'series of omega, body axes')
W2 = room_of_body.numbers(LENGTH, 'rad/s', 'the same')
W3 = room_of_body.numbers(LENGTH, 'rad/s', 'the same')
Q1 = room_of_body.numbers(LENGTH, '-', 'series of q')
Q2 = room_of_body.numbers(LENGTH, '-', 'the same')
Q3 = room_of_body.numbers(LENGTH, '-', 'the same')
Q4 = room_of_body.numbers(LENGTH, '-', 'the same')
SIZE = room_of_body.size

ORDER = slot('[-] highest power of h')
series = slot('kernel (q, omega, h, rates, room): sums the series, see `_series`')


def _series(q, omega, h, rates, room):
    """
    Sum the series of q and omega over h.

        q, omega : at the start, omega in body axes
        rates    : (3,) (I2 - I3) / I1 and cyclic
    """
    w1, w2, w3 = room[W1:W2], room[W2:W3], room[W3:Q1]
    q1, q2, q3, q4 = room[Q1:Q2], room[Q2:Q3], room[Q3:Q4], room[Q4:SIZE]
    k1, k2, k3 = rates
    w1[0], w2[0], w3[0] = omega
    q1[0], q2[0], q3[0], q4[0] = q
    for n in range(ORDER):
        s1 = s2 = s3 = r1 = r2 = r3 = r4 = 0.0
        for j in range(n + 1):
            a = w1[n - j]
            b = w2[n - j]
            c = w3[n - j]
            s1 += w2[j] * c
            s2 += w3[j] * a
            s3 += w1[j] * b
            x = q1[j]
            y = q2[j]
            z = q3[j]
            w = q4[j]
            r1 += w * a + (y * c - z * b)
            r2 += w * b + (z * a - x * c)
            r3 += w * c + (x * b - y * a)
            r4 -= x * a + (y * b + z * c)
        f = h / (n + 1)
        w1[n + 1] = f * k1 * s1
        w2[n + 1] = f * k2 * s2
        w3[n + 1] = f * k3 * s3
        f = 0.5 * f
        q1[n + 1] = f * r1
        q2[n + 1] = f * r2
        q3[n + 1] = f * r3
        q4[n + 1] = f * r4
    x = y = z = w = a = b = c = 0.0
    for n in range(ORDER, -1, -1):
        a += w1[n]
        b += w2[n]
        c += w3[n]
        x += q1[n]
        y += q2[n]
        z += q3[n]
        w += q4[n]
    f = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return (x * f, y * f, z * f, w * f), (a, b, c)


@kernel
def _scale(omega, rates):
    """Rate at which a free body turns, or at which its omega changes [rad/s]."""
    a, b, c = omega
    k1, k2, k3 = rates
    aa, bb, cc = a * a, b * b, c * c
    change = abs(k2 * k3) * aa + abs(k3 * k1) * bb + abs(k1 * k2) * cc
    return math.sqrt(max(aa + bb + cc, change))


@kernel
def _over_radius(omega, rates):
    """Inverse distance of the nearest pole from real time, 1 / rho [1/s]."""
    k1, k2, k3 = rates
    a = abs(k2 * k3) * omega[0] * omega[0]
    b = abs(k3 * k1) * omega[1] * omega[1]
    c = abs(k1 * k2) * omega[2] * omega[2]
    if k3 * k1 >= 0.0:  # the middle moment, which counts twice, is that of axis 2
        p, q = b + c, a + b
    elif k2 * k3 >= 0.0:
        p, q = a + b, c + a
    else:
        p, q = c + a, b + c
    p, q = math.sqrt(p), math.sqrt(q)
    for _mean in range(MEANS):
        p, q = 0.5 * (p + q), math.sqrt(p * q)
    return p * (2.0 / math.pi)


def _drift(block, lanes, kick, h, rotation, method):
    """
    Kick the angular momentum, then let one block of bodies turn freely.

        L <- L + kick * torque
        q <- attitude after free rotation over h
    """
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    room = method[block * METHOD : block * METHOD + METHOD]
    for k in range(lanes):
        l1 = s[k + LX] + kick * s[k + TX]
        l2 = s[k + LY] + kick * s[k + TY]
        l3 = s[k + LZ] + kick * s[k + TZ]
        s[k + LX], s[k + LY], s[k + LZ] = l1, l2, l3
        rates = (
            (s[k + I2] - s[k + I3]) * s[k + J1],
            (s[k + I3] - s[k + I1]) * s[k + J2],
            (s[k + I1] - s[k + I2]) * s[k + J3],
        )
        q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        a, b, c = rotated_back(q, (l1, l2, l3))
        omega = a * s[k + J1], b * s[k + J2], c * s[k + J3]
        span = abs(h) * _scale(omega, rates)
        if span < FARTHEST:
            pieces = max(1, int(math.ceil(span / LONGEST)))
            to_pole = abs(h) * _over_radius(omega, rates)
            pieces = max(pieces, int(math.ceil(to_pole / NEAREST)))
            for _piece in range(pieces):
                q, omega = series(q, omega, h / pieces, rates, room)
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = q
        else:
            s[k + QW] = math.nan  # the check at the end of the call reports it


def drift(order: int) -> Callable[..., Any]:
    """Make the drift kernel of an order, 1 to 17."""
    name = f'taylor{order}'
    return specialise(_drift, name=name, series=specialise(_series, name=name, ORDER=order))


def coefficients(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Make the room in which the drift keeps the series of a body."""
    return np.zeros((len(moments), ROOM))
