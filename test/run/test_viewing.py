# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What viewers ask for is recorded when asked for, belongs to the states, and replays bit for bit.
"""

import json

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.analysis.recorded_poses import from_bag
from rigid_body_sim.errors import UserError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.every_body import with_every_body
from rigid_body_sim.runs.asked_states import AskedState
from rigid_body_sim.runs.commands import Command, CommandRules
from rigid_body_sim.runs.recorded_run import RecordedRun
from rigid_body_sim.runs.recorder import RunRecorder
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.runs.view import ViewSettings
from rigid_body_sim.runs.viewing import check_view, view_settings_of, view_text
from rigid_body_sim.runs.views import VIEWS

ALL = tuple(view.option for view in VIEWS.values())
LANDING = """
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: timestep}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}}
  - name: box
    shape: {type: box, size: [0.2, 0.2, 0.2]}
    mass: 1.0
    initial: {position: [0, 0, 0.1005], angular_velocity: [0, 0, 1]}
    frames: {nose: {position: [0.1, 0, 0]}}
  - {name: stone, shape: {type: particle}, mass: 0.5, initial: {position: [1, 0, 0.3]}}
"""
COMMANDS = """time,body,kind,frame,fx,fy,fz
0.05,box,force,world,1,0,0
0.15,box,force,world,0,0,0
0.20,stone,impulse,world,0,0,1
"""


@pytest.fixture
def scene(tmp_path):
    """
    A box just above the ground, and a stone that falls.
    """
    path = tmp_path / 'landing.yaml'
    path.write_text(LANDING)
    return path


@pytest.fixture
def plain(monkeypatch):
    """
    Without compiling: short runs of few bodies.
    """
    monkeypatch.setenv('RIGID_BODY_SIM_COMPILE', '0')


def messages_of(bag, topic):
    kind = bag.topics[topic].type
    return [(m.log_time, cdr.decode(kind, m.data)) for m in bag.messages([topic])]


def test_all_views_are_recorded_belong_to_the_states_and_replay(as_json, verb, scene, tmp_path):
    table, path = tmp_path / 'commands.csv', tmp_path / 'run'
    table.write_text(COMMANDS)
    words = ('simulate', scene, '-o', path, '--duration', '0.4', '--commands', table)
    code, result = as_json(*words, *ALL, '--contacts', '--frame-prefix', 'lab/')
    assert code == 0, result
    bag = Bag(path)
    states = [time for time, _ in messages_of(bag, '/box/pose')]
    twists = dict(messages_of(bag, '/box/twist'))
    for topic in ('/box/odom', '/tf', '/poses', '/twists'):
        assert [time for time, _ in messages_of(bag, topic)] == states
    places = dict(messages_of(bag, '/box/pose'))
    for time, message in messages_of(bag, '/box/odom'):
        assert (message.frame_id, message.child_frame_id) == ('world', 'lab/box')
        assert (message.position, message.orientation) == (
            *(places[time].position, places[time].orientation),
        )
        speed = np.linalg.norm(twists[time].linear)
        assert np.linalg.norm(message.linear) == pytest.approx(speed, rel=1e-12, abs=1e-15)
    _, message = messages_of(bag, '/tf')[-1]
    assert [each['child_frame_id'] for each in message.values['transforms']] == [
        *('lab/ground', 'lab/box', 'lab/stone', 'lab/box/nose')
    ]
    wrenches = messages_of(bag, '/box/contact_wrench')
    assert [time for time, _ in wrenches] == states[1:]
    assert wrenches[-1][1].force[2] == pytest.approx(9.81, abs=1e-3)  # it lies still
    check_markers(bag, states)
    with AnyReader([path]) as reader:
        assert {c.topic for c in reader.connections} == set(bag.topics)
        count = sum(1 for c, _, data in reader.messages() if reader.deserialize(data, c.msgtype))
    assert count == sum(bag.counts.values())
    code, outcome = as_json('replay', path)
    assert (code, outcome['identical']) == (0, True), outcome
    code, _, _ = verb('bag', 'check', path)
    assert code == 0


def check_markers(bag, states):
    """
    At 25 Hz, from the start on; arrows come with what acts and end with it.
    """
    found = messages_of(bag, '/rigid_body_sim/markers')
    assert [time for time, _ in found] == states[::5]
    arrows = {
        (time, marker['ns'], marker['id']): marker['action']
        for time, message in found
        for marker in message.values['markers']
        if marker['ns'] not in ('shapes', 'frames')
    }
    acting = [(t, a) for (t, name, k), a in arrows.items() if (name, k) == ('forces', 1)]
    assert acting == [(80_000_000, 0), (120_000_000, 0), (160_000_000, 2)]
    assert any(name == 'contact_forces' for _, name, _ in arrows)
    for _, message in found:
        shapes = [m for m in message.values['markers'] if m['ns'] == 'shapes']
        assert [m['id'] for m in shapes] == [0, 1, 2]


def test_nothing_is_recorded_that_nobody_asked_for(as_json, scene, tmp_path):
    as_json('simulate', scene, '-o', tmp_path / 'run', '--duration', '0.1')
    leaves = {name.rsplit('/', 1)[-1] for name in Bag(tmp_path / 'run').topics}
    assert leaves == {'clock', 'pose', 'twist', 'applied_wrench'}


def test_a_recording_from_the_middle_deletes_the_arrows_that_were_there(
    as_json, scene, tmp_path, plain
):
    view = ViewSettings(frozenset({'markers'}), marker_every=2)
    run = Run(Simulation(load_scene(scene)), RunSettings(publish_every=3, view=view))
    run.advance(1, [Command('box', 'force', (1.0, 0.0, 0.0))])
    while run.simulation.tick < 20:
        run.advance(1)
    assert run.viewing.shown.forces == {1}
    recorder = RunRecorder(run, tmp_path / 'run')
    tick = run.simulation.tick
    recorder.record(run.advance(1, [Command('box', 'force', (0.0, 0.0, 0.0))]), tick=tick)
    while run.simulation.tick < 50:
        tick = run.simulation.tick
        recorder.record(run.advance(1), tick=tick)
    recorder.close('stopped')
    first, second, *_ = messages_of(Bag(tmp_path / 'run'), '/rigid_body_sim/markers')
    for _, message in (first, second):
        assert 2 in [m['action'] for m in message.values['markers'] if m['ns'] == 'forces']
    _, outcome = as_json('replay', tmp_path / 'run')
    assert outcome['identical'], outcome


def test_views_keep_their_order_in_bags_so_that_older_ones_replay(scene, plain):
    asked = ViewSettings(frozenset(VIEWS))
    run = Run(Simulation(load_scene(scene)), RunSettings(view=asked))
    leaves = dict.fromkeys(topic.name.rsplit('/', 1)[-1] for topic in run.viewing.topics)
    assert list(leaves) == ['odom', 'tf', 'poses', 'twists', 'contact_wrench', 'markers']
    flags = ['odometry', 'transforms', 'markers', 'arrays', 'contact_wrenches']
    assert list(json.loads(view_text(asked)))[: len(flags)] == flags


def test_what_was_asked_for_is_read_from_a_manifest_and_what_is_newer_than_it_was_not():
    asked = ViewSettings(frozenset({'markers', 'contact_wrenches'}), marker_every=3)
    told = json.loads(view_text(asked))
    assert [name for name in VIEWS if told[name]] == ['markers', 'contact_wrenches']
    assert view_settings_of(told) == asked
    older = {name: value for name, value in told.items() if name not in ('arrays', 'odometry')}
    assert view_settings_of(older) == asked
    for strange in ({'markers': 1}, {'no such view': True}, {'marker_every': 0}):
        with pytest.raises(ValueError, match=next(iter(strange))):
            view_settings_of(told | strange)


@pytest.mark.parametrize(
    ('wanted', 'named'),
    [('', []), ('none', []), ('b*', ['box']), ('stone, box', ['box', 'stone'])],
)
def test_bodies_without_topics_of_their_own_are_in_the_arrays(
    as_json, verb, scene, tmp_path, wanted, named
):
    path = tmp_path / 'run'
    code, _ = as_json(
        *('simulate', scene, '-o', path, '--duration', '0.1', '--contacts', *ALL),
        *('--body-topics', wanted),
    )
    assert code == 0
    bag = Bag(path)
    own = [name.split('/')[1] for name in bag.topics if name.endswith('/pose')]
    assert own == named
    _, twists = messages_of(bag, '/twists')[-1]
    assert twists.values['joint_names'] == ['ground', 'box', 'stone']
    code, outcome = as_json('replay', path)
    assert outcome['identical'], outcome
    table = tmp_path / 'commands.csv'
    table.write_text(COMMANDS)
    code, _, said = verb(
        *('simulate', scene, '-o', tmp_path / 'more', '--commands', table, '--duration', '0.3'),
        *('--body-topics', wanted),
    )
    assert (code == 2) is ('box' not in named or 'stone' not in named)
    assert code == 0 or 'body_topics' in said


def test_bodies_without_topics_are_read_from_the_arrays_bit_for_bit(as_json, scene, tmp_path):
    found = {}
    for name, wanted in (('each', '*'), ('few', 'box'), ('none', 'none')):
        path = tmp_path / name
        as_json(
            *('simulate', scene, '-o', path, '--duration', '0.2', '--arrays'),
            *('--body-topics', wanted),
        )
        bag = with_every_body(Bag(path))
        leaves = [t for t in bag.topics if t.endswith(('/pose', '/twist'))]
        found[name] = sorted((m.log_time, m.topic, m.data) for m in bag.messages(leaves))
        assert bag.counts['/stone/pose'] == bag.counts['/clock']
        _, outcome = as_json('replay', path, '--dt', '0.002')
        assert sorted(outcome['errors']) == ['box', 'ground', 'stone']
        assert outcome['errors']['stone']['largest']
    assert found['each'] == found['few'] == found['none']
    assert {body.body for body in from_bag(Bag(tmp_path / 'none'))} == {'ground', 'box', 'stone'}


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (('--body-topics', 'bux'), "'bux'"),
        (('--frame-prefix', '/lab'), "'/lab'"),
        (('--marker-rate', 'nan'), '--marker-rate'),
        (('--marker-rate', '0'), '--marker-rate'),
        (('--arrow-scale', '-1'), '--arrow-scale'),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_line(verb, scene, tmp_path, words, said):
    code, _, error = verb('simulate', scene, '-o', tmp_path / 'run', *words)
    assert code == 2
    assert said in error and error.count('\n') == 1
    assert not (tmp_path / 'run').exists()


def test_frames_of_bodies_may_be_named_with_the_prefix_and_without(scene):
    rules = CommandRules(load_scene(scene), frame_prefix='lab/')
    for frame, meant in (
        *(('', 'world'), ('world', 'world')),
        *(('box', 'body'), ('lab/box', 'body')),
        *(('box/nose', 'nose'), ('lab/box/nose', 'nose'), ('nose', 'nose')),
    ):
        command = Command('box', 'force', (1.0, 0.0, 0.0), frame_id=frame)
        assert rules.refusal(command) is None, frame
        assert rules.frame(command) == meant
    for frame in ('lab/world', 'lab/', 'lab/lab/box', 'other/box', 'lab/stone'):
        assert rules.refusal(Command('box', 'force', frame_id=frame)) is not None, frame


@pytest.mark.parametrize(
    ('world_frame', 'prefix', 'named'),
    [
        *(('box', '', 'box'), ('ground', '', 'ground'), ('box/nose', '', 'box/nose')),
        *(('box', 'lab/', 'box'), ('lab/box', 'lab/', 'box'), ('world', 'wor', 'ld')),
    ],
)
def test_no_frame_id_means_both_the_world_and_a_body(world_frame, prefix, named):
    text = LANDING.replace('name: stone', 'name: ld')
    settings = ViewSettings(frame_prefix=prefix)
    with pytest.raises(UserError, match=f"world_frame: got '{world_frame}'.*names '{named}'"):
        check_view(load_scene(text.encode()), settings, world_frame)


def test_a_world_frame_of_its_own_is_anything_that_no_body_is_called():
    read = load_scene(LANDING.encode())
    for world_frame in ('world', 'map', 'lab', 'nose', 'other/box'):
        assert check_view(read, ViewSettings(), world_frame) == ['ground', 'box', 'stone']


def test_a_state_may_be_asked_for_as_odometry_tells_it(scene):
    rules = CommandRules(load_scene(scene), frame_prefix='lab/')
    for child, axes in (('lab/box', 'body'), ('box', 'body'), ('', 'world'), ('map', 'world')):
        command = Command('box', 'set_state', state=AskedState(child_frame_id=child))
        assert rules.refusal(command) is None, child
        assert rules.without_prefix(command).state.axes('box') == axes
    for child in ('lab/stone', 'stone', 'lab/box/nose', 'nose'):
        command = Command('box', 'set_state', state=AskedState(child_frame_id=child))
        assert rules.refusal(command) is not None, child


def test_a_prefix_that_makes_two_frames_of_one_name_is_refused(verb, tmp_path):
    path = tmp_path / 'twins.yaml'
    path.write_text(
        'version: 1\nname: twins\ndt: 0.01\nbodies:\n'
        '  - {name: box, shape: {type: particle}, mass: 1}\n'
        '  - {name: abox, shape: {type: particle}, mass: 1}\n'
    )
    code, _, error = verb('simulate', path, '-o', tmp_path / 'run', '--frame-prefix', 'a')
    assert code == 2 and "'abox'" in error


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('view', '{"markers": 1}'),
        ('view', '{"unknown": true}'),
        ('view', '{"marker_every": 0}'),
        ('view', '[]'),
        ('shown_at_start', '[[0], [9], 0]'),
        ('shown_at_start', '[[0], [0]]'),
        ('shown_at_start', '[[0], [0], -1]'),
    ],
)
def test_a_manifest_that_says_nonsense_is_damaged(
    as_json, scene, tmp_path, monkeypatch, key, value
):
    as_json('simulate', scene, '-o', tmp_path / 'run', '--duration', '0.1')
    real = Bag.need_run
    monkeypatch.setattr(Bag, 'need_run', lambda bag: {**real(bag), key: value})
    with pytest.raises(Exception, match=f'damaged: {key}'):
        RecordedRun(tmp_path / 'run')


def test_the_manifest_says_what_is_on(as_json, scene, tmp_path):
    as_json('simulate', scene, '-o', tmp_path / 'run', '--duration', '0.1', '--tf')
    view = json.loads(Bag(tmp_path / 'run').manifest['view'])
    assert view['transforms'] and not view['markers']
