# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation solved: Jacobi's elliptic functions for the momentum in the body, a quadrature for
the precession.

Axes sorted by moment, I1 <= I2 <= I3 (right-handed: the last is reversed where need be),
m = R^T L / |L|, G = |L|:
    a1 = m2^2 (I2-I1)/I2 + m3^2 (I3-I1)/I3,   a3 = m1^2 (I3-I1)/I1 + m2^2 (I3-I2)/I2,
    a2 = m3^2 (I3-I2)/I3 - m1^2 (I2-I1)/I1
    a2 >= 0: (x, y, z) = (m1, m2, m3), (A, B, C) = (I1, I2, I3), ax = a3, az = a1
    a2 <  0: (x, y, z) = (m3, m2, m1), (A, B, C) = (I3, I2, I1), ax = a1, az = a3
    x = X cn u,  y = Y sn u,  z = Z dn u,  u = u0 + sign(z) nu t
    nu^2 = G^2 |C-B| az / (A B C),  k^2 = |B-A| ax / (|C-B| az),  k'^2 = |C-A| |a2| / (|C-B| az)
    X^2 = A ax / |C-A|,  Y^2 = B ax / |C-B|,  Z^2 = C az / |C-A|, with the sign of z
Precession about L of the body axis that m never approaches, of C if X^2 > 1/2, else of A:
    psi' = G (x^2/A + y^2/B) / (x^2 + y^2)   or   G (y^2/B + z^2/C) / (y^2 + z^2)
    R(t) = R0 F(m0) Rz(psi) F(m)^T,   F(m) = (c1, c2, m)
    c1 = unit part of that axis across m,  c2 = m x c1
psi is summed by six-point Gauss–Legendre over panels of nu t <= 0.3. No momentum, no motion.
Two equal moments I1 and a third I3 along e3, a sphere among them, need none of this:
    R(t) = exp(t L / I1) R0 exp(t (L.e3) (1/I3 - 1/I1) e3)      at any t

Exact but for round-off: 1e-16 rad a step, amplified near the separatrix as the motion itself
amplifies it. L is not touched. One body costs half a microsecond, whatever the step up to
h nu = 0.3, a symmetric one a tenth of that, and does not vectorise.

Source: Landau and Lifshitz, Mechanics, section 37; Celledoni, Fassò, Säfström & Zanna, SIAM J.
Sci. Comput. 30 (2008).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.compile.kernels import inline, kernel
from rigid_body_sim.physics.integration.free_rotation.euler import exponential
from rigid_body_sim.physics.integration.free_rotation.jacobi_functions import (
    PAIRS,
    jacobi,
    means,
    of_sum,
)
from rigid_body_sim.physics.state.blocks import (
    I1,
    J1,
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

PANEL = 0.3  # [-] of nu t; twice as long loses the last digits of psi
LONGEST = 1200.0  # [-] of nu t in a step; beyond it a step has no meaning left
NODES = (0.2386191860831969, 0.6612093864662645, 0.9324695142031521)  # Gauss–Legendre, six points
WEIGHTS = (0.4679139345726910, 0.3607615730481386, 0.1713244923791704)

# the three body axes as offsets of rows
AXIS_1, AXIS_2, AXIS_3 = 0, LANES, 2 * LANES

of_body = Record(stride=LANES)
LOW = of_body.number('-', 'body axis of the lowest moment, as an offset of rows')
MIDDLE = of_body.number('-', 'of the middle one')
HIGH = of_body.number('-', 'of the highest one')
HAND = of_body.number('-', '1, or -1 where the sorted axes are left-handed')
AXIS = of_body.number('-', 'of symmetry, as an offset of rows; -1: no two moments are equal')
MEANS = of_body.numbers(2 * PAIRS, '-', 'room for the means')
METHOD = of_body.size  # numbers in a block

# [-] square of half an angle up to which the rational sine and cosine are right to 1e-16
SMALL = 0.07


def coefficients(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Sort the axes of each body.

        moments : (n, 3) [kg m^2]
        returns : (n, METHOD / LANES): LOW, MIDDLE, HIGH, HAND, AXIS and room for means
    """
    order = np.argsort(moments, axis=1, kind='stable')
    hand = np.where((order[:, 1] - order[:, 0]) % 3 == 1, 1.0, -1.0)
    equal = moments[:, [1, 2, 0]] == moments[:, [2, 0, 1]]
    axis = np.where(equal.any(axis=1), float(LANES) * equal.argmax(axis=1), -1.0)
    room = np.zeros((len(moments), 2 * PAIRS))
    return np.hstack([float(LANES) * order, hand[:, None], axis[:, None], room]).astype(np.float64)


@inline
def _pick(offset, v):
    """Give the component along the axis of a row offset."""
    return v[0] if offset == AXIS_1 else (v[1] if offset == AXIS_2 else v[2])


@inline
def _turned(q, turn):
    """Attitude q turn, normalised."""
    x, y, z, w = q
    a, b, c, d = turn
    u = x * d + w * a + (y * c - z * b)
    v = y * d + w * b + (z * a - x * c)
    t = z * d + w * c + (x * b - y * a)
    r = w * d - (x * a + y * b + z * c)
    f = 1.0 / math.sqrt(u * u + v * v + t * t + r * r)
    return u * f, v * f, t * f, r * f


@inline
def _frame(m, third):
    """Unit part across m of the third axis (or the first), and m x it."""
    m1, m2, m3 = m
    if third:
        f = 1.0 / math.sqrt(m1 * m1 + m2 * m2)
        return (-m1 * m3 * f, -m2 * m3 * f, (m1 * m1 + m2 * m2) * f), (m2 * f, -m1 * f, 0.0)
    f = 1.0 / math.sqrt(m2 * m2 + m3 * m3)
    return ((m2 * m2 + m3 * m3) * f, -m1 * m2 * f, -m1 * m3 * f), (0.0, m3 * f, -m2 * f)


@inline
def _quaternion(matrix):
    """Quaternion of a rotation matrix of three rows, from its largest component."""
    r11, r12, r13 = matrix[0]
    r21, r22, r23 = matrix[1]
    r31, r32, r33 = matrix[2]
    trace = r11 + r22 + r33
    if trace > 0.0:
        d = 0.5 * math.sqrt(1.0 + trace)
        f = 0.25 / d
        return (r32 - r23) * f, (r13 - r31) * f, (r21 - r12) * f, d
    if r11 >= r22 and r11 >= r33:
        a = 0.5 * math.sqrt(1.0 + r11 - r22 - r33)
        f = 0.25 / a
        return a, (r12 + r21) * f, (r13 + r31) * f, (r32 - r23) * f
    if r22 >= r33:
        b = 0.5 * math.sqrt(1.0 - r11 + r22 - r33)
        f = 0.25 / b
        return (r12 + r21) * f, b, (r23 + r32) * f, (r13 - r31) * f
    c = 0.5 * math.sqrt(1.0 - r11 - r22 + r33)
    f = 0.25 / c
    return (r13 + r31) * f, (r23 + r32) * f, c, (r21 - r12) * f


@inline
def _steady(h, omega):
    """Rotation by h omega."""
    a, b, c = 0.5 * h * omega[0], 0.5 * h * omega[1], 0.5 * h * omega[2]
    angle = math.sqrt(a * a + b * b + c * c)
    f = math.sin(angle) / angle if angle > 1e-150 else 1.0
    return a * f, b * f, c * f, math.cos(angle)


@inline
def _precession_rate(xyz, about_c, inverses):
    """psi' / G."""
    x, y, z = xyz
    over_a, over_b, over_c = inverses
    if about_c:
        return (x * x * over_a + y * y * over_b) / (x * x + y * y)
    return (y * y * over_b + z * z * over_c) / (y * y + z * z)


@inline
def _combined(p, q, m, f, g, n):
    """Rows of the matrix p f^T + q g^T + m n^T."""
    return (
        (
            p[0] * f[0] + q[0] * g[0] + m[0] * n[0],
            p[0] * f[1] + q[0] * g[1] + m[0] * n[1],
            p[0] * f[2] + q[0] * g[2] + m[0] * n[2],
        ),
        (
            p[1] * f[0] + q[1] * g[0] + m[1] * n[0],
            p[1] * f[1] + q[1] * g[1] + m[1] * n[1],
            p[1] * f[2] + q[1] * g[2] + m[1] * n[2],
        ),
        (
            p[2] * f[0] + q[2] * g[0] + m[2] * n[0],
            p[2] * f[1] + q[2] * g[1] + m[2] * n[1],
            p[2] * f[2] + q[2] * g[2] + m[2] * n[2],
        ),
    )


@kernel
def _free(h, speed, m, moments, method, k):
    """
    Rotation of a body in the time h, in its sorted axes at the start.

        speed   : G [kg m^2/s]
        m       : (3,) direction of the momentum
        moments : (3,) I1 <= I2 <= I3
        returns : quaternion, or NaN where the step is too long
    """
    m1, m2, m3 = m
    i1, i2, i3 = moments
    a1 = m2 * m2 * ((i2 - i1) / i2) + m3 * m3 * ((i3 - i1) / i3)
    a3 = m1 * m1 * ((i3 - i1) / i1) + m2 * m2 * ((i3 - i2) / i2)
    a2 = m3 * m3 * ((i3 - i2) / i3) - m1 * m1 * ((i2 - i1) / i1)
    high = a2 >= 0.0
    if high:
        x, y, z, a, b, c, ax, az = m1, m2, m3, i1, i2, i3, a3, a1
    else:
        x, y, z, a, b, c, ax, az = m3, m2, m1, i3, i2, i1, a1, a3
    wide = abs(c - a)
    near = abs(c - b)
    if near * az == 0.0:
        return _steady(h, (speed * m1 / i1, speed * m2 / i2, speed * m3 / i3))
    over_a, over_b, over_c = 1.0 / a, 1.0 / b, 1.0 / c
    sign = 1.0 if z >= 0.0 else -1.0
    u = sign * h * speed * math.sqrt(near * over_c * (az * over_a * over_b))
    if not abs(u) < LONGEST:
        return math.nan, math.nan, math.nan, math.nan
    k2 = abs(b - a) * ax / (near * az)
    xx = math.sqrt(a * ax / wide)
    yy = math.sqrt(b * ax / near)
    zz = sign * math.sqrt(c * az / wide)
    s0, c0, d0 = 0.0, 1.0, z / zz
    if xx > 0.0 and yy > 0.0:
        s0, c0 = y / yy, x / xx
        f = math.sqrt(s0 * s0 + c0 * c0)
        s0, c0 = (s0 / f, c0 / f) if f > 0.0 else (0.0, 1.0)
    start = s0, c0, d0
    count, limit = means(math.sqrt(wide * abs(a2) / (near * az)), method, k + MEANS)
    about_c = xx * xx > 0.5
    inverses = over_a, over_b, over_c
    if k2 == 0.0 and about_c:
        psi = _precession_rate((x, y, z), about_c, inverses)
    else:
        psi = 0.0
        panels = 1 + int(abs(u) / PANEL)
        for panel in range(panels):
            for node in range(6):
                place = NODES[node >> 1] if node & 1 else -NODES[node >> 1]
                later = jacobi(
                    u * (panel + 0.5 + 0.5 * place) / panels, count, limit, method, k + MEANS
                )
                s, e, d = of_sum(start, later, k2)
                psi += (0.5 * WEIGHTS[node >> 1]) * _precession_rate(
                    (xx * e, yy * s, zz * d), about_c, inverses
                )
        psi /= panels
    psi *= h * speed
    s, e, d = of_sum(start, jacobi(u, count, limit, method, k + MEANS), k2)
    n1, n2, n3 = (xx * e, yy * s, zz * d) if high else (zz * d, yy * s, xx * e)
    f = 1.0 / math.sqrt(n1 * n1 + n2 * n2 + n3 * n3)
    return _between(m, (n1 * f, n2 * f, n3 * f), psi, about_c == high)


@inline
def _between(m, n, psi, third):
    """Rotation F(m) Rz(psi) F(n)^T."""
    p, q = _frame(m, third)
    cosine, sine = math.cos(psi), math.sin(psi)
    p, q = (
        (
            cosine * p[0] + sine * q[0],
            cosine * p[1] + sine * q[1],
            cosine * p[2] + sine * q[2],
        ),
        (
            cosine * q[0] - sine * p[0],
            cosine * q[1] - sine * p[1],
            cosine * q[2] - sine * p[2],
        ),
    )
    f, g = _frame(n, third)
    return _quaternion(_combined(p, q, m, f, g, n))


@inline
def _exponential(a, b, c):
    """Unit quaternion of a rotation by twice the vector (a, b, c) [rad]."""
    y = a * a + b * b + c * c
    if y < SMALL:
        return exponential(a, b, c)
    angle = math.sqrt(y)
    f = math.sin(angle) / angle
    return a * f, b * f, c * f, math.cos(angle)


@inline
def _symmetric(k, h, axis, s):
    """Turn a body of which two moments are equal: about L, and about its axis of symmetry."""
    x, y, z, w = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
    momentum = s[k + LX], s[k + LY], s[k + LZ]
    m = rotated_back((x, y, z, w), momentum)
    over = s[k + J1 + AXIS_2] if axis == AXIS_1 else s[k + J1]
    spin = (0.5 * h) * _pick(axis, m) * (s[k + J1 + axis] - over)
    f = 0.5 * h * over
    a, b, c, d = _exponential(f * momentum[0], f * momentum[1], f * momentum[2])
    q = (
        a * w + d * x + (b * z - c * y),
        b * w + d * y + (c * x - a * z),
        c * w + d * z + (a * y - b * x),
        d * w - (a * x + b * y + c * z),
    )
    about_axis = _exponential(
        spin if axis == AXIS_1 else 0.0,
        spin if axis == AXIS_2 else 0.0,
        spin if axis == AXIS_3 else 0.0,
    )
    s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = _turned(q, about_axis)


@kernel
def drift(block, lanes, kick, h, rotation, method):
    """
    Kick the angular momentum, then let one block of bodies turn freely.

        L <- L + kick * torque
        q <- attitude after free rotation over h
    """
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    own = method[block * METHOD : block * METHOD + METHOD]
    for k in range(lanes):
        l1 = s[k + LX] + kick * s[k + TX]
        l2 = s[k + LY] + kick * s[k + TY]
        l3 = s[k + LZ] + kick * s[k + TZ]
        s[k + LX], s[k + LY], s[k + LZ] = l1, l2, l3
        axis = int(own[k + AXIS])
        if axis >= 0:
            _symmetric(k, h, axis, s)
            continue
        largest = max(abs(l1), abs(l2), abs(l3))
        if largest > 1e-300:
            l1, l2, l3 = l1 / largest, l2 / largest, l3 / largest
            size = math.sqrt(l1 * l1 + l2 * l2 + l3 * l3)
            q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
            direction = rotated_back(q, (l1 / size, l2 / size, l3 / size))
            low, middle, high = int(own[k + LOW]), int(own[k + MIDDLE]), int(own[k + HIGH])
            hand = own[k + HAND]
            m = _pick(low, direction), _pick(middle, direction), hand * _pick(high, direction)
            moments = s[k + I1 + low], s[k + I1 + middle], s[k + I1 + high]
            a, b, c, d = _free(h, largest * size, m, moments, own, k)
            c *= hand
            # back to the order of the body: which of low, middle, high is axis 1, 2, 3
            turn = (
                a if low == AXIS_1 else (b if middle == AXIS_1 else c),
                a if low == AXIS_2 else (b if middle == AXIS_2 else c),
                a if low == AXIS_3 else (b if middle == AXIS_3 else c),
                d,
            )
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = _turned(q, turn)
