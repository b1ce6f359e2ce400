# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a partner makes of states and of what its controller returns.
"""

import numpy as np
import pytest
from geometry_msgs.msg import Vector3Stamped, WrenchStamped
from rclpy.serialization import serialize_message

from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import cdr
from rigid_body_sim.ros.partner import encoded, stamp_of, states_of
from rigid_body_sim.runs.commands import decode

STAMP = 2**31 * 10**9 - 7  # [ns] the last seconds that a stamp holds


@pytest.mark.parametrize(
    ('kind', 'given', 'force', 'torque'),
    [
        ('force', [1, 2, 3], (1, 2, 3), (0, 0, 0)),
        ('torque', np.array([1.0, 2.0, 3.0]), (0, 0, 0), (1, 2, 3)),
        ('wrench', ([1, 2, 3], np.array([4, 5, 6])), (1, 2, 3), (4, 5, 6)),
        ('impulse', np.arange(6), (0, 1, 2), (3, 4, 5)),
    ],
)
def test_numbers_become_a_command_with_the_stamp_of_the_state(kind, given, force, torque):
    command = decode('box', kind, encoded(f'box/{kind}', given, STAMP))
    assert (command.force, command.torque) == (force, torque)
    assert (command.stamp_ns, command.frame_id) == (STAMP, '')
    assert stamp_of(command.message) == STAMP


def test_a_message_keeps_its_frame_and_gets_the_stamp_of_the_state():
    message = WrenchStamped()
    message.header.frame_id = 'box'
    message.header.stamp.sec = 5
    message.wrench.torque.z = 4.0
    command = decode('box', 'wrench', encoded('box/wrench', message, STAMP))
    assert (command.frame_id, command.torque, command.stamp_ns) == ('box', (0, 0, 4), STAMP)


@pytest.mark.parametrize(
    ('topic', 'given'),
    [
        ('box/force', [1, 2]),
        ('box/force', None),
        ('box/force', 'much'),
        ('box/wrench', [1, 2, 3]),
        ('box/wrench', ([1, 2, 3], [1, 2])),
        ('box/wrench', Vector3Stamped()),
        ('box/set_state', [0] * 6),
    ],
)
def test_anything_else_is_refused_with_what_is_allowed(topic, given):
    with pytest.raises(
        UserError, match=rf'{topic}: the controller returned .*; allowed: .*message'
    ):
        encoded(topic, given, 0)


def test_states_are_read_in_world_and_in_body_axes():
    half = np.sqrt(0.5)
    parts = {
        'box/pose': cdr.encode(cdr.PoseStamped(1, 2, 'world', (1, 2, 3), (0, 0, half, half))),
        'box/twist': cdr.encode(cdr.TwistStamped(1, 2, 'world', (4, 5, 6), (7, 8, 9))),
    }
    states = states_of(1_000_000_002, parts, ['box'])
    assert states.time == 1.000000002
    box = states['box']
    assert box.position.tolist() == [1, 2, 3]
    assert box.velocity.tolist() == [4, 5, 6]
    # turned by 90 degrees about z: the x axis of the body points along y of the world
    np.testing.assert_allclose(box.angular_velocity_body, [8, -7, 9], rtol=1e-15)


def test_the_stamp_is_read_in_either_byte_order():
    message = Vector3Stamped()
    message.header.stamp.sec, message.header.stamp.nanosec = 7, 8
    little = serialize_message(message)
    big = b'\0\0' + little[2:4] + little[7:3:-1] + little[11:7:-1] + little[12:]
    assert stamp_of(little) == stamp_of(big) == 7_000_000_008
