# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A node of many bodies: it does not compare its own topics with each other, says that it makes them,
and can be stopped meanwhile.
"""

import os
import subprocess
import sys

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray

from rigid_body_sim.ros.middleware import PROFILE_FILES, PROFILE_VARIABLES
from rigid_body_sim.testing.surroundings import PROFILE

from ..patience import HANGING
from .conftest import NodeProcess

# how many subscriptions a publisher of a node has where its own one is the only one
HEARD = """
import sys
import rclpy
from std_msgs.msg import Empty
from rigid_body_sim.ros.middleware import PROFILE_VARIABLES, deaf_to_itself
from rigid_body_sim.stop_signals import STOP

STOP.listen(owns_process=sys.argv[1] == 'own')
with deaf_to_itself(sys.argv[2:]):
    rclpy.init(args=[])
    node = rclpy.create_node('one')
publisher = node.create_publisher(Empty, 'it', 1)
subscription = node.create_subscription(Empty, 'it', lambda message: None, 1)
print(publisher.get_subscription_count())
import os
print(any(os.environ.get(name) for name in PROFILE_VARIABLES))
node.destroy_node()
rclpy.shutdown()
"""


def heard(folder, *words, profile=''):
    """
    How many hear a publisher of a process, its own subscription alone, and whether the variable of
    the profile is set after that.
    """
    surroundings = {k: v for k, v in os.environ.items() if k not in PROFILE_VARIABLES}
    if profile:
        surroundings[PROFILE_VARIABLES[0]] = str(profile)
    done = subprocess.run(
        [sys.executable, '-c', HEARD, *words],
        cwd=folder, env=surroundings, capture_output=True, text=True, timeout=HANGING, check=True,
    )  # fmt: skip
    count, is_set = done.stdout.split()
    return int(count), is_set == 'True'


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        (['own', '-r', '__ns:=/lab', '-r', '/tf:=tf', '-p', 'scene:=force'], 0),
        (['own', '-r', 'a/applied_wrench:=b/wrench'], 1),
        pytest.param(
            ['own', '--remap', 'a/impulse:=/a/contact_wrench'], 1, marks=pytest.mark.long
        ),
        (['shared', '-r', '__ns:=/lab'], 1),
    ],
)
def test_a_process_of_its_own_does_not_listen_to_itself_unless_asked(tmp_path, words, expected):
    assert heard(tmp_path, *words) == (expected, False)


def test_a_profile_of_the_user_stays_as_it_is(tmp_path):
    assert heard(tmp_path, 'own', profile=PROFILE) == (1, True)
    (tmp_path / PROFILE_FILES[0]).write_bytes(PROFILE.read_bytes())
    assert heard(tmp_path, 'own') == (1, False)


def test_what_a_node_publishes_can_be_led_to_its_own_commands(start_node, meet, monkeypatch):
    for name in PROFILE_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    node = start_node(more=['-r', 'box/applied_wrench:=stone/wrench'], diagnostics_period=0.1)
    peer = meet(node)
    accepted = []

    def take(message):
        values = {pair.key: pair.value for pair in message.status[0].values}
        accepted.append(int(values['accepted commands']))

    subscription = peer.node.create_subscription(DiagnosticArray, '/diagnostics', take, 10)
    peer.until(lambda: accepted and accepted[-1] > 3, 'commands of the node to itself')
    peer.node.destroy_subscription(subscription)
    assert node.stop() == 0


def test_a_crowd_says_that_topics_are_made_and_heeds_a_signal_meanwhile(tmp_path):
    bodies = [
        {'name': f'b{i}', 'shape': {'type': 'particle'}, 'mass': 1.0,
         'initial': {'position': [i, 0, 0]}}
        for i in range(1000)
    ]  # fmt: skip
    scene = tmp_path / 'crowd.yaml'
    scene.write_text(yaml.safe_dump({'version': 1, 'dt': 0.01, 'bodies': bodies}))
    node = NodeProcess(tmp_path, namespace='/crowd', parameters={'scene': scene})
    try:
        node.wait_until_said('making 8001 topics of 1000 bodies')
        assert node.stop() == 0
        assert 'stopped by Ctrl-C before it was ready' in node.said
        assert 'body_topics:=none' in node.said and 'publish_arrays:=true' in node.said
        assert 'ready:' not in node.said
    finally:
        node.close()
