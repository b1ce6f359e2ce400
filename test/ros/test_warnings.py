# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Limits that are passed on the way, of the integrator and of numbers: in diagnostics and log.
"""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import WrenchStamped


def test_a_limit_passed_on_the_way_turns_the_diagnostics_to_warn(start_node, meet, messages):
    node = start_node(integrator='explicit_euler', diagnostics_period=0.1)
    peer = meet(node)
    statuses = []
    subscription = peer.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: statuses.append(message.status[0]), 10
    )
    peer.until(lambda: statuses, 'diagnostics')
    values = statuses[-1].values
    assert values and not any('turns by' in pair.value for pair in values)
    # 0.05 N m s about y, 0.0283 kg m^2: 1.8 rad/s, h |omega| = 0.0018 where 0.001 is allowed
    peer.sender('box/impulse', WrenchStamped).publish(messages.wrench((0, 0, 0), (0, 0.05, 0)))
    peer.until(
        lambda: any('turns by' in pair.value for pair in statuses[-1].values), 'the warning'
    )
    status = statuses[-1]
    assert status.level == DiagnosticStatus.WARN
    assert "'box' turns by h |omega| = 0.00" in status.message
    peer.until(lambda: "'box' turns by h |omega|" in node.said, 'the warning in the log')
    assert node.said.count("'box' turns by h |omega|") == 1
    peer.node.destroy_subscription(subscription)
    assert node.stop() == 0


def test_an_energy_beyond_all_numbers_is_warned_of_until_a_reset(start_node, meet, messages):
    node = start_node(diagnostics_period=0.1, command_timeout=0.0)
    peer = meet(node)
    statuses = []
    subscription = peer.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: statuses.append(message.status[0]), 10
    )
    beyond = 'the energy balance has no numbers any more'

    def is_told():
        return any(beyond in pair.value for pair in statuses[-1].values)

    peer.until(lambda: statuses, 'diagnostics')
    assert not is_told()
    # 0.5 kg: half m v^2 is beyond 1.8e308 after 1.4 s
    peer.sender('stone/wrench', WrenchStamped).publish(messages.wrench((9.9e153, 0, 0)))
    peer.until(is_told, 'the warning')
    assert statuses[-1].level == DiagnosticStatus.WARN
    assert beyond in statuses[-1].message
    assert '~/reset' in statuses[-1].message
    peer.until(lambda: beyond in node.said, 'the warning in the log')
    assert node.said.count(beyond) == 1
    assert peer.trigger('reset').success
    peer.until(lambda: not is_told(), 'the end of the warning')
    peer.node.destroy_subscription(subscription)
    assert node.stop() == 0
