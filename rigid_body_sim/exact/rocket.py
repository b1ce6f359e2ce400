# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Vertical rocket with constant mass flow in uniform gravity.

v = v0 + v_e ln(m0/m) - g t,   m = m0 - mu t
z = z0 + v0 t + v_e t - v_e (m/mu) ln(m0/m) - g t^2/2    (no digit is lost at small mu t/m0)
    m0 : [kg]  mu : [kg/s] mass flow out  v_e : [m/s] exhaust speed  g : [m/s^2]
Valid while m > 0. Source: Tsiolkovsky.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact import quotients
from rigid_body_sim.exact.motion import Translation, column


def ascent(
    t: ArrayLike,
    *,
    mass: float,
    mass_flow: float,
    exhaust_speed: float,
    gravity: float = 0.0,
    height: float = 0.0,
    speed: float = 0.0,
) -> Translation:
    """
    Height and upward speed of a rocket.

    t             : (*T) [s]  t < mass/mass_flow
    mass          : [kg]      at t = 0
    mass_flow     : [kg/s]    >= 0, leaving the rocket
    exhaust_speed : [m/s]     relative to the rocket
    gravity       : [m/s^2]   downwards
    height, speed : [m], [m/s] at t = 0, upwards
    returns d = 1
    """
    s = column(t)
    burnt = mass_flow * s / mass
    log_ratio = -np.log1p(-burnt)
    thrown = exhaust_speed * s * quotients.burnt(burnt)  # [m] gained by thrust
    return Translation(
        height + (speed - 0.5 * gravity * s) * s + thrown,
        speed + exhaust_speed * log_ratio - gravity * s,
    )
