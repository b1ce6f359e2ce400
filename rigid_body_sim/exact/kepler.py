# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two bodies that attract each other: ellipses about their common centre of mass.

    r'' = -mu r/|r|^3,   mu = G (m_a + m_b),   r from A to B, at t = 0 nearest
    E - e sin E = n t,   n = sqrt(mu/a^3)                                  Kepler's equation
    r = a (cos E - e, sqrt(1 - e^2) sin E),   r' = n a^2/|r| (-sin E, sqrt(1 - e^2) cos E)
        a : [m] semi-major axis   e : [-] eccentricity, 0 <= e < 1   E : [rad] eccentric anomaly
    x_A = -m_b/(m_a + m_b) r,   x_B = m_a/(m_a + m_b) r
Source: Goldstein, Classical Mechanics, section 3.8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.motion import Array, Translation
from rigid_body_sim.exact.quotients import less_sine

SWEEPS = 50  # of Newton's iteration; four to eight are usual
SETTLED = 4.0 * float(np.finfo(float).eps)  # [-] of E: a smaller step is rounding


def eccentric_anomaly(mean: ArrayLike, *, eccentricity: float) -> Array:
    """
    Solve Kepler's equation for E.

    mean         : (*T) [rad]  n t
    eccentricity : [-]         0 <= e < 1
    returns      : (*T) [rad]
    """
    anomaly, turns = _anomaly(np.asarray(mean, dtype=float), eccentricity)
    return anomaly + turns


def _anomaly(mean: Array, e: float) -> tuple[Array, Array]:
    """
    Return E [rad] between -pi and pi, to round-off of itself, and the whole turns [rad] beside it.

    (1 - e) E + e (E - sin E) = M on 0..pi, whose terms are positive and convex. Each start is
    beyond the root, from where Newton's iteration comes back to it: E <= M + e, E <= M/(1 - e),
    and E^3 <= pi^2 M/e, as E - sin E >= E^3/pi^2.
    """
    if not 0.0 <= e < 1.0:
        raise ValueError(
            f'eccentricity {e:g}; allowed: 0 (circle) to below 1 (ellipse); '
            'parabolas and hyperbolas have no such closed form here'
        )
    turns = 2.0 * np.pi * np.round(mean / (2.0 * np.pi))
    m = np.abs(mean - turns)
    anomaly = np.minimum(m + e, m / (1.0 - e))
    if e > 0.0:
        anomaly = np.minimum(anomaly, np.cbrt(np.pi**2 * m / e))
    for _ in range(SWEEPS):
        beyond = (1.0 - e) * anomaly + e * less_sine(anomaly) - m
        step = beyond / _distance(anomaly, e)
        anomaly = anomaly - step
        if np.all(np.abs(step) <= SETTLED * anomaly):
            break
    return np.copysign(anomaly, mean - turns), turns


def _distance(anomaly: Array, e: float) -> Array:
    """Return |r|/a = 1 - e cos E [-], without loss near e = 1 and E = 0."""
    return (1.0 - e) + 2.0 * e * np.sin(0.5 * anomaly) ** 2


def relative(
    t: ArrayLike, *, parameter: float, semi_major_axis: float, eccentricity: float
) -> Translation:
    """
    Motion of B as A sees it, in the plane (x, y), nearest on the x axis at t = 0.

    t            : (*T) [s]
    parameter    : [m^3/s^2]  mu
    eccentricity : [-]        0 <= e < 1
    returns d = 3
    """
    a, e = semi_major_axis, eccentricity
    rate = np.sqrt(parameter / a**3)
    anomaly, _ = _anomaly(rate * np.asarray(t, dtype=float), e)
    sine, cosine = np.sin(anomaly), np.cos(anomaly)
    across = np.sqrt((1.0 - e) * (1.0 + e))
    zero = np.zeros_like(sine)
    along = (1.0 - e) - 2.0 * np.sin(0.5 * anomaly) ** 2  # cos E - e
    position = a * np.stack([along, across * sine, zero], axis=-1)
    speed = rate * a / _distance(anomaly, e)
    velocity = np.stack([-speed * sine, speed * across * cosine, zero], axis=-1)
    return Translation(position, velocity)


def period(*, parameter: float, semi_major_axis: float) -> float:
    """Period [s]: 2 pi sqrt(a^3/mu)."""
    return float(2.0 * np.pi * np.sqrt(semi_major_axis**3 / parameter))
