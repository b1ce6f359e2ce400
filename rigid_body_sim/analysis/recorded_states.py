# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Poses and twists of a scene to whole states: rates in body axes, momenta, angular momenta.

    w_B = R^T w,   p = m v,   L = R I w_B          m, I : those at the time of the state
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.model import rotation as so3
from rigid_body_sim.physics.model.inertia_over_time import along
from rigid_body_sim.physics.model.plain_products import times
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.model.variable_mass import flow_of, mass_at, masses_at
from rigid_body_sim.physics.state import snapshot

Array = NDArray[np.float64]


@np.errstate(all='ignore')
def complete(scene: Scene, values: Array, time: Array) -> Array | None:
    """
    Put into the rows of states what follows from their poses and twists.

    values : (m, n, COLUMNS)  rows of `snapshot.body`, poses and twists in world axes filled in
    time   : (m,) [s]         since the scene began
    returns : masses (m, n) [kg]; None where the mass of no body changes
    """
    for i, body in enumerate(scene.bodies):
        out = values[:, i]
        q = out[:, snapshot.ORIENTATION : snapshot.VELOCITY]
        v = out[:, snapshot.VELOCITY : snapshot.ANGULAR_VELOCITY]
        w = out[:, snapshot.ANGULAR_VELOCITY : snapshot.ANGULAR_VELOCITY_BODY]
        out[:, snapshot.MOMENTUM :] = 0.0
        w_body = so3.rotate_back(q, w)
        out[:, snapshot.ANGULAR_VELOCITY_BODY : snapshot.MOMENTUM] = w_body
        if body.fixed:
            continue
        mass = np.full(len(time), body.mass)
        if flow_of(body) is not None:
            mass = np.array([mass_at(body, now) for now in time.tolist()])
        out[:, snapshot.MOMENTUM : snapshot.ANGULAR_MOMENTUM] = mass[:, None] * v
        if body.inertia is not None:
            changing = along(body, time)
            spin = times(body.inertia, w_body) if changing is None else w_body * changing[0]
            turned = so3.rotate(q, spin) * (mass / body.mass)[:, None]
            out[:, snapshot.ANGULAR_MOMENTUM : snapshot.COLUMNS] = turned
    if not any(flow_of(body) is not None for body in scene.bodies):
        return None
    return np.array([masses_at(scene.bodies, now) for now in time.tolist()])
