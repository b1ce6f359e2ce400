# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a run that goes on: a bag is followed while it is written, a browser sees it."""

from __future__ import annotations

import argparse
import contextlib
import http.client
import struct
import threading
import time

import numpy as np
import pytest

from rigid_body_sim.analysis.recorded_contacts import read_points
from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import cdr
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.batch import MESSAGE_HEAD, MESSAGE_LENGTH_EXTRA, MESSAGE_OPCODE
from rigid_body_sim.recording.chunk import Chunk
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.scene import load_scene
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view import bag_follower, live_server
from rigid_body_sim.view.bag_follower import BEGINNING, BagFollower
from rigid_body_sim.view.contact_arrows import read_arrows
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.growing_motion import GrowingMotion, joined
from rigid_body_sim.view.recorded_motion import read_motion

DURATION = 4.0  # [s]


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """The bytes of a recorded run, and its bag."""
    path = tmp_path_factory.mktemp('live') / 'bag'
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = ['two_bodies', '-o', str(path), '--duration', str(DURATION), '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    return next(path.glob('*.mcap')).read_bytes(), Bag(path)


class Writing:
    """A bag whose bytes come bit by bit, as a writer would append them."""

    def __init__(self, folder, content):
        self.path = folder / 'bag'
        self.path.mkdir()
        self._file, self._content = self.path / 'bag_0.mcap', content

    def up_to(self, part):
        self._file.write_bytes(self._content[: round(part * len(self._content))])


def test_what_is_followed_is_what_is_in_the_bag_wherever_the_file_ends_meanwhile(
    written, tmp_path
):
    content, bag = written
    writing = Writing(tmp_path, content)
    writing.up_to(0.37)
    follower = BagFollower(writing.path)
    blocks = [follower.begin()]
    assert (follower.title, follower.ended) == ('two_bodies', False)
    for part in (0.3702, 0.5, 0.77, 0.9999, 1.0):
        writing.up_to(part)
        block = follower.more()
        if block is not None:
            blocks.append(block)
    assert follower.ended and follower.more() is None
    whole, found = read_motion(bag, samples=10**6), joined(blocks)
    for wanted, track in zip(whole.tracks, found.tracks, strict=True):
        assert track.name == wanted.name
        assert np.all(np.diff(track.time) > 0)
        assert track.time[-1] == wanted.time[-1]  # thinned, but the newest is there
        places = np.searchsorted(wanted.time, track.time)
        for name in ('time', 'position', 'orientation', 'velocity', 'angular_velocity'):
            assert np.array_equal(getattr(track, name), getattr(wanted, name)[places])


def test_what_is_no_bag_that_goes_on_is_refused(tmp_path):
    (tmp_path / 'note.txt').write_text('no bag')
    follower, begun = BagFollower(tmp_path / 'note.txt'), time.monotonic()
    with pytest.raises(UserError, match='not a bag'):
        follower.begin()
    assert time.monotonic() - begun < 0.5 * BEGINNING  # at once, not when nothing has come
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    for words, said in (
        (['bag', '--live', '-o', 'run.html'], 'leave out -o'),
        (['bag', '--live', '--port', '70000'], '--port 70000'),
        ([], 'give a BAG and -o FILE'),
    ):
        with pytest.raises(UserError, match=said):
            view.run(parser.parse_args(words))


def test_what_is_not_there_is_said_at_once_and_may_still_come(
    written, tmp_path, monkeypatch, capsys
):
    nowhere = BagFollower(tmp_path / 'no' / 'bag')
    with pytest.raises(UserError, match='nor the folder it would be in'):
        nowhere.begin()  # at once
    monkeypatch.setattr(bag_follower, 'BEGINNING', 0.2)
    with pytest.raises(UserError, match='no such file or directory, and no run made it'):
        BagFollower(tmp_path / 'nosuch').begin()
    assert 'nosuch: no such file or directory yet; waiting' in capsys.readouterr().err
    monkeypatch.setattr(bag_follower, 'BEGINNING', BEGINNING)
    late = threading.Timer(0.3, lambda: Writing(tmp_path, written[0]).up_to(0.5))
    late.start()
    assert BagFollower(tmp_path / 'bag').begin().tracks
    late.join()


POSE, TURTLE = cdr.PoseStamped.TYPE, 'turtlesim/msg/Pose'
PLACED = cdr.encode(cdr.PoseStamped(1, 0, 'map', (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)))
CRAWLS = b'\0\1\0\0' + struct.pack('<5f', 5, 5, 0, 0, 0)


def foreign(path, *messages):
    """A bag of another recorder: (topic, type, payload), a topic is declared when it comes."""
    path.mkdir()
    schemas, channels = {}, {}
    with (path / 'bag_0.mcap').open('xb', buffering=0) as stream:
        file = McapFile(stream, library='another')
        for time_ns, (topic, kind, payload) in enumerate(messages):
            if kind not in schemas:
                schemas[kind] = file.add_schema(kind, 'ros2msg', b'')
            if topic not in channels:
                channels[topic] = file.add_channel(schemas[kind], topic, 'cdr', {})
            size = MESSAGE_LENGTH_EXTRA + len(payload)
            head = MESSAGE_HEAD.pack(MESSAGE_OPCODE, size, channels[topic], 0, time_ns, time_ns)
            number, when = np.array([channels[topic]], np.uint16), np.array([time_ns], np.int64)
            file.write_chunk(Chunk(head + payload, number, when, np.zeros(1, np.int64)))
        file.finish()
    return path


def followed(path):
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    return view.run(parser.parse_args([str(path), '--live']))


@pytest.mark.parametrize('first', [True, False])
def test_poses_of_another_type_are_left_out_of_what_is_followed(tmp_path, first):
    turtle, ball = ('/turtle/pose', TURTLE, CRAWLS), ('/ball/pose', POSE, PLACED)
    messages = (turtle, ball) if first else (ball, turtle)
    (track,) = BagFollower(foreign(tmp_path / 'bag', *messages)).begin().tracks
    assert track.name == 'ball'
    np.testing.assert_array_equal(track.position, [[1.0, 2.0, 3.0]])


def test_a_bag_that_holds_poses_of_another_type_alone_is_refused_at_once(tmp_path):
    path, begun = foreign(tmp_path / 'bag', ('/turtle/pose', TURTLE, CRAWLS)), time.monotonic()
    with pytest.raises(RunError, match='expected messages of geometry_msgs/msg/PoseStamped'):
        followed(path)
    assert time.monotonic() - begun < 0.5 * BEGINNING


def test_a_body_whose_topic_comes_behind_the_first_states_is_left_out(tmp_path):
    late = cdr.encode(cdr.PoseStamped(2, 0, 'map', (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0)))
    path = foreign(tmp_path / 'bag', ('/ball/pose', POSE, PLACED), ('/late/pose', POSE, late))
    (track,) = BagFollower(path).begin().tracks
    assert (track.name, len(track.time)) == ('ball', 1)


def test_what_is_followed_and_no_message_of_its_type_is_a_line_and_no_traceback(tmp_path):
    path = foreign(tmp_path / 'bag', ('/ball/pose', POSE, CRAWLS))
    with pytest.raises(DamagedBag, match='bag: damaged: what it holds does not fit together'):
        followed(path)


def test_a_browser_sees_the_run_grow_and_end(tab, written, tmp_path):
    content, _ = written
    writing = Writing(tmp_path, content)
    writing.up_to(0.4)
    run = live_server.LiveRun(BagFollower(writing.path))
    server = live_server.Server(0, run)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        tab.open(f'http://127.0.0.1:{server.server_port}/')
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        before = tab.evaluate('[view.run.instants, view.run.end, view.player.now]')
        assert before[1] < DURATION and before[2] == before[1]
        for part in (0.7, 1.0):
            writing.up_to(part)
            run.look()
        tab.wait_for("document.body.dataset.live === 'ended'")
        now, end = tab.evaluate('[view.player.now, view.run.end]')
        assert now == end == pytest.approx(DURATION)
        assert tab.evaluate('view.run.instants') > before[0]
        lengths = tab.evaluate(
            'Object.values(view.run.series).map(each => each.values.length / each.width)'
        )
        assert len(set(lengths)) == 1  # every series has grown alike
        tab.evaluate('view.seek(1.0)')
        assert not tab.evaluate("document.getElementById('live').checked")
        assert tab.errors == []
        assert '<script' not in _answer(server, 'evil.example')
    finally:
        run.stop()
        server.shutdown()
        server.server_close()


@pytest.fixture(scope='module')
def touching(tmp_path_factory):
    """The bytes of a run in which bodies meet, with its contacts, and its bag."""
    path = tmp_path_factory.mktemp('touching') / 'bag'
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = ['rolling_sphere', '-o', str(path), '--duration', '1', '--json', '--contacts']
    assert simulate.run(parser.parse_args(words)) == 0
    return next(path.glob('*.mcap')).read_bytes(), Bag(path)


def test_energies_and_contact_forces_grow_with_the_run_as_the_whole_bag_has_them(
    tab, touching, tmp_path
):
    content, bag = touching
    writing = Writing(tmp_path, content)
    writing.up_to(0.2)
    with live_page_of(BagFollower(writing.path)) as (run, address):
        tab.open(address)
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        for part in (0.3, 0.6, 1.0):
            writing.up_to(part)
            run.look()
        tab.wait_for("document.body.dataset.live === 'ended'")
        grown = tab.evaluate("""({
            times: [...view.run.times], starts: [...view.arrows.sets.at(-1).starts],
            forces: [...view.arrows.sets.at(-1).numbers],
            energies: ['kinetic', 'potential', 'total'].map(x => [...view.run.series[x].values]),
            titles: [...document.querySelectorAll('figure .title')].map(x => x.textContent) })""")
        struck = int(np.flatnonzero(np.diff(grown['starts']))[0])
        tab.evaluate(f'view.seek({grown["times"][struck]})')
        assert tab.evaluate('view.arrows.count.contact') >= 1
        said = tab.evaluate("document.getElementById('legend').innerText")
        assert 'contact force' in said and 'commanded' not in said  # nobody commanded anything
        assert tab.errors == []
    times = np.array(grown['times'])
    whole = read_arrows(bag, times, {'ground': 0, 'ball': 1})
    assert grown['starts'] == whole.starts.tolist() and whole.starts[-1] > 0
    assert np.array_equal(grown['forces'], whole.arrows.astype('f4').ravel())
    kinetic, potential, total = np.array(grown['energies'])
    scene = load_scene('rolling_sphere')
    history = energy_history(scene, read_motion(bag, samples=10**6))
    rows = np.searchsorted(history.time, times)
    assert np.array_equal(kinetic, history.kinetic[rows])
    assert np.array_equal(potential, history.potential[rows])
    assert np.array_equal(total, kinetic + potential)
    assert 'energy [J]' in grown['titles']


BALLS = """
dt: 0.004
gravity: [0, 0, -9.81]
contact: {mode: event}
bodies:
  - {name: ground, shape: {type: plane, normal: [0, 0, 1]}, restitution: 0.9}
  - {name: low, shape: {type: sphere, radius: 0.1}, mass: 1, initial: {position: [0, 0, 0.3]}}
  - {name: high, shape: {type: sphere, radius: 0.1}, mass: 1, initial: {position: [1, 0, 0.4]}}
"""


class Hesitant(BagFollower):
    """A follower that has read the end, but has not yet given what came before it."""

    def __init__(self, path):
        super().__init__(path)
        self.has_read, self.may_give = threading.Event(), threading.Event()

    def more(self):
        block = super().more()
        self.has_read.set()
        assert self.may_give.wait(30)
        return block


def test_a_run_has_not_ended_before_its_last_block_is_there(written, tmp_path):
    content, _ = written
    writing = Writing(tmp_path, content)
    writing.up_to(0.5)
    source = Hesitant(writing.path)
    run = live_server.LiveRun(source)
    told, _ = run.after(0)
    writing.up_to(1.0)
    looking = threading.Thread(target=run.look)
    looking.start()
    assert source.has_read.wait(30)
    assert source.ended and not run.ended  # who streams meanwhile goes on waiting
    source.may_give.set()
    looking.join()
    assert run.ended
    assert run.after(told)[1] is not None


def test_impacts_grow_with_the_run_as_the_whole_bag_has_them(tab, tmp_path):
    scene = tmp_path / 'balls.yaml'
    scene.write_text(BALLS)
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = [str(scene), '-o', str(tmp_path / 'run'), '--duration', '2', '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    whole = read_impacts(Bag(tmp_path / 'run'))
    writing = Writing(tmp_path, next((tmp_path / 'run').glob('*.mcap')).read_bytes())
    writing.up_to(0.1)  # nobody has met anybody yet
    with live_page_of(BagFollower(writing.path)) as (run, address):
        tab.open(address)
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        assert tab.evaluate('[view.impacts.times.length, !!view.layers.impacts]') == [0, True]
        for part in (0.4, 0.7, 1.0):
            writing.up_to(part)
            run.look()
        tab.wait_for("document.body.dataset.live === 'ended'")
        times, places = tab.evaluate('[[...view.impacts.times], [...view.impacts.places]]')
        tab.evaluate(f'view.seek({times[0] + 0.02})')
        tab.wait_for('view.impacts.mesh.count === 1')
        assert tab.errors == []
        tab.open(address)  # who comes later finds all of them
        tab.wait_for("document.body.dataset.state === 'ready'")
        assert tab.evaluate('[...view.impacts.times]') == times
    assert len(whole) > 10
    assert times == whole.time.tolist()
    assert places == np.hstack((whole.point, whole.normal)).astype('f4').ravel().tolist()


def test_a_state_waits_for_the_contacts_that_come_behind_it(touching):
    """Topics of a node come in any order: contacts behind the states of their tick too."""
    _, bag = touching
    names = ['/ball/pose', '/ground/pose', '/ball/twist', '/ground/twist', '/ball/contacts']
    messages = sorted(bag.messages(names), key=lambda m: (m.log_time, names.index(m.topic)))
    growing, found = GrowingMotion(names[:2], names, late=True), []
    for message in messages:
        growing.take(message.topic, message.data)
        found.append(growing.whole(most=25))
    found.append(growing.whole(most=25))
    motion = joined([each for each in found if each is not None])
    assert motion.tracks[0].time[-1] == messages[-1].log_time / 1e9
    told = sum(len(rows) for each in motion.touching for rows in each.values())
    assert told == sum(len(read_points(m.data)) for m in bag.messages(names[4:])) > 0


@contextlib.contextmanager
def live_page_of(source):
    """Serve a source; gives the run and its address."""
    run = live_server.LiveRun(source)
    server = live_server.Server(0, run)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield run, f'http://127.0.0.1:{server.server_port}/'
    finally:
        run.stop()
        server.shutdown()
        server.server_close()


def _answer(server, host):
    """What somebody gets who comes under another name: a page of another site, for example."""
    connection = http.client.HTTPConnection('127.0.0.1', server.server_port, timeout=30)
    connection.request('GET', '/', headers={'Host': host})
    answer = connection.getresponse()
    assert answer.status == 403
    return answer.read().decode()
