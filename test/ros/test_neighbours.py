# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Two nodes that cannot live beside each other say so, both; given qualities of service are used;
commands that a flood loses are counted.
"""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Vector3Stamped
from rclpy.qos import ReliabilityPolicy

from rigid_body_sim.ros.qos_overrides import QosOverrides

from .conftest import start

FLOOD = 5000  # [messages]


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

    values, sent = _flood(peer, messages, lambda: told[name][-1])
    lost, accepted = int(values['lost commands']), int(values['accepted commands'])
    assert accepted >= FLOOD or lost > 0, values
    assert accepted + lost <= sent

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
        qualities = {
            info.qos_profile.reliability
            for info in peer.node.get_publishers_info_by_topic(f'{space}/box/twist')
        }
        assert qualities == {ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT}
        assert second.stop() == 0
    finally:
        second.close()

    def warnings():
        return [p.value for p in told[name][-1].values if p.key.startswith('warning')]

    peer.until(lambda: not any('named' in text for text in warnings()), 'the end of the warning')
    seen = [status for status in told[name] if any('named' in p.value for p in status.values)]
    assert seen[-1].level == DiagnosticStatus.WARN
    assert any(f'is published by {space}/rigid_body_sim too' in p.value for p in seen[-1].values)
    peer.node.destroy_subscription(subscription)
    assert first.stop() == 0


def _flood(peer, messages, status):
    """Send more at once than the sender keeps; return the figures when all came or were lost."""
    sender = peer.node.create_publisher(Vector3Stamped, peer.full('box/force'), 10)
    peer.until(sender.get_subscription_count, 'a subscriber of box/force')
    message = messages.force(0, 0, 1)
    sent = 0

    def figures():
        return {pair.key: pair.value for pair in status().values}

    def is_heard():
        """Send one more, until one came: the node may learn of the sender later."""
        nonlocal sent
        sender.publish(message)
        sent += 1
        return int(figures()['accepted commands']) > 0

    peer.until(is_heard, 'a first command')
    for _ in range(FLOOD):
        sender.publish(message)
    sent += FLOOD
    seen = []
    peer.until(
        lambda: seen.append(figures()) or (len(seen) > 1 and _came(seen)), 'the end of the flood'
    )
    peer.node.destroy_publisher(sender)
    return seen[-1], sent


def _came(seen):
    """Whether a later report tells of no more commands."""
    ticks = sorted({int(values['tick']) for values in seen})
    if len(ticks) < 3:
        return False
    late = [values for values in seen if int(values['tick']) >= ticks[-2]]
    return (
        int(late[0]['accepted commands']) > 0
        and len({(values['accepted commands'], values['lost commands']) for values in late}) == 1
    )


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
