# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Free rotation by the implicit midpoint rule with a Cayley rotation.

    I w + u x I w = m,   u = (h/2) w,   m = R^T L        body axes
    q <- q (u, 1) / |(u, 1)|

        w : angular velocity in the middle of the step [rad/s], by Newton from I^-1 m on
        u : tangent of half the angle, along the axis [-]

The Cayley rotation of u carries I w + u x I w into I w - u x I w, so that L = R m stays what it
is: L is not touched here,
not in its last bit. The energy w . I w / 2 is the same before and after as well. Symmetric, order
two.

Source: Austin, Krishnaprasad & Wang, J. Comput. Phys. 107 (1993) 105. The error of the phase is
some hundred times that of the splitting into rotations; its merit is that it stays bounded at any
step that resolves nothing.

Limits: Newton converges from I^-1 m up to about h |omega| = 4; beyond, the step is halved until it
does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import inline, kernel
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
)

# [-] first change of w over |w| in two steps with one Jacobian; the error left is at most its
# cube, times h |omega|
CONVERGED = 3e-6
CAREFULLY_CONVERGED = (
    1e-11  # the same where h |omega| is large and the Jacobian may be nearly singular
)
MORE_STEPS = 40  # of the careful pass, before the step is halved
HALVINGS = 10  # beyond h |omega| = 1000 rad a step has no meaning left

METHOD = LANES  # numbers in a block of coefficients: 1 where the fast pass did not converge


def coefficients(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one number per body, for the kernel to write into."""
    return np.zeros((len(moments), 1))


@inline
def _two_steps(w, m, moments, gyroscopic):
    """
    Improve w in I w + (h/2) w x I w = m twice with one Jacobian, inverted by Cramer's rule.

        gyroscopic : (h/2) (I2 - I3), (h/2) (I3 - I1), (h/2) (I1 - I2)
        returns    : new w, size of the first change
    """
    a, b, c = w
    m1, m2, m3 = m
    i1, i2, i3 = moments
    e1, e2, e3 = gyroscopic
    ac, ab = -e1 * c, -e1 * b
    bc, ba = -e2 * c, -e2 * a
    cb, ca = -e3 * b, -e3 * a
    n11 = i2 * i3 - ba * ca
    n21 = ba * cb - bc * i3
    n31 = bc * ca - i2 * cb
    over = 1.0 / (i1 * n11 + ac * n21 + ab * n31)
    n12, n22, n32 = ab * ca - ac * i3, i1 * i3 - ab * cb, ac * cb - i1 * ca
    n13, n23, n33 = ac * ba - ab * i2, ab * bc - i1 * ba, i1 * i2 - ac * bc
    r1 = (i1 * a - e1 * b * c - m1) * over
    r2 = (i2 * b - e2 * c * a - m2) * over
    r3 = (i3 * c - e3 * a * b - m3) * over
    da = n11 * r1 + n12 * r2 + n13 * r3
    db = n21 * r1 + n22 * r2 + n23 * r3
    dc = n31 * r1 + n32 * r2 + n33 * r3
    a, b, c = a - da, b - db, c - dc
    r1 = (i1 * a - e1 * b * c - m1) * over
    r2 = (i2 * b - e2 * c * a - m2) * over
    r3 = (i3 * c - e3 * a * b - m3) * over
    return (
        a - (n11 * r1 + n12 * r2 + n13 * r3),
        b - (n21 * r1 + n22 * r2 + n23 * r3),
        c - (n31 * r1 + n32 * r2 + n33 * r3),
    ), abs(da) + abs(db) + abs(dc)


@inline
def _turned(q, g, rate):
    """Attitude q (u, 1), normalised, of u = g rate."""
    x, y, z, w = q
    u1, u2, u3 = g * rate[0], g * rate[1], g * rate[2]
    n = 1.5 - 0.5 * (x * x + y * y + z * z + w * w)
    n = n / math.sqrt(1.0 + (u1 * u1 + u2 * u2 + u3 * u3))
    return (
        (x + (w * u1 + (y * u3 - z * u2))) * n,
        (y + (w * u2 + (z * u1 - x * u3))) * n,
        (z + (w * u3 + (x * u2 - y * u1))) * n,
        (w - (x * u1 + y * u2 + z * u3)) * n,
    )


@inline
def _gyroscopic(g, moments):
    """Products of half the step with the differences of the moments."""
    i1, i2, i3 = moments
    return g * (i2 - i3), g * (i3 - i1), g * (i1 - i2)


@kernel
def _carefully(k, h, s):
    """Turn one body with as many Newton steps as it takes, and in as many equal pieces."""
    momentum = s[k + LX], s[k + LY], s[k + LZ]
    moments = s[k + I1], s[k + I2], s[k + I3]
    pieces = 1
    for _halving in range(HALVINGS + 1):
        q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        g = 0.5 * h / pieces
        done = 0
        while done < pieces:
            m = rotated_back(q, momentum)
            w = m[0] * s[k + J1], m[1] * s[k + J2], m[2] * s[k + J3]
            converged = False
            steps = 0
            while not converged and steps < MORE_STEPS:
                w, change = _two_steps(w, m, moments, _gyroscopic(g, moments))
                size = abs(w[0]) + abs(w[1]) + abs(w[2])
                if not size < 1e150:
                    break
                converged = change <= CAREFULLY_CONVERGED * size
                steps += 1
            if not converged:
                break
            q = _turned(q, g, w)
            done += 1
        if done == pieces:
            s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = q
            return
        pieces *= 2
    s[k + QW] = math.nan  # the check at the end of the call reports it


@inline
def _guess(m, inverses, gyroscopic):
    """Angular velocity from I^-1 m by two sweeps (Gauss–Seidel)."""
    m1, m2, m3 = m
    v1, v2, v3 = inverses
    e1, e2, e3 = gyroscopic
    b, c = m2 * v2, m3 * v3
    a = (m1 + e1 * b * c) * v1
    b = (m2 + e2 * c * a) * v2
    c = (m3 + e3 * a * b) * v3
    a = (m1 + e1 * b * c) * v1
    b = (m2 + e2 * c * a) * v2
    return a, b, (m3 + e3 * a * b) * v3


@kernel
def drift(block, lanes, kick, h, rotation, method):
    """
    Kick the angular momentum, then let one block of bodies turn freely.

        L <- L + kick * torque
        q <- attitude after free rotation over h

    A fast pass of two sweeps and two Newton steps without branches serves every lane (to
    h |omega| = 0.07); the lanes that it did not bring to convergence are then done one by one. So
    the result for a body does not depend on its neighbours.
    """
    s = rotation[block * ROTATION : block * ROTATION + ROTATION]
    flags = method[block * METHOD : block * METHOD + METHOD]
    g = 0.5 * h
    missed = 0
    for k in range(lanes):
        q = s[k + QX], s[k + QY], s[k + QZ], s[k + QW]
        l1 = s[k + LX] + kick * s[k + TX]
        l2 = s[k + LY] + kick * s[k + TY]
        l3 = s[k + LZ] + kick * s[k + TZ]
        m = rotated_back(q, (l1, l2, l3))
        moments = s[k + I1], s[k + I2], s[k + I3]
        gyroscopic = _gyroscopic(g, moments)
        w = _guess(m, (s[k + J1], s[k + J2], s[k + J3]), gyroscopic)
        w, change = _two_steps(w, m, moments, gyroscopic)
        good = change <= CONVERGED * (abs(w[0]) + abs(w[1]) + abs(w[2]))
        s[k + QX], s[k + QY], s[k + QZ], s[k + QW] = select(good, _turned(q, g, w), q)
        s[k + LX], s[k + LY], s[k + LZ] = l1, l2, l3
        flags[k] = 0.0 if good else 1.0
        missed += 0 if good else 1
    if missed > 0:
        for k in range(lanes):
            if flags[k] > 0.0:
                _carefully(k, h, s)
