# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""A run as a film: frames of the page in a real browser, at the times they stand for."""

from __future__ import annotations

import argparse
import errno
import itertools
import shutil
import subprocess
import tempfile

import numpy as np
import pytest
from PIL import Image

from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import UserError
from rigid_body_sim.verbs import simulate, view
from rigid_body_sim.view.film import FilmSettings

from .. import chromium

needs_browser = pytest.mark.skipif(chromium.find() is None, reason='no Chromium here')


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Half a second of a spinning disc."""
    path = tmp_path_factory.mktemp('film') / 'bag'
    parser = argparse.ArgumentParser()
    simulate.add_arguments(parser)
    words = ['symmetric_top', '-o', str(path), '--duration', '0.5', '--json']
    assert simulate.run(parser.parse_args(words)) == 0
    return path


def drawn(bag, output, *words):
    parser = argparse.ArgumentParser()
    view.add_arguments(parser)
    return view.run(parser.parse_args([str(bag), '-o', str(output), *words]))


@needs_browser
def test_a_gif_has_a_frame_for_each_of_its_times_and_the_body_turns_in_it(bag, tmp_path):
    """0.5 s at a tenth of the speed and 2 frames a second: 11 frames, played for 5.5 s."""
    words = ('--size', '200x160', '--fps', '2', '--speed', '0.1', '--dark')
    assert drawn(bag, tmp_path / 'run.gif', *words) == 0
    with Image.open(tmp_path / 'run.gif') as film:
        assert (film.size, film.n_frames, film.info['duration']) == ((200, 160), 11, 500)
        frames = []
        for place in range(film.n_frames):
            film.seek(place)
            frames.append(np.asarray(film.convert('RGB'), dtype=float))
    assert frames[0][:20, -20:].mean() < 60  # dark ground
    body = (slice(20, 130), slice(60, 140))
    changes = [np.abs(a[body] - b[body]).max() for a, b in itertools.pairwise(frames)]
    assert min(changes) > 30  # 1 rad from frame to frame: its pattern is somewhere else each time


def test_a_full_folder_of_frames_is_told_with_the_folder_and_its_cure(
    bag, tmp_path, monkeypatch, capsys
):
    def full(_page, output, _settings):
        raise OSError(errno.ENOSPC, 'No space left on device', str(output))

    monkeypatch.setattr(view, 'film', full)
    monkeypatch.setattr(view, 'need_tools', lambda _output: None)
    monkeypatch.setattr(tempfile, 'tempdir', str(tmp_path))
    assert main(['view', str(bag), '-o', str(tmp_path / 'run.gif')]) == 1
    assert (
        f'error: {tmp_path}: cannot be written: No space left on device; run.gif is drawn there '
        'first: make room, or name another folder: TMPDIR=DIR\n'
    ) in capsys.readouterr().err


@needs_browser
def test_a_film_is_drawn_where_the_temporary_folder_cannot_be_written(bag, tmp_path, monkeypatch):
    monkeypatch.setenv('TMPDIR', '/proc')  # that may not be written even by root
    words = ('--size', '200x160', '--fps', '10')
    assert drawn(bag, tmp_path / 'run.gif', *words) == 0


def test_a_film_without_any_temporary_folder_names_those_and_the_cure(
    bag, tmp_path, monkeypatch, capsys
):
    def nowhere():
        raise FileNotFoundError(errno.ENOENT, 'No usable temporary directory found')

    monkeypatch.setattr(view, 'need_tools', lambda _output: None)
    monkeypatch.setattr(tempfile, 'gettempdir', nowhere)
    assert main(['view', str(bag), '-o', str(tmp_path / 'run.gif')]) == 2
    said = capsys.readouterr().err
    assert 'run.gif: its frames need a temporary folder, and none can be' in said
    assert said.endswith('TMPDIR=DIR\n') and said.count('\n') == 1


@needs_browser
@pytest.mark.skipif(shutil.which('ffmpeg') is None, reason='no ffmpeg here')
def test_an_mp4_lasts_as_long_as_was_asked_for(bag, tmp_path):
    words = ('--size', '200x160', '--fps', '10', '--speed', '0.5')
    assert drawn(bag, tmp_path / 'run.mp4', *words) == 0
    asked = ['ffprobe', '-v', 'error', '-show_entries', 'format=duration', '-of', 'csv=p=0']
    told = subprocess.run([*asked, str(tmp_path / 'run.mp4')], capture_output=True, check=True)
    assert float(told.stdout) == pytest.approx(1.1, abs=0.01)  # eleven frames of 0.1 s


@pytest.mark.parametrize('words', [('--body', 'nope'), ('--follow',), ('--fps', '10')])
@pytest.mark.parametrize('name', ['run.png', 'run.html'])
def test_what_only_a_film_can_do_is_refused_of_a_picture_and_a_page(bag, tmp_path, name, words):
    with pytest.raises(UserError, match=f'{words[0]} is of a film, and changes nothing here'):
        drawn(bag, tmp_path / name, *words)
    assert not (tmp_path / name).exists()


def test_what_is_missing_is_said_with_its_cure(bag, tmp_path, monkeypatch):
    monkeypatch.setenv('PATH', str(tmp_path))  # neither a browser nor ffmpeg
    with pytest.raises(UserError, match='drawn by a browser, and none is here: apt-get'):
        drawn(bag, tmp_path / 'run.gif')
    browser = tmp_path / chromium.NAMES[0]
    browser.write_text('#!/bin/sh\n')
    browser.chmod(0o755)
    with pytest.raises(UserError, match=r'ffmpeg.*apt-get install ffmpeg; or give run\.gif'):
        drawn(bag, tmp_path / 'run.mp4')


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        ({'size': (201, 160)}, 'even numbers of pixels'),
        ({'rate': 0.0}, '1 to 120 frames'),
        ({'speed': float('nan')}, '--speed nan'),
    ],
)
def test_other_settings_are_refused(words, said):
    with pytest.raises(UserError, match=said):
        FilmSettings(**words)
