# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Physical pendulum released from rest: a body that swings about a fixed horizontal axis.

    theta'' = -w0^2 sin theta,   w0^2 = m g l/I          theta from the lowest position
    sin(theta/2) = k cd(w0 t),   cos(theta/2) = k'/dn,   k = sin(theta0/2), k' = cos(theta0/2)
    theta' = -2 k k' w0 sn/dn                            sn, cn, dn at w0 t
    period = 4 K(k)/w0
        I     : [kg m^2] moment of inertia about the axis
        m g l : [N m]    weight times distance from axis to centre of mass
Source: Landau & Lifshitz, Mechanics, section 11, problem 1; DLMF 22.19.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import jacobi
from rigid_body_sim.exact.motion import Array


class Swing(NamedTuple):
    """Angle from the lowest position and its rate, each (*T) [rad], [rad/s]."""

    angle: Array
    rate: Array


def swing(t: ArrayLike, *, inertia: float, weight_moment: float, angle: float) -> Swing:
    """
    Swing of a pendulum released from rest.

    t             : (*T) [s]
    inertia       : [kg m^2]  I, about the axis
    weight_moment : [N m]     m g l > 0
    angle         : [rad]     theta0 between -pi and pi, both excluded
    """
    rate = np.sqrt(weight_moment / inertia)
    k, k_c = np.sin(0.5 * angle), float(np.cos(0.5 * angle))
    f = jacobi.functions(
        jacobi.reduce(rate * np.asarray(t, dtype=float), jacobi.quarter_period(k_c)), k_c
    )
    return Swing(2.0 * np.arctan2(k * f.cn, k_c), -2.0 * k * k_c * rate * f.sn / f.dn)


def period(*, inertia: float, weight_moment: float, angle: float) -> float:
    """Period [s]; arguments as for `swing`."""
    quarter = jacobi.quarter_period(float(np.cos(0.5 * angle)))
    return 4.0 * quarter * float(np.sqrt(inertia / weight_moment))
