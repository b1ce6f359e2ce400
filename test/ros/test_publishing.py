# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A message is sent where somebody listens; in a crowd those who came lately are asked for again.
"""

import pytest
import rclpy
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.template import MessageTemplate
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.ros import publishing

from .conftest import DOMAIN, Peer

HOUR = 3_600_000_000_000  # [ns]


@pytest.fixture
def sending():
    """
    A node that publishes one topic, and how it sends its message number k.
    """
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = rclpy.create_node('sender', context=context)
    topic = Topic('/count', cdr.Clock.TYPE)
    publisher = node.create_publisher(Clock, topic.name, QoSProfile(depth=10))
    template = MessageTemplate(topic, 1, payload=cdr.encode(cdr.Clock(0, 0)), stamps=[4])

    def make():
        senders = publishing.Senders([topic], {topic.name: publisher})
        return senders, lambda k: senders.send(template.batch(k, k))

    yield publisher, make
    node.destroy_node()
    context.try_shutdown()


@pytest.fixture
def peer():
    """
    Another node.
    """
    peer = Peer('')
    yield peer
    peer.close()


def hear(peer, publisher):
    """
    Subscribe, and wait for the match at both ends; what is heard.
    """
    heard = []
    subscription = peer.node.create_subscription(
        Clock, '/count', lambda message: heard.append(message.clock.nanosec), 10
    )
    peer.until(publisher.get_subscription_count, 'the match')
    peer.until(subscription.get_publisher_count, 'the match')
    return heard


def test_who_has_matched_gets_the_next_message_and_a_crowd_the_next_after_a_look(
    sending, peer, monkeypatch
):
    publisher, make = sending
    _, send = make()
    monkeypatch.setattr(publishing, 'CROWD', 0)
    monkeypatch.setattr(publishing, 'ASK_EVERY', HOUR)
    crowd, send_in_crowd = make()
    send(1)
    send_in_crowd(2)
    heard = hear(peer, publisher)
    send(3)
    send_in_crowd(4)
    crowd.look()
    send_in_crowd(5)
    send(6)
    peer.until(lambda: 6 in heard, 'the last message')
    assert heard == [3, 5, 6]
