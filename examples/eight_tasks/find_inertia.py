# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The inertia of a satellite from its motion and the torques that made it: least squares."""

import numpy as np

import rigid_body_sim as rbs
from rigid_body_sim import rotation


def waves(t, state):
    torque = 0.1 * np.sin([1.1 * t, 1.7 * t, 2.3 * t])
    return {'satellite': rbs.Wrench(torque=torque, frame='body')}


body = rbs.simulate('satellite', duration=30, every=0.01, controller=waves)['satellite']
w, torque = body.angular_velocity_body[1:-1], rotation.rotate_back(body.orientation, body.torque)
a = (body.angular_velocity_body[2:] - body.angular_velocity_body[:-2]) / 0.02
acted = 0.5 * (torque[:-2] + torque[1:-1]).ravel()  # each holds over the 0.01 s after its row
basis = [(i, j) for i in range(3) for j in range(i, 3)]
units = [np.eye(9)[3 * i + j].reshape(3, 3) for i, j in basis]
units = [np.maximum(unit, unit.T) for unit in units]  # ixx, ixy, ixz, iyy, iyz, izz
motion = np.stack([(a @ unit + np.cross(w, w @ unit)).ravel() for unit in units], axis=1)
found = np.linalg.lstsq(motion, acted, rcond=None)[0]  # torque = I a + w x I w, linear in I
print(dict(zip(('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), np.round(found, 5).tolist())))
assert np.abs(found - [0.35, 0.01, 0, 0.3, 0, 0.25]).max() < 1e-4  # kg m^2; of the differences
