# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contacts over DDS: off by default, and where they are asked for, published, recorded, replayed.
"""

import json
import signal

import pytest

from rigid_body_sim.analysis.recorded_contacts import contact_topics
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.contact_packing import FORCE, OTHER, cloud_points

TOWER = """
dt: 0.01
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: box
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1.0
    initial: {position: [0, 0, 0.1]}
    repeat: {count: [1, 1, 2], spacing: [0, 0, 0.2]}
"""


@pytest.fixture
def tower(tmp_path):
    """
    A scene of two boxes, one on the other: few enough for plain kernels.
    """
    path = tmp_path / 'tower.yaml'
    path.write_text(TOWER)
    return path


def test_contacts_are_published_and_recorded_and_replay(start_node, meet, run_verb, tower):
    node = start_node(scene=tower, publish_contacts='true', record='true', record_path='live')
    peer = meet(node)
    heard = peer.listen('box_1/contacts', cdr.PointCloud2)
    peer.until(lambda: heard and heard[-1].sec >= 1, 'a contact after the first second')
    points = cloud_points(heard[-1])
    ground = points[points[:, OTHER] == 0]
    assert heard[-1].frame_id == 'world'
    # Two boxes of 1 kg; what swings in the soft contacts has faded to a hundredth.
    assert ground[:, FORCE].sum(axis=0) == pytest.approx((0, 0, 2 * 9.81), abs=0.2)
    assert node.stop(signal.SIGINT) == 0
    assert 'energy rise' in node.said and 'deepest gap' in node.said
    bag = Bag(node.folder / 'live')
    recorded = {
        (message.log_time, message.data)
        for message in bag.messages([f'{node.namespace}/box_1/contacts'])
    }
    assert {(m.sec * 10**9 + m.nanosec, cdr.encode(m)) for m in heard} <= recorded
    outcome = json.loads(run_verb('replay', bag.path, '--json').stdout)
    assert outcome['identical'], outcome


@pytest.mark.long  # in the short form: of a scene with impacts, in test_live_page
def test_contacts_are_off_by_default(start_node, tower):
    node = start_node(scene=tower, record='true', record_path='live', stop_time=0.1)
    assert node.wait() == 0
    assert not contact_topics(Bag(node.folder / 'live'))


def test_contacts_of_a_scene_without_contact_end_the_node_with_2(start_node):
    node = start_node(publish_contacts='true')
    assert node.wait() == 2
    assert "contacts of the scene 'laboratory': asked for, but its bodies do not meet" in node.said
