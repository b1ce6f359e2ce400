# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Torque-free symmetric top: it precesses about L at |L|/I1 and spins about its own axis.

R(t) = exp(t [L]/I1) R0 exp(t w3 (1 - I3/I1) [e3])
    I1 : [kg m^2] moment about any axis across, I3 about the symmetry axis e3 (body z)
    L  : [kg m^2/s] angular momentum, world, constant
    w3 : [rad/s] spin about e3, constant
Source: Landau and Lifshitz, Mechanics, section 33. Sphere, disc, rod: all included.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.attitude import IDENTITY, product, rotate, turn
from rigid_body_sim.exact.motion import Rotation

E3 = (0.0, 0.0, 1.0)


def rotation(
    t: ArrayLike,
    *,
    inertia_across: float,
    inertia_axial: float,
    angular_velocity_body: ArrayLike,
    orientation: ArrayLike = IDENTITY,
) -> Rotation:
    """
    Orientation and angular velocity of a free symmetric top.

    t                     : (*T) [s]
    inertia_across        : [kg m^2]     I1 = I2 > 0, about body x and y
    inertia_axial         : [kg m^2]     I3, about body z
    angular_velocity_body : (3,) [rad/s] at t = 0, body axes
    orientation           : (4,) [-]     at t = 0, xyzw, body to world
    """
    t = np.asarray(t, dtype=float)
    w1, w2, w3 = np.asarray(angular_velocity_body, dtype=float)
    L = rotate(orientation, (inertia_across * w1, inertia_across * w2, inertia_axial * w3))
    G = np.linalg.norm(L)
    spin = w3 * (inertia_across - inertia_axial) / inertia_across * t
    precession = turn(L / G if G > 0.0 else E3, G / inertia_across * t)
    across = np.stack(
        [w1 * np.cos(spin) + w2 * np.sin(spin), w2 * np.cos(spin) - w1 * np.sin(spin)], axis=-1
    )
    return Rotation(
        product(product(precession, orientation), turn(E3, spin)),
        np.concatenate([across, np.full((*t.shape, 1), w3)], axis=-1),
    )
