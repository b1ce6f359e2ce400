# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A controller in lock-step with the node: a satellite turns by 60 degrees to where it should look.

    torque = -k_p 2 e_v - k_d omega,   e = q t*,   world axes

    q : orientation      t : the target      e : the error, whose vector part is e_v

Start the node, then this; both go as fast as they can, and every run writes the same bag:

    sim_node --ros-args -p scene:=satellite -p step_mode:=lockstep -p real_time_factor:=0.0 \
        -p "lockstep_topics:=[satellite/torque]" -p record:=true -p stop_time:=30.0
"""

import numpy as np
import rclpy

from rigid_body_sim.ros.partner import Partner

PROPORTIONAL, DERIVATIVE = 0.4, 0.9  # [N m], [N m s]
TARGET = np.array([0.0, 0.0, np.sin(np.pi / 6), np.cos(np.pi / 6)])
EVERY = 5_000_000_000  # [ns] between two lines


def attitude(states):
    """Answer the state of an instant."""
    satellite = states['satellite']
    q, t = satellite.orientation, TARGET
    error = t[3] * q[:3] - q[3] * t[:3] - np.cross(q[:3], t[:3])
    cosine = q @ t
    torque = -2 * PROPORTIONAL * error * np.copysign(1.0, cosine)
    torque -= DERIVATIVE * satellite.angular_velocity
    if states.stamp % EVERY == 0:
        angle = np.degrees(2 * np.arctan2(np.linalg.norm(error), abs(cosine)))
        print(f'{states.time:6.1f} s   {angle:8.4f} degrees from the target')
    return {'satellite/torque': torque}


rclpy.init()
partner = Partner(
    rclpy.create_node('attitude_controller'),
    attitude,
    bodies=['satellite'],
    topics=['satellite/torque'],
    spins=True,  # three times as fast as an executor, which takes any other node beside it
)
partner.spin(until=30.0, patience=60.0)  # [s] of simulation; [s] to wait for the node
