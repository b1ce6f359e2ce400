# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the README shows is run, word for word."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from rigid_body_sim.__main__ import main
from rigid_body_sim.scene import load_scene

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / 'README.md').read_text()


BLOCK = re.compile(r'^```(\w*)\n(.*?)^```$', flags=re.DOTALL | re.MULTILINE)
BLOCKS = BLOCK.findall(TEXT)


def block_with(language, words):
    (found,) = (text for kind, text in BLOCKS if kind == language and words in text)
    return found


def run(command, *, folder, **environment):
    result = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {'PYTHONPATH': str(ROOT)} | environment,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_the_scene_is_the_shipped_scene_and_loads():
    shown = yaml.safe_load(block_with('yaml', 'name: two_bodies'))
    assert len(load_scene(shown).bodies) == 2
    shipped = yaml.safe_load((ROOT / 'config' / 'scenes' / 'two_bodies.yaml').read_text())
    assert shown['name'] == shipped['name']


def test_the_scene_of_contact_loads():
    ground = '- {name: ground, shape: {type: plane, normal: [0, 0, 1]}, friction: 0.4}'
    bodies = load_scene(block_with('yaml', ground).encode()).bodies
    assert [body.name for body in bodies][:2] == ['ground', 'box_1'] and len(bodies) == 11


def test_the_bodies_of_the_scene_with_a_hammer_load():
    (hammer,) = load_scene(block_with('yaml', 'name: hammer\n').encode()).bodies
    assert hammer.pivot is not None
    assert hammer.initial.position[2] < 1.0  # its head hangs down


def test_the_python_example_runs():
    printed = run(
        [sys.executable, '-c', block_with('python', "integrator='dmv6'")],
        folder=ROOT,
        RIGID_BODY_SIM_COMPILE='0',
    )
    assert printed.startswith('1.0 ')


def test_the_controller_of_the_first_minute_stops_the_satellite():
    printed = run(
        [sys.executable, '-c', block_with('python', 'def damper(t, state)')],
        folder=ROOT,
        RIGID_BODY_SIM_COMPILE='0',
    )
    time, *rates = map(float, printed.replace('[', ' ').replace(']', ' ').split())
    assert time == 5.0 and max(map(abs, rates)) < 1e-3  # rad/s: from 0.05, like exp(-0.5 t / 0.35)


@pytest.mark.parametrize(
    'words', ['simulate bouncing_ball', 'simulate heavy_top', 'sweep satellite']
)
def test_the_first_minutes_of_students_and_of_researchers_work(
    words, tmp_path, monkeypatch, capsys
):
    if 'sweep' in words:
        pytest.importorskip('pyarrow')
    monkeypatch.chdir(tmp_path)
    for line in block_with('', words).strip().splitlines():
        command = shlex.split(line, comments=True)
        if command[1] == '-m':
            assert main(command[3:]) == 0, capsys.readouterr()
        else:  # a lesson; test_lecture runs it
            assert (ROOT / command[1]).is_file()
    shown = capsys.readouterr().out
    assert '  bag: ' in shown or 'sweep' in words
    if 'heavy_top' in words:
        assert 'estimated error: position 4.3e-11 m' in shown and 'not reliable' not in shown
        assert 'estimated error: position' in shown and 'identical' in shown
        assert 'no drift, to the last bit' in shown


def test_the_commands_of_a_first_run_work(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = block_with('', 'simulate two_bodies').strip().splitlines()
    assert len(lines) == 8
    for line in lines:
        words = shlex.split(line, comments=True)
        assert words[:3] == ['python', '-m', 'rigid_body_sim']
        assert main(words[3:]) == 0, capsys.readouterr()
    assert (tmp_path / 'run.png').stat().st_size > 10_000
    assert len((tmp_path / 'run.csv').read_text().splitlines()) == 1 + 1001  # t = 0 is one of them


def test_the_test_of_a_controller_is_the_one_that_ships():
    """And that one is run by test/testing."""
    shipped = ROOT / 'examples' / 'controller_tests' / 'test_attitude_damper.py'
    licence = 2  # lines
    shown = block_with('python', 'simulation(')
    assert shown.splitlines() == shipped.read_text().splitlines()[licence:]


def test_the_test_of_a_node_of_its_own_passes(tmp_path):
    pytest.importorskip('rclpy')
    page = (ROOT / 'docs' / 'testing_controllers.md').read_text()
    (text,) = (text for _, text in BLOCK.findall(page) if 'class RateDamper' in text)
    (tmp_path / 'test_controller.py').write_text(text)
    plugin = ('-p', 'rigid_body_sim.testing.plugin', '-p', 'no:cacheprovider')
    printed = run(
        [sys.executable, '-m', 'pytest', '-q', *plugin, 'test_controller.py'],
        folder=tmp_path,
        RIGID_BODY_SIM_COMPILE='0',
    )
    assert '1 passed' in printed
