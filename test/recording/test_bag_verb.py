# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
`bag info|check|recover|diff`: exit codes and what is printed.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rigid_body_sim.__main__ import main
from rigid_body_sim.errors import RunError, UserError
from rigid_body_sim.recording import cdr
from rigid_body_sim.verbs import bag

ROOT = Path(__file__).parents[2]


def call(*words):
    """
    Run the verb; returns the exit code.
    """
    parser = argparse.ArgumentParser()
    bag.add_arguments(parser)
    return bag.run(parser.parse_args([str(word) for word in words]))


def test_info_shows_topics_counts_manifest_and_ending(record, capsys):
    directory = record()
    assert call('info', directory) == 0
    text = capsys.readouterr().out
    for expected in (
        '/box/pose',
        cdr.PoseStamped.TYPE,
        'dmv6',
        'stop_time',
        'scene.yaml',
        '0.1 s',
    ):
        assert expected in text
    assert call('info', '--json', directory) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts['topics']['/clock'] == {'type': cdr.Clock.TYPE, 'count': 20}
    assert facts['ending']['end_reason'] == 'stop_time'
    assert (facts['start'], facts['duration'], facts['complete']) == (0.0, 0.1, True)


def test_check_exits_with_1_and_names_the_finding(tmp_path, capsys):
    directory = tmp_path / 'bag'
    assert main(['simulate', 'oscillator', '-o', str(directory), '--duration', '0.05']) == 0
    capsys.readouterr()
    assert call('check', directory) == 0
    assert 'whole' in capsys.readouterr().out
    (directory / 'metadata.yaml').unlink()
    assert call('check', directory) == 1
    assert 'bag recover' in capsys.readouterr().out
    assert call('check', '--json', directory) == 1
    assert len(json.loads(capsys.readouterr().out)['findings']) == 1


def test_recover_reports_what_was_saved(record, tmp_path, mcap_of, capsys):
    directory = record()
    path = mcap_of(directory)
    path.write_bytes(path.read_bytes()[:-10])
    assert call('recover', directory, '-o', tmp_path / 'saved') == 0
    assert 'up to tick 100' in capsys.readouterr().out
    assert call('recover', '--json', directory, '-o', tmp_path / 'again') == 0
    assert json.loads(capsys.readouterr().out)['last_tick'] == 100
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RunError) as failure:
        call('recover', directory, '-o', tmp_path / 'third')
    assert failure.value.exit_code == 1


def test_equal_messages_are_identical(record, capsys):
    assert call('diff', record('a'), record('b')) == 0
    assert 'identical' in capsys.readouterr().out


def test_diff_names_the_first_difference_in_ulps(run, tmp_path, capsys):
    arrays = run.arrays(10)
    for name in ('a', 'b'):
        writer = run.open(tmp_path / name)
        writer.write(run.state(5))
        writer.write(run.packer.pack(10, **arrays))
        writer.close({})
        arrays['velocity'][1, 2] = np.nextafter(np.nextafter(arrays['velocity'][1, 2], 9), 9)
    assert call('diff', '--json', tmp_path / 'a', tmp_path / 'b') == 3
    found = json.loads(capsys.readouterr().out)
    assert found['identical'] is False
    assert (found['tick'], found['topic'], found['field']) == (10, '/ball/twist', 'linear.z')
    assert (found['ulps'], found['messages']) == (2, 13)
    assert call('diff', tmp_path / 'a', tmp_path / 'b') == 3
    assert '(2 ulps)' in capsys.readouterr().out


def test_diff_tells_minus_zero_from_zero(run, tmp_path, capsys):
    for name, zero in (('a', 0.0), ('b', -0.0)):
        writer = run.open(tmp_path / name)
        payload = cdr.encode(cdr.Vector3Stamped(0, 0, 'box', (1.0, zero, 0.0)))
        writer.write_message('/box/force', 3, 0, payload)
        writer.close({})
    assert call('diff', '--json', tmp_path / 'a', tmp_path / 'b') == 3
    found = json.loads(capsys.readouterr().out)
    assert (found['field'], found['ulps'], found['tick']) == ('vector.y', 1, 3)


@pytest.mark.parametrize(
    ('change', 'field'),
    [
        ({'topic': '/ball/force'}, 'topic'),
        ({'sequence': 4}, 'sequence'),
        ({'time_ns': 7}, 'log_time'),
        ({'payload': b'\0\1\0\0'}, 'byte 4'),
    ],
)
def test_diff_names_what_is_no_message_field(run, tmp_path, capsys, change, field):
    payload = cdr.encode(cdr.Vector3Stamped(0, 0, 'box', (1.0, 2.0, 3.0)))
    message = {'topic': '/box/force', 'sequence': 3, 'time_ns': 3, 'payload': payload}
    for name, content in (('a', message), ('b', message | change)):
        writer = run.open(tmp_path / name)
        writer.write_message(*content.values())
        writer.close({})
    assert call('diff', '--json', tmp_path / 'a', tmp_path / 'b') == 3
    assert json.loads(capsys.readouterr().out)['field'] == field


def test_a_shorter_recording_differs_at_its_end(record, capsys):
    short, long = record('short', ticks=50), record('long', ticks=100)
    for pair, side in (((short, long), 'end of A'), ((long, short), 'end of B')):
        assert call('diff', *pair) == 3
        assert side in capsys.readouterr().out


@pytest.mark.parametrize('words', [('info',), ('check',), ('diff',), ('recover', '-o', 'saved')])
def test_an_unusable_path_is_the_users_error(tmp_path, words):
    paths = [tmp_path / 'missing'] * (2 if words[0] == 'diff' else 1)
    with pytest.raises(UserError) as failure:
        call(*words, *paths)
    assert failure.value.exit_code == 2
    assert '\n' not in str(failure.value)


def test_a_bag_with_an_umlaut_in_its_name_is_found_in_a_locale_without_one(tmp_path):
    """Names of files in metadata.yaml are UTF-8 whatever the locale of the reader."""
    bag = tmp_path / 'Ünsere'
    assert main(['simulate', 'oscillator', '--duration', '0.1', '-o', str(bag)]) == 0
    done = subprocess.run(
        [sys.executable, '-m', 'rigid_body_sim', 'bag', 'check', bag.rename(tmp_path / 'bag')],
        env=os.environ | {'LC_ALL': 'C', 'PYTHONUTF8': '0', 'PYTHONPATH': str(ROOT)},
        capture_output=True,
        check=False,
    )
    said = f'{tmp_path / "bag"}: whole\n'.encode()
    assert (done.returncode, done.stdout, done.stderr) == (0, said, b'')
