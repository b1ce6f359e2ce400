# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What comes faster than it is looked at keeps nobody waiting, and is counted.
"""

import re
import time

from geometry_msgs.msg import Vector3Stamped
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message

from rigid_body_sim.recording import cdr
from rigid_body_sim.ros.listener import LONGEST_DRAIN, NotForExecutors, OwnWaitSet
from rigid_body_sim.ros.remarks import MOST, WHILE, Remarks

from ..patience import PATIENCE
from .conftest import Peer, force

SENT, FLOOD = 100, 9000  # [messages]


def test_a_flood_is_taken_in_parts_in_its_order_and_what_is_left_is_counted():
    peer, taken = Peer('/flood'), []
    profile = QoSProfile(depth=SENT)
    subscription = peer.node.create_subscription(
        Vector3Stamped, '/flood/force', id, profile, callback_group=NotForExecutors(), raw=True
    )
    sender = peer.sender('force', Vector3Stamped)

    def slowly(data):
        taken.append(data)
        time.sleep(LONGEST_DRAIN * 1e-9 / 4)

    door = OwnWaitSet(peer.context, {subscription: slowly})
    try:
        for number in range(SENT):
            sender.publish(force(number, 0, 0))
        assert sender.wait_for_all_acked(Duration(seconds=PATIENCE))
        door.wait(10**10)
        first = len(taken)
        assert 1 <= first <= 5
        door.wait(0)  # it does not wait for another message
        assert first < len(taken) < SENT
    finally:
        door.close()
    assert door.unread == SENT - len(taken)
    kind = cdr.Vector3Stamped.TYPE
    assert [cdr.decode(kind, data).vector[0] for data in taken] == list(range(len(taken)))
    peer.close()


def test_every_command_that_came_is_in_the_last_line_looked_at_or_not(start_node, meet):
    node = start_node(publish_clock='false')
    peer = meet(node)
    sender = peer.node.create_publisher(
        Vector3Stamped, peer.full('box/force'), QoSProfile(depth=FLOOD)
    )
    peer.until(sender.get_subscription_count, 'the node')
    peer.be_known()
    data = serialize_message(force(1, 0, 0, frame='nowhere'))  # faster than they are looked at
    for _ in range(FLOOD):
        sender.publish(data)
    assert sender.wait_for_all_acked(Duration(seconds=PATIENCE))
    assert node.stop() == 0
    told = re.search(r'refused (\d+)(?:, unread at the end (\d+))?; ', node.said)
    assert sum(map(int, filter(None, told.groups()))) == FLOOD


def test_each_cause_is_told_once_in_a_while_and_of_many_the_first_few():
    now = [0]
    remarks = Remarks(lambda: now[0])
    assert remarks.is_due('a frame')
    assert remarks.is_due('no number')  # another cause is told too
    assert not remarks.is_due('a frame')
    now[0] = WHILE
    told = [remarks.is_due(str(number)) for number in range(10 * MOST)]
    assert told == [True] * MOST + [False] * (9 * MOST)
