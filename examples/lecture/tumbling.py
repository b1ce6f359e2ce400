# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A free body: r, R, p, L. Its angular momentum stays, and so it must turn over."""

import numpy as np
from lesson import claim, follow
from scipy.spatial.transform import Rotation

run = follow('tumbling_box', 10.0, 0.02, dt=0.005)
box = run.simulation.scene.bodies[0]
L = run.angular_momentum[0]

claim('without torque L keeps its last bit', run.angular_momentum - L, within=0, unit='kg m²/s')
claim('and the energy stays', run.energy / run.energy[0] - 1, within=1e-13)
R = Rotation.from_quat(run.attitude[:, 0])
in_body = R.inv().apply(L)
claim(
    'L = R I Rᵀ ω',
    in_body - (R.inv().apply(run.spin[:, 0]) @ box.inertia),
    within=1e-14,
    unit='kg m²/s',
)
orthogonal = R.as_matrix() @ R.as_matrix().transpose(0, 2, 1) - np.eye(3)
claim('R stays a rotation', orthogonal, within=1e-14)
middle = run.spin[:, 0] * 0
middle = R.inv().apply(run.spin[:, 0])[:, 1]
flips = run.time[1:][np.diff(np.sign(middle)) != 0]
claim(
    'about the middle axis it turns over every 3.866 s',
    np.diff(flips) - 3.866,
    within=0.02,
    unit='s',
)


def draw(axes):
    """The spin in body axes."""
    for i, name in enumerate('xyz'):
        axes.plot(run.time, R.inv().apply(run.spin[:, 0])[:, i], label=f'ω_{name}, body axes')
    axes.set(xlabel='time [s]', ylabel='ω [rad/s]')
