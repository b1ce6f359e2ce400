# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Damped oscillator with a constant force: under, critically and over damped, any stiffness.

m x'' = -k x - c x' + F
    x : [m]  m : [kg]  k : [N/m]  c : [N s/m]  F : [N]
(x, v)(h) = Phi (x0, v0) + (Psi, Psi') F/m,  with g = c/(2m), w0^2 = k/m:
    g < w0 : w = sqrt(w0^2 - g^2),  C = e^(-g h) cos w h,  S = e^(-g h) sin(w h)/w,
             Phi = [[C + g S, S], [-w0^2 S, C - g S]]
    g >= w0: kap = sqrt(g^2 - w0^2),  lam = -w0^2/(g + kap)  (slow exponent),
             E = e^(-2 kap h),  D = (1 - E)/(2 kap)  (h when kap = 0),
             Phi = e^(lam h) [[1 - lam D, D], [-w0^2 D, E + lam D]]
The second form is the first with hyperbolic functions, written so that nothing overflows and no
nearly equal numbers are subtracted. k = 0 is its limit: v decays, x tends to a constant.
A constant force gives Psi = (1 - Phi_11)/w0^2 and Psi' = Phi_12. With p1(x) = (1 - e^-x)/x that is
    g < w0 : (1 - C - g S)/w0^2
    g >= w0: (h p1(-lam h) - D e^(lam h))/(g + kap)
    2 g h < 1 and w0 h < 1: its powers of h, from Psi'' = 1 - 2 g Psi' - w0^2 Psi
so that a soft spring keeps all digits, and k = 0 is free motion with damping.
Source: textbook; Landau and Lifshitz, Mechanics, section 25.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import quotients
from rigid_body_sim.exact.motion import Array, Translation

SHORT = 1.0  # [-] 2 g h and w0 h below which powers of h are summed: the rest is 2^20/22!
POWERS = 22


def propagator(h: ArrayLike, *, mass: float, stiffness: float, damping: float = 0.0) -> Array:
    """
    Matrix that carries (displacement from equilibrium [m], velocity [m/s]) over a time.

    h         : (*T) [s]
    mass      : [kg]     > 0
    stiffness : [N/m]    >= 0
    damping   : [N s/m]  >= 0
    returns   : (*T, 2, 2)
    """
    h = np.asarray(h, dtype=float)
    g, w0 = damping / (2.0 * mass), np.sqrt(stiffness / mass)
    if g < w0:
        w = np.sqrt((w0 - g) * (w0 + g))
        cosine, sine = np.exp(-g * h) * np.cos(w * h), np.exp(-g * h) * np.sin(w * h) / w
        rows = [[cosine + g * sine, sine], [-(w0**2) * sine, cosine - g * sine]]
    else:
        kap = np.sqrt((g - w0) * (g + w0))
        lam = -(w0**2) / (g + kap) if g > 0.0 else 0.0
        fast, slow = np.exp(-2.0 * kap * h), np.exp(lam * h)
        gain = -np.expm1(-2.0 * kap * h) / (2.0 * kap) if kap > 0.0 else h
        rows = [
            [slow * (1.0 - lam * gain), slow * gain],
            [-(w0**2) * slow * gain, slow * (fast + lam * gain)],
        ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def oscillation(
    t: ArrayLike,
    *,
    mass: float,
    stiffness: float,
    damping: float = 0.0,
    force: ArrayLike = 0.0,
    position: ArrayLike,
    velocity: ArrayLike = 0.0,
) -> Translation:
    """
    Motion of a point on a linear spring of zero rest length, held at the origin.

    t         : (*T) [s]
    mass      : [kg]     > 0
    stiffness : [N/m]    >= 0
    damping   : [N s/m]  >= 0
    force     : (d,) [N]    constant, world
    position  : (d,) [m]    at t = 0, from the anchor
    velocity  : (d,) [m/s]  at t = 0
    A scalar force, position and velocity mean d = 1.
    """
    x0, v0, f = np.broadcast_arrays(*(np.atleast_1d(x) for x in (position, velocity, force)))
    phi = propagator(t, mass=mass, stiffness=stiffness, damping=damping)
    by_force = _response(np.asarray(t, dtype=float), phi, mass, stiffness, damping)
    way, rate = by_force[..., np.newaxis], phi[..., 0, 1, np.newaxis]
    state = np.einsum('...ij,jd->...id', phi, np.stack([x0, v0]))
    return Translation(state[..., 0, :] + way * f / mass, state[..., 1, :] + rate * f / mass)


def _response(h: Array, phi: Array, mass: float, stiffness: float, damping: float) -> Array:
    """Displacement Psi (*T) [s^2] from rest, after h (*T) [s] of a force of one newton per kg."""
    g, w0 = damping / (2.0 * mass), np.sqrt(stiffness / mass)
    short = np.maximum(2.0 * g, w0) * np.abs(h) < SHORT
    long = np.where(short, 0.0, h)
    if g < w0:
        direct = (1.0 - phi[..., 0, 0]) / w0**2
    elif g > 0.0:
        kap = np.sqrt((g - w0) * (g + w0))
        lam = -(w0**2) / (g + kap)
        gain = long * quotients.decay_once(2.0 * kap * long)
        direct = long * quotients.decay_once(-lam * long) - gain * np.exp(lam * long)
        direct = direct / (g + kap)
    else:  # neither spring nor damping: all times are short
        direct = np.zeros_like(h)
    return np.where(short, _powers_of_time(np.where(short, h, 0.0), g, w0), direct)


def _powers_of_time(h: Array, g: float, w0: float) -> Array:
    """Psi by its Taylor series: (n+1) (n+2) a_(n+2) = -2 g (n+1) a_(n+1) - w0^2 a_n, 2 a_2 = 1."""
    before, now = np.zeros_like(h), 0.5 * h**2  # terms a_n h^n
    total = now.copy()
    for n in range(1, POWERS):
        before, now = (
            now,
            (-2.0 * g * h * now / (n + 2) - (w0 * h) ** 2 * before / (n + 1) / (n + 2)),
        )
        total += now
    return total
