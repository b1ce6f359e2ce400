# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a run that goes on: a bag is followed while it is written, a browser sees it."""

from __future__ import annotations

import argparse
import contextlib
import http.client
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from rigid_body_sim.analysis.recorded_contacts import read_points
from rigid_body_sim.analysis.recorded_impacts import read_impacts
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import cdr, chunk_queue
from rigid_body_sim.recording.bag_reader import Bag, DamagedBag
from rigid_body_sim.recording.batch import (
    MESSAGE_HEAD,
    MESSAGE_LENGTH_EXTRA,
    MESSAGE_OPCODE,
    Batch,
    TickLayout,
)
from rigid_body_sim.recording.chunk import Chunk
from rigid_body_sim.recording.mcap_file import McapFile
from rigid_body_sim.recording.topic_names import own_by_kind
from rigid_body_sim.scene import load_scene
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view import bag_follower, live_server
from rigid_body_sim.view.bag_follower import BEGINNING, BagFollower
from rigid_body_sim.view.contact_arrows import read_arrows
from rigid_body_sim.view.energy_history import energy_history
from rigid_body_sim.view.growing_motion import KINDS, GrowingMotion, joined, size_of, thinned
from rigid_body_sim.view.playback_page import unpacked
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track, read_motion

from ..pages import array_of
from ..patience import PATIENCE

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


@pytest.mark.parametrize('named', ['none', 'box_2,box_9', '*'])
def test_bodies_that_stand_in_arrays_alone_are_followed_as_the_whole_bag_has_them(tmp_path, named):
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = ['--arrays', '--body-topics', named, '--duration', '0.5', '--json']
    whole = tmp_path / 'whole'
    assert simulate.run(parser.parse_args(['stack', '-o', str(whole), *words])) == 0
    content = next(whole.glob('*.mcap')).read_bytes()
    writing = Writing(tmp_path, content)
    writing.up_to(0.9)
    follower = BagFollower(writing.path)
    blocks = [follower.begin()]
    writing.up_to(1.0)
    blocks += filter(None, [follower.more()])
    followed, read = joined(blocks), read_motion(Bag(whole), samples=10**6)
    assert len(followed.tracks) == 11 and follower.title == 'stack'
    expected = {track.name: track for track in read.tracks}
    for track in followed.tracks:
        for name in ('time', 'position', 'orientation', 'velocity', 'angular_velocity'):
            found, kept = getattr(track, name), getattr(expected[track.name], name)
            assert found.tobytes() == kept.tobytes()


@pytest.mark.parametrize('part', [0.5, pytest.param(1.0, marks=pytest.mark.long)])
@pytest.mark.parametrize('how', ['moved', 'removed', 'overwritten'])
def test_another_run_begins_where_another_bag_comes_in_its_place(written, tmp_path, part, how):
    content, _ = written
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    other = tmp_path / 'other'
    words = ['satellite', '-o', str(other), '--duration', '1', '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    writing = Writing(tmp_path, content)
    writing.up_to(part)
    follower = BagFollower(writing.path)
    run = live_server.LiveRun(follower)
    first = run.name
    if how == 'moved':
        writing.path.rename(tmp_path / 'away')
        other.rename(writing.path)
    elif how == 'removed':
        shutil.rmtree(writing.path)
        run.look()  # nothing is there: another run may come
        other.rename(writing.path)
    else:
        (writing.path / 'bag_0.mcap').write_bytes(next(other.glob('*.mcap')).read_bytes())
    run.look()
    assert (run.name != first, follower.title) == (True, 'satellite')
    assert follower.scene is not None and follower.scene.name == 'satellite'
    assert '<title>satellite' in run.page() and run.ended
    run.look()
    assert run.after(first, 1) is None  # which lets the page of the first load itself anew


def test_a_bag_that_goes_before_it_is_whole_is_waited_for_and_then_missed(
    written, tmp_path, monkeypatch
):
    monkeypatch.setattr(bag_follower, 'BEGINNING', 0.3)
    writing = Writing(tmp_path, written[0])
    writing.up_to(0.5)
    follower = BagFollower(writing.path)
    follower.begin()
    shutil.rmtree(writing.path)
    assert follower.more() is None
    time.sleep(0.4)
    with pytest.raises(RunError, match='no longer there, and no run made it anew within'):
        follower.more()


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
    told = np.array(grown['forces']).astype('f4')  # those of the first block are
    assert np.array_equal(told, whole.arrows.astype('f4').ravel())
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
    told, _ = run.after(run.name, 1)
    writing.up_to(1.0)
    looking = threading.Thread(target=run.look)
    looking.start()
    assert source.has_read.wait(30)
    assert source.ended and not run.ended  # who streams meanwhile goes on waiting
    source.may_give.set()
    looking.join()
    assert run.ended
    assert run.after(run.name, told)[1] is not None


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
    assert places == np.hstack((whole.point, whole.normal)).ravel().tolist()


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


def test_a_record_of_any_size_that_the_format_allows_is_followed(tmp_path):
    cloud = ('/cloud', cdr.PointCloud2.TYPE, bytes(70 << 20))
    path = foreign(tmp_path / 'bag', ('/ball/pose', POSE, PLACED), cloud)
    follower = BagFollower(path)
    assert follower.begin().tracks[0].time.tolist() == [1.0]
    while not follower.ended:
        assert follower.more() is None


def test_a_run_that_is_written_faster_than_it_is_read_is_shown_at_its_newest(
    tmp_path, monkeypatch
):
    """Of much more than a look may interpret, chunks are stepped over evenly."""
    for name in ('LARGEST_CHUNK_BYTES', 'THREADED_CHUNK_BYTES'):
        monkeypatch.setattr(chunk_queue, name, 5000)  # some hundred chunks
    path = tmp_path / 'fast'
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = ['two_bodies', '-o', str(path), '--duration', str(DURATION), '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    content, bag = next(path.glob('*.mcap')).read_bytes(), Bag(path)
    writing = Writing(tmp_path, content)
    writing.up_to(0.2)
    monkeypatch.setattr(bag_follower, 'LATER_LOOK', 20_000)
    assert len(content) > 10 * 20_000
    follower = BagFollower(writing.path)
    before = follower.begin().tracks[0].time[-1]
    writing.up_to(0.6)
    newest = BagFollower(writing.path).begin().tracks[0].time[-1]  # read whole
    assert before < follower.more().tracks[0].time[-1] == newest
    before = newest
    writing.up_to(1.0)
    block = follower.more()
    assert follower.ended
    (time, whole) = block.tracks[0].time, read_motion(bag, samples=10**6).tracks[0]
    assert time[-1] == DURATION and np.all(np.diff(time) > 0)
    assert before < time[0] < before + 0.1 * DURATION  # evenly: also of what came first
    places = np.searchsorted(whole.time, time)
    assert np.array_equal(block.tracks[0].position, whole.position[places])


def test_what_piles_up_at_a_writer_goes_out_in_chunks_of_bounded_size(monkeypatch):
    monkeypatch.setattr(chunk_queue, 'LARGEST_CHUNK_BYTES', 1000)
    layout = TickLayout.of_records((), 1, channels=[], sizes=[1], time_offsets=[])
    may_write, written = threading.Event(), []

    def slow(batches):
        assert may_write.wait(30)
        written.append(b''.join(batch.data for batch in batches))

    queue = chunk_queue.ThreadedQueue(slow)
    batches = [bytes([k]) * 300 for k in range(100)]
    for data in batches:
        queue.put(Batch(layout, data, (0,), None))
    may_write.set()
    queue.stop()
    assert b''.join(written) == b''.join(batches)
    assert max(map(len, written)) <= 1000 + 300  # one batch beyond


class Told:
    """A source that says what it is told to."""

    def __init__(self, *blocks):
        self.scene, self.title, self.about, self.ended, self.run = None, 'told', '', False, 0
        self.coming = list(blocks)

    def begin(self):
        return self.coming.pop(0)

    def more(self):
        return self.coming.pop(0) if self.coming else None


def moving(*times):
    """A ball at so many instants, which is pushed at each of them."""
    time, k = np.array(times, dtype=float), len(times)
    place, turn = np.outer(time, [1.0, 0.0, 0.0]), np.tile([0.0, 0.0, 0.0, 1.0], (k, 1))
    still = np.zeros((k, 3))
    track = Track('ball', time, place, turn, time, still, still, time, place, still)
    return RecordedMotion((track,), np.empty(0))


def test_what_is_kept_for_browsers_is_bounded_and_its_older_instants_are_thinned(monkeypatch):
    block = moving(*range(25))
    monkeypatch.setattr(live_server, 'MOST_BYTES', 100 * size_of(block))
    source = Told(block)
    run = live_server.LiveRun(source)
    for k in range(1, 1000):
        source.coming.append(moving(*range(25 * k, 25 * k + 25)))
        run.look()
        assert run.size <= live_server.MOST_BYTES
    assert len(run.page()) < 2 * len(live_server.LiveRun(Told(block)).page())
    record, numbers = unpacked(run.page())
    times = array_of(record['series']['time'], numbers)
    steps = np.diff(times)
    assert times[0] == 0.0 and times[-1] == 24_999.0 and np.all(steps > 0.0)
    assert np.all(steps[-25:] == 1.0) and steps.max() < 100.0  # evenly
    assert run.after(run.name, record['live']['told'] - 1)[1] is not None
    assert run.after(run.name, 30) is None  # those after it are apart no more


PUSHED = {
    'dt': 0.01,
    'bodies': [{'name': 'ball', 'shape': {'type': 'sphere', 'radius': 0.1}, 'mass': 1,
                'mass_rate': -0.01, 'final_mass': 0.5}],
    'forces': [{'type': 'time', 'body': 'ball', 'table': [[0, 0, 0, 0], [100, 100, 0, 0]]}],
}  # fmt: skip


def test_forces_over_time_count_from_the_last_reset_as_soon_as_somebody_tells_of_it():
    """
    A force of as many newtons as seconds have passed; the news of a reset comes behind its states.
    Whoever has a page with other forces loads it anew.
    """
    source = Told(replace(moving(0, 1, 2), began=()))
    source.scene = load_scene(PUSHED)
    run = live_server.LiveRun(source)
    assert live_server.UNKNOWN_BEGIN in run.page()
    begins = [(), (0.0,), (0.0,), (0.0, 7.0), (0.0, 7.0)]
    for k, began in enumerate(begins, start=1):
        name, told = run.name, 2
        source.coming.append(replace(moving(*range(3 * k, 3 * k + 3)), began=began))
        run.look()
        assert (run.after(name, told) is None) is (k in (2, 4))
    assert live_server.UNKNOWN_BEGIN not in run.page()
    record, numbers = unpacked(run.page())
    assert {'kinetic', 'potential'} <= set(record['series'])
    drive = array_of(record['series']['arrows_0'], numbers).reshape(-1, 3)
    assert drive[:, 0].tolist() == [0, 1, 2, 3, 4, 5, 6, *range(11)]


def test_a_motion_with_fewer_instants_has_the_largest_of_its_wrenches():
    (track,) = thinned(moving(1, 2, 3, 4, 5, 6, 7), 4).tracks
    assert track.time.tolist() == track.twist_time.tolist() == [1, 3, 5, 7]
    assert track.position[:, 0].tolist() == track.force[:, 0].tolist() == [1, 3, 5, 7]


def test_a_page_keeps_no_more_than_so_many_instants_of_a_run_that_goes_on(tab):
    source = Told(moving(*range(1000)))
    with live_page_of(source) as (run, address):
        tab.open(address)
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        for k in range(1, 60):
            source.coming.append(moving(*np.linspace(1000 * k, 1000 * k + 999, 1000)))
            run.look()
        source.ended = True
        run.look()
        tab.wait_for("document.body.dataset.live === 'ended'")
        times, lengths = tab.evaluate("""[[...view.run.times],
            Object.values(view.run.series).map(each => each.values.length / each.width)]""")
        assert tab.errors == []
    assert set(lengths) == {len(times)} and len(times) < 50_000
    assert np.diff(times).max() < 4.0  # evenly
    assert times[-1] == 59_999.0 and np.all(np.diff(times) > 0.0)


def test_another_run_begins_where_stamps_go_back():
    """As of a node that was started again: what came before is no part of it."""
    names = ['/ball/pose', '/ball/twist']
    growing = GrowingMotion(names[:1], names)

    def tick(stamp):
        for name, kind, three in zip(
            names, (cdr.PoseStamped, cdr.TwistStamped), ((0.0, 0.0, 0.0, 1.0), (0.0,) * 3)
        ):
            growing.take(name, cdr.encode(kind(stamp, 0, 'world', (1.0, 2.0, 3.0), three)))

    for stamp in (7, 8, 8, 9):
        tick(stamp)
    assert growing.whole(most=25).tracks[0].time.tolist() == [7, 8, 9] and growing.run == 0
    tick(10)
    for stamp in (0, 1):
        tick(stamp)
    assert growing.run == 1
    assert growing.whole(most=25).tracks[0].time.tolist() == [0, 1]


def test_a_page_shows_the_run_that_begins_and_tells_how_long_nothing_came(tab):
    source = Told(moving(100, 101))
    with live_page_of(source) as (run, address):
        tab.open(f'{address}#theme=dark')
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        assert tab.evaluate('view.player.now') == 101
        tab.wait_for("document.getElementById('news').textContent.startsWith('nothing new for ')")
        source.run, source.coming = 1, [moving(0, 0.5)]
        run.look()
        comes_to(tab, "window.view?.run.end === 0.5 && document.body.dataset.live === 'on'")
        assert tab.evaluate("document.getElementById('news').textContent") == ''
        source.coming = [moving(0.75)]
        run.look()
        tab.wait_for('view.player.now === 0.75')
        assert tab.errors == []


def comes_to(tab, condition):
    """Wait, over a page that loads itself anew meanwhile."""
    deadline = time.monotonic() + PATIENCE
    while True:
        with contextlib.suppress(RunError):  # it is between two pages
            if tab.evaluate(condition):
                return
        assert time.monotonic() < deadline, condition
        time.sleep(0.1)


def test_the_page_of_a_server_that_was_killed_says_so_and_shows_the_run_of_the_next_one(
    tab, written, touching, tmp_path
):
    with socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        port = free.getsockname()[1]
    words = [sys.executable, '-m', 'rigid_body_sim', 'view', '--live', '--port', str(port)]
    bags = []
    for name, (content, _) in (('first', written), ('second', touching)):
        (tmp_path / name).mkdir()
        writing = Writing(tmp_path / name, content)
        writing.up_to(0.5)
        bags.append(writing.path)
    news = "document.getElementById('news').textContent"
    with killed([*words, str(bags[0])]) as address:
        tab.open(address)
        tab.wait_for("document.body.dataset.state === 'ready' && document.body.dataset.live")
        assert tab.evaluate("document.querySelector('h1').textContent") == 'two_bodies'
    tab.wait_for(f"{news} === 'connection lost'")
    with killed([*words, str(bags[1])]):
        comes_to(tab, "document.querySelector('h1').textContent === 'rolling_sphere'")
        # a slow page may tell meanwhile that nothing is new: its bag is not written on
        comes_to(tab, f"document.body.dataset.live === 'on' && {news} !== 'connection lost'")


@pytest.mark.parametrize(
    ('remapped', 'own', 'lost'),
    [
        (['/gps/pose'], {'/gps/pose': '/lab/a/pose'}, []),  # the only one that lacks its pose
        (
            ['/gps/a/fix', '/gps/b/fix'],
            {'/gps/a/fix': '/lab/a/pose', '/gps/b/fix': '/lab/b/pose'},
            [],
        ),
        (['/gps/one', '/gps/two'], {}, ['/gps/one', '/gps/two']),
    ],
)
def test_a_remapped_pose_is_of_the_body_that_lacks_one_or_whose_name_it_holds(remapped, own, lost):
    bodies = ['a', 'b', 'silent']  # the last has no topics
    twists = {f'/lab/{body}/twist': cdr.TwistStamped.TYPE for body in 'ab'}
    left = {f'/lab/{body}/pose': POSE for body in 'ab'[len(remapped) :]}
    wires = {**twists, **left, **dict.fromkeys(remapped, POSE)}
    found = own_by_kind(wires, bodies, namespace='/lab', kinds=KINDS)
    assert found == ({wire: wire for wire in (*twists, *left)} | own, lost)


@pytest.mark.parametrize(
    'there',
    [
        'nothing',
        *(
            pytest.param(there, marks=pytest.mark.long)
            for there in ('an empty folder', 'the begin of a bag')
        ),
    ],
)
def test_who_waits_for_a_bag_is_stopped_by_ctrl_c_and_says_so(tmp_path, written, there):
    path = tmp_path / 'bag'
    if there == 'the begin of a bag':
        Writing(tmp_path, written[0]).up_to(0.001)
    elif there == 'an empty folder':
        path.mkdir()
    words = [sys.executable, '-m', 'rigid_body_sim', 'view', str(path), '--live']
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        time.sleep(3.0)  # it waits, or it is still on the way: the same is said of both
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith('rigid_body_sim view: stopped by Ctrl-C before ')


@contextlib.contextmanager
def killed(words):
    """A server that is killed at the end; gives its address."""
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process.stdout.readline().split()[0]
        finally:
            process.kill()


@contextlib.contextmanager
def live_page_of(source, port=0):
    """Serve a source; gives the run and its address."""
    run = live_server.LiveRun(source)
    server = live_server.Server(port, run)
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
