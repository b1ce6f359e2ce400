# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Accelerations of bodies that may touch: of what acts at this instant, and of the contacts.

    a     = a_F + F/m
    alpha = alpha_F + R I^-1 R^T T
        F, T         : [N], [N m]  of contacts, T about the centre of mass: `Contacts.wrenches`
        a_F, alpha_F : of all that acts otherwise at the start of the coming tick, see
                       `Simulation.accelerations`
        I, R         : inertia about the centre of mass, body axes, and the attitude

and of a body that turns about a pivot, see `model.pivot`:

    alpha = alpha_F + R I_O^-1 R^T (T + a x F),   a' = alpha x a + omega x (omega x a)
        a, I_O : [m]  arm from the pivot to the centre of mass, and the inertia about the pivot
        a'     : [m/s^2]  of the centre of mass

A contact is known as the impulse of a tick, so its force is the mean over the last one; before
the first tick, and after a reset, nothing is known of it: what lies on a floor seems to fall.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import inertia_at
from rigid_body_sim.physics.model.pivot import arm_of, inertia_of
from rigid_body_sim.physics.simulation import Simulation

Array = NDArray[np.float64]


def felt_accelerations(simulation: Simulation) -> tuple[Array, Array]:
    """
    Give linear [m/s^2] and angular [rad/s^2] accelerations, (n, 3) each, scene order, world axes.
    """
    linear, angular = simulation.accelerations()
    if not simulation.has_contact:
        return linear, angular
    forces, torques = simulation.contact_wrenches()
    state = simulation.state
    for i in np.flatnonzero(forces.any(axis=1) | torques.any(axis=1)):
        body = simulation.scene.bodies[i]
        if body.fixed:
            continue
        force, torque, q = forces[i], torques[i], state.orientation[i]
        if body.pivot is not None:
            arm, omega = so3.rotate(q, arm_of(body)), state.angular_velocity[i]
            angular[i] += _turn(inertia_of(body), q, torque + np.cross(arm, force))
            linear[i] = np.cross(angular[i], arm) + np.cross(omega, np.cross(omega, arm))
            continue
        linear[i] += force / (body.mass if state.masses is None else float(state.masses[i]))
        inertia = inertia_at(body, simulation.scene_time)
        if inertia is not None:
            angular[i] += _turn(inertia, q, torque)
    return linear, angular


def _turn(inertia: Array, q: Array, torque: Array) -> Array:
    """Angular acceleration [rad/s^2] by a torque [N m]: R I^-1 R^T T."""
    return so3.rotate(q, np.linalg.solve(inertia, so3.rotate_back(q, torque)))
