# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The states of t = 0 are in the bag, and what a publish rate makes of a run is said.
"""

import pytest

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import Run, RunSettings

from .conftest import SCENES

SCENE = SCENES / 'two_bodies.yaml'


def decoded(bag, topic):
    return [cdr.decode(bag.topics[topic].type, m.data) for m in bag.messages([topic])]


def test_a_bag_begins_with_the_state_of_the_scene(verb, bag):
    opened = Bag(bag)
    first = [(m.topic, m.sequence, m.log_time) for m in opened.messages()][:5]
    names = ('/clock', '/box/pose', '/ball/pose', '/box/twist', '/ball/twist')
    assert first == [(name, 0, 0) for name in names]
    state = Simulation(load_scene(SCENE)).state
    assert decoded(opened, '/ball/pose')[0].position == tuple(state.position[1])
    assert decoded(opened, '/box/twist')[0].angular == tuple(state.angular_velocity[0])
    # t = 0, and one more each hundredth of a second
    assert opened.counts['/clock'] == 1 + int(opened.ending['last_tick']) // 10
    assert opened.counts['/box/pose'] == opened.counts['/clock']


@pytest.mark.parametrize('publish_start', [True, False])
def test_recordings_with_and_without_it_replay(as_json, tmp_path, publish_start):
    simulation = Simulation(load_scene(SCENE))
    simulation.step(13)  # a recording that begins in the middle of a run
    run = Run(simulation, RunSettings(publish_start=publish_start))
    recorder = RunRecorder(run, tmp_path / 'b')
    for tick, output in run.follow({}, 35):
        recorder.record(output, tick=tick)
    recorder.close('stopped')
    found = [pose.nanosec // 1_000_000 for pose in decoded(Bag(tmp_path / 'b'), '/box/pose')]
    assert found == [*([13] if publish_start else []), 20, 30]
    code, told = as_json('replay', tmp_path / 'b')
    assert (code, told['identical'], told['ticks']) == (0, True, 22)
    # with other settings the state that both were given counts for nothing
    code, told = as_json('replay', tmp_path / 'b', '--dt', 0.0005)
    assert code == 0 and 0.0 < told['errors']['box']['last']['angle'] < 1e-6


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['--dt', 0.1], 'states are published at 10 Hz in place of 100 Hz'),
        (['--publish-rate', 300], 'states are published at 333.333 Hz in place of 300 Hz'),
        (['--publish-rate', 0.5], 'will hold the state of its start alone'),
        (['--publish-rate', 50], ''),
    ],
)
def test_a_rate_that_is_not_what_was_asked_for_is_said(verb, tmp_path, words, said):
    code, _, err = verb('simulate', SCENE, '-o', tmp_path / 'b', '--duration', 0.2, *words)
    assert code == 0
    assert said in err and bool(err) == bool(said)


def test_json_names_the_rate_that_was_reached(as_json, tmp_path):
    words = ('-o', tmp_path / 'b', '--duration', 0.2, '--publish-rate', 300)
    assert as_json('simulate', SCENE, *words)[1]['publish_rate'] == pytest.approx(1000 / 3)
