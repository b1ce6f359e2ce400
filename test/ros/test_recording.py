# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Bags written by the node: complete after every kind of end, and a replay of each is identical.
"""

import json
import resource
import signal
import time
from types import SimpleNamespace

import pytest
from geometry_msgs.msg import Vector3Stamped, WrenchStamped

from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.physics.simulation import Simulation
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.recording.cdr import WrenchStamped as Applied
from rigid_body_sim.ros import session
from rigid_body_sim.ros.bags import Bags
from rigid_body_sim.ros.inbox import Inbox
from rigid_body_sim.ros.run_loop import RunLoop
from rigid_body_sim.runs.run import Run, RunSettings
from rigid_body_sim.scene import load_scene

from .test_live_page import BOUNCING

DT_NS = 1_000_000


def replayed(run_verb, path):
    """
    Replay a bag; returns what it said.
    """
    done = run_verb('replay', path, '--json')
    assert done.returncode in (0, 3), done.stderr
    return json.loads(done.stdout)


def test_commands_of_another_process_are_recorded_at_the_tick_on_which_they_acted(
    start_node, meet, messages, commands_in, run_verb
):
    node = start_node(record='true', record_path='live')
    peer = meet(node)
    applied = peer.listen('box/applied_wrench', Applied)
    felt = peer.listen('stone/applied_wrench', Applied)
    force, wrench = (
        peer.sender('box/force', Vector3Stamped),
        peer.sender('stone/wrench', WrenchStamped),
    )
    sent = []
    for k in range(1, 31):
        message = messages.force(k, 0, 0, frame='box' if k % 2 else '')
        message.header.stamp.nanosec = k
        force.publish(message)
        wrench.publish(messages.wrench((0, 0, -k)))
        sent.append(float(k))
        seen = len(applied)
        peer.until(lambda seen=seen: len(applied) > seen, 'the next applied wrench')
    force.publish(messages.force(1, 0, 0, frame='nowhere'))
    peer.until(lambda: 'refused' in node.said, 'the refusal')
    peer.until(lambda: any(a.force[2] == -30.0 for a in felt), 'the last wrench')
    assert node.stop(signal.SIGINT) == 0
    bag = Bag(node.folder / 'live')
    assert bag.complete
    assert bag.ending['end_reason'] == 'signal'
    recorded = [
        message for message in commands_in(bag.path) if message.topic.endswith('box/force')
    ]
    decoded = [cdr.decode(cdr.Vector3Stamped.TYPE, message.data) for message in recorded]
    assert [message.vector[0] for message in decoded] == sent
    assert [message.nanosec for message in decoded] == list(range(1, 31))
    assert len(commands_in(bag.path)) == 60
    # the applied wrench of the very tick shows the command
    shown = {
        m.sequence: cdr.decode(Applied.TYPE, m.data)
        for m in bag.messages([f'{node.namespace}/box/applied_wrench'])
    }
    last_of_tick = {m.sequence: command for m, command in zip(recorded, decoded)}
    for tick, command in last_of_tick.items():
        x, y, _ = shown[tick].force
        assert (y if command.frame_id == 'box' else x) == pytest.approx(
            command.vector[0], rel=1e-15
        )
    assert all(m.log_time == m.sequence * DT_NS for m in recorded)
    outcome = replayed(run_verb, bag.path)
    assert outcome['identical'], outcome


@pytest.mark.long  # in the short form: of a burst, in test_playback
def test_no_impulse_of_a_burst_is_lost_while_the_machine_lets_the_node_wait(
    start_node, meet, messages, commands_in
):
    node = start_node(record='true', record_path='burst')
    peer = meet(node)
    twists = peer.listen('stone/twist', cdr.TwistStamped)
    sender = peer.sender('stone/impulse', WrenchStamped)
    node.process.send_signal(signal.SIGSTOP)
    for _ in range(200):
        sender.publish(messages.wrench((0, 0, 1)))
    node.process.send_signal(signal.SIGCONT)
    # 200 times 1 N s on 0.5 kg, all exact in binary
    peer.until(lambda: twists and twists[-1].linear[2] == 400.0, 'the last impulse')
    assert node.stop() == 0
    assert len(commands_in(node.folder / 'burst')) == 200


def test_recording_from_the_middle_with_a_held_command_replays_identically(
    start_node, meet, messages, run_verb
):
    node = start_node(command_timeout=0.0, record_path='middle')
    peer = meet(node)
    applied = peer.listen('box/applied_wrench', Applied)
    sender = peer.sender('box/wrench', WrenchStamped)
    sender.publish(messages.wrench((1, 0, 0), (0, 0, 0.1), frame='box'))
    peer.until(lambda: any(any(a.force) for a in applied), 'the force')
    steady = peer.listen('stone/applied_wrench', Applied)
    push = peer.sender('stone/force', Vector3Stamped)
    push.publish(messages.force(0, 1, 0))
    peer.until(lambda: any(any(a.force) for a in steady), 'the steady force')
    answer = peer.switch('record', True)
    assert 'recording to middle' in answer.message
    assert 'already' in peer.switch('record', True).message
    refusal = peer.set('command_timeout', 1.0)
    assert not refusal.successful
    assert 'recording' in refusal.reason
    for _ in range(5):
        push.publish(messages.force(0, 1, 0))  # nothing changes, so no wrench is published for it
        sender.publish(messages.wrench((1, 0, 0), (0, 0, 0.1), frame='box'))
        seen = len(applied)
        peer.until(lambda seen=seen: len(applied) > seen, 'the next applied wrench')
    assert peer.switch('record', False).success
    # a second stretch gets a bag of its own
    assert 'middle_2' in peer.switch('record', True).message
    sender.publish(messages.wrench((0, 2, 0)))
    peer.until(lambda: any(a.force[1] == 2.0 for a in applied), 'the other force')
    assert node.stop(signal.SIGTERM) == 0
    for name, reason in (('middle', 'stopped'), ('middle_2', 'signal')):
        bag = Bag(node.folder / name)
        assert bag.ending['end_reason'] == reason
        assert int(bag.manifest['first_tick']) > 0
        outcome = replayed(run_verb, bag.path)
        assert outcome['identical'], outcome


def test_a_reset_ends_the_bag_and_begins_another(start_node, meet, run_verb):
    node = start_node(record='true', record_path='run', start_paused='true', step_count=25)
    peer = meet(node)
    assert peer.trigger('step').success
    refused = peer.set('command_timeout', 1.0)
    assert refused.reason.startswith('command_timeout: got 1 s while recording to run;')
    peer.until(lambda: refused.reason in node.said, 'the refusal in the log')
    assert 'command_timeout: command_timeout:' not in node.said
    answer = peer.trigger('reset')
    assert 'run_2' in answer.message
    assert peer.trigger('step').success
    assert node.stop() == 0
    first, second = Bag(node.folder / 'run'), Bag(node.folder / 'run_2')
    assert (first.ending['end_reason'], first.ending['last_tick']) == ('reset', '25')
    assert (second.ending['end_reason'], second.manifest['first_tick']) == ('signal', '25')
    assert second.ending['last_tick'] == '50'
    for bag, begins in ((first, 0), (second, 25)):  # with the states of their first instant
        assert next(m.sequence for m in bag.messages(['/clock'])) == begins
    assert replayed(run_verb, second.path)['identical']


def loop_of(scene, *, publish=id, bags=None, **settings):
    """A loop as fast as possible, for 120 ms, and its run."""
    run = Run(Simulation(load_scene(scene.encode())), RunSettings(**settings))
    loop = RunLoop(
        run, inbox=Inbox(run.rules), bags=bags or Bags(run, None), publish=publish, report=id,
        report_period=1.0, factor=0.0, stop_time=0.12, paused=False,
    )  # fmt: skip
    return loop, run


@pytest.mark.usefixtures('plain_source')
def test_impacts_that_no_published_tick_tells_are_published_at_the_end():
    published = []
    loop, _ = loop_of(BOUNCING, publish=published.append, publish_every=25)
    loop.run()
    assert loop.ending.problem is None
    (told,) = (batch for batch in published if batch.layout.topics[0].name.endswith('/impacts'))
    assert told is published[-1]
    assert told.times == (30 * 4_000_000,)


def fail(*_):
    raise LookupError('no such thing')


@pytest.mark.usefixtures('plain_source')
def test_a_request_that_only_looks_fails_alone():
    loop, run = loop_of(BOUNCING)
    asked = [loop.requests.post('visit', fail) for _ in range(2)]
    asked.append(loop.requests.post('real_time_factor', None))
    seen = loop.requests.post('visit', lambda visit: None)
    loop.run()
    assert (loop.ending.reason, loop.ending.problem) == ('stop_time', None)
    for request in asked[:2]:
        assert request.answer == (False, 'LookupError: no such thing')
    assert not asked[2].answer.granted and seen.answer.granted
    said = 'visit: failed, and the run goes on: LookupError: no such thing'
    assert run.warnings.count(said) == 1  # each failure once


@pytest.mark.usefixtures('plain_source')
@pytest.mark.parametrize('name', ['step', 'steps', 'reset', 'record'])
def test_a_request_that_fails_on_its_way_ends_the_run(name, monkeypatch):
    loop, _ = loop_of(BOUNCING)
    monkeypatch.setattr(loop, '_answer', fail)
    request = loop.requests.post(name)
    loop.run()
    assert (loop.ending.reason, str(loop.ending.problem)) == ('error', 'no such thing')
    assert not request.answer.granted


@pytest.mark.usefixtures('plain_source')
def test_a_bag_whose_node_fails_before_it_runs_is_closed(monkeypatch, tmp_path):
    _, run = loop_of(BOUNCING)
    settings = SimpleNamespace(step_mode='free', record=True, record_path=str(tmp_path / 'bag'))
    node = SimpleNamespace(settings=settings, open_topics=lambda *_: None, get_logger=lambda: None)
    monkeypatch.setattr(session, '_make_loop', fail)
    monkeypatch.setattr(session.STOP, 'keep', lambda: None)
    with pytest.raises(LookupError):
        session._serve(node, run, None)
    bag = Bag(tmp_path / 'bag')
    assert bag.complete and bag.ending['end_reason'] == 'error'


def test_impacts_that_no_published_tick_tells_come_before_a_reset_and_into_each_bag(
    start_node, meet, run_verb, tmp_path
):
    path = tmp_path / 'dropped.yaml'
    path.write_text(BOUNCING)
    node = start_node(
        scene=path, record='true', record_path='run', start_paused='true', step_count=30,
        publish_rate=10.0,
    )  # fmt: skip
    peer = meet(node)
    told = peer.listen('rigid_body_sim/impacts', cdr.PointCloud2)
    assert peer.trigger('step').success  # 25 was published last
    assert peer.trigger('reset').success
    peer.until(lambda: told, 'the impact before the reset')
    assert (told[0].sec, told[0].nanosec) == (0, 30 * 4_000_000)
    assert peer.trigger('step').success  # 50 was published last
    assert node.stop() == 0
    for name, tick in (('run', 25), ('run_2', 55)):
        bag = Bag(node.folder / name)
        (recorded,) = bag.messages([f'{node.namespace}/rigid_body_sim/impacts'])
        assert name == 'run_2' or recorded.data == cdr.encode(told[0])
        assert read_impacts(bag).tick_ns.tolist() == [tick * 4_000_000]
        assert replayed(run_verb, bag.path)['identical']


def test_what_a_service_began_to_record_is_recorded_behind_a_reset_too(start_node, meet, run_verb):
    node = start_node(record_path='run', start_paused='true', step_count=25)
    peer = meet(node)
    assert 'recording to run from' in peer.switch('record', True).message
    assert peer.trigger('step').success
    answer = peer.trigger('reset').message
    assert 'closed run;' in answer
    assert answer.endswith('recording to run_2')
    assert peer.trigger('step').success
    assert peer.switch('record', False).message == 'closed run_2'
    assert 'recording' not in peer.trigger('reset').message  # the wish has ended
    assert peer.switch('record', False).message == 'already not recording'
    assert node.stop() == 0
    assert sorted(path.name for path in node.folder.glob('run*')) == ['run', 'run_2']
    second = Bag(node.folder / 'run_2')
    assert (second.manifest['first_tick'], second.ending['last_tick']) == ('25', '50')
    assert replayed(run_verb, second.path)['identical']


def test_a_reset_goes_on_where_the_next_bag_cannot_be_made(start_node, meet, run_verb):
    folder = 'b' * 248  # the names of the next bag and of the file in it are too long
    node = start_node(record='true', record_path=folder, start_paused='true', step_count=25)
    peer = meet(node)
    assert peer.trigger('step').success
    answer = peer.trigger('reset')
    assert answer.success
    assert 'not recording from tick 25' in answer.message
    assert '~/record' in answer.message
    assert peer.trigger('step').message.startswith('at tick 50')
    assert not peer.switch('record', True).success
    assert node.stop() == 0
    assert 'Traceback' not in node.said
    assert 'WARN' in node.said
    assert [path.name for path in node.folder.glob('b*')] == [folder]
    assert Bag(node.folder / folder).ending['end_reason'] == 'reset'
    assert replayed(run_verb, node.folder / folder)['identical']


def test_a_killed_recording_can_be_recovered_and_replayed(start_node, meet, messages, run_verb):
    node = start_node(record='true', record_path='torn')
    peer = meet(node)
    applied = peer.listen('box/applied_wrench', Applied)
    peer.sender('box/force', Vector3Stamped).publish(messages.force(1, 0, 0))
    peer.until(lambda: any(a.force[0] for a in applied), 'the force')
    looks = [(time.monotonic(), applied[-1])]

    def later():
        looks.append((time.monotonic(), applied[-1]))
        return looks[-1][0] > looks[0][0] + 0.9

    peer.until(later, 'almost another second')
    killed = time.monotonic()
    assert node.stop(signal.SIGKILL) == -signal.SIGKILL
    saved = node.folder / 'saved'
    done = run_verb('bag', 'recover', node.folder / 'torn', '-o', saved)
    assert done.returncode == 0, done.stderr
    bag = Bag(saved)
    # The promise is of half a second on the wall, in which a node may catch up with many ticks.
    old = [a for moment, a in looks if moment < killed - 0.5][-1]
    assert bag.last_time >= old.sec * 1_000_000_000 + old.nanosec
    assert bag.counts[f'{node.namespace}/box/force'] == 1
    assert replayed(run_verb, saved)['identical']


def test_stop_time_ends_the_run_with_a_whole_bag(start_node):
    node = start_node(record='true', record_path='all', real_time_factor=0.0, stop_time=2.0)
    assert node.wait() == 0
    bag = Bag(node.folder / 'all')
    assert (bag.ending['end_reason'], bag.ending['last_tick']) == ('stop_time', '2000')
    assert bag.counts['/clock'] == 201  # with that of t = 0


@pytest.mark.parametrize('publish_rate', [pytest.param(1e-6, marks=pytest.mark.long), 1e-9])
def test_the_run_ends_before_the_tick_that_no_message_can_bear(
    start_node, tmp_path, run_verb, publish_rate
):
    scene = tmp_path / 'ages.yaml'
    scene.write_text(
        'version: 1\nname: ages\ndt: 1000000\ngravity: [0, 0, 0]\nbodies:\n'
        '  - {name: b, shape: {type: particle}, mass: 1.0, initial: {velocity: [1, 0, 0]}}\n'
    )
    node = start_node(
        scene=scene,
        record='true',
        record_path='ages',
        real_time_factor=0.0,
        publish_rate=publish_rate,
    )
    assert node.wait() == 1
    assert 'Traceback' not in node.said
    last = node.said.strip().splitlines()[-1]
    assert 'tick 2147, 2.147e+09 s' in last
    assert '2^31 s' in last
    assert 'stop_time' in last
    bag = Bag(node.folder / 'ages')
    assert (bag.ending['end_reason'], bag.ending['last_tick']) == ('error', '2147')
    assert bag.counts['/clock'] == 1 + 2147 // round(1e-6 / publish_rate)
    assert run_verb('bag', 'check', bag.path).returncode == 0
    assert replayed(run_verb, bag.path)['identical']


def test_a_full_disk_ends_the_run_with_1_and_says_what_is_safe(start_node):
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    # twice real time: as fast as possible the first chunk may be more than there is room for
    node = start_node(record='true', record_path='full', real_time_factor=2.0, preexec=small_files)
    assert node.wait() == 1
    summary, bag, last = node.said.strip().splitlines()[-3:]
    assert 'are safe' in last
    assert summary.startswith('[ERROR]')
    assert 'error: full: writing failed' in summary  # why, and how far it came
    assert ' ticks, ' in summary
    assert bag.startswith('[ERROR]')
    assert 'recorded in part: full, without an ending' in bag
    assert 'bag recover full -o NEW' in bag
    assert 'Traceback' not in node.said


@pytest.mark.parametrize('called', [pytest.param('reset', marks=pytest.mark.long), 'record'])
def test_a_recording_whose_folder_is_removed_fails_by_name(start_node, meet, called):
    node = start_node(record='true', record_path='gone', start_paused='true', step_count=25)
    peer = meet(node)
    assert peer.trigger('step').success
    (node.folder / 'gone' / 'gone_0.mcap').unlink()  # metadata could be written beside nothing
    answer = peer.trigger('reset') if called == 'reset' else peer.switch('record', False)
    assert not answer.success
    assert 'gone: the file of this recording was removed' in answer.message
    assert 'what was recorded is lost' in answer.message
    assert node.wait() == 1
    assert 'safe' not in node.said
    assert 'bag recover' not in node.said
    assert 'recorded: ' not in node.said
    assert 'Traceback' not in node.said


def test_a_recording_that_could_not_begin_on_a_full_disk_can_be_begun_later(
    start_node, meet, run_verb
):
    node = start_node(record_path='later')
    peer = meet(node)
    limit = resource.RLIMIT_FSIZE
    free = resource.prlimit(node.process.pid, limit)
    for most in (1_000, 10_000):  # room for its head alone, and for no states
        resource.prlimit(node.process.pid, limit, (most, free[1]))
        refused = peer.switch('record', True)
        assert not refused.success
        assert 'nothing is recorded' in refused.message
        assert not (node.folder / 'later').exists()
    resource.prlimit(node.process.pid, limit, free)
    assert 'recording to later from' in peer.switch('record', True).message
    assert peer.switch('record', False).success
    assert node.stop() == 0
    assert replayed(run_verb, node.folder / 'later')['identical']


def test_a_run_that_diverges_ends_with_1_and_a_readable_bag(start_node, tmp_path):
    scene = tmp_path / 'stiff.yaml'
    scene.write_text(
        'version: 1\ndt: 0.1\nintegrator: explicit_euler\nbodies:\n'
        '  - {name: b, shape: {type: particle}, mass: 1.0e-3, initial: {position: [1, 0, 0]}}\n'
        'forces:\n  - {type: spring, a: b, b: world, stiffness: 1.0e+9, rest_length: 0.1}\n'
    )
    node = start_node(
        scene=scene, record='true', record_path='wild', real_time_factor=0.0, publish_rate=10.0
    )
    assert node.wait() == 1
    assert "'b' diverged in tick" in node.said.strip().splitlines()[-1]
    assert 'Traceback' not in node.said
    before, _, _ = node.said.partition('ready:')
    assert "'b' may swing at 1e+06 rad/s" in before  # it was warned of before the first tick
    bag = Bag(node.folder / 'wild')
    warnings = json.loads(bag.ending['warnings'])  # of its limit once, then of what it gains
    assert [text for text in warnings if 'may swing' in text] == warnings[:1]
    assert bag.ending['end_reason'] == 'diverged'
    assert bag.counts['/clock'] == 1 + int(bag.ending['last_tick']) > 1
