# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two nodes that cannot live beside each other say so, both; given qualities of service are used;
commands that a flood loses are counted.
"""

import signal
import time
from types import SimpleNamespace

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.qos import ReliabilityPolicy

from rigid_body_sim.ros.neighbours import Neighbours
from rigid_body_sim.ros.qos_overrides import QosOverrides

from .conftest import start

FLOOD = 2000  # [messages]
AGAIN = 5.0  # [s] ten diagnostics: what a flood has lost is told, or nothing was


def test_two_nodes_of_one_name_and_two_clocks_are_told_of_each_other(
    start_node, meet, messages, tmp_path_factory
):
    taken = 'qos_overrides.{}/box/twist.publisher.reliability'
    first = start_node(diagnostics_period=0.5, **{'qos_overrides./box/pose.publisher.depth': 3})
    space = first.namespace
    peer = meet(first)
    told = {}

    def keep(message):
        status = message.status[0]
        told.setdefault(status.name, []).append(status)

    subscription = peer.node.create_subscription(DiagnosticArray, '/diagnostics', keep, 100)
    name = f'{space.strip("/")}/rigid_body_sim: simulation'
    peer.until(lambda: name in told, 'diagnostics of the first')
    assert 'qos_overrides./box/pose.publisher.depth has no effect' in first.said

    sender = peer.node.create_publisher(Vector3Stamped, peer.full('box/force'), 10)
    peer.until(sender.get_subscription_count, 'a subscriber of box/force')

    def figure(name_of_it):
        return next(int(p.value) for p in told[name][-1].values if p.key == name_of_it)

    sent, told_by = 0, 0.0

    def some_are_lost():
        """Send more to a node that stands still than sender and socket keep, till it says so."""
        nonlocal sent, told_by
        if time.monotonic() > told_by:
            first.process.send_signal(signal.SIGSTOP)
            for _ in range(FLOOD):
                sender.publish(messages.force(0, 0, 1))
            first.process.send_signal(signal.SIGCONT)
            sent, told_by = sent + FLOOD, time.monotonic() + AGAIN
        return figure('lost commands')

    peer.until(some_are_lost, 'a lost command')
    assert figure('accepted commands') + figure('lost commands') <= sent
    peer.node.destroy_publisher(sender)

    second = start(
        tmp_path_factory.mktemp('second'),
        space,
        diagnostics_period=30.0,
        **{taken.format(space): 'best_effort'},
    )
    try:
        for node in (first, second):
            for words in (
                f'another node is named {space}/rigid_body_sim too',
                '/clock is published by',
            ):
                peer.until(lambda n=node, w=words: w in n.said, f'the warning {words!r}')

        def qualities():
            found = peer.node.get_publishers_info_by_topic(f'{space}/box/twist')
            return {info.qos_profile.reliability for info in found}

        both = {ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT}
        peer.until(lambda: qualities() == both, 'the quality of service that was given')
        assert second.stop() == 0
    finally:
        second.close()

    def warnings():
        return [p.value for p in told[name][-1].values if p.key.startswith('warning')]

    peer.until(lambda: not any('named' in text for text in warnings()), 'the end of the warning')
    seen = [status for status in told[name] if any('named' in p.value for p in status.values)]
    assert seen[-1].level == DiagnosticStatus.WARN
    # its clock may be gone some time before its name is
    told_of = [p.value for status in seen for p in status.values]
    assert any(f'is published by {space}/rigid_body_sim too' in text for text in told_of)
    peer.node.destroy_subscription(subscription)
    assert first.stop() == 0


def test_an_override_that_no_topic_takes_is_named():
    given = [
        'qos_overrides./box/pose.publisher.depth',
        'qos_overrides./box/pose.publisher.deepness',
        'qos_overrides./box/force.subscription.reliability',
    ]
    overrides = QosOverrides(['dt', *given])
    assert overrides.options('/box/twist', 'publisher') is None
    assert len(overrides.options('/box/pose', 'publisher').policy_kinds) == 1
    assert overrides.options('/box/force', 'publisher') is None
    force, deepness = overrides.warnings()
    assert given[2] in force
    assert given[1] in deepness


def test_each_who_publishes_the_clock_is_named_once_with_the_cure():
    def of(name, space='/'):
        return SimpleNamespace(node_name=name, node_namespace=space)

    heard = [of('player'), of('sim', '/lab'), of('player'), of('sim', '/lab'), of('player')]
    node = SimpleNamespace(
        get_name=lambda: 'sim',
        get_namespace=lambda: '/lab',
        get_fully_qualified_name=lambda: '/lab/sim',
        get_node_names_and_namespaces=list,
        get_publishers_info_by_topic=lambda _: heard,
    )
    (warning,) = Neighbours(node, clock='/clock').look()
    assert 'by /lab/sim, /player too' in warning  # another of our name too; each once
    assert 'publish_clock:=false' in warning
    assert 'ros2 bag play BAG --topics' in warning
