# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Accelerations at one instant, from the forces that act then.

    a = F/m,   alpha_B = I^-1 (T_B - omega_B x L_B - I' omega_B),   alpha = q alpha_B q*
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.compile.kernels import argument
from rigid_body_sim.physics.forces.acting_elements import ActingElements
from rigid_body_sim.physics.integration.schemes.steps import start_evaluation
from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import rates_at
from rigid_body_sim.physics.model.plain_products import cross
from rigid_body_sim.physics.state.blocks import (
    ANGULAR_MOMENTUM,
    FORCE,
    INVERSE_MASS,
    MOMENTS,
    ORIENTATION,
    ROTATION,
    TORQUE,
    TRANSLATION,
    gather,
)
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]


@np.errstate(all='ignore')  # a state on its way to infinity
def accelerations_now(
    layout: Layout, acting: ActingElements, translation: Array, rotation: Array, *, time: float
) -> tuple[Array, Array]:
    """
    Evaluate everything that acts at a time [s]; the blocks stay as they are.

    returns : linear (n_moving, 3) [m/s^2] and angular (n_rigid, 3) [rad/s^2], core order, world
              axes
    """
    translation, rotation = translation.copy(), rotation.copy()
    n, n_rigid = layout.n_moving, layout.n_rigid
    arrays = (argument(translation), argument(rotation))
    start_evaluation(n, n_rigid, *arrays)
    acting.evaluate()(0, time, *arrays, *acting.arguments)
    linear = gather(translation, TRANSLATION, FORCE, 3, n) * gather(
        translation, TRANSLATION, INVERSE_MASS, 1, n
    )
    q = gather(rotation, ROTATION, ORIENTATION, 4, n_rigid)
    momentum, torque = (
        so3.rotate_back(q, gather(rotation, ROTATION, x, 3, n_rigid))
        for x in (ANGULAR_MOMENTUM, TORQUE)
    )
    moments = gather(rotation, ROTATION, MOMENTS, 3, n_rigid)  # those of the instant
    omega = momentum / moments
    spin = torque - cross(omega, momentum)
    for core in range(n_rigid):
        law = layout.body(core).inertia_over_time
        if law is not None:
            spin[core] -= rates_at(law, time) * omega[core]
    angular = so3.rotate(q, spin / moments)
    if acting.pivots.count:
        acting.pivots.accelerate(linear, angular, q, so3.rotate(q, omega))
    return linear, angular
