# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What cannot be used ends the node with exit code 2 and one line; nothing is left behind.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from rigid_body_sim.__main__ import main
from rigid_body_sim.recording.bag_reader import Bag
from rigid_body_sim.ros.parameters import PARAMETERS, strangers
from rigid_body_sim.scene.shipped_scenes import find_scene

from ..patience import PATIENCE

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ('given', 'expected'),
    [
        ('dt:=1', ['dt', '1.0']),
        ('publish_rate:=100', ['publish_rate', '100.0']),
        ('publish_rate:=-1.0', ['publish_rate', '-1.0']),
        ('real_time_factor:=.nan', ['real_time_factor', 'nan']),
        ('real_time_factor:=1.0e-12', ['real_time_factor', '1e-12', '~/pause']),
        ('command_timeout:=4.0e-10', ['command_timeout', '4e-10 s', 'until changed', '1e-09']),
        ('lockstep_timeout:=1.0e-300', ['lockstep_timeout', '1e-300 s', 'for ever', '1e-09']),
        ('dt:=0.3333333333333333', ['nanosecond']),
        ('scene:=no_such_scene', ['no_such_scene', 'ten_bodies']),
        ('integrator:=rk5', ['rk5', 'dmv6']),
        ('record:=1', ['record', 'true or false']),
        ('use_sim_time:=true', ['use_sim_time']),
        ('step_mode:=lockstep', ['lockstep_topics', '<body>/wrench']),
        ('step_mode:=some', ['step_mode', 'free']),
        ('lockstep_topics:=[a]', ['lockstep_topics', 'step_mode:=lockstep']),
        ('frame_prefix:=/lab', ['frame_prefix', '/lab']),
        ("frame_prefix:='a b/'", ['frame_prefix', "'a b/'", 'without blanks']),
        ("world_frame:='my map'", ['world_frame', "'my map'", 'without blanks']),
        ('body_topics:=nobody', ['body_topics', 'nobody']),
        ("world_frame:=''", ['world_frame']),
        ('world_frame:=box', ['world_frame', "'box' of the scene", 'such as world']),
        ('command_reliability:=maybe', ['command_reliability', 'best_effort']),
        ('record_path:=taken', ['taken', 'exists']),
    ],
)
def test_a_bad_parameter_exits_2_with_one_line(monkeypatch, tmp_path, capfd, given, expected):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'taken').mkdir()
    code = main(['sim_node', '--ros-args', '-p', given])
    said = capfd.readouterr().err
    assert code == 2
    (line,) = [line for line in said.splitlines() if 'error' in line]
    assert line.startswith('rigid_body_sim sim_node: error:')
    assert all(word in line for word in expected), line
    assert 'Traceback' not in said
    assert [path.name for path in tmp_path.iterdir()] == ['taken']


def test_lockstep_on_terms_that_do_not_fit_the_scene_exits_2(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    given = ['scene:=satellite', 'step_mode:=lockstep', 'lockstep_topics:=[satellite/torqe]']
    assert main(['sim_node', '--ros-args', *(w for one in given for w in ('-p', one))]) == 2
    said = capfd.readouterr().err
    (line,) = [line for line in said.splitlines() if 'error' in line]
    assert 'did you mean satellite/torque?' in line
    assert 'Traceback' not in said


@pytest.mark.parametrize('words', [['-q'], ['--params-file', 'none.yaml'], ['-r', '__ns:=//3']])
def test_bad_arguments_for_ros_exit_2(capfd, words):
    assert main(['sim_node', '--ros-args', *words]) == 2
    assert 'Traceback' not in capfd.readouterr().err


def test_a_name_that_is_no_text_is_refused_in_a_line(capfd):
    assert main(['sim_node', '--ros-args', '-p', 'record_path:=M\udcfcnchen']) == 2
    assert r'error: record_path:=M\udcfcnchen: holds bytes that are no ' in capfd.readouterr().err


def test_a_node_that_finds_no_folder_for_logs_says_so_and_not_that_its_words_are_wrong():
    bare = {k: v for k, v in os.environ.items() if k not in ('HOME', 'ROS_LOG_DIR', 'ROS_HOME')}
    words = [sys.executable, '-m', 'rigid_body_sim', 'sim_node', '--ros-args']
    words += ['-p', 'scene:=satellite', '-p', 'stop_time:=0.01']
    result = subprocess.run(
        words, env=bare, capture_output=True, text=True, timeout=60, check=False
    )
    assert result.returncode == 2
    assert 'set ROS_LOG_DIR to one that can be written, or HOME' in result.stderr
    assert 'arguments for ROS' not in result.stderr


def test_paths_may_begin_with_the_home_folder(tmp_path):
    home, here = tmp_path / 'home', tmp_path / 'here'
    home.mkdir(), here.mkdir()
    shutil.copy(find_scene('satellite'), home / 'mine.yaml')
    words = [sys.executable, '-m', 'rigid_body_sim', 'sim_node', '--ros-args']
    for given in ('scene:=~/mine.yaml', 'record_path:=~/bag', 'record:=true', 'stop_time:=0.01'):
        words += ['-p', given]
    result = subprocess.run(
        words, env={**os.environ, 'HOME': str(home)}, cwd=here, capture_output=True, text=True,
        timeout=PATIENCE, check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert f'recorded: {home / "bag"}' in result.stderr
    assert Bag(home / 'bag').complete
    assert not [*here.iterdir()]


def test_the_node_takes_no_words_of_its_own(capfd):
    with pytest.raises(SystemExit) as ended:
        main(['sim_node', 'demo.yaml'])
    assert ended.value.code == 2


def test_help_lists_every_parameter(capsys):
    with pytest.raises(SystemExit) as ended:
        main(['sim_node', '--help'])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert all(f'  {entry.name} [' in said and entry.description in said for entry in PARAMETERS)


def test_the_parameter_file_holds_every_parameter_with_its_default():
    content = yaml.safe_load((ROOT / 'config' / 'sim_node.yaml').read_text())
    given = content['/**']['ros__parameters']
    assert list(given.items()) != []
    assert {name: type(value) for name, value in given.items() if value != []} == {
        entry.name: type(entry.default) for entry in PARAMETERS if entry.default != ()
    }
    for entry in PARAMETERS:
        assert given[entry.name] == (list(entry.default) if entry.default == () else entry.default)


def test_a_mistyped_parameter_is_named_with_the_nearest_one():
    (warning,) = strangers(['dt', 'record_pth', 'qos_overrides./clock.publisher.depth'])
    assert 'record_pth' in warning
    assert 'record_path' in warning
