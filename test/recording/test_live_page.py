# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a run that goes on: a bag is followed while it is written, a browser sees it."""

from __future__ import annotations

import argparse
import http.client
import threading

import numpy as np
import pytest

from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view import live_server
from rigid_body_sim.view.bag_follower import BagFollower
from rigid_body_sim.view.growing_motion import joined
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
    follower = BagFollower(tmp_path / 'note.txt')
    with pytest.raises((RunError, UserError)):
        follower.begin()
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    for words, said in (
        (['bag', '--live', '-o', 'run.html'], 'leave out -o'),
        (['bag', '--live', '--port', '70000'], '--port 70000'),
        ([], 'give a BAG and -o FILE'),
    ):
        with pytest.raises(UserError, match=said):
            view.run(parser.parse_args(words))


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
        assert 'Content' not in _answer(server, 'evil.example')
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
