# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Direct and inverse kinematics: from a state to the motion of a point, and from points back."""

import numpy as np
from lesson import claim, follow
from scipy.spatial.transform import Rotation

from rigid_body_sim import inverse_kinematics

wheel = {
    'dt': 0.001,
    'bodies': [
        {
            'name': 'wheel',
            'shape': {'type': 'cylinder', 'radius': 0.5, 'length': 0.1},
            'mass': 1.0,
            'initial': {'velocity': [1, 0, 0], 'angular_velocity': [0, 0, 2]},
        }
    ],
}
run = follow(wheel, 3.0, 0.01)
RIM, SPIN, SPEED = np.array([0.5, 0, 0]), np.array([0, 0, 2.0]), np.array([1.0, 0, 0])

# direct: r_P = r + R s,  v_P = v + ω × R s,  a_P = a + ω × (ω × R s)
arm = Rotation.from_quat(run.attitude[:, 0]).apply(RIM)
point = run.position[:, 0] + arm
end = run.simulation.motion_of('wheel', RIM)
s = Rotation.from_quat(run.simulation.state.orientation[0]).apply(RIM)
claim(
    'a point goes with v + ω × s',
    end.velocity - SPEED - np.cross(SPIN, s),
    within=1e-13,
    unit='m/s',
)
inward = np.cross(SPIN, np.cross(SPIN, s))
claim('and is drawn in with ω × (ω × s)', end.acceleration - inward, within=1e-12, unit='m/s²')

# inverse: only the positions of the point are known, and how it began
found = inverse_kinematics(run.time, point, start_velocity=SPEED + np.cross(SPIN, RIM))
error = found.velocity - SPEED - np.cross(SPIN, arm)
claim('positions give the velocity back', error, within=1e-6, unit='m/s')
error = found.acceleration - np.cross(SPIN, np.cross(SPIN, arm))
claim('and the acceleration', error[5:-5], within=1e-4, unit='m/s²')


def draw(axes):
    """The path of the rim and the acceleration found from it."""
    axes.plot(*point[:, :2].T, label='a point of the rim')
    few = slice(None, None, 25)
    axes.quiver(
        *point[few, :2].T, *found.acceleration[few, :2].T, width=0.004, label='acceleration'
    )
    axes.set(xlabel='x [m]', ylabel='y [m]', aspect='equal')
