# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where numba is missing everything works, and one line says what that costs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

ROOT = Path(__file__).parents[2]
HIDE = "import sys\nsys.modules['numba'] = None\n"  # as if it were not installed
SIMULATE = (
    HIDE
    + """
from rigid_body_sim import Simulation, load_scene
from rigid_body_sim.scene.shipped_scenes import find_scene
for _ in range(2):
    sim = Simulation(load_scene(find_scene('free_fall')))
    sim.step(3)
print(sim.tick)
"""
)
VERB = HIDE + 'from rigid_body_sim.__main__ import main\nsys.exit(main(sys.argv[1:]))\n'
COST = 'kernels run as plain Python, with the same bits but some 200 times slower, 700 times where'


def run(code, *arguments, **environment):
    known = {k: v for k, v in os.environ.items() if k != 'RIGID_BODY_SIM_COMPILE'}
    return subprocess.run(
        [sys.executable, '-c', code, *arguments],
        cwd=ROOT,
        env=known | {'PYTHONPATH': str(ROOT)} | environment,
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=True,
    )


def test_a_program_is_warned_once():
    done = run(SIMULATE)
    assert done.stdout == '3\n'
    assert done.stderr.count('RuntimeWarning: numba cannot be imported') == 1
    assert COST in done.stderr
    assert done.stderr.startswith('<string>:')  # the line of the program, not one of the package


def test_who_asks_for_plain_source_is_not_warned():
    assert run(SIMULATE, RIGID_BODY_SIM_COMPILE='0').stderr == ''


def test_a_verb_says_it_in_one_line_of_its_own(tmp_path):
    done = run(VERB, 'simulate', 'free_fall', '--duration', '0.003', '-o', str(tmp_path / 'bag'))
    lines = [line for line in done.stderr.splitlines() if 'numba' in line]
    (line,) = lines
    assert line.startswith('rigid_body_sim simulate: warning: numba cannot be imported')
    assert COST in line


def test_numba_is_installed_with_the_package():
    text = (ROOT / 'setup.py').read_text()
    required = text.partition('install_requires=[')[2].partition(']')[0]
    assert "'numba'" in required


def test_the_node_logs_it():
    """Its log goes to standard error and to /rosout."""
    pytest.importorskip('rclpy')
    done = run(VERB, 'sim_node', '--ros-args', '-p', 'scene:=free_fall', '-p', 'stop_time:=0.01')
    (line,) = [line for line in done.stderr.splitlines() if 'numba' in line]
    assert line.startswith('[WARN]')
    assert 'numba cannot be imported' in line
    assert COST in line
