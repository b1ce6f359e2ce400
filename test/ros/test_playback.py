# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`wrench_pub`: commands of the command line, and of any recording, reach a node in another process.
"""

import time

import pytest
from geometry_msgs.msg import Vector3Stamped
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.cdr import PoseStamped
from rigid_body_sim.recording.cdr import WrenchStamped as Applied
from rigid_body_sim.recording.topics import Topic
from rigid_body_sim.ros import playback
from rigid_body_sim.runs.commands import Command

from ..patience import PATIENCE

PUSH = ['box', '--force', '1', '0', '0']
FIRST = 1_700_000_000_000_000_000  # [ns] a foreign recorder stamps with wall time


@pytest.fixture
def foreign_bag(tmp_path):
    """
    A bag as another recorder writes it: commands every 20 ms, and topics that are none.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = {
        f'geometry_msgs/msg/{name}': store.types[f'geometry_msgs/msg/{name}']
        for name in ('Vector3Stamped', 'WrenchStamped', 'Vector3', 'Wrench')
    }
    header, time = store.types['std_msgs/msg/Header'], store.types['builtin_interfaces/msg/Time']
    vector, wrench = kinds['geometry_msgs/msg/Vector3'], kinds['geometry_msgs/msg/Wrench']
    path = tmp_path / 'foreign'
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {
            name: writer.add_connection(topic, kind, typestore=store)
            for name, topic, kind in (
                ('force', '/lab/stone/force', 'geometry_msgs/msg/Vector3Stamped'),
                ('impulse', '/lab/box/impulse', 'geometry_msgs/msg/WrenchStamped'),
                ('other', '/lab/stone/felt', 'geometry_msgs/msg/Vector3Stamped'),
            )
        }

        def write(name, ms, message):
            kind = topics[name].msgtype
            writer.write(topics[name], FIRST + ms * 1_000_000, store.serialize_cdr(message, kind))

        def head(ms):
            return header(stamp=time(sec=5, nanosec=ms), frame_id='')

        for k in range(10):
            push = vector(x=float(k + 1), y=0.0, z=0.0)
            write(
                'force',
                20 * k,
                kinds['geometry_msgs/msg/Vector3Stamped'](header=head(k), vector=push),
            )
            write(
                'other',
                20 * k,
                kinds['geometry_msgs/msg/Vector3Stamped'](header=head(k), vector=push),
            )
        zero = vector(x=0.0, y=0.0, z=0.0)
        jolt = wrench(force=vector(x=0.0, y=0.0, z=4.0), torque=zero)
        write(
            'impulse', 100, kinds['geometry_msgs/msg/WrenchStamped'](header=head(0), wrench=jolt)
        )
    return path


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """
    A sender finds its listener, however busy the machine is.
    """
    monkeypatch.setattr(playback, 'MATCHING', PATIENCE)


class OwnTime:
    """
    A clock for the sender: it counts what is slept, and SENDING for each message, nothing else.
    """

    SENDING = 0.007  # [s]

    def __init__(self):
        self.now = 0.0
        self.sent = []  # (topic, when)

    def monotonic(self):
        return self.now

    def monotonic_ns(self):
        return time.monotonic_ns()  # for names

    def sleep(self, seconds):
        self.now += seconds
        time.sleep(seconds)

    def note(self, send):
        """
        Note when each message is sent by `send`.
        """

        def noted(sender, topic, data):
            self.sent.append((topic, self.now))
            self.now += self.SENDING
            send(sender, topic, data)

        return noted


def test_commands_of_a_foreign_bag_drive_the_node_as_they_were_spaced(
    lab, foreign_bag, commands_in, monkeypatch, capsys
):
    applied = lab.listen('stone/applied_wrench', Applied)
    poses = lab.listen('box/pose', PoseStamped)
    clock = OwnTime()
    monkeypatch.setattr(playback, 'time', clock)
    monkeypatch.setattr(playback.Sender, 'send', clock.note(playback.Sender.send))
    assert lab.switch('record', True).success
    assert main(['wrench_pub', '--bag', str(foreign_bag)]) == 0
    assert '11 messages sent' in capsys.readouterr().out
    lab.until(lambda: any(a.force[0] == 10.0 for a in applied), 'the last force')
    lab.until(lambda: poses and poses[-1].position[2] > 0, 'the jolt')
    bag = lab.switch('record', False).message.removeprefix('closed ')
    forces = [
        cdr.decode(cdr.Vector3Stamped.TYPE, message.data).vector[0]
        for message in commands_in(lab.node_process.folder / bag)
        if message.topic == '/lab/stone/force'
    ]
    assert forces == [float(k) for k in range(1, 11)]
    when = [moment for topic, moment in clock.sent if topic == '/lab/stone/force']
    # 20 ms apart although sending takes some of it; round-off
    assert [moment - when[0] for moment in when] == pytest.approx([0.02 * k for k in range(10)])


def test_a_bag_of_the_node_itself_can_be_played_and_chosen_from(
    lab, start_node, meet, messages, capsys
):
    node = start_node(record='true', record_path='own', start_paused='true')
    peer = meet(node)
    peer.sender('box/force', Vector3Stamped).publish(messages.force(0.5, 0, 0))
    applied = peer.listen('box/applied_wrench', Applied)
    peer.until(
        lambda: peer.trigger('step').success and any(a.force[0] for a in applied), 'the force'
    )
    assert node.stop() == 0
    chosen, timed = playback.commands_of_bag(node.folder / 'own', topics=[], rate_factor=1.0)
    assert [topic.name for topic in chosen] == [f'{node.namespace}/box/force']
    (message,) = timed
    assert cdr.decode(chosen[0].type, message.data).vector == (0.5, 0.0, 0.0)
    assert main(['wrench_pub', '--bag', str(node.folder / 'own'), '--topics', '/x/force']) == 2
    assert f'{node.namespace}/box/force' in capsys.readouterr().err


def test_a_bag_is_played_twice_as_fast_on_request(foreign_bag):
    _, slow = playback.commands_of_bag(foreign_bag, topics=['/lab/stone/force'], rate_factor=1.0)
    _, fast = playback.commands_of_bag(foreign_bag, topics=['/lab/stone/force'], rate_factor=2.0)
    assert [m.time for m in slow] == pytest.approx([0.02 * k for k in range(10)])
    assert [m.time for m in fast] == pytest.approx([0.01 * k for k in range(10)])


def only_timed(monkeypatch):
    """
    Let the sender note when it would send, at once; return its clock.
    """
    clock = OwnTime()
    clock.SENDING = 0.0
    monkeypatch.setattr(playback, 'time', clock)
    monkeypatch.setattr(clock, 'sleep', lambda seconds: setattr(clock, 'now', clock.now + seconds))
    monkeypatch.setattr(playback.Sender, 'send', clock.note(lambda *_: None))
    return clock


def test_of_a_burst_at_one_instant_nothing_is_lost(lab, tmp_path, monkeypatch, capsys):
    twists = lab.listen('stone/twist', cdr.TwistStamped)  # of a body at rest
    clock = OwnTime()
    monkeypatch.setattr(playback, 'time', clock)
    count, push = 3000, cdr.WrenchStamped(0, 0, '', (0.0, 2.0**-20, 0.0), (0.0, 0.0, 0.0))
    burst = [playback.Message(0.0, '/lab/stone/impulse', cdr.encode(push))] * count
    topic = Topic('/lab/stone/impulse', push.TYPE)
    monkeypatch.setattr(playback, 'commands_of_bag', lambda *_, **__: ([topic], burst))
    assert main(['wrench_pub', '--bag', str(tmp_path)]) == 0
    assert f'{count} messages sent' in capsys.readouterr().out
    # of all impulses together over 0.5 kg, exact; the newest state alone tells it, so that nothing
    # hangs on how many states wait for us while we send
    lab.until(lambda: twists and twists[-1].linear[1] == count * 2.0**-19, 'all of it')


def test_the_beginning_of_a_burst_goes_at_once_and_the_rest_as_fast_as_it_is_taken(monkeypatch):
    clock = only_timed(monkeypatch)
    with playback.Sender() as sender:
        messages = [playback.Message(0.0, topic, b'') for topic in ('a', 'b') for _ in range(3000)]
        assert sender.play(messages) == 6000
    for topic in ('a', 'b'):
        when = [moment for name, moment in clock.sent if name == topic]
        assert when[999] - when[0] == pytest.approx(0.0, abs=1e-9)  # round-off
        assert when[-1] - when[0] == pytest.approx(2000 / playback.FASTEST, abs=1e-3)  # a message


def test_a_stream_slower_than_it_is_taken_is_not_delayed(monkeypatch):
    clock = only_timed(monkeypatch)
    with playback.Sender() as sender:
        sender.play([playback.Message(0.001 * k, 'a', b'') for k in range(5000)])
    when = [moment for _, moment in clock.sent]
    assert when == pytest.approx([0.001 * k for k in range(5000)], abs=1e-9)  # round-off


@pytest.mark.parametrize(
    ('rate', 'seconds', 'count'), [(100.0, 1.0, 100), (0.1, 1.0, 1), (1.0, 2.5, 3), (3.0, 1.0, 3)]
)
def test_a_wrench_ends_after_its_time_whatever_the_rate(monkeypatch, rate, seconds, count):
    clock = only_timed(monkeypatch)
    monkeypatch.setattr(playback.Sender, 'open', lambda *_: None)
    push = Command('box', 'wrench', (1.0, 0.0, 0.0))
    sent = playback.publish_command(push, namespace='', rate_hz=rate, seconds=seconds)
    when = [moment - clock.sent[0][1] for _, moment in clock.sent]
    assert sent == len(when) == count + 1
    assert when[:-1] == pytest.approx([k / rate for k in range(count)], abs=1e-9)  # round-off
    assert when[-1] == pytest.approx(seconds, abs=1e-9)


def test_what_has_not_arrived_is_told_and_exits_1(lab, foreign_bag, monkeypatch, capsys):
    missed = ['/lab/stone/force']
    monkeypatch.setattr(playback.Sender, 'finish', lambda sender: missed)
    assert main(['wrench_pub', '--bag', str(foreign_bag)]) == 1
    said = capsys.readouterr()
    assert '11 messages sent, but after 30 s not all of them have arrived on /lab/st' in said.err
    assert said.err.count('\n') == 1 and 'sent' not in said.out


def test_a_wrench_of_the_command_line_acts_and_is_let_go(lab, run_verb):
    applied = lab.listen('box/applied_wrench', Applied)
    assert lab.set('command_timeout', 0.0).successful
    done = run_verb(
        'wrench_pub', 'box', '--namespace', '/lab',
        '--force', '-1e-1', '0', '.5', '--torque', '0', '0', '-2',
        '--frame', 'body', '--rate', '10', '--for', '1',
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert '11 messages sent' in done.stdout
    lab.until(
        lambda: applied and not any(applied[-1].force) and any(any(a.force) for a in applied),
        'release',
    )
    acting = next(a for a in applied if any(a.force))
    assert acting.force == pytest.approx((0, -0.1, 0.5), abs=1e-12)  # its x axis points along y
    assert acting.torque == pytest.approx((0, 0, -2), abs=1e-12)


def test_an_impulse_of_the_command_line_acts_once(lab, capsys):
    applied = lab.listen('stone/applied_wrench', Applied)
    words = [
        'wrench_pub',
        'stone',
        '--impulse',
        '--force',
        '0',
        '0.002',
        '0',
        '--namespace',
        'lab',
    ]
    assert main(words) == 0
    struck = lab.until(lambda: [a for a in applied if a.force[1]], 'the jolt')
    seen = len(applied)
    lab.until(lambda: len(applied) > seen + 5, 'later ticks')
    assert len([a for a in applied if a.force[1]]) == len(struck) == 1
    assert struck[0].force[1] == pytest.approx(0.002 / 0.001)


def test_the_sender_is_told_what_a_frame_may_be_that_only_the_node_knows(monkeypatch, capsys):
    sent = []
    monkeypatch.setattr(
        'rigid_body_sim.verbs.wrench_pub.publish_command',
        lambda command, **_: sent.append(command.frame_id) or 1,
    )
    for frame, frame_id, is_told in (
        ('mars', 'box/mars', True),
        ('box/mars', 'box/mars', True),
        ('box', 'box', False),
        ('body', 'box', False),
        ('world', '', False),
    ):
        assert main(['wrench_pub', 'box', '--force', '0', '0', '1', '--frame', frame]) == 0
        err = capsys.readouterr().err
        assert sent.pop() == frame_id
        assert ('refuses every message' in err and 'always known: world, body' in err) == is_told


def test_nobody_listening_is_an_error(monkeypatch, capsys):
    monkeypatch.setattr(playback, 'MATCHING', 0.2)
    assert main(['wrench_pub', 'nobody', '--force', '1', '0', '0']) == 1
    said = capsys.readouterr().err
    assert '/nobody/wrench' in said
    assert said.count('\n') == 1


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        (['box'], '--force'),
        ([], 'BODY'),
        (['box', '--bag', 'b'], 'BODY'),
        (['--bag', 'none'], 'none'),
        (['box', '--force', '1', '0', '0', '--rate', '0'], '--rate'),
        (['box', '--force', '1', '0', '0', '--for', '-1'], '--for'),
        (['--bag', 'b', '--impulse'], '--impulse'),
        (['--bag', 'b', '--rate', '100'], '--bag b: --rate is of a command to a BODY; '),
        (['--bag', 'b', '--rate', '2'], 'how fast a bag is played is --rate-factor'),
        (['--bag', 'b', '--for', '3'], '--bag b: --for is of'),
        (['--bag', 'b', '--frame', 'body'], '--bag b: --frame is of'),
        (['--bag', 'b', '--namespace', 'lab'], '--bag b: --namespace is of'),
        ([*PUSH, '--rate-factor', '2'], 'without --bag: --rate-factor is of a bag'),
        ([*PUSH, '--topics', '/a'], 'without --bag: --topics is of a bag'),
        ([*PUSH, '--impulse', '--for', '2'], '--impulse: --for is of a wrench'),
    ],
)
def test_a_bad_command_line_exits_2_with_one_line(capsys, words, expected):
    assert main(['wrench_pub', *words]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert said.count('\n') == 1
