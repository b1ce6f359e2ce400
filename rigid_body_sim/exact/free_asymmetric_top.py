# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Torque-free top with any principal moments: Jacobi's solution, exact at any time.

Body axes sorted by moment, I1 <= I2 <= I3, m = I w (body axes), G = |m|:
    a1 = m2^2 (I2-I1)/I2 + m3^2 (I3-I1)/I3    = G^2 - 2 T I1
    a3 = m1^2 (I3-I1)/I1 + m2^2 (I3-I2)/I2    = 2 T I3 - G^2
    a2 = m3^2 (I3-I2)/I3 - m1^2 (I2-I1)/I1    = G^2 - 2 T I2
a2 >= 0: (x, y, z) = (m1, m2, m3), (A, B, C) = (I1, I2, I3), the momentum circles the axis of I3;
a2 <  0: (x, y, z) = (m3, m2, m1), (A, B, C) = (I3, I2, I1), it circles the axis of I1;
a2 =  0: the separatrix.  With az = G^2 - 2 T A, ax = 2 T C - G^2 (both times the sign of C - A):
    x = X cn u,  y = Y sn u,  z = Z dn u,  u = u0 +- nu t
    nu^2 = (C-B) az/(ABC),  k'^2 = (C-A) a2/((C-B) az)
    X^2 = A ax/(C-A),  Y^2 = B ax/(C-B),  Z^2 = C az/(C-A)
Precession about L, measured from a body axis that the momentum never approaches (the axis of C if
X^2 > G^2/2, else that of A; the other choice loses all digits on a thin rod):
    axis of C: psi' = G (x^2/A + y^2/B)/(x^2 + y^2)
    axis of A: psi' = G (y^2/B + z^2/C)/(y^2 + z^2)
Its integral is an elliptic integral of the third kind, taken over whole periods 2 K at once: late
times cost no accuracy beyond the round-off of nu t. With B(m) that carries the axis onto m:
    R(t) = R0 B(m0) R_axis(psi) B(m)^T
A sphere and a spin about a principal axis keep their w and are turned directly; two equal moments
need no care. Near the separatrix the motion itself amplifies round-off of the start by 1/k'.
Source: Landau and Lifshitz, Mechanics, section 37; DLMF chapters 19 and 22.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import jacobi
from rigid_body_sim.exact.attitude import IDENTITY, inverse, product, turn
from rigid_body_sim.exact.motion import Array, Rotation


class Orbit(NamedTuple):
    """
    The closed curve of the momentum on its sphere, and how it is run through.

    axes      : body axes (0, 1, 2) that carry x, y, z
    moments   : (A, B, C) [kg m^2]
    amplitude : (X, Y, +-Z) [kg m^2/s]
    rate      : u' [1/s], with its sign
    k_c       : complementary modulus k' [-]
    """

    axes: tuple[int, int, int]
    moments: tuple[float, float, float]
    amplitude: tuple[float, float, float]
    rate: float
    k_c: float


def rotation(
    t: ArrayLike,
    *,
    inertia: ArrayLike,
    angular_velocity_body: ArrayLike,
    orientation: ArrayLike = IDENTITY,
) -> Rotation:
    """
    Orientation and angular velocity of a free rigid body.

    t                     : (*T) [s]
    inertia               : (3,) [kg m^2]  principal moments, body axes
    angular_velocity_body : (3,) [rad/s]   at t = 0, body axes
    orientation           : (4,) [-]       at t = 0, xyzw, body to world
    """
    t = np.asarray(t, dtype=float)
    moments, w = np.asarray(inertia, dtype=float), np.asarray(angular_velocity_body, dtype=float)
    if _is_steady(moments, w):
        return _steady(t, w, orientation)
    momentum = moments * w
    orbit = _orbit(moments, momentum)
    quarter = jacobi.quarter_period(orbit.k_c)
    start = _start(momentum, orbit, quarter)
    m, psi, reference = _run(t, start, orbit, quarter)
    m0, psi0, _ = _run(np.zeros(()), start, orbit, quarter)
    G = np.linalg.norm(momentum)
    pole = np.eye(3)[reference]
    turned = product(_carry(m0, reference), turn(pole, G * (psi - psi0)))
    q = product(orientation, product(turned, inverse(_carry(m, reference))))
    return Rotation(q / np.linalg.norm(q, axis=-1, keepdims=True), m / moments)


def period(*, inertia: ArrayLike, angular_velocity_body: ArrayLike) -> float:
    """
    Time [s] after which the angular velocity returns in body axes; infinite where it never does.

    4 K/nu, between two flips half of it; a steady rotation, which never leaves, gives 0.
    Arguments as in `rotation`.
    """
    moments, w = np.asarray(inertia, dtype=float), np.asarray(angular_velocity_body, dtype=float)
    if _is_steady(moments, w):
        return 0.0
    orbit = _orbit(moments, moments * w)
    return 4.0 * jacobi.quarter_period(orbit.k_c) / abs(orbit.rate)


def _is_steady(moments: Array, w: Array) -> bool:
    """Whether w x I w vanishes: a sphere, a spin about a principal axis, no motion."""
    (I1, I2, I3), (w1, w2, w3) = moments, w
    return (I3 - I2) * w2 * w3 == (I1 - I3) * w3 * w1 == (I2 - I1) * w1 * w2 == 0.0


def _steady(t: Array, w: Array, orientation: ArrayLike) -> Rotation:
    speed = np.linalg.norm(w)
    axis = w / speed if speed > 0.0 else np.array([0.0, 0.0, 1.0])
    return Rotation(
        product(orientation, turn(axis, speed * t)), np.broadcast_to(w, (*t.shape, 3)).copy()
    )


def _orbit(moments: Array, momentum: Array) -> Orbit:
    """Constants of the motion; sums of terms of one sign, so that no digits cancel."""
    lowest, middle, highest = (int(i) for i in np.argsort(moments, kind='stable'))
    I1, I2, I3 = (float(moments[i]) for i in (lowest, middle, highest))
    m1, m2, m3 = (float(momentum[i]) for i in (lowest, middle, highest))
    a1 = m2**2 * (I2 - I1) / I2 + m3**2 * (I3 - I1) / I3
    a3 = m1**2 * (I3 - I1) / I1 + m2**2 * (I3 - I2) / I2
    a2 = m3**2 * (I3 - I2) / I3 - m1**2 * (I2 - I1) / I1
    if a2 >= 0.0:
        axes, A, B, C, ax, az, z = (lowest, middle, highest), I1, I2, I3, a3, a1, m3
    else:
        axes, A, B, C, ax, az, z = (highest, middle, lowest), I3, I2, I1, a1, a3, m1
    wide, near = abs(C - A), abs(C - B)
    # Sorted axes that are left-handed run the same orbit backwards.
    hand = 1.0 if (middle - lowest) % 3 == 1 else -1.0
    return Orbit(
        axes=axes,
        moments=(A, B, C),
        amplitude=(
            float(np.sqrt(A * ax / wide)),
            float(np.sqrt(B * ax / near)),
            float(np.copysign(np.sqrt(C * az / wide), z)),
        ),
        rate=float(np.copysign(np.sqrt(near * az / (A * B * C)), hand * z)),
        k_c=float(np.sqrt(wide * abs(a2) / (near * az))),
    )


def _start(momentum: Array, orbit: Orbit, quarter: float) -> float:
    """Return u at t = 0."""
    x, y, z = (momentum[i] / a for i, a in zip(orbit.axes, orbit.amplitude, strict=True))
    radius = np.hypot(x, y)
    return jacobi.argument(jacobi.Jacobi(y / radius, x / radius, z), quarter)


def _run(t: Array, start: float, orbit: Orbit, quarter: float) -> tuple[Array, Array, int]:
    """Momentum (*T, 3) [kg m^2/s], psi/G (*T) [s/(kg m^2)], and the body axis psi refers to."""
    phase = jacobi.reduce(start + orbit.rate * t, quarter)
    f = jacobi.functions(phase, orbit.k_c)
    X, Y, Z = orbit.amplitude
    A, B, C = orbit.moments
    m = np.empty((*t.shape, 3))
    m[..., orbit.axes] = np.stack([X * f.cn, Y * f.sn, Z * f.dn], axis=-1)
    if abs(Z) < X:  # X^2 + Z^2 = G^2
        reference, base, ratio, p, p_quarter = 2, A, (Y / X) ** 2, f.cn**2, 0.0
    else:
        reference, base, ratio, p, p_quarter = 0, C, (Y / Z) ** 2, f.dn**2, orbit.k_c**2
    integral = jacobi.third_kind(
        phase, f, p=p + ratio * f.sn**2, p_quarter=p_quarter + ratio, k_c=orbit.k_c
    )
    psi = t / base + (1.0 / B - 1.0 / base) * ratio * integral / orbit.rate
    return m, psi, orbit.axes[reference]


def _carry(m: Array, axis: int) -> Array:
    """Quaternion that carries body axis `axis` onto the direction of m: polar angle, longitude."""
    along, first, second = (m[..., (axis + i) % 3] for i in range(3))
    longitude = turn(np.eye(3)[axis], np.arctan2(second, first))
    tilt = turn(np.eye(3)[(axis + 2) % 3], np.arctan2(np.hypot(first, second), along))
    return product(longitude, tilt)
