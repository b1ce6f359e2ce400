# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Accelerations at one instant, from the forces that act then.

    a = F/m,   alpha_B = I^-1 (T_B - omega_B x L_B),   alpha = q alpha_B q*
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics import rotation as so3
from rigid_body_sim.physics.blocks import FX, IM, LX, QX, ROTATION, TRANSLATION, TX, gather
from rigid_body_sim.physics.forces.pivot import Pivots
from rigid_body_sim.physics.kernels import argument
from rigid_body_sim.physics.layout import Layout
from rigid_body_sim.physics.schemes.steps import start_evaluation

Array = NDArray[np.float64]


def accelerations_now(
    layout: Layout,
    pivots: Pivots,
    translation: Array,
    rotation: Array,
    evaluate: Callable[..., Any],
    time: float,
    elements: Any,
    ranges: Any,
) -> tuple[Array, Array]:
    """
    Evaluate everything that acts; the blocks stay as they are.

    evaluate, elements, ranges : kernel of the force elements and its tables
    returns : linear (n_moving, 3) [m/s^2] and angular (n_rigid, 3) [rad/s^2], core order, world
    """
    translation, rotation = translation.copy(), rotation.copy()
    n, n_rigid = layout.n_moving, layout.n_rigid
    arrays = (argument(translation), argument(rotation))
    start_evaluation(n, n_rigid, *arrays)
    evaluate(0, time, *arrays, elements, ranges)
    linear = gather(translation, TRANSLATION, FX, 3, n) * gather(
        translation, TRANSLATION, IM, 1, n
    )
    q = gather(rotation, ROTATION, QX, 4, n_rigid)
    momentum, torque = (
        so3.rotate_back(q, gather(rotation, ROTATION, x, 3, n_rigid)) for x in (LX, TX)
    )
    omega = momentum / layout.moments
    angular = so3.rotate(q, (torque - np.cross(omega, momentum)) / layout.moments)
    pivots.accelerate(linear, angular, q, so3.rotate(q, omega))
    return linear, angular
