# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What viewers ask for over DDS: the messages of ROS, the same bytes in the bag, replayed; and the
files that viewers and launch read name what the node has.
"""

import ast
import json
import signal
from pathlib import Path

import pytest
import yaml
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message

from rigid_body_sim.recording import cdr
from rigid_body_sim.recording import marker_packing as names
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros.parameters import PARAMETERS
from rigid_body_sim.runs.views import VIEWS

from ..message_packages import importable
from ..readme.test_how_to import build

ROOT = Path(__file__).parents[2]
ALL = {view.parameter: 'true' for view in VIEWS.values()}
LAB = """
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: box
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1.0
    initial: {position: [0, 0, 0.1]}
    frames: {nose: {position: [0.1, 0, 0]}}
"""


@pytest.fixture
def lab_file(tmp_path):
    """
    A box with a named frame on the ground.
    """
    path = tmp_path / 'lab.yaml'
    path.write_text(LAB)
    return path


def raw(peer, name, kind):
    """
    Collect the bytes of a topic as a subscriber of its ROS type gets them.
    """
    heard = []
    peer.node.create_subscription(
        kind, peer.full(name), heard.append, QoSProfile(depth=1000), raw=True
    )
    return heard


def up_to_fours(payload):
    """
    What DDS delivers of a payload: filled up to a multiple of four bytes.
    """
    return payload + bytes(-len(payload) % 4)


def test_all_views_are_published_as_recorded_and_replay(
    start_node, meet, run_verb, messages, lab_file
):
    with importable('tf2_msgs'):
        node = start_node(
            scene=lab_file,
            frame_prefix='lab/',
            marker_rate=100.0,
            record='true',
            record_path='live',
            **ALL,
        )
        from geometry_msgs.msg import PoseArray, WrenchStamped
        from nav_msgs.msg import Odometry
        from sensor_msgs.msg import MultiDOFJointState
        from tf2_msgs.msg import TFMessage
        from visualization_msgs.msg import MarkerArray

        kinds = {
            'box/odom': Odometry,
            'box/contact_wrench': WrenchStamped,
            'poses': PoseArray,
            'twists': MultiDOFJointState,
            'rigid_body_sim/markers': MarkerArray,
            '/tf': TFMessage,
        }
        peer = meet(node)
        heard = {name: raw(peer, name, kind) for name, kind in kinds.items()}
        states = peer.listen('box/pose', cdr.PoseStamped)
        push = peer.sender('box/wrench', WrenchStamped)
        peer.until(lambda: all(heard.values()) and states, 'a message of each topic')
        push.publish(messages.wrench((5, 0, 0), frame='lab/box/nose'))

        def arrows():
            found = cdr.decode(cdr.MARKERS, heard['rigid_body_sim/markers'][-1])
            return {
                (marker['ns'], marker['action'])
                for marker in found.values['markers']
                if marker['ns'] not in (names.SHAPES, names.FRAMES)
            }

        peer.until(lambda: (names.FORCES, names.ADD) in arrows(), 'an arrow')
        assert (names.CONTACT_FORCES, names.ADD) in arrows()
        peer.until(lambda: (names.FORCES, names.DELETE) in arrows(), 'its end')
        odometry = deserialize_message(heard['box/odom'][-1], Odometry)
        assert odometry.child_frame_id == 'lab/box'
        transforms = deserialize_message(heard['/tf'][-1], TFMessage)
        assert [each.child_frame_id for each in transforms.transforms] == [
            *('lab/ground', 'lab/box', 'lab/box/nose')
        ]
        assert node.stop(signal.SIGINT) == 0, node.said
    bag = Bag(node.folder / 'live')
    for name, payloads in heard.items():
        recorded = {message.data for message in bag.messages([peer.full(name)])}
        whole = {up_to_fours(payload) for payload in recorded}
        assert payloads and set(payloads) <= whole, name
    outcome = json.loads(run_verb('replay', bag.path, '--json').stdout)
    assert outcome['identical'], outcome


@pytest.mark.long  # in the short form: of all views above; the page in readme/test_how_to
def test_the_topic_of_the_page_is_published_as_recorded(start_node, meet, tmp_path, monkeypatch):
    monkeypatch.setenv('RIGID_BODY_SIM_COMPILE', '0')
    build(ROOT / 'docs' / 'how-to' / 'topic.md', tmp_path)  # where the node finds it first
    node = start_node(
        scene='scene.yaml', publish_angular_momentum='true', record='true', record_path='live'
    )
    peer = meet(node)
    heard = peer.listen('wheel/angular_momentum', cdr.Vector3Stamped)
    peer.until(lambda: len(heard) > 3, 'some messages')
    assert node.stop(signal.SIGINT) == 0, node.said
    bag, topic = Bag(node.folder / 'live'), peer.full('wheel/angular_momentum')
    kind = bag.topics[topic].type
    recorded = {cdr.decode(kind, message.data) for message in bag.messages([topic])}
    assert set(heard) <= recorded
    for message in heard:  # L = L(0) + T t
        time = message.sec + message.nanosec * 1e-9
        assert message.vector == pytest.approx((0.1, 0.4 + 0.1 * time, 0.125 + 0.3 * time))


def test_transforms_without_their_package_are_recorded_all_the_same(
    start_node, run_verb, lab_file
):
    node = start_node(
        scene=lab_file, stop_time=0.1, record='true', record_path='live', body_topics='none', **ALL
    )
    assert node.wait() == 0
    assert node.said.count('/tf is not published: the ROS package tf2_msgs is not installed') == 1
    bag = Bag(node.folder / 'live')
    assert bag.counts['/tf'] == bag.counts['/clock']
    assert not any(topic.startswith(f'{node.namespace}/box/') for topic in bag.topics)
    outcome = json.loads(run_verb('replay', bag.path, '--json').stdout)
    assert outcome['identical'], outcome


def test_viewers_and_launch_name_what_the_node_has():
    shown = yaml.safe_load((ROOT / 'config' / 'rigid_body_sim.rviz').read_text())
    displays = {d['Name']: d for d in shown['Visualization Manager']['Displays']}
    namespaces = {*(names.SHAPES, names.FRAMES, names.FORCES, names.TORQUES, names.CONTACT_FORCES)}
    assert displays['Bodies']['Topic']['Value'] == 'rigid_body_sim/markers'
    assert set(displays['Bodies']['Namespaces']) == namespaces
    layout = json.loads((ROOT / 'config' / 'foxglove_layout.json').read_text())
    topics = layout['configById']['3D!rigid_body_sim']['topics']
    assert set(topics) == {'/rigid_body_sim/markers'}
    assert set(topics['/rigid_body_sim/markers']['namespaces']) == namespaces
    tree = ast.parse((ROOT / 'launch' / 'sim_node.launch.py').read_text())
    texts = {n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)}
    known = {entry.name for entry in PARAMETERS}
    assert {text for text in texts if str(text).startswith('publish_')} <= known
    given = yaml.safe_load((ROOT / 'config' / 'seen.yaml').read_text())
    assert set(given['/**']['ros__parameters']) <= known
