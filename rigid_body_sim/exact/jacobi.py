# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Jacobi elliptic functions of real argument, and the integral of the third kind.

sn, cn, dn (u | k) by the arithmetic-geometric mean; K(k) = pi/(2 agm(1, k'))
    k' = sqrt(1 - k^2): given directly, so that a modulus near 1 keeps its digits
k' = 0 is the limit sn = tanh, cn = dn = 1/cosh, K infinite.
Source: Bulirsch 1965 (descending Landen transformation); DLMF chapters 19 (Carlson) and 22.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import elliprf, elliprj

from rigid_body_sim.exact.motion import Array

AGM_TOLERANCE = 1e-8  # [-] the error after one more mean is its square: below round-off
SMALLEST = 1e-300  # [-] keeps R_J away from two zero arguments where 1/cosh^2 underflows


class Jacobi(NamedTuple):
    """The three functions at one argument: sn, cn, dn, each (...) [-]."""

    sn: Array
    cn: Array
    dn: Array


class Phase(NamedTuple):
    """
    An argument taken apart: u = 2 K `half_turns` + `rest`, |rest| <= K.

    half_turns : (...) whole numbers
    rest       : (...) [-]
    """

    half_turns: Array
    rest: Array


def quarter_period(k_c: float) -> float:
    """Complete integral K for the complementary modulus k_c = k' >= 0; infinite for 0."""
    if k_c == 0.0:
        return float('inf')
    a, b = 1.0, k_c
    while abs(a - b) > AGM_TOLERANCE * a:
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return float(np.pi / (a + b))


def reduce(u: ArrayLike, quarter: float) -> Phase:
    """Take whole periods 2 K of sn^2 off the argument; K = `quarter`."""
    u = np.asarray(u, dtype=float)
    if np.isinf(quarter):
        return Phase(np.zeros_like(u), u)
    half_turns = np.rint(u / (2.0 * quarter))
    return Phase(half_turns, u - 2.0 * quarter * half_turns)


def functions(phase: Phase, k_c: float) -> Jacobi:
    """sn, cn, dn at a reduced argument, for the complementary modulus k_c = k' in [0, 1]."""
    half_turn = 1.0 - 2.0 * (phase.half_turns % 2.0)  # sn(u + 2K) = -sn u, cn likewise
    sn, cn, dn = _separatrix(phase.rest) if k_c == 0.0 else _landen(phase.rest, k_c)
    return Jacobi(half_turn * sn, half_turn * cn, dn)


def _separatrix(u: Array) -> Jacobi:
    sech = 1.0 / np.cosh(np.clip(u, -700.0, 700.0))  # cosh overflows beyond 710
    return Jacobi(np.tanh(u), sech, sech)


def _landen(u: Array, k_c: float) -> Jacobi:
    """Bulirsch's form of the descending Landen transformation."""
    means, a, b = [], 1.0, k_c
    while True:
        means.append((a, b))
        g = 0.5 * (a + b)
        if abs(a - b) <= AGM_TOLERANCE * a:
            break
        a, b = g, np.sqrt(a * b)
    sine, cosine = np.sin(g * u), np.cos(g * u)
    zero = np.abs(sine) < 1e-100  # [-] its inverse squared would overflow
    q = cosine / np.where(zero, 1.0, sine)
    c, d = g * q, np.ones_like(u)
    for mean, geometric in reversed(means):
        q = c * q
        c = d * c
        d = (geometric + q) / (mean + q)
        q = c / mean
    sn = np.copysign(1.0 / np.sqrt(c * c + 1.0), sine)
    return Jacobi(np.where(zero, 0.0, sn), np.where(zero, cosine, c * sn), np.where(zero, 1.0, d))


def argument(f: Jacobi, quarter: float) -> float:
    """
    Invert: the u in (-K, 2K + K) at which the three functions take these values.

    u = sn R_F(cn^2, dn^2, 1) in the half period where cn >= 0; on the other side 2K - u.
    """
    u = float(f.sn * elliprf(f.cn**2, f.dn**2, 1.0))
    return u if f.cn >= 0.0 else 2.0 * quarter - u


def third_kind(phase: Phase, f: Jacobi, *, p: ArrayLike, p_quarter: float, k_c: float) -> Array:
    """
    Integral of sn^2/p from 0: the part of Legendre's third kind that a precession needs.

    J(u) = int_0^u sn^2/p du,  p = 1 - n sn^2
         = sn^3/3 R_J(cn^2, dn^2, 1, p) on |u| <= K, odd there, and 2 J(K) more per half turn
        f         : the functions at u
        p         : (...) [-] at u, computed by the caller as a sum of positive terms
        p_quarter : [-]       its value at u = K, 1 - n
    """
    cn2, dn2 = np.maximum(f.cn**2, SMALLEST), np.maximum(f.dn**2, SMALLEST)
    part = np.copysign(np.abs(f.sn) ** 3, phase.rest) / 3.0 * elliprj(cn2, dn2, 1.0, p)
    if k_c == 0.0:
        return part
    return part + 2.0 * phase.half_turns * elliprj(0.0, k_c**2, 1.0, p_quarter) / 3.0
