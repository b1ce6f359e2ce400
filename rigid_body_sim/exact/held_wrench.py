# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Held wrenches: a constant force at the centre of mass, a constant torque about a principal axis.

r = r0 + v0 t + (F/m) t^2/2,   angle = w0 t + (tau/I) t^2/2
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.exact.attitude import IDENTITY, product, turn
from rigid_body_sim.exact.ballistic import flight
from rigid_body_sim.exact.motion import Rotation, Translation


def held_force(
    t: ArrayLike,
    *,
    mass: float,
    force: ArrayLike,
    position: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
) -> Translation:
    """
    Position and velocity under a constant force.

    t        : (*T) [s]
    mass     : [kg]
    force    : (d,) [N]    world
    position : (d,) [m]    at t = 0, world
    velocity : (d,) [m/s]  at t = 0, world
    """
    acceleration = np.asarray(force, dtype=float) / mass
    return flight(t, position=position, velocity=velocity, acceleration=acceleration)


def held_torque(
    t: ArrayLike,
    *,
    axis: int,
    inertia: float,
    torque: float,
    angular_velocity: float = 0.0,
    orientation: ArrayLike = IDENTITY,
) -> Rotation:
    """
    Rotation about a principal axis under a constant torque about that axis.

    The axis stays where it is in the world, so the torque may be held in world or in body axes.

    t                : (*T) [s]
    axis             : 0, 1 or 2  body axis, principal
    inertia          : [kg m^2]   moment about it
    torque           : [N m]      about it
    angular_velocity : [rad/s]    about it, at t = 0
    orientation      : (4,) [-]   at t = 0, xyzw, body to world
    """
    t = np.asarray(t, dtype=float)
    e = np.eye(3)[axis]
    angle = t * (angular_velocity + 0.5 * (torque / inertia) * t)
    rate = angular_velocity + (torque / inertia) * t
    return Rotation(product(orientation, turn(e, angle)), rate[..., np.newaxis] * e)
