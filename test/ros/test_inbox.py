# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The inbox judges bytes as they come over the wire.
"""

import math
import struct
from dataclasses import replace

import pytest
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message

from rigid_body_sim.ros import inbox as inbox_module
from rigid_body_sim.ros.inbox import OTHER, Inbox
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command, CommandRules, encode
from rigid_body_sim.scene import load_scene

SCENE = {
    'dt': 0.001,
    'bodies': [
        {'name': 'box', 'shape': {'type': 'box', 'size': [1, 1, 1]}, 'mass': 1.0},
    ],
}


@pytest.fixture
def inbox():
    return Inbox(CommandRules(load_scene(SCENE)))


def test_what_ros_serialises_is_read_to_the_bit(inbox):
    message = WrenchStamped()
    message.header.frame_id = 'box'
    message.header.stamp.sec, message.header.stamp.nanosec = 7, 8
    message.wrench.force.x, message.wrench.torque.z = math.pi, -0.0
    assert inbox.receive('box', 'wrench', serialize_message(message)) is None
    (command,) = inbox.take()
    assert command == Command(
        'box', 'wrench', (math.pi, 0.0, 0.0), (0.0, 0.0, -0.0), 'box', 7_000_000_008
    )
    assert math.copysign(1, command.torque[2]) == -1


def test_commands_come_out_in_the_order_in_which_they_came(inbox):
    sent = [
        Command('box', kind, (float(k), 0.0, 0.0))
        for k in range(10)
        for kind in ('force', 'impulse')
    ]
    for command in sent:
        assert inbox.receive('box', command.kind, encode(command)) is None
    assert inbox.take() == sent
    assert inbox.take() == []
    assert inbox.accepted == 20


@pytest.mark.parametrize('cut', [0, 3, 11, 20, 43])
def test_torn_bytes_are_refused(inbox, cut):
    assert 'cannot be read' in inbox.receive('box', 'force', encode(Command('box', 'force'))[:cut])
    assert inbox.take() == []
    assert sum(inbox.refused.values()) == 1


def test_refusals_are_counted_by_reason_and_a_flood_of_reasons_fills_no_memory(inbox):
    for k in range(200):
        inbox.receive('box', 'force', encode(Command('box', 'force', frame_id=f'f{k}')))
    for _ in range(5):
        inbox.receive('box', 'force', encode(Command('box', 'force', frame_id='f1')))
    assert sum(inbox.refused.values()) == 205
    assert len(inbox.refused) <= 51
    assert inbox.refused[OTHER] == 150
    assert "'f1'" in inbox.last_refusal


def test_of_a_frame_with_a_very_long_name_the_beginning_is_told(inbox):
    name = 'frame' * 12_000
    asked = Command('box', 'set_state', state=AskedState((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    for command in (Command('box', 'force', frame_id=name), replace(asked, frame_id=name)):
        assert 'frame' in inbox.receive('box', command.kind, encode(command))
    for reason in inbox.refused:
        assert len(reason) < 400
        assert name[:100] in reason
        assert 'box' in reason
    assert len(inbox.refused) == 2


def test_a_full_inbox_refuses(inbox, monkeypatch):
    monkeypatch.setattr(inbox_module, 'ROOM', 3)
    data = encode(Command('box', 'force'))
    assert [inbox.receive('box', 'force', data) is None for _ in range(4)] == [
        True,
        True,
        True,
        False,
    ]
    assert 'paused' in inbox.last_refusal


def test_nan_hidden_in_any_byte_order_is_refused(inbox):
    big = (
        b'\0\0\0\0'
        + struct.pack('>iII', 0, 0, 1)
        + b'\0' * 4
        + struct.pack('>3d', 1.0, math.nan, 0.0)
    )
    assert 'finite' in inbox.receive('box', 'force', big)
