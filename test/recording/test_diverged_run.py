# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run that diverged can be looked at, up to where its numbers leave what can be drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rigid_body_sim as rbs
from rigid_body_sim.errors import UserError
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.view.bag_follower import BagFollower
from rigid_body_sim.view.drawn_part import MOST, drawn_part, note_of
from rigid_body_sim.view.live_server import LiveRun
from rigid_body_sim.view.recorded_motion import RecordedMotion, Track, read_motion

from ..pages import PageOf

SCENE = """
version: 1
name: too stiff
dt: 0.01
bodies:
  - {name: ball, shape: {type: particle}, mass: 1, initial: {position: [1, 0, 0]}}
forces:
  - {type: spring, a: ball, b: world, b_point: [0, 0, 0], stiffness: 1.5e5, rest_length: 0.8}
"""


@pytest.fixture
def diverged(verb, tmp_path: Path) -> Path:
    """Run a spring with h omega = 3.9, where rk4 bears 2.8, to the end of all numbers."""
    (tmp_path / 'stiff.yaml').write_text(SCENE)
    words = (tmp_path / 'stiff.yaml', '-o', tmp_path / 'bag', '--integrator', 'rk4')
    code, out, _ = verb('simulate', *words, '--duration', '5')
    assert code == 1
    assert 'energy balance: none, the energy is beyond all numbers' in out
    return tmp_path / 'bag'


def test_a_run_that_diverged_is_drawn_up_to_where_its_numbers_can_be(
    verb, diverged: Path, tmp_path: Path
) -> None:
    for suffix in ('html', 'png'):
        assert verb('view', diverged, '-o', tmp_path / f'run.{suffix}')[0] == 0
    page = PageOf(tmp_path / 'run.html')
    whole = read_motion(Bag(diverged), samples=2000)
    assert page.times[-1] < whole.tracks[0].time[-1]
    for name in page['series']:
        assert np.isfinite(page.series(name)).all(), name
    assert 'the run diverged, and later instants' in (tmp_path / 'run.html').read_text()
    assert 'the run diverged' in rbs.open_bag(diverged)._repr_html_()


@pytest.mark.filterwarnings('error')
def test_the_live_page_of_a_run_that_diverges_ends_where_its_numbers_can_be_drawn(
    diverged: Path, tmp_path: Path
) -> None:
    content = next(diverged.glob('*.mcap')).read_bytes()
    (tmp_path / 'live').mkdir()
    file = tmp_path / 'live' / 'live_0.mcap'
    file.write_bytes(content[: len(content) // 4])  # the bag grows by the end of the numbers
    run = LiveRun(BagFollower(tmp_path / 'live'))
    for _ in range(2):  # what comes behind the end is left out, too
        file.write_bytes(content)
        run.look()
    (tmp_path / 'run.html').write_text(run.page())
    page = PageOf(tmp_path / 'run.html')
    for name in page['series']:
        assert np.isfinite(page.series(name)).all(), name
    whole = read_motion(Bag(diverged), samples=2000)
    assert 0 < page.times[-1] < whole.tracks[0].time[-1]
    assert 'the run diverged, and later instants' in run.page()


def motion_of(places: list[float]) -> RecordedMotion:
    """Give one body on the x axis, an instant each second."""
    time, rows = np.arange(float(len(places))), np.zeros((len(places), 3))
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (len(places), 1))
    position = rows.copy()
    position[:, 0] = places
    return RecordedMotion((Track('ball', time, position, turns, time, rows, rows),), time)


def test_what_is_drawn_ends_at_what_is_too_large_and_not_at_what_is_missing() -> None:
    lost = motion_of([0.0, np.nan, 1.0, 2.0])  # a tracker that did not see its body
    assert drawn_part(lost, name='run') is lost and note_of(lost) == ''
    part = drawn_part(motion_of([0.0, 1.0, 2.0 * MOST, 1.0]), name='run')
    assert part.tracks[0].time.tolist() == part.command_time.tolist() == [0.0, 1.0]
    assert note_of(part).startswith('Drawn up to 1 s: ') and 'passed at 2 s' in note_of(part)
    with pytest.raises(UserError, match='run: nothing of it can be drawn: at its first instant'):
        drawn_part(motion_of([np.inf, 1.0]), name='run')
