# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The exact motion of linear oscillators over a time h.

    s'' = -k s - c s' + b          mass one, k >= 0, c >= 0, b constant
    (s, s') <- Phi (s, s') + (Psi_r, Psi_v) b

        g = c/2, k = w0^2:
        Phi = [[C + g S, S], [-k S, C - g S]],   Psi_r = integral of S,   Psi_v = S
        w0 > g : C = exp(-g h) cos(w h), S = exp(-g h) sin(w h) / w,  w^2 = w0^2 - g^2
        w0 < g : C, S from the exponentials of slow = -k/(g + q) and fast = -(g + q),  q^2 = g^2 -
        w0^2
        w0 = g : C = exp(-g h), S = h exp(-g h); near it the series of sine and cosine

Never cosh and sinh beside exp(-g h), which overflow, and never q - g, which cancels. Right to
round-off for any k, c and h, k = 0 and c = 0 among them. Source: textbook; checked against the
matrix exponential.

Several oscillators, M s'' = -K s - C s' + M b, are taken apart into such ones where K and C have
common modes, and by the
matrix exponential (Higham, 2005; scipy) where they have not.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SERIES = 0.1  # [-] |w0^2 - g^2| h^2 up to which eight terms of the series are right to round-off
SLOW = 1.0  # [-] w0 h and c h up to which Psi_r is taken as a power series: so k = 0 too is served
ZERO = 1e-12  # [-] least stiffness of a mode, relative, where it may be nothing but rounding
COMMON = (
    1e-13  # [-] largest entry beside the diagonal, relative, of matrices that count as diagonal
)


def oscillator(k: float, c: float, h: float) -> tuple[float, ...]:
    """
    Give the motion of one oscillator over h.

        returns : Phi_rr, Phi_rv, Phi_vr, Phi_vv, Psi_r, Psi_v, Phi_rr - 1, Phi_vv - 1; each right
                  to its own last digits
    """
    g = 0.5 * c
    root = math.sqrt(k)
    delta = (root - g) * (root + g) * h * h
    if abs(delta) <= SERIES:
        decay = math.exp(-g * h)
        cosine, sine = _series(delta)
        big_c, big_s = decay * cosine, decay * h * sine
        rr, vv = big_c + g * big_s, big_c - g * big_s
        psi = _displacement(k, c, h) if max(root, c) * h <= SLOW else (1.0 - rr) / k
    elif delta > 0.0:
        w = math.sqrt(delta) / h
        decay = math.exp(-g * h)
        big_c, big_s = decay * math.cos(w * h), decay * math.sin(w * h) / w
        rr, vv = big_c + g * big_s, big_c - g * big_s
        psi = _displacement(k, c, h) if max(root, c) * h <= SLOW else (1.0 - rr) / k
    else:
        q = math.sqrt(-delta) / h
        slow, fast = -k / (g + q), -(g + q)
        small = k / (2.0 * q * (g + q))  # (g / q - 1) / 2
        rr = (1.0 + small) * math.exp(slow * h) - small * math.exp(fast * h)
        vv = (1.0 + small) * math.exp(fast * h) - small * math.exp(slow * h)
        big_s = math.exp(slow * h) * -math.expm1((fast - slow) * h) / (2.0 * q)
        ratio = math.expm1(slow * h) / (slow * h) if slow != 0.0 else 1.0
        psi = 0.5 * (1.0 + g / q) * h * ratio / (g + q) + math.expm1(fast * h) / (
            2.0 * q * (q + g)
        )
    return rr, big_s, -k * big_s, vv, psi, big_s, -k * psi, -k * psi - c * big_s


def _series(delta: float) -> tuple[float, float]:
    """Give cos x and sin x / x of x^2 = delta of either sign."""
    cosine = sine = 1.0
    for n in range(8, 0, -1):
        cosine = 1.0 - cosine * delta / ((2 * n - 1) * 2 * n)
        sine = 1.0 - sine * delta / (2 * n * (2 * n + 1))
    return cosine, sine


def _displacement(k: float, c: float, h: float) -> float:
    """
    Give the displacement from rest under b = 1 as a power series in h, for small k h^2 and c h.
    """
    term, before, total = 0.5 * h * h, 0.0, 0.0
    for n in range(2, 26):
        total += term
        term, before = -(c * h * term / (n + 1) + k * h * h * before / ((n + 1) * n)), term
    return total


def system(
    masses: Array, stiffness: Array, damping: Array, h: float, *, drifts: bool
) -> tuple[Array, ...]:
    """
    Give the motion of coupled oscillators over h.

        masses             : (n,) [kg]
        stiffness, damping : (n, n) [N/m], [N s/m], symmetric, positive semidefinite
        drifts             : nothing holds the whole: a mode without stiffness is exactly so
        returns            : eight (n, n) matrices, as `oscillator`; b in m/s^2
    """
    root = np.sqrt(masses)
    k = stiffness / np.outer(root, root)
    c = damping / np.outer(root, root)
    _, modes = (
        np.linalg.eigh(_unit(k) + math.sqrt(2.0) * _unit(c)) if len(masses) > 1 else (0, np.eye(1))
    )
    k_modes, c_modes = modes.T @ k @ modes, modes.T @ c @ modes
    if _is_diagonal(k_modes) and _is_diagonal(c_modes):
        k_least = ZERO * np.abs(k).max() if drifts else 0.0
        c_least = ZERO * np.abs(c).max() if drifts else 0.0
        entries = [
            oscillator(a if a > k_least else 0.0, b if b > c_least else 0.0, h)
            for a, b in zip(np.diag(k_modes).tolist(), np.diag(c_modes).tolist(), strict=True)
        ]
        parts = [modes @ np.diag(column) @ modes.T for column in np.array(entries).T]
    else:
        parts = _exponential(k, c, h)
    return tuple(part * (root[None, :] / root[:, None]) for part in parts)


def _unit(matrix: Array) -> Array:
    size = float(np.abs(matrix).max())
    return matrix / size if size > 0.0 else matrix


def _is_diagonal(matrix: Array) -> bool:
    rest = np.abs(matrix - np.diag(np.diag(matrix))).max()
    return bool(rest <= COMMON * np.abs(matrix).max())


def _exponential(k: Array, c: Array, h: float) -> list[Array]:
    from scipy.linalg import expm  # a tenth of a second to import: only where it is needed

    n = len(k)
    zero, one = np.zeros((n, n)), np.eye(n)
    whole = expm(h * np.block([[zero, one, zero], [-k, -c, one], [zero, zero, zero]]))
    rr, rv, psi_r = whole[:n, :n], whole[:n, n : 2 * n], whole[:n, 2 * n :]
    vr, vv, psi_v = whole[n : 2 * n, :n], whole[n : 2 * n, n : 2 * n], whole[n : 2 * n, 2 * n :]
    return [rr, rv, vr, vv, psi_r, psi_v, rr - one, vv - one]
