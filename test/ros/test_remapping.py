# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What remapping moves is recorded under the name on the wire, as rosbag2 does, and replays."""

import json

import pytest
import yaml
from geometry_msgs.msg import Vector3Stamped, WrenchStamped

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.cdr import WrenchStamped as Applied
from rigid_body_sim.recording.topic_names import names_on_the_wire

RULES = {
    'box/pose': '/gps/pose',
    'box/force': '/thrust',
    'box/twist': 'stone/twist',  # these two change places
    'stone/twist': 'box/twist',
    'box/impulse': '/kick',  # two that would have one name
    'stone/impulse': '/kick',
    '/clock': '/simulated/clock',
}


def test_a_remapped_topic_is_recorded_under_the_name_on_the_wire(
    start_node, meet, messages, capsys
):
    rules = [word for old, new in RULES.items() for word in ('-r', f'{old}:={new}')]
    node = start_node(more=rules, record='true', record_path='moved', publish_clock='false')
    peer = meet(node)
    applied = peer.listen('box/applied_wrench', Applied)
    felt = peer.listen('stone/applied_wrench', Applied)
    peer.sender('/thrust', Vector3Stamped).publish(messages.force(0, 0, 3))
    peer.until(lambda: any(a.force[2] == 3.0 for a in applied), 'the force')
    kick = peer.sender('/kick', WrenchStamped)
    peer.until(lambda: kick.get_subscription_count() == 2, 'both that are kicked')
    kick.publish(messages.wrench((1, 0, 0)))
    peer.until(lambda: any(a.force[0] for a in applied), 'the kick')
    peer.until(lambda: any(a.force[0] for a in felt), 'the kick of the other')
    assert node.stop() == 0
    assert 'remapping gives one name to several topics' in node.said
    bag = node.folder / 'moved'

    space = node.namespace
    own = {
        name if name[0] == '/' else f'{space}/{name}' for name in RULES if name != 'stone/impulse'
    }
    wire = {
        topic['topic_metadata']['name']: topic['message_count']
        for topic in yaml.safe_load((bag / 'metadata.yaml').read_text())[
            'rosbag2_bagfile_information'
        ]['topics_with_message_count']
    }
    assert wire['/thrust'] == 1
    assert wire['/gps/pose'] == wire['/simulated/clock'] > 0
    assert not {f'{space}/box/pose', f'{space}/box/force', '/clock', '/kick'} & wire.keys()
    assert {f'{space}/box/impulse', f'{space}/stone/impulse'} <= wire.keys()

    opened = Bag(bag)
    assert own <= opened.topics.keys()
    first = next(opened.messages([f'{space}/box/twist']))
    assert opened.wire_name(first.topic) == f'{space}/stone/twist'

    assert main(['bag', 'check', str(bag)]) == 0
    capsys.readouterr()
    assert main(['bag', 'info', str(bag), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['topics'].keys() == wire.keys()
    assert main(['replay', str(bag), '-o', str(node.folder / 'again')]) == 0
    assert Bag(node.folder / 'again').wire_names == opened.wire_names


@pytest.mark.parametrize(
    ('rule', 'named'),
    [
        ('satellite/pose:=satellite/twist', ['/satellite/pose', '/satellite/twist']),
        ('/clock:=/satellite/pose', ['/clock', '/satellite/pose']),
        ('/diagnostics:=/satellite/pose', ['/diagnostics', '/satellite/pose']),
        ('satellite/force:=inspector/wrench', ['/satellite/force', '/inspector/wrench']),
        ('/clock:=/rosout', ['/clock', '/rosout']),
        ('~/pause:=~/step', ['~/pause', '~/step']),
    ],
)
def test_one_name_for_two_types_exits_2_with_one_line(tmp_path, monkeypatch, capfd, rule, named):
    monkeypatch.chdir(tmp_path)
    given = ['-p', 'scene:=satellite', '-p', 'record:=true', '-r', rule]
    assert main(['sim_node', '--ros-args', *given]) == 2
    said = capfd.readouterr().err
    (line,) = [line for line in said.splitlines() if 'error' in line]
    assert line.startswith('rigid_body_sim sim_node: error: arguments for ROS: remapping makes')
    assert all(name in line for name in named), line
    assert 'Traceback' not in said
    assert not list(tmp_path.iterdir())


def test_names_that_would_meet_stay_apart():
    rules = {'/a': '/x', '/b': '/x', '/c': '/a', '/d': '/e', '/e': '/d'}
    names, kept = names_on_the_wire([*rules, '/f'], lambda name: rules.get(name, name))
    assert names == {'/d': '/e', '/e': '/d'}  # /c would take the name that /a keeps
    assert sorted(kept) == ['/a', '/b', '/c']
