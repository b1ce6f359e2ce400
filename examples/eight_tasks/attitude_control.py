# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A PD controller turns a satellite by 60 degrees to where it should look, within a minute."""

import numpy as np

import rigid_body_sim as rbs
from rigid_body_sim import rotation

target = rotation.exp((0, 0, np.pi / 3))


def controller(t, state):
    body = state['satellite']
    error = rotation.log(rotation.multiply(rotation.inverse(body.orientation), target))
    torque = 0.4 * error - 0.9 * body.angular_velocity_body
    return {'satellite': rbs.Wrench(torque=torque, frame='body')}


run = rbs.simulate('satellite', duration=60, every=0.1, controller=controller)
left = rotation.angle_between(run['satellite'].orientation, target)
print(f'{np.degrees(left[0]):.1f} degrees at the start, {np.degrees(left[-1]):.1e} at the end')
assert left[-1] < 1e-6  # rad; the slowest part of the error fades as exp(-0.6 t)
