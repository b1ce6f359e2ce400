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

SWEEPS = 50  # of Newton's iteration; four to eight are usual


def eccentric_anomaly(mean: ArrayLike, *, eccentricity: float) -> Array:
    """Solve Kepler's equation for E [rad]; mean : (*T) [rad] n t."""
    m = np.asarray(mean, dtype=float)
    e = eccentricity
    turns = 2.0 * np.pi * np.round(m / (2.0 * np.pi))
    m = m - turns  # between -pi and pi
    anomaly = m + e * np.sign(m)  # from beyond the root Newton's iteration comes back to it
    for _ in range(SWEEPS):
        step = (anomaly - e * np.sin(anomaly) - m) / (1.0 - e * np.cos(anomaly))
        anomaly = anomaly - step
        if np.all(np.abs(step) <= 1e-16 * (1.0 + np.abs(anomaly))):
            break
    return anomaly + turns


def relative(
    t: ArrayLike, *, parameter: float, semi_major_axis: float, eccentricity: float
) -> Translation:
    """
    Motion of B as A sees it, in the plane (x, y), nearest on the x axis at t = 0.

    t         : (*T) [s]
    parameter : [m^3/s^2]  mu
    returns d = 3
    """
    a, e = semi_major_axis, eccentricity
    rate = np.sqrt(parameter / a**3)
    anomaly = eccentric_anomaly(rate * np.asarray(t, dtype=float), eccentricity=e)
    cosine, sine = np.cos(anomaly), np.sin(anomaly)
    across = np.sqrt((1.0 - e) * (1.0 + e))
    zero = np.zeros_like(cosine)
    position = a * np.stack([cosine - e, across * sine, zero], axis=-1)
    speed = rate * a / (1.0 - e * cosine)
    velocity = np.stack([-speed * sine, speed * across * cosine, zero], axis=-1)
    return Translation(position, velocity)


def period(*, parameter: float, semi_major_axis: float) -> float:
    """Period [s]: 2 pi sqrt(a^3/mu)."""
    return float(2.0 * np.pi * np.sqrt(semi_major_axis**3 / parameter))
