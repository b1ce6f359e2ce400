# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every example runs as it stands; each judges its own numbers."""

import ast
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from .. import inside
from ..children import run_script
from ..patience import PATIENCE

ROOT = Path(__file__).parents[2]
WITH_NODE = ROOT / 'examples' / 'lockstep_controller.py'
EIGHT = sorted((ROOT / 'examples' / 'eight_tasks').glob('*.py'))
EXAMPLES = [*sorted({*(ROOT / 'examples').glob('*.py')} - {WITH_NODE}), *EIGHT]
COMPILED = {'stack', *(path.stem for path in EIGHT)}  # some hundred times slower as plain source
MOST_LINES = 12  # of public API in each of the eight tasks


@pytest.mark.parametrize('path', EXAMPLES, ids=lambda path: path.stem)
def test_the_example_runs_from_any_folder_and_its_numbers_hold(path, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        if path.stem not in COMPILED:
            inside.run_plain(patch)
        code, printed = run_script(path)
    assert code == 0, printed
    assert printed.strip(), 'an example shows something'


def test_each_of_the_eight_tasks_takes_at_most_twelve_lines_of_public_api():
    assert len(EIGHT) == 8
    for path in EIGHT:
        tree = ast.parse(path.read_text())
        told = [*tree.body[:1], *(node for node in ast.walk(tree) if is_no_api(node))]
        skipped = {k for node in told for k in range(node.lineno, node.end_lineno + 1)}
        lines = enumerate(path.read_text().splitlines(), start=1)
        api = [line for k, line in lines if k not in skipped and line.split('#')[0].strip()]
        assert len(api) <= MOST_LINES, f'{path.name}: {len(api)} lines'
        assert 'rigid_body_sim.' not in path.read_text().replace('rigid_body_sim maintainers.', '')


def is_no_api(node):
    """Whether a statement imports, prints or judges the numbers."""
    prints = isinstance(node, ast.Expr) and ast.unparse(node).startswith('print(')
    return prints or isinstance(node, ast.Import | ast.ImportFrom | ast.Assert)


@pytest.mark.parametrize('until', ['16.0', pytest.param('30.0', marks=pytest.mark.long)])
def test_the_controller_in_lock_step_turns_the_satellite_of_the_node_that_its_text_starts(
    tmp_path, until
):
    """As it stands in the long form; else for a third of its time."""
    pytest.importorskip('rclpy')
    from rigid_body_sim.testing.domains import DomainLease
    from rigid_body_sim.testing.surroundings import PROFILE, PROFILE_VARIABLES

    source = WITH_NODE.read_text()
    assert source.count('=30.0') == 2  # of the node, and of the controller
    program = tmp_path / WITH_NODE.name
    program.write_text(source.replace('=30.0', f'={until}'))
    text = ast.get_docstring(ast.parse(program.read_text()))
    command = text[text.index('sim_node --ros-args') :].replace('\\\n', ' ')
    lease = DomainLease()
    environment = os.environ | {
        'PYTHONPATH': str(ROOT),
        'RIGID_BODY_SIM_COMPILE': '0',
        'ROS_DOMAIN_ID': str(lease.number),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        PROFILE_VARIABLES[0]: str(PROFILE),
    }
    words = [sys.executable, '-m', 'rigid_body_sim', *shlex.split(command)]
    node = subprocess.Popen(words, cwd=tmp_path, env=environment, stderr=subprocess.PIPE)
    try:
        result = subprocess.run(
            [sys.executable, str(program)],
            env=environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        _, said = node.communicate(timeout=PATIENCE)
    finally:
        node.kill()
        node.wait()
    assert result.returncode == 0, result.stderr
    assert node.returncode == 0, said
    lines = result.stdout.splitlines()
    angles = [float(line.split(' s ')[1].split()[0]) for line in lines]
    assert angles[0] > 50.0
    assert angles[-1] < 0.1  # degrees; it decays like exp(-0.4 t / 0.45)
    assert [path.name for path in tmp_path.iterdir() if path.is_dir()], 'a bag'
