# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""The examples of tests of controllers are short, and pass beside each other, as the page says."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..patience import HANGING

pytest.importorskip('rclpy')

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / 'examples' / 'controller_tests').glob('*.py'))
PATH = [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])]
LONGEST = 15  # [lines] of a file


@pytest.mark.parametrize('count', [2, pytest.param(3, marks=pytest.mark.long)])
def test_the_examples_are_short_and_pass_in_two_workers(tmp_path, count):
    assert len(EXAMPLES) == 3
    tried = sorted(EXAMPLES, key=lambda path: 'hover' in path.name)[:count]
    assert [len(path.read_text().splitlines()) <= LONGEST for path in EXAMPLES] == [True] * 3
    plugins = ('-p', 'rigid_body_sim.testing.plugin', '-p', 'xdist', '-p', 'no:cacheprovider')
    run = subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', *plugins, '-n', '2', *map(str, tried)],
        cwd=tmp_path,
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(PATH), 'RIGID_BODY_SIM_COMPILE': '0'},
        capture_output=True,
        text=True,
        timeout=HANGING,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert f'{count} passed' in run.stdout
