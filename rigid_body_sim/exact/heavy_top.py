# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Symmetric heavy top on a fixed pivot (Lagrange): cusped start, and steady precession.

R = R_z(phi) R_x(theta) R_z(psi),  body z = symmetry axis, world z up, u = cos theta
    I1 : [kg m^2] moment about an axis across through the pivot, I3 about the symmetry axis
    w3 : [rad/s]  spin w.e3, constant
    m g l : [N m] weight times distance from pivot to centre of mass

Cusped start: theta = theta0, theta' = phi' = 0 at t = 0. With a = I3 w3/I1, beta = 2 m g l/I1:
    u1, u3 = roots of beta (1 - u^2) = a^2 (u0 - u), u1 < u2 = u0 < 1 < u3
    k^2 = (u2 - u1)/(u3 - u1),  lambda = sqrt(beta (u3 - u1))/2
    u = u1 + (u2 - u1) cd^2 = u0 - (u2 - u1) k'^2 sd^2,  cd = cn/dn, sd = sn/dn at lambda t
    phi' = a (u0 - u)/(1 - u^2) = (a/2) (P - M),      P = (1 + u0)/(1 + u)
    psi' = w3 - u phi' = w3 - a + (a/2) (P + M),      M = (1 - u0)/(1 - u)
    P, M = 1 + (h/l - 1) r sn^2/(cn^2 + r sn^2),  r = k'^2 l/h,  h = 1 +- u0, l = 1 +- u1
Steady precession at the rate W:  I1 W^2 cos theta - I3 w3 W + m g l = 0.
Source: Goldstein, Classical Mechanics, section 5.7.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import jacobi
from rigid_body_sim.exact.attitude import product, turn
from rigid_body_sim.exact.motion import Array, Rotation

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def cusped(
    t: ArrayLike,
    *,
    inertia_across: float,
    inertia_axial: float,
    weight_moment: float,
    spin: float,
    tilt: float,
) -> Rotation:
    """
    Top released with spin alone: its axis falls, precesses, and rises to a cusp again and again.

    At t = 0 the orientation is R_x(tilt) and the angular velocity (0, 0, spin) in body axes.

    t              : (*T) [s]
    inertia_across : [kg m^2]  I1, about the pivot
    inertia_axial  : [kg m^2]  I3
    weight_moment  : [N m]     m g l > 0 (centre of mass above the pivot when upright)
    spin           : [rad/s]   w3, not 0
    tilt           : [rad]     theta0 between 0 and pi, both excluded
    """
    t = np.asarray(t, dtype=float)
    a, beta = inertia_axial * spin / inertia_across, 2.0 * weight_moment / inertia_across
    fall, gap, depth = _roots(a, beta, tilt)
    lam, k_c = 0.5 * np.sqrt(beta * (fall + gap)), float(np.sqrt(gap / (fall + gap)))
    phase = jacobi.reduce(lam * t, jacobi.quarter_period(k_c))
    f = jacobi.functions(phase, k_c)
    sd2, cd2 = (k_c * f.sn / f.dn) ** 2, (f.cn / f.dn) ** 2
    over, under = 2.0 * np.cos(0.5 * tilt) ** 2, 2.0 * np.sin(0.5 * tilt) ** 2  # 1 + u0, 1 - u0

    def pole(highest: float, lowest: float) -> Array:
        """Integral over time of (1 +- u0)/(1 +- u), from 1 +- u at u0 and at u1."""
        ratio = k_c**2 * lowest / highest
        part = jacobi.third_kind(phase, f, p=f.cn**2 + ratio * f.sn**2, p_quarter=ratio, k_c=k_c)
        return t + (highest / lowest - 1.0) * ratio * part / lam

    up, down = pole(over, depth), pole(under, under + fall)
    phi, psi = 0.5 * a * (up - down), (spin - a) * t + 0.5 * a * (up + down)
    above, below = depth + fall * cd2, under + fall * sd2  # 1 + u, 1 - u
    sine = np.sqrt(above * below)
    theta_rate = 2.0 * lam * fall * k_c**2 * f.sn * f.cn / (f.dn**3 * sine)
    across = a * fall * sd2 / sine  # phi' sin theta
    turned = product(product(turn(Z, phi), turn(X, 2.0 * np.arctan2(below, sine))), turn(Z, psi))
    return Rotation(
        turned,
        np.stack(
            [
                across * np.sin(psi) + theta_rate * np.cos(psi),
                across * np.cos(psi) - theta_rate * np.sin(psi),
                np.full(t.shape, spin),
            ],
            axis=-1,
        ),
    )


def _roots(a: float, beta: float, tilt: float) -> tuple[float, float, float]:
    """
    Return u0 - u1, u3 - u0 and 1 + u1, all positive, without cancellation.

    beta d^2 + b d - beta sin^2(tilt) = 0,  d = u0 - u,  b = a^2 - 2 beta cos(tilt)
    beta y^2 - c y + a^2 (1 + u0) = 0,      y = 1 + u,   c = a^2 + 2 beta
    The larger root in size first, the other from the product.
    """
    b, c = a**2 - 2.0 * beta * np.cos(tilt), a**2 + 2.0 * beta
    discriminant = np.hypot(b, 2.0 * beta * np.sin(tilt))  # the same for both
    larger = (abs(b) + discriminant) / (2.0 * beta)
    smaller = np.sin(tilt) ** 2 / larger
    depth = 4.0 * (a * np.cos(0.5 * tilt)) ** 2 / (c + discriminant)
    return (smaller, larger, depth) if b >= 0.0 else (larger, smaller, depth)


def spin_for(
    precession: float,
    *,
    inertia_across: float,
    inertia_axial: float,
    weight_moment: float,
    tilt: float,
) -> float:
    """
    Spin w3 [rad/s] at which a top of given tilt [rad] precesses steadily at a rate [rad/s].

    w3 = (m g l + I1 W^2 cos theta)/(I3 W)
    """
    torque = weight_moment + inertia_across * precession**2 * np.cos(tilt)
    return float(torque / (inertia_axial * precession))


def slow_precession(
    spin: float, *, inertia_across: float, inertia_axial: float, weight_moment: float, tilt: float
) -> float:
    """
    Slower of the two steady precession rates W [rad/s] for a spin w3 [rad/s]; nan if none.

    W = 2 m g l/(I3 w3 + sqrt((I3 w3)^2 - 4 I1 m g l cos theta)), for spin > 0
    """
    momentum = inertia_axial * spin
    below = momentum**2 - 4.0 * inertia_across * weight_moment * np.cos(tilt)
    root = np.copysign(np.sqrt(below), momentum) if below >= 0.0 else np.nan
    return float(2.0 * weight_moment / (momentum + root))


def steady(t: ArrayLike, *, precession: float, spin: float, tilt: float) -> Rotation:
    """
    Steady precession: R = R_z(W t) R_x(theta) R_z(psi), psi = (w3 - W cos theta) t.

    t          : (*T) [s]
    precession : [rad/s]  W
    spin       : [rad/s]  w3; `spin_for` and `slow_precession` give matching pairs
    tilt       : [rad]    theta
    """
    t = np.asarray(t, dtype=float)
    psi = (spin - precession * np.cos(tilt)) * t
    across = precession * np.sin(tilt)
    return Rotation(
        product(product(turn(Z, precession * t), turn(X, tilt)), turn(Z, psi)),
        np.stack([across * np.sin(psi), across * np.cos(psi), np.full(t.shape, spin)], axis=-1),
    )
