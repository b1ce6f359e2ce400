# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Accelerations of bodies that may touch: of what acts at this instant, and of the contacts.

    a     = F/m + sum J / (m dt)
    alpha = alpha_F + R I^-1 R^T sum (x - r) x J / dt
        J, x   : [N s, m]  impulse of a contact over the last tick, and where it acted
        F      : all that acts otherwise at the start of the coming tick, see
                 `Simulation.accelerations`
        I, R   : inertia about the centre of mass r, body axes, and the attitude

A contact is known as the impulse of a tick, so its force is the mean over the last one; before
the first tick, and after a reset, nothing is known of it: what lies on a floor seems to fall.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import inertia_at
from rigid_body_sim.physics.simulation import Simulation

Array = NDArray[np.float64]


def felt_accelerations(simulation: Simulation) -> tuple[Array, Array]:
    """
    Give linear [m/s^2] and angular [rad/s^2] accelerations, (n, 3) each, scene order, world axes.
    """
    linear, angular = simulation.accelerations()
    if not simulation.has_contact:
        return linear, angular
    found = simulation.contacts()
    force, torque = np.zeros_like(linear), np.zeros_like(angular)
    state = simulation.state
    for side, sign in ((0, -1.0), (1, 1.0)):
        body = found.bodies[:, side]
        pushed = sign * found.impulse / simulation.dt
        np.add.at(force, body, pushed)
        np.add.at(torque, body, np.cross(found.point - state.position[body], pushed))
    for i, body in enumerate(simulation.scene.bodies):
        if body.fixed or not (force[i].any() or torque[i].any()):
            continue
        mass = body.mass if state.masses is None else float(state.masses[i])
        linear[i] += force[i] / mass
        inertia = inertia_at(body, simulation.scene_time)
        if inertia is None:
            continue
        q = state.orientation[i]
        turn = np.linalg.solve(inertia, so3.rotate_back(q, torque[i]))
        angular[i] += so3.rotate(q, turn)
    return linear, angular
