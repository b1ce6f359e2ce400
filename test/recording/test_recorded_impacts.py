# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Impacts at their instants in a bag: what the simulation had, to the bit, also for other readers.
"""

import csv
import dataclasses
import json
import struct

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import rigid_body_sim as rbs
from rigid_body_sim.__main__ import main
from rigid_body_sim.physics.state.impacts import KINDS
from rigid_body_sim.recording.impact_packing import FIELDS

SCENE = {
    'version': 1,
    'name': 'bouncing',
    'dt': 0.004,
    'gravity': [0, 0, -9.81],
    'contact': {'mode': 'event'},
    'bodies': [
        {'name': 'ground', 'shape': {'type': 'plane', 'normal': [0, 0, 1]}},
        {
            'name': 'ball', 'mass': 1.0, 'restitution': 0.6,
            'shape': {'type': 'sphere', 'radius': 0.1},
            'initial': {'position': [0, 0, 1.1], 'velocity': [0.5, 0, 0]},
        },
    ],
}  # fmt: skip


@pytest.fixture(scope='module')
def run():
    return rbs.simulate(SCENE, duration=3.0, every=0.02)


@pytest.fixture(scope='module')
def bag(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp('impacts') / 'bag'
    run.save(folder)
    return folder


def test_a_bag_has_the_impacts_of_the_run_to_the_bit(run, bag):
    assert len(run.impacts) > 10
    again = rbs.open_bag(bag).impacts
    for each in dataclasses.fields(again):
        np.testing.assert_array_equal(
            getattr(again, each.name), getattr(run.impacts, each.name), err_msg=each.name
        )


def test_another_reader_finds_them_as_a_cloud_of_points(run, bag):
    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        topic = [c for c in reader.connections if c.topic == '/rigid_body_sim/impacts']
        assert [c.msgtype for c in topic] == ['sensor_msgs/msg/PointCloud2']
        rows = []
        for connection, _, raw in reader.messages(connections=topic):
            cloud = reader.deserialize(raw, connection.msgtype)
            assert tuple(field.name for field in cloud.fields) == FIELDS
            rows += struct.iter_unpack(f'<{len(FIELDS)}d', bytes(cloud.data))
    assert len(rows) == len(run.impacts)
    told = np.array(rows)
    time = told[:, FIELDS.index('sec')] + told[:, FIELDS.index('nanosec')] * 1e-9
    time += told[:, FIELDS.index('remainder')]
    np.testing.assert_allclose(time, run.impacts.time, rtol=1e-15, atol=0)
    np.testing.assert_array_equal(told[:, 6:9], run.impacts.impulse)


def test_bag_info_counts_them_and_names_the_hardest(run, bag, capsys):
    assert main(['bag', 'info', str(bag), '--json']) == 0
    found = json.loads(capsys.readouterr().out)['impacts']
    assert found['impacts'] == len(run.impacts)
    assert found['kinds']['summed'] == np.sum(run.impacts.kind == KINDS.index('summed')) == 1
    largest = found['largest_impulse']
    assert set(largest['bodies']) == {'ground', 'ball'}
    assert largest['value'] == np.linalg.norm(run.impacts.impulse, axis=1).max()
    assert main(['bag', 'info', str(bag)]) == 0
    assert f'impacts:    {len(run.impacts)} (' in capsys.readouterr().out


def test_replay_makes_the_same_impacts_again(bag, capsys):
    assert main(['replay', str(bag), '--json']) == 0
    assert json.loads(capsys.readouterr().out)['identical']


def test_without_event_mode_there_is_neither_topic_nor_word(tmp_path, capsys):
    folder = tmp_path / 'bag'
    scene = {**SCENE, 'contact': {'mode': 'none'}}
    run = rbs.simulate(scene, duration=0.1, every=0.02)
    assert len(run.impacts) == 0
    run.save(folder)
    assert main(['bag', 'info', str(folder), '--json']) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts['impacts'] is None
    assert not [name for name in facts['topics'] if name.endswith('impacts')]


def test_a_table_of_impacts_has_their_numbers_to_the_bit(run, bag, tmp_path):
    file = tmp_path / 'impacts.csv'
    assert main(['export', str(bag), '-o', str(file), '--impacts']) == 0
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows) == len(run.impacts)
    assert [float(row['remainder']) for row in rows] == run.impacts.remainder.tolist()
    assert [float(row['impulse.z']) for row in rows] == run.impacts.impulse[:, 2].tolist()
    assert {row['a'] for row in rows} | {row['b'] for row in rows} == {'ground', 'ball'}
    assert rows[-1]['kind'] == 'summed'
